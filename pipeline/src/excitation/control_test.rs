//! The control test as a part program in the dialect of its control.

use datasets::excitation::{Block, ControlTest, Coordinates};
use gcode::{Feed, Move, MoveKind, append_number, format_number};
use machine::ProgramWords;

use super::recording::in_program_words;
use super::style::{FEED_DECIMALS, Style, WAIT_S, header, in_work_coordinates};
use crate::error::{Error, ProgramFault, Result};
use crate::input::Input;
use crate::part::{Part, ReadSettings, stated};
use crate::setup::Setup;
use crate::travel;
use crate::units::in_programs;

/// Longest planned duration, s: with the reserve for a control that plans slower the program takes less than two minutes.
const LONGEST_S: f64 = 90.0;
/// Share of the machine's speeds, and whether the test is short, until it takes no longer: at a lower speed the figures are
/// smaller.
const ATTEMPTS: [(f64, bool); 8] =
    [(1.0, false), (0.75, false), (0.5, false), (0.6, true), (0.4, true), (0.25, true), (0.15, true), (0.1, true)];
/// Smallest number of decimals: with fewer the ends of arcs lie off their circles.
const LEAST_DECIMALS: usize = 3;
/// Share of a move at which it is compared: there whole and half circles of either direction differ.
const CHECKED: f64 = 0.25;
/// Relative difference of feeds that rounding may cause.
const FEED_SHARE: f64 = 0.01;

/// A control test as a program.
#[derive(Debug, Clone, PartialEq)]
pub struct ControlProgram {
    /// Text of the program.
    pub text: String,
    /// Duration as planned for the machine, s.
    pub seconds: f64,
}

impl ControlProgram {
    /// Name of the program, without ending.
    pub const NAME: &str = "control-test";
}

/// Program of the [`ControlTest`] for the machine of `setup`, drawn from `seed`; `number` is the index of the program, from
/// 0, and `travel` the lowest and highest position of every axis, mm or rad. `None` where no axis is one of x, y, z, a, b, c, or none
/// has room to move.
///
/// The program first raises the tool to its highest Z, then moves above the start, then descends at a feed. Linear axes
/// start in the middle of their travel, rotary axes at zero or near it. The text is read back and compared, and planned for its duration.
///
/// # Errors
/// When a position cannot be written, the text read back does not match, or the machine cannot run it.
pub fn control_test(
    number: usize,
    setup: &Setup,
    travel: &[(f64, f64)],
    style: &Style,
    seed: u64,
) -> Result<Option<ControlProgram>> {
    let style = Style { decimals: style.decimals.max(LEAST_DECIMALS), ..style.clone() };
    let mut last = None;
    for attempt in ATTEMPTS {
        last = planned(number, setup, travel, &style, attempt, seed)?;
        if last.as_ref().is_none_or(|program| program.seconds <= LONGEST_S) {
            break;
        }
    }
    Ok(last)
}

/// The program of one of [`ATTEMPTS`].
fn planned(
    number: usize,
    setup: &Setup,
    travel: &[(f64, f64)],
    style: &Style,
    (speed_share, is_short): (f64, bool),
    seed: u64,
) -> Result<Option<ControlProgram>> {
    let axes = setup.kinematics.axes();
    // Where the words are the tool tip's, single axes move alone only while the rotary axes are at zero.
    let home = |(axis, (low, high)): (&motion::Axis, &(f64, f64))| match axis.kind {
        motion::AxisKind::Linear => f64::midpoint(*low, *high),
        motion::AxisKind::Rotary => 0.0_f64.clamp(*low, *high),
    };
    let joints: Vec<f64> = axes.iter().zip(travel).map(home).collect();
    let origin_mm = style.origin_mm;
    let home: Coordinates = moved(stated(&joints, setup.kinematics.as_ref(), setup.words).into(), origin_mm.map(|by| -by));
    let is_within = |at: &Coordinates| is_within(&moved(*at, origin_mm), &joints, setup, travel);
    let groups = ControlTest { axes, limits: &setup.limits, home, speed_share, is_short, is_within: &is_within }.groups(seed);
    let failed = |source| Error::Excitation { run: ControlProgram::NAME.to_owned(), source };
    let mut text = Text { style, words: words_of(setup), body: String::new(), at: [f64::NAN; 6], written: Vec::new() };
    let moves = groups.iter().flat_map(|group| &group.blocks);
    text.body = style.first_block().map_err(failed)?;
    text.approach(&home, highest_z(&home, moves)).map_err(failed)?;
    for group in &groups {
        text.body += &style.comment(group.title);
        group.blocks.iter().try_for_each(|block| text.block(block)).map_err(failed)?;
    }
    // Where the travel is smaller than the last decimal nothing moves.
    if text.written.is_empty() {
        return Ok(None);
    }
    text.wait(WAIT_S).map_err(failed)?;
    let part = read(&style.framed(number, &[], &text.body), setup, origin_mm)?;
    text.check(&part).map_err(failed)?;
    let path = Input::from(part);
    // Nobody knows where the tool comes from.
    let from = path.part().and_then(|part| first_sample(part, &text)).unwrap_or_default();
    travel::check_from(&path, setup, from)?;
    let planned = in_work_coordinates(&in_program_words(path.trajectory(), setup)?, style)?;
    let ranges: Vec<[f64; 2]> =
        axes.iter().zip(planned.columns()).map(|(axis, column)| text.range(axis, &home, &column[from..])).collect();
    let header = header(ControlProgram::NAME, (axes, &ranges), planned.duration_s(), style, text.feeds());
    let seconds = planned.duration_s();
    Ok(Some(ControlProgram { text: style.framed(number, &header, &text.body), seconds }))
}

