//! A part program as a planned path.

use std::sync::Arc;

use anyhow::{Result, anyhow, bail};
use gcode::{Diagnostic, Feed, GcodeError, Move, MoveKind, Options, PathMode, Program, Shiftable, Toolpath};
use motion::curves::{Arc as CircularArc, Line};
use motion::{Curve, Kinematics, Limits, Piece, Plan, PlanSettings, ToolPath, Vec3};

/// Shorter moves are no moves, mm.
pub(super) const POINT_MM: f64 = 1e-7;

/// A part program, read and planned.
#[derive(Debug)]
pub struct Part {
    /// File name, for messages.
    pub name: String,
    /// The program's bytes, blocks and words.
    pub program: Program,
    /// How it was read.
    pub options: Options,
    /// Its moves.
    pub toolpath: Toolpath,
    /// The path in machine coordinates; program coordinates plus the work offset.
    pub path: ToolPath,
    /// For every piece of the path the move that it stands for; `None` for a way that the program does not state (from a tool
    /// change, from a home position).
    pub owners: Vec<Option<usize>>,
    /// Machine minus program coordinates, mm.
    pub work_offset: Vec3,
    /// What the programmed feed of every move is multiplied by.
    pub feed_factors: Vec<f64>,
    /// How it is planned.
    pub settings: PlanSettings,
    /// Positions over time.
    pub plan: Plan,
}

/// Why a program was not accepted: its faults, rendered with carets.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct Refused(pub String);

impl Part {
    /// Reads and plans a program.
    ///
    /// # Errors
    /// [`Refused`] when the program holds a feed move that cannot be predicted, or none at all.
    pub fn read(
        name: &str,
        bytes: Vec<u8>,
        options: Option<&Options>,
        work_offset: Vec3,
        kinematics: &Arc<dyn Kinematics>,
        limits: &Limits,
        settings: &PlanSettings,
    ) -> Result<Self> {
        let program = gcode::parse(bytes);
        let options = options.copied().unwrap_or_else(|| gcode::Dialect::detect(&program).into());
        let toolpath = gcode::interpret(&program, &options).map_err(|error| match error {
            GcodeError::Refused { diagnostics } => anyhow!(Refused(render(&diagnostics, &program, name))),
            other => anyhow!(other),
        })?;
        let feed_factors = vec![1.0; toolpath.moves.len()];
        let (path, owners) = pieces(&toolpath, work_offset, &feed_factors)?;
        if !toolpath.moves.iter().any(Move::is_feed) {
            bail!(Refused(format!("{name}: the program has no feed move; there is nothing to plan or to compensate")));
        }
        let plan = motion::plan(&path, kinematics, limits, settings)?;
        let settings = settings.clone();
        Ok(Self { name: name.to_owned(), program, options, toolpath, path, owners, work_offset, feed_factors, settings, plan })
    }

    /// The same program with its feeds multiplied by `factors`, one a move, and planned anew.
    ///
    /// # Errors
    /// When it cannot be planned.
    pub fn with_feeds(self, factors: Vec<f64>, limits: &Limits) -> Result<Self> {
        let (path, owners) = pieces(&self.toolpath, self.work_offset, &factors)?;
        let plan = motion::plan(&path, self.plan.desired.kinematics(), limits, &self.settings)?;
        Ok(Self { path, owners, plan, feed_factors: factors, ..self })
    }

    /// The move that a sample of the plan belongs to.
    #[must_use]
    pub fn move_at(&self, sample: usize) -> Option<usize> {
        self.owners.get(self.plan.samples.get(sample)?.piece).copied().flatten()
    }

    /// Whether a sample of the plan belongs to a move that may be compensated.
    #[must_use]
    pub fn shiftable_at(&self, sample: usize) -> bool {
        self.move_at(sample).is_some_and(|index| is_shiftable(&self.toolpath.moves[index]))
    }

    /// Whether a sample of the plan belongs to a feed move; the nearest one does for a place beyond the ends.
    #[must_use]
    pub fn feeds_at(&self, sample: usize) -> bool {
        let sample = sample.min(self.plan.samples.len().saturating_sub(1));
        self.move_at(sample).is_some_and(|index| self.toolpath.moves[index].is_feed())
    }

    /// Line of the program, from 1, that a sample of the plan belongs to.
    #[must_use]
    pub fn line_at(&self, sample: usize) -> Option<usize> {
        self.move_at(sample).map(|index| self.toolpath.moves[index].block as usize + 1)
    }

