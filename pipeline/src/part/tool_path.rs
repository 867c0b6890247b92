//! Moves of a program as path pieces in machine coordinates.

use std::sync::Arc;

use gcode::{Feed, Move, MoveKind, PathMode, Position, ToolLength, Toolpath};
use machine::ProgramWords;
use motion::curves::{Arc as CircularArc, Line};
use motion::{Curve, Kinematics, MM_PER_RAD, Piece, RotaryPath, ToolPath, Turning, Vec3, Vec6};

use super::offsets::Placement;
use crate::error::Result;

/// Length below which a move counts as no motion, mm.
pub const POINT_MM: f64 = 1e-7;

/// Meaning of the words of a move; `usual` without tip control.
pub(super) fn words_of(toolpath: &Toolpath, of: &Move, usual: ProgramWords) -> ProgramWords {
    if toolpath.modal(of).tool_length == ToolLength::TipControl { ProgramWords::Tip } else { usual }
}

/// Program coordinates of a position: X, Y, Z in mm, A, B, C in rad. Unknown coordinates take their nominal value.
#[must_use]
pub fn coordinates(of: &Position) -> Vec6 {
    let ([x, y, z], [a, b, c]) = (of.nominal_mm(), of.nominal_rotary_rad());
    Vec6::new(x, y, z, a, b, c)
}

/// Path pieces in machine coordinates, with the index of the move of each piece. The machine comes from `before`, machine coordinates in mm
/// and rad, where that is given.
pub(super) fn pieces(
    toolpath: &Toolpath,
    placement: &Placement,
    feed_factors: &[f64],
    kinematics: &dyn Kinematics,
    usual: ProgramWords,
    before: Option<Vec6>,
) -> Result<(ToolPath, Vec<Option<usize>>)> {
    let count = toolpath.moves.len();
    let (path, owners) = (Vec::with_capacity(count), Vec::with_capacity(count));
    let mut builder = Builder { path, owners, at: before, words: usual, kinematics };
    for (index, step) in toolpath.moves.iter().enumerate() {
        if step.after_stop {
            builder.stop();
        }
        let offset = offset_of(placement, toolpath, step);
        builder.set_words(words_of(toolpath, step, usual))?;
        let start = coordinates(&step.start) + offset;
        let end = coordinates(&step.end) + offset;
        match step.kind {
            MoveKind::Dwell { seconds } => builder.dwell(seconds.unwrap_or(0.0)),
            MoveKind::Home => builder.stop(),
            MoveKind::Line | MoveKind::Arc(_) => {
                let mode = toolpath.modal(step).path;
                let exact = matches!(mode, PathMode::ExactPath | PathMode::ExactStop);
                builder.rapid(start, None);
                let curve: Arc<dyn Curve> = match step.kind {
                    MoveKind::Arc(arc) => Arc::new(circular(&arc, linear(&start), linear(&end), &linear(&offset))?),
                    _ => Arc::new(Line { start: linear(&start), end: linear(&end) }),
                };
                let length = step.length_mm().unwrap_or(0.0);
                // Rotary axes count only where the machine has them.
                let turned = if kinematics.has_rotary_axes() { rotary(&(end - start)).norm() * MM_PER_RAD } else { 0.0 };
                let distance = length.hypot(turned);
                let feed_mm_s = match step.feed {
                    Some(Feed::Linear { mm_s }) if length > 0.0 => mm_s * distance / length,
                    Some(Feed::Angular { rad_s }) => rad_s * MM_PER_RAD,
                    Some(Feed::Duration { seconds }) if seconds > 0.0 => distance / seconds,
                    _ => f64::INFINITY,
                };
                if distance > POINT_MM {
                    let mut piece = Piece::whole(curve, feed_mm_s * feed_factors[index]).turning(builder.turning(start, end));
                    piece.stop_after = exact;
                    if let PathMode::Continuous { tolerance_mm, .. } = mode {
                        piece.corner_tolerance_mm = tolerance_mm;
                    }
                    builder.push(piece, Some(index), end);
                }
            }
            MoveKind::Rapid | MoveKind::Thread | MoveKind::Probe | MoveKind::Cycle(_) => builder.rapid(end, Some(index)),
        }
    }
    Ok((builder.path.into(), builder.owners))
}

/// Machine minus program coordinates of a move, mm and rad.
pub(super) fn offset_of(placement: &Placement, toolpath: &Toolpath, of: &Move) -> Vec6 {
    let offset = placement.of(toolpath.modal(of).work_offset);
    Vec6::new(offset.x, offset.y, offset.z, 0.0, 0.0, 0.0)
}

fn linear(at: &Vec6) -> Vec3 {
    at.fixed_rows::<3>(0).into_owned()
}

fn rotary(at: &Vec6) -> Vec3 {
    at.fixed_rows::<3>(3).into_owned()
}

struct Builder<'a> {
    path: Vec<Piece>,
    owners: Vec<Option<usize>>,
    /// End of the path so far, in the meaning of `words`.
    at: Option<Vec6>,
    words: ProgramWords,
    kinematics: &'a dyn Kinematics,
}