/// Coordinates with their linear ones moved by `by`, mm.
fn moved(at: Coordinates, by: [f64; 3]) -> Coordinates {
    std::array::from_fn(|slot| at[slot] + by.get(slot).copied().unwrap_or_default())
}

/// The first sample of the moves behind the approach.
fn first_sample(part: &Part, text: &Text<'_>) -> Option<usize> {
    let moves = part.toolpath.moves.iter().enumerate().filter(|(_, of)| of.is_feed() || matches!(of.kind, MoveKind::Rapid));
    let (first, _) = moves.rev().nth(text.written.len().checked_sub(1)?)?;
    (0..part.plan.desired.trajectory().len()).find(|sample| part.move_at(*sample).is_some_and(|of| of >= first))
}

/// Whether a position in machine coordinates is within the travel.
fn is_within(at: &Coordinates, near: &[f64], setup: &Setup, travel: &[(f64, f64)]) -> bool {
    let (axes, mut joints) = (setup.kinematics.axes(), near.to_vec());
    match setup.words {
        ProgramWords::Axes => {
            for (joint, slot) in joints.iter_mut().zip(axes).filter_map(|(joint, axis)| Some((joint, axis.slot()?))) {
                *joint = at[slot];
            }
        }
        ProgramWords::Tip => {
            let [x, y, z, rotary @ ..] = *at;
            if setup.kinematics.place_at(&motion::Vec3::new(x, y, z), &rotary, &mut joints).is_err() {
                return false;
            }
        }
    }
    joints.iter().zip(travel).all(|(joint, (low, high))| (*low..=*high).contains(joint))
}

/// Highest Z of the blocks.
fn highest_z<'a>(home: &Coordinates, blocks: impl Iterator<Item = &'a Block>) -> f64 {
    let ends = blocks.filter_map(|block| match block {
        Block::Rapid { to } | Block::Line { to, .. } | Block::Arc { to, .. } => Some(to[2]),
        Block::Dwell => None,
    });
    ends.fold(home[2], f64::max)
}

/// Slot, letter and factor from mm or rad of the words that state a position.
fn words_of(setup: &Setup) -> Vec<(usize, char, f64)> {
    let axes = setup.kinematics.axes().iter();
    let known = axes.filter_map(|axis| Some((axis.slot()?, in_programs(axis.kind).0)));
    known.map(|(slot, scale)| (slot, ['X', 'Y', 'Z', 'A', 'B', 'C'][slot], scale)).collect()
}

/// The program as planned under the work offset with which the user is to run it.
fn read(text: &str, setup: &Setup, origin_mm: [f64; 3]) -> Result<Part> {
    let settings = ReadSettings { work_offsets: vec![(None, origin_mm)], ..ReadSettings::default() };
    Part::read(ControlProgram::NAME, text, setup, &settings)
}

/// A written move.
struct Written {
    /// End as read back, mm and rad.
    at: Coordinates,
    /// Position of the linear axes after a share of [`CHECKED`] of the path, mm.
    checked_mm: [f64; 3],
    /// mm/s, or rad/s where only rotary axes move; `None` for a rapid.
    feed: Option<f64>,
    is_rotary: bool,
}

/// Text of the motion while it is written.
struct Text<'a> {
    style: &'a Style,
    words: Vec<(usize, char, f64)>,
    body: String,
    /// Present position as read back, mm and rad.
    at: Coordinates,
    /// Moves after the approach.
    written: Vec<Written>,
}