    /// How much of a correction every sample may take: 1 on moves that may be compensated, 0 elsewhere, with a fade over `fade_s` at
    /// both ends of each stretch so that it begins and ends exactly where the program says.
    #[must_use]
    pub fn weights(&self, fade_s: f64) -> Vec<f64> {
        let n = self.plan.samples.len();
        let fade = (fade_s / self.plan.desired.trajectory().period_s()).round().max(1.0);
        let mut weights: Vec<f64> = (0..n).map(|k| f64::from(u8::from(self.shiftable_at(k)))).collect();
        let ramp = |weights: &mut [f64], order: &mut dyn Iterator<Item = usize>| {
            let mut inside = 0.0_f64;
            for k in order {
                inside = if weights[k] > 0.0 { inside + 1.0 } else { 0.0 };
                // A raised cosine has no kink at either end; the sample at rest beside another move is not shifted at all.
                let share = 0.5 - 0.5 * (std::f64::consts::PI * ((inside - 1.0) / fade).clamp(0.0, 1.0)).cos();
                weights[k] = weights[k].min(share);
            }
        };
        ramp(&mut weights, &mut (0..n));
        ramp(&mut weights, &mut (0..n).rev());
        weights
    }
}

/// Whether a move may be compensated.
#[must_use]
pub fn is_shiftable(of: &Move) -> bool {
    of.shiftable == Shiftable::Yes && of.is_feed() && of.start.nominal_rotary_rad() == of.end.nominal_rotary_rad()
}

/// The program's faults, each with its line and a caret under the word.
#[must_use]
pub fn render(diagnostics: &[Diagnostic], program: &Program, name: &str) -> String {
    diagnostics.iter().map(|diagnostic| diagnostic.render(program, name)).collect::<Vec<_>>().join("\n")
}

fn pieces(toolpath: &Toolpath, work_offset: Vec3, feed_factors: &[f64]) -> Result<(ToolPath, Vec<Option<usize>>)> {
    let mut builder = Builder { path: Vec::new(), owners: Vec::new(), tip: None };
    for (index, step) in toolpath.moves.iter().enumerate() {
        let start = Vec3::from(step.start.nominal_mm()) + work_offset;
        let end = Vec3::from(step.end.nominal_mm()) + work_offset;
        match step.kind {
            MoveKind::Dwell { seconds } => builder.dwell(seconds.unwrap_or(0.0)),
            MoveKind::Home => builder.stop(),
            MoveKind::Line | MoveKind::Arc(_) => {
                let exact = matches!(toolpath.modal(step).path, PathMode::ExactPath | PathMode::ExactStop);
                builder.rapid(start, None);
                let curve: Arc<dyn Curve> = match step.kind {
                    MoveKind::Arc(arc) => Arc::new(circular(&arc, start, end, work_offset)?),
                    _ => Arc::new(Line { start, end }),
                };
                let length = step.length_mm().unwrap_or(0.0);
                let feed_mm_s = match step.feed {
                    Some(Feed::Linear { mm_s }) => mm_s,
                    Some(Feed::Duration { seconds }) if seconds > 0.0 => length / seconds,
                    _ => f64::INFINITY,
                };
                if length > POINT_MM {
                    builder.feed(curve, feed_mm_s * feed_factors[index], exact, index, end);
                }
            }
            MoveKind::Rapid | MoveKind::Thread | MoveKind::Probe | MoveKind::Cycle(_) => builder.rapid(end, Some(index)),
        }
    }
    let mut path = ToolPath::default();
    builder.path.into_iter().for_each(|piece| path.push(piece));
    Ok((path, builder.owners))
}

struct Builder {
    path: Vec<Piece>,
    owners: Vec<Option<usize>>,
    tip: Option<Vec3>,
}

impl Builder {
    /// A straight way at full speed, with rests at both ends; none where the tool is there already.
    fn rapid(&mut self, to: Vec3, owner: Option<usize>) {
        if let Some(tip) = self.tip.replace(to)
            && (to - tip).norm() > POINT_MM
        {
            self.stop();
            let mut piece = Piece::whole(Arc::new(Line { start: tip, end: to }), f64::INFINITY);
            piece.stop_after = true;
            self.path.push(piece);
            self.owners.push(owner);
        }
    }

    fn feed(&mut self, curve: Arc<dyn Curve>, feed_mm_s: f64, stop_after: bool, owner: usize, end: Vec3) {
        let mut piece = Piece::whole(curve, feed_mm_s);
        piece.stop_after = stop_after;
        self.path.push(piece);
        self.owners.push(Some(owner));
        self.tip = Some(end);
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

/// The arc of a program as a curve; G18's plane turns Z towards X, which `Plane::axes` keeps right-handed.
fn circular(arc: &gcode::Arc, start: Vec3, end: Vec3, work_offset: Vec3) -> Result<CircularArc> {
    let [first, second, normal] = arc.plane.axes();
    let mut center = start;
    center[first] = arc.centre_mm[0] + work_offset[first];
    center[second] = arc.centre_mm[1] + work_offset[second];
    let axis = Vec3::from_fn(|i, _| f64::from(u8::from(i == normal)));
    Ok(CircularArc::new(start, center, axis, arc.sweep, arc.radius_end_mm, end[normal] - start[normal])?)
}
