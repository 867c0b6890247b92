//! The learned reference, written back into the program.
//!
//! Points of the original geometry are moved by the correction that holds at their time: the ends of all moves, and within arcs and
//! long lines as many more as the correction and the arc's shape need. Nothing else of the program changes.

use anyhow::Result;
use gcode::{Edits, FeedMode, Move, MoveKind, Units, format_coordinate, format_number};
use motion::{Trajectory, Vec3, poses_of};
use serde::{Deserialize, Serialize};

use super::Part;
use super::part::{POINT_MM, is_shiftable};

/// How the points of a compensated program carry their time.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum Carrier {
    /// Inverse time: `F` is one over the line's duration in minutes.
    G93,
    /// Units a minute, an `F` on every line.
    G94,
    /// The program's own feed words, unchanged.
    Keep,
}

/// How a program is written.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RefitSettings {
    /// How points carry their time.
    pub carrier: Carrier,
    /// Decimals of a coordinate in mm; inch coordinates get one more.
    pub decimals: usize,
    /// Least time between points within one move, s.
    pub spacing_s: f64,
    /// Largest distance of a line between points from the corrected curve, mm.
    pub chord_tolerance_mm: f64,
}

/// A program with its points moved.
#[derive(Debug)]
pub struct Refitted {
    /// The patches.
    pub edits: Edits,
    /// For every move that was rewritten its index and the ends of the lines in its place, program coordinates, mm.
    pub targets: Vec<(usize, Vec<Vec3>)>,
    /// Largest correction of a written point, mm.
    pub largest_shift_mm: f64,
}

/// Writes the correction `reference − desired` of `part`'s plan into its program.
///
/// Stretches whose correction is zero keep every byte.
///
/// # Errors
/// When a block cannot be split into several lines.
pub fn refit(part: &Part, reference: &Trajectory, settings: &RefitSettings) -> Result<Refitted> {
    let desired = &part.plan.desired;
    let tips = poses_of(reference, desired.kinematics().as_ref())?;
    let shifts: Vec<Vec3> = tips.iter().zip(desired.poses()).map(|(r, d)| r.tip - d.tip).collect();
    let mut out = Refitted { edits: Edits::new(), targets: Vec::new(), largest_shift_mm: 0.0 };
    let pieces: Vec<usize> = (0..part.owners.len()).collect();
    let runs = pieces.chunk_by(|a, b| shiftable(part, *a) && shiftable(part, *b));
    let mut from = 0;
    for run in runs {
        let samples = from..from + part.plan.samples[from..].partition_point(|sample| sample.piece <= run[run.len() - 1]);
        from = samples.end;
        let refed = |piece: &usize| part.owners[*piece].is_some_and(|owner| part.feed_factors[owner] != 1.0);
        if shiftable(part, run[0]) && (samples.clone().any(|k| shifts[k].norm() > 0.0) || run.iter().any(refed)) {
            Stretch { part, shifts: &shifts, settings, samples }.write(run, &mut out)?;
        }
    }
    Ok(out)
}

fn shiftable(part: &Part, piece: usize) -> bool {
    part.owners[piece].is_some_and(|owner| is_shiftable(&part.toolpath.moves[owner]))
}

/// Whether a move is a feed move to where the tool is already.
fn leads_nowhere(step: &Move) -> bool {
    matches!(step.kind, MoveKind::Line) && is_shiftable(step) && step.length_mm().is_some_and(|length| length <= POINT_MM)
}

/// Consecutive moves that may be compensated.
struct Stretch<'a> {
    part: &'a Part,
    shifts: &'a [Vec3],
    settings: &'a RefitSettings,
    /// Samples of the plan that belong to it.
    samples: std::ops::Range<usize>,
}

/// A point to be written.
struct Target {
    point: Vec3,
    time_s: f64,
}