impl Text<'_> {
    /// Raises the tool, moves above the start, descends.
    fn approach(&mut self, home: &Coordinates, highest_mm: f64) -> std::result::Result<(), ProgramFault> {
        let (words, at) = self.position(home)?;
        let is_z = |word: &&String| word.starts_with('Z');
        let z = words.iter().find(is_z);
        if z.is_some() {
            self.body += &format!("G0 Z{}\n", format_number(highest_mm, self.style.decimals)?);
        }
        let others: Vec<&str> = words.iter().filter(|word| !is_z(word)).map(String::as_str).collect();
        if !others.is_empty() {
            self.body += &format!("G0 {}\n", others.join(" "));
        }
        if let Some(z) = z {
            self.body += &format!("G1 {z} F{}\n", format_number(self.style.plunge_mm_min, FEED_DECIMALS)?);
        }
        self.at = at;
        self.wait(WAIT_S)
    }

    fn block(&mut self, block: &Block) -> std::result::Result<(), ProgramFault> {
        match *block {
            Block::Dwell => self.wait(ControlTest::DWELL_S),
            Block::Rapid { to } => self.straight("G0", &to, None),
            Block::Line { to, feed } => self.straight("G1", &to, Some(feed)),
            Block::Arc { to, centre_mm, clockwise, feed } => self.arc(&to, centre_mm, clockwise, feed),
        }
    }

    fn wait(&mut self, seconds: f64) -> std::result::Result<(), ProgramFault> {
        self.body += &format!("{}\n", self.style.dwell(seconds)?);
        Ok(())
    }

    fn straight(&mut self, code: &str, to: &Coordinates, feed: Option<f64>) -> std::result::Result<(), ProgramFault> {
        let from = self.at;
        let (words, at) = self.position(to)?;
        // A word without motion would make a rotation look like a move of the linear axes.
        let moved: Vec<String> =
            words.into_iter().zip(&self.words).filter(|(_, (slot, ..))| at[*slot] != from[*slot]).map(|(word, _)| word).collect();
        if moved.is_empty() {
            return Ok(());
        }
        let checked_mm = std::array::from_fn(|slot| from[slot] + CHECKED * (at[slot] - from[slot]));
        let is_rotary = at[..3] == from[..3];
        self.body += &format!("{code} {}{}\n", moved.join(" "), feed_word(feed, is_rotary)?);
        self.at = at;
        self.written.push(Written { at, checked_mm, feed, is_rotary });
        Ok(())
    }

    /// An arc; a line where it is smaller than the last decimal.
    fn arc(
        &mut self,
        to: &Coordinates,
        centre_mm: [f64; 2],
        clockwise: bool,
        feed: f64,
    ) -> std::result::Result<(), ProgramFault> {
        let from = self.at;
        let (words, at) = self.position(to)?;
        let end: Vec<String> = words.into_iter().filter(|word| word.starts_with(['X', 'Y'])).collect();
        let (mut i, mut j) = ("I".to_owned(), "J".to_owned());
        let centre_mm = [
            append_number(&mut i, centre_mm[0], self.style.decimals)?,
            append_number(&mut j, centre_mm[1], self.style.decimals)?,
        ];
        if centre_mm == [0.0; 2] {
            return self.straight("G1", to, Some(feed));
        }
        let code = if clockwise { "G2" } else { "G3" };
        self.body += &format!("{code} {} {i} {j}{}\n", end.join(" "), feed_word(Some(feed), false)?);
        let angle = |at: &Coordinates| (at[1] - from[1] - centre_mm[1]).atan2(at[0] - from[0] - centre_mm[0]);
        let turn = if clockwise { -1.0 } else { 1.0 };
        let sweep = (turn * (angle(&at) - angle(&from))).rem_euclid(std::f64::consts::TAU);
        let sweep = if at == from { std::f64::consts::TAU } else { sweep };
        let reached = angle(&from) + turn * CHECKED * sweep;
        let radius = centre_mm[0].hypot(centre_mm[1]);
        let checked_mm =
            [from[0] + centre_mm[0] + radius * reached.cos(), from[1] + centre_mm[1] + radius * reached.sin(), at[2]];
        self.at = at;
        self.written.push(Written { at, checked_mm, feed: Some(feed), is_rotary: false });
        Ok(())
    }

    /// Words of a position, and the position as read back.
    fn position(&self, to: &Coordinates) -> std::result::Result<(Vec<String>, Coordinates), ProgramFault> {
        let (mut words, mut at) = (Vec::new(), [0.0; 6]);
        for (slot, letter, scale) in &self.words {
            let mut word = letter.to_string();
            at[*slot] = append_number(&mut word, to[*slot] * scale, self.style.decimals)? / scale;
            words.push(word);
        }
        Ok((words, at))
    }

    /// Lowest and highest position of an axis, mm or rad: in the plan, and at the ends of moves, since a plan may leave out turns without a feed of their own.
    fn range(&self, axis: &motion::Axis, home: &Coordinates, planned: &[f64]) -> [f64; 2] {
        let at = |of: &Coordinates| axis.slot().map(|slot| of[slot]);
        let ends = self.written.iter().filter_map(|written| at(&written.at)).chain(at(home));
        let planned = planned.iter().copied().filter(|_| axis.kind == motion::AxisKind::Linear);
        ends.chain(planned).fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], at| [low.min(at), high.max(at)])
    }

    /// Lowest and highest feed of the linear axes, mm/min.
    fn feeds(&self) -> Option<(f64, f64)> {
        let feeds = self.written.iter().filter(|of| !of.is_rotary).filter_map(|of| of.feed);
        feeds.map(|feed| 60.0 * feed).fold(None, |range, feed| {
            let (low, high) = range.unwrap_or((feed, feed));
            Some((f64::min(low, feed), f64::max(high, feed)))
        })
    }

    /// Compares the moves as read with those written.
    fn check(&self, part: &Part) -> std::result::Result<(), ProgramFault> {
        let moves: Vec<&Move> =
            part.toolpath.moves.iter().filter(|of| of.is_feed() || matches!(of.kind, MoveKind::Rapid)).collect();
        // The approach comes first.
        let moves = moves.get(moves.len().saturating_sub(self.written.len())..).unwrap_or_default();
        if moves.len() != self.written.len() {
            return Err(ProgramFault::Lines { read: moves.len(), wanted: self.written.len() });
        }
        let last_digit = 0.1_f64.powi(i32::try_from(self.style.decimals).unwrap_or(i32::MAX));
        for (read, wanted) in moves.iter().zip(&self.written) {
            let line = read.block as usize + 1;
            let ([x, y, z], [a, b, c]) = (read.end.nominal_mm(), read.end.nominal_rotary_rad());
            let ends = [x, y, z, a, b, c];
            if let Some((slot, ..)) = self.words.iter().find(|(slot, ..)| (ends[*slot] - wanted.at[*slot]).abs() > 1e-9) {
                return Err(ProgramFault::Elsewhere { line, read: ends[*slot], wanted: wanted.at[*slot] });
            }
            // The ends of an arc are rounded, and so lie on two circles.
            for (read, wanted) in read.point_mm(CHECKED).into_iter().zip(wanted.checked_mm) {
                if (read - wanted).abs() > 10.0 * last_digit + 1e-9 {
                    return Err(ProgramFault::Elsewhere { line, read, wanted });
                }
            }
            let feed = match read.feed {
                Some(Feed::Linear { mm_s: feed } | Feed::Angular { rad_s: feed }) => Some(feed),
                _ => None,
            };
            if let Some(wanted) = wanted.feed
                && !feed.is_some_and(|feed| (feed - wanted).abs() <= FEED_SHARE * wanted)
            {
                return Err(ProgramFault::NoFeed { line });
            }
        }
        Ok(())
    }
}