impl Builder<'_> {
    /// Rotary motion of a move from `start` to `end`.
    fn turning(&self, start: Vec6, end: Vec6) -> Turning {
        let path = RotaryPath::linear(rotary(&start), rotary(&end));
        match self.words {
            _ if !self.kinematics.has_rotary_axes() => Turning::Curve,
            ProgramWords::Axes => Turning::Axes(path),
            ProgramWords::Tip => Turning::Tip(path),
        }
    }

    /// Changes the meaning of coordinates from here on. The machine does not move.
    fn set_words(&mut self, words: ProgramWords) -> Result<()> {
        if words != self.words
            && self.kinematics.has_rotary_axes()
            && let Some(at) = &mut self.at
        {
            let near = vec![0.0; self.kinematics.axes().len()];
            let joints = match self.words {
                ProgramWords::Axes => {
                    self.kinematics.axes().iter().map(|axis| axis.slot().map_or(0.0, |slot| at[slot])).collect()
                }
                ProgramWords::Tip => self.kinematics.place(&linear(at), &rotary(at).into(), &near)?,
            };
            *at = stated(&joints, self.kinematics, words);
            self.stop();
        }
        self.words = words;
        Ok(())
    }

    /// Straight rapid with stops at both ends; nothing where the tool is already there.
    fn rapid(&mut self, to: Vec6, owner: Option<usize>) {
        let Some(at) = self.at else {
            self.at = Some(to);
            return;
        };
        let displacement = to - at;
        if linear(&displacement).norm() > POINT_MM
            || (self.kinematics.has_rotary_axes() && rotary(&displacement).norm() > POINT_MM)
        {
            self.stop();
            let line = Line { start: linear(&at), end: linear(&to) };
            let mut piece = Piece::whole(Arc::new(line), f64::INFINITY).turning(self.turning(at, to));
            piece.stop_after = true;
            self.push(piece, owner, to);
        }
    }

    fn push(&mut self, piece: Piece, owner: Option<usize>, end: Vec6) {
        self.path.push(piece);
        self.owners.push(owner);
        self.at = Some(end);
    }

    fn stop(&mut self) {
        if let Some(last) = self.path.last_mut() {
            last.stop_after = true;
        }
    }

    fn dwell(&mut self, seconds: f64) {
        if let Some(last) = self.path.last_mut() {
            last.dwell_s += seconds.max(0.0);
        }
    }
}

/// Axis positions as program coordinates of this meaning, in the machine frame: mm and rad.
#[must_use]
pub fn stated(joints: &[f64], kinematics: &dyn Kinematics, words: ProgramWords) -> Vec6 {
    let mut out = Vec6::zeros();
    for (axis, position) in kinematics.axes().iter().zip(joints) {
        if let Some(slot) = axis.slot() {
            out[slot] = *position;
        }
    }
    if words == ProgramWords::Tip {
        out.fixed_rows_mut::<3>(0).copy_from(&kinematics.forward(joints).tip);
    }
    out
}

/// A circular arc of the program as a curve. In G18 the rotation is from Z to X, which `Plane::axes` keeps
/// right-handed.
fn circular(arc: &gcode::Arc, start: Vec3, end: Vec3, offset: &Vec3) -> Result<CircularArc> {
    let [first, second, normal] = arc.plane.axes();
    let mut center = start;
    center[first] = arc.centre_mm[0] + offset[first];
    center[second] = arc.centre_mm[1] + offset[second];
    let axis = Vec3::from_fn(|i, _| f64::from(u8::from(i == normal)));
    Ok(CircularArc::new(start, center, axis, arc.sweep, arc.radius_end_mm, end[normal] - start[normal])?)
}

#[cfg(test)]
mod tests {
    use machine::MachineSpec;

    use crate::part::{Part, ReadSettings};
    use crate::setup::Setup;

    #[test]
    fn the_tool_waits_where_the_program_states_it() {
        let setup = Setup::new(&MachineSpec::builtin("ballscrew").unwrap(), None).unwrap();
        // Nor one that does not run, or may not.
        let plan = |text: &str, block_delete: Option<bool>| {
            let program = format!("G21 G90 G54\nG0 X0 Y0 Z0\nG1 X10 F600\nY10\n{text}X0\nY0\n");
            let settings = ReadSettings { at_zero: true, block_delete, ..Default::default() };
            Part::read("p.nc", program, &setup, &settings).unwrap().path.pieces()[1].stop_after
        };
        for (text, block_delete, stops) in [
            ("/M0\n", Some(true), false),
            ("/M0\n", Some(false), true),
            ("/M0\n", None, false),
            ("GOTO 10\nM0\nN10 ", None, false),
        ] {
            assert_eq!(plan(text, block_delete), stops, "{text} {block_delete:?}");
        }
        for (stop, plans_it) in [("M0", true), ("M1", false), ("M3", false)] {
            for text in [format!("Y10 {stop}\nX0\n"), format!("Y10\n{stop}\nX0\n")] {
                let program = format!("G21 G90 G54\nG0 X0 Y0 Z0\nG1 X10 F600\n{text}Y0\n");
                let part = Part::read("p.nc", program, &setup, &ReadSettings { at_zero: true, ..Default::default() }).unwrap();
                let [first, second] = [0, 1].map(|piece| (part.path.pieces()[piece].stop_after, part.borders()[piece]));
                assert_eq!(first, (false, false), "{text}");
                assert_eq!(second, (plans_it, stop != "M3"), "{text}");
            }
        }
    }
}