impl Stretch<'_> {
    fn write(&self, run: &[usize], out: &mut Refitted) -> Result<()> {
        let part = self.part;
        let first = self.owner(run[0]);
        let Some(last) = run.last().map(|piece| self.owner(*piece)) else { return Ok(()) };
        let mut writer = Writer::new(part, self.settings, &part.toolpath.moves[first]);
        let mut before_s = self.time_at(part.plan.piece_ends_mm[run[0]].min(self.start_mm()));
        for piece in run {
            let owner = self.owner(*piece);
            let step = &part.toolpath.moves[owner];
            let targets = self.targets(*piece, step);
            let mut lines = Vec::with_capacity(targets.len());
            for target in &targets {
                lines.push(writer.line(owner, lines.is_empty(), target, before_s)?);
                before_s = target.time_s;
            }
            out.edits.replace_motion(&part.program, step.block as usize, &lines)?;
            out.targets.push((owner, targets.iter().map(|target| target.point).collect()));
            // A line that leads nowhere has no piece of the path; left as it is, it would lead back to the point as programmed.
            if let Some(end) = targets.last() {
                for still in
                    (owner + 1..part.toolpath.moves.len()).take_while(|index| leads_nowhere(&part.toolpath.moves[*index]))
                {
                    let line = writer.line(still, true, end, before_s)?;
                    out.edits.replace_motion(&part.program, part.toolpath.moves[still].block as usize, &[line])?;
                    out.targets.push((still, vec![end.point]));
                }
            }
        }
        let largest = self.samples.clone().map(|k| self.shifts[k].norm()).fold(0.0, f64::max);
        out.largest_shift_mm = out.largest_shift_mm.max(largest);
        if let Some(line) = writer.restore(&part.toolpath.moves[last])? {
            out.edits.insert_after(&part.program, part.toolpath.moves[last].block as usize, &[line])?;
        }
        self.restore_motion_code(last, out);
        Ok(())
    }

    /// A move after the stretch that relies on a motion code which the stretch no longer leaves behind gets it stated.
    fn restore_motion_code(&self, last: usize, out: &mut Refitted) {
        let moves = &self.part.toolpath.moves;
        let Some(next) = moves.get(last + 1) else { return };
        if next.explicit_motion || is_shiftable(next) {
            return;
        }
        let code = match (next.kind, moves[last].kind) {
            (MoveKind::Arc(arc), MoveKind::Arc(_)) => {
                if arc.sweep > 0.0 {
                    "G3"
                } else {
                    "G2"
                }
            }
            _ => return,
        };
        let words = self.part.program.block_words(next.block as usize);
        if let Some(word) = words.iter().find(|word| gcode::is_motion_word(word)) {
            out.edits.replace(gcode::Span { start: word.span.start, end: word.span.start }, code);
        }
    }

    fn owner(&self, piece: usize) -> usize {
        // Checked by `shiftable` for every piece of a run.
        self.part.owners[piece].unwrap_or_default()
    }

    fn start_mm(&self) -> f64 {
        self.samples.start.checked_sub(1).map_or(0.0, |k| self.part.plan.samples[k].position_mm)
    }

    /// Time at which the plan passes an arc length, s.
    fn time_at(&self, position_mm: f64) -> f64 {
        let samples = &self.part.plan.samples;
        let period = self.part.plan.desired.trajectory().period_s();
        let after = samples.partition_point(|sample| sample.position_mm < position_mm);
        let Some(before) = after.checked_sub(1) else { return 0.0 };
        let Some(next) = samples.get(after) else { return before as f64 * period };
        let share = (position_mm - samples[before].position_mm) / (next.position_mm - samples[before].position_mm);
        (before as f64 + share) * period
    }

    /// The correction at a time, mm.
    fn shift_at(&self, time_s: f64) -> Vec3 {
        let index = time_s / self.part.plan.desired.trajectory().period_s();
        let last = self.shifts.len() - 1;
        let before = (index.floor() as usize).min(last);
        let after = (before + 1).min(last);
        self.shifts[before].lerp(&self.shifts[after], index - before as f64)
    }

    /// Ends of the lines that replace a move.
    fn targets(&self, piece: usize, step: &Move) -> Vec<Target> {
        let plan = &self.part.plan;
        let period = plan.desired.trajectory().period_s();
        let (from_mm, to_mm) = (piece.checked_sub(1).map_or(0.0, |p| plan.piece_ends_mm[p]), plan.piece_ends_mm[piece]);
        let (from_s, to_s) = (self.time_at(from_mm), self.time_at(to_mm));
        let length = (to_mm - from_mm).max(1e-12);
        // Points of the original geometry, at the share of its length that the plan has passed.
        let corrected = |time_s: f64| {
            let index = (time_s / period) as usize;
            let samples = &plan.samples;
            let (a, b) = (samples[index.min(samples.len() - 1)], samples[(index + 1).min(samples.len() - 1)]);
            let position = a.position_mm + (b.position_mm - a.position_mm) * (time_s / period - index as f64);
            let share = ((position - from_mm) / length).clamp(0.0, 1.0);
            Vec3::from(step.point_mm(share)) + self.shift_at(time_s)
        };
        let end = Target { point: Vec3::from(step.end.nominal_mm()) + self.shift_at(to_s), time_s: to_s };
        let mut targets = Vec::new();
        let mut start = (from_s, Vec3::from(step.start.nominal_mm()) + self.shift_at(from_s));
        let steps = ((to_s - from_s) / self.settings.spacing_s).floor() as usize;
        let mut held = 0;
        for i in 1..steps {
            // The line so far reaches to point `i`; if it leaves the curve in between, the last good point is written.
            let at = |i: usize| from_s + (to_s - from_s) * i as f64 / steps as f64;
            let candidate = corrected(at(i + 1).min(to_s));
            let fits = (held + 1..=i).all(|j| off_line(corrected(at(j)), start.1, candidate) <= self.settings.chord_tolerance_mm)
                && i - held < MOST_POINTS;
            if !fits {
                let point = corrected(at(i));
                targets.push(Target { point, time_s: at(i) });
                start = (at(i), point);
                held = i;
            }
        }
        targets.push(end);
        targets
    }
}

/// Samples over which one line may reach: bounds the work of checking it.
const MOST_POINTS: usize = 64;