/// F word of a feed in mm/s or rad/s; empty for a rapid.
fn feed_word(feed: Option<f64>, is_rotary: bool) -> std::result::Result<String, ProgramFault> {
    let Some(feed) = feed else { return Ok(String::new()) };
    let per_min = if is_rotary { feed.to_degrees() * 60.0 } else { feed * 60.0 };
    Ok(format!(" F{}", format_number(per_min, FEED_DECIMALS)?))
}

#[cfg(test)]
mod tests {
    use machine::MachineSpec;

    use super::*;
    use crate::output::OutputSettings;

    #[test]
    fn a_program_that_reads_back_as_another_is_refused() {
        let setup = Setup::new(&MachineSpec::builtin("ballscrew").unwrap(), None).unwrap();
        let style = Style::of(&OutputSettings::new(&setup, None, None, None).refit(), None, &setup);
        let mut text =
            Text { style: &style, words: words_of(&setup), body: String::new(), at: [f64::NAN; 6], written: Vec::new() };
        text.body = style.first_block().unwrap();
        text.approach(&[0.0; 6], 5.0).unwrap();
        let at = |x: f64, y: f64| [x, y, 0.0, 0.0, 0.0, 0.0];
        let half = Block::Arc { to: at(6.0, 0.0), centre_mm: [-2.0, 0.0], clockwise: false, feed: 20.0 };
        for block in [Block::Line { to: at(10.0, 0.0), feed: 20.0 }, half, Block::Dwell, Block::Rapid { to: at(0.0, 0.0) }] {
            text.block(&block).unwrap();
        }
        let check = |body: &str| text.check(&read(&style.framed(0, &[], body), &setup, [0.0; 3]).unwrap());
        assert_eq!(check(&text.body), Ok(()));
        for (written, other) in [
            ("G1 X10. F", "G1 X10. Z1. F"),
            ("F1200.", "F1300."),
            ("G0 X0.", "G0 X1."),
            ("J0.", "J1."),
            ("G3 ", "G2 "),
            ("F1200.", "F120."),
        ] {
            assert!(text.body.contains(written), "{}", text.body);
            let edited = text.body.replacen(written, other, 1);
            assert!(check(&edited).is_err(), "{other}");
        }
    }
}