/// Distance of a point from the line between two others, mm.
fn off_line(point: Vec3, start: Vec3, end: Vec3) -> f64 {
    let chord = end - start;
    let length = chord.norm();
    if length < 1e-12 { (point - start).norm() } else { (point - start).cross(&chord).norm() / length }
}

/// Writes lines in the program's own units and modes.
struct Writer<'a> {
    part: &'a Part,
    settings: &'a RefitSettings,
    /// Where the written lines have led, program coordinates as rounded, mm.
    written: Vec3,
    mode: FeedMode,
    g1_active: bool,
    /// Feed word in force where feeds are changed.
    feed: Option<f64>,
}

impl<'a> Writer<'a> {
    fn new(part: &'a Part, settings: &'a RefitSettings, first: &Move) -> Self {
        let modal = part.toolpath.modal(first);
        Self {
            part,
            settings,
            written: Vec3::from(first.start.nominal_mm()),
            mode: modal.feed_mode,
            g1_active: false,
            feed: first.feed_word,
        }
    }

    fn line(&mut self, owner: usize, first_of_block: bool, target: &Target, before_s: f64) -> Result<String> {
        let (step, factor) = (&self.part.toolpath.moves[owner], self.part.feed_factors[owner]);
        let modal = self.part.toolpath.modal(step);
        let mut text = String::new();
        let wanted = match self.settings.carrier {
            Carrier::G93 => FeedMode::InverseTime,
            Carrier::G94 => FeedMode::PerMinute,
            Carrier::Keep => self.mode,
        };
        if wanted != self.mode {
            text.push_str(if wanted == FeedMode::InverseTime { "G93" } else { "G94" });
            self.mode = wanted;
        }
        if !self.g1_active || (first_of_block && step.explicit_motion) {
            text.push_str("G1");
            self.g1_active = true;
        }
        let length_before = self.written;
        let mut moves = false;
        let decimals = self.settings.decimals + usize::from(modal.units == Units::Inch);
        for axis in 0..3 {
            let Some(value) = self.part.toolpath.programmed(step, axis, self.written[axis], target.point[axis]) else { continue };
            let number = format_coordinate(value, modal.units, decimals)?;
            // What a control reads back, so that incremental programs gather no rounding.
            let read: f64 = number.parse::<f64>().unwrap_or_default() * modal.units.mm();
            let reached = self.written[axis]
                + (read - self.part.toolpath.programmed(step, axis, self.written[axis], self.written[axis]).unwrap_or_default());
            // A line needs an axis word, or it is no move.
            let last_chance = !moves && axis == 2;
            if (reached - self.written[axis]).abs() > 0.0 || (axis == 0 && self.settings.carrier != Carrier::Keep) || last_chance
            {
                text.push(['X', 'Y', 'Z'][axis]);
                text.push_str(&number);
                self.written[axis] = reached;
                moves = true;
            }
        }
        let duration = (target.time_s - before_s).max(1e-5);
        match self.settings.carrier {
            Carrier::G93 => text.push_str(&format!("F{}", format_number(60.0 / duration, 4)?)),
            Carrier::G94 => {
                let feed = (self.written - length_before).norm().max(1e-6) / duration * 60.0 / modal.units.mm();
                text.push_str(&format!("F{}", format_number(feed.max(1e-4), 4)?));
            }
            Carrier::Keep => {
                let wanted = step.feed_word.map(|feed| feed * factor);
                match step.words(&self.part.program).feed {
                    Some(word) if first_of_block && factor == 1.0 => {
                        let span = self.part.program.words()[word].span;
                        text.push_str(&String::from_utf8_lossy(self.part.program.text(span)));
                    }
                    _ if wanted != self.feed => {
                        if let Some(feed) = wanted {
                            text.push_str(&format!("F{}", format_number(feed, 4)?));
                        }
                    }
                    _ => {}
                }
                self.feed = wanted;
            }
        }
        Ok(text)
    }

    /// The line after a stretch that puts the program's own feed back.
    fn restore(&self, last: &Move) -> Result<Option<String>> {
        if self.settings.carrier == Carrier::Keep {
            let changed = self.feed != last.feed_word;
            let feed = last.feed_word.filter(|_| changed).map(|feed| format_number(feed, 6)).transpose()?;
            return Ok(feed.map(|feed| format!("F{feed}")));
        }
        let modal = self.part.toolpath.modal(last);
        let mode = match modal.feed_mode {
            FeedMode::InverseTime => "G93",
            FeedMode::PerMinute => "G94",
            FeedMode::PerRevolution => "G95",
        };
        let feed = match (last.feed_word, modal.feed_mode) {
            // Inverse time holds for one line only.
            (Some(word), FeedMode::PerMinute | FeedMode::PerRevolution) => format!("F{}", format_number(word, 6)?),
            _ => String::new(),
        };
        let text = if modal.feed_mode == self.mode { feed } else { format!("{mode}{feed}") };
        Ok((!text.is_empty()).then_some(text))
    }
}
