//! The learned reference, written back into the program.
//!
//! Points of the original geometry are moved by the correction that holds at their time: the ends of all moves, and within arcs and
//! long lines as many more as the correction and the arc's shape need. Nothing else of the program changes.

use anyhow::Result;
use gcode::{Dialect, Edits, FeedMode, Move, MoveKind, PathMode, Span, Units, format_angle, format_coordinate, format_number};
use motion::{Trajectory, Vec6};
use serde::{Deserialize, Serialize};

use super::Part;
use super::part::{POINT_MM, coordinates, stated};

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
    /// Path tolerance that a stretch states, mm, where the control knows one; `None` keeps the program's own.
    pub path_tolerance_mm: Option<f64>,
}

/// A program with its points moved.
#[derive(Debug)]
pub struct Refitted {
    /// The patches.
    pub edits: Edits,
    /// For every move that was rewritten its index and the ends of the lines in its place, program coordinates: mm, rad.
    pub targets: Vec<(usize, Vec<Vec6>)>,
    /// Largest correction of the tool tip, mm.
    pub largest_shift_mm: f64,
}

/// Writes the correction `reference − desired` of `part`'s plan into its program.
///
/// Stretches whose correction is zero keep every byte.
///
/// # Errors
/// When a block cannot be split into several lines.
pub fn refit(part: &Part, reference: &Trajectory, settings: &RefitSettings) -> Result<Refitted> {
    let shifts = shifts(part, reference)?;
    let tips = part.plan.desired.tips_of(reference)?;
    let mut out = Refitted { edits: Edits::new(), targets: Vec::new(), largest_shift_mm: 0.0 };
    let pieces: Vec<usize> = (0..part.owners.len()).collect();
    let runs = pieces.chunk_by(|a, b| shiftable(part, *a) && shiftable(part, *b));
    let mut from = 0;
    for run in runs {
        let samples = from..from + part.plan.samples[from..].partition_point(|sample| sample.piece <= run[run.len() - 1]);
        from = samples.end;
        let refed = |piece: &usize| part.owners[*piece].is_some_and(|owner| part.feed_factors[owner] != 1.0);
        if shiftable(part, run[0]) && (samples.clone().any(|k| shifts[k] != Vec6::zeros()) || run.iter().any(refed)) {
            let largest = samples.clone().map(|k| (tips[k] - part.plan.desired.poses()[k].tip).norm()).fold(0.0, f64::max);
            out.largest_shift_mm = out.largest_shift_mm.max(largest);
            Stretch { part, shifts: &shifts, settings }.write(run, &mut out)?;
        }
    }
    Ok(out)
}

/// The correction of every sample, in the coordinates of the words of its move: mm, rad.
fn shifts(part: &Part, reference: &Trajectory) -> Result<Vec<Vec6>> {
    let desired = &part.plan.desired;
    let kinematics = desired.kinematics().as_ref();
    if !kinematics.turns() {
        let tips = desired.tips_of(reference)?;
        let moved = tips.iter().zip(desired.poses()).map(|(tip, pose)| tip - pose.tip);
        return Ok(moved.map(|d| Vec6::new(d.x, d.y, d.z, 0.0, 0.0, 0.0)).collect());
    }
    reference.check_matches(desired.trajectory())?;
    let joints = |of: &Trajectory, k: usize| of.at(k).collect::<Vec<f64>>();
    Ok((0..reference.len())
        .map(|k| {
            let words = part.move_at(k).map_or(part.words, |index| part.words_of(&part.toolpath.moves[index]));
            let stated = |of: &Trajectory| stated(&joints(of, k), kinematics, words);
            stated(reference) - stated(desired.trajectory())
        })
        .collect())
}

fn shiftable(part: &Part, piece: usize) -> bool {
    part.owners[piece].is_some_and(|owner| part.is_shiftable(&part.toolpath.moves[owner]))
}

/// Whether a move is a feed move to where the tool is already.
fn leads_nowhere(part: &Part, step: &Move) -> bool {
    let way = coordinates(&step.end) - coordinates(&step.start);
    matches!(step.kind, MoveKind::Line) && part.is_shiftable(step) && way.norm() <= POINT_MM
}

/// Consecutive moves that may be compensated.
struct Stretch<'a> {
    part: &'a Part,
    shifts: &'a [Vec6],
    settings: &'a RefitSettings,
}

/// A point to be written, program coordinates: mm, rad.
struct Target {
    point: Vec6,
    time_s: f64,
    /// Share of the move's way that has been gone.
    way: f64,
}

impl Stretch<'_> {
    fn write(&self, run: &[usize], out: &mut Refitted) -> Result<()> {
        let part = self.part;
        let first = self.owner(run[0]);
        let Some(last) = run.last().map(|piece| self.owner(*piece)) else { return Ok(()) };
        let mut writer = Writer::new(part, self.settings, &part.toolpath.moves[first]);
        let mut own_path = None;
        for piece in run {
            let owner = self.owner(*piece);
            let step = &part.toolpath.moves[owner];
            let path = part.toolpath.modal(step).path;
            if own_path != Some(path) {
                if let Some([stated, _]) = self.tolerance(step)? {
                    out.edits.insert_before(&part.program, step.block as usize, &[stated])?;
                }
                own_path = Some(path);
            }
            let mut before_s = self.departure(self.start_of(*piece));
            let targets = self.targets(*piece, step);
            let mut lines = Vec::with_capacity(targets.len());
            let mut way = 0.0;
            for target in &targets {
                lines.push(writer.line(owner, lines.is_empty(), target, before_s, target.way - way)?);
                (before_s, way) = (target.time_s, target.way);
            }
            out.edits.replace_motion(&part.program, step.block as usize, &lines)?;
            self.drop_feed_modes(step.block as usize, out);
            out.targets.push((owner, targets.iter().map(|target| target.point).collect()));
            // A line that leads nowhere has no piece of the path; left as it is, it would lead back to the point as programmed.
            if let Some(end) = targets.last() {
                for still in
                    (owner + 1..part.toolpath.moves.len()).take_while(|index| leads_nowhere(part, &part.toolpath.moves[*index]))
                {
                    let line = writer.line(still, true, end, before_s, 1.0)?;
                    out.edits.replace_motion(&part.program, part.toolpath.moves[still].block as usize, &[line])?;
                    out.targets.push((still, vec![end.point]));
                }
            }
        }
        let own_tolerance = self.tolerance(&part.toolpath.moves[last])?.map(|[_, own]| own).filter(|own| !own.is_empty());
        let after: Vec<String> = writer.restore(&part.toolpath.moves[last])?.into_iter().chain(own_tolerance).collect();
        out.edits.insert_after(&part.program, part.toolpath.moves[last].block as usize, &after)?;
        self.restore_motion_code(last, out);
        Ok(())
    }

    /// Takes away a block's own feed mode where its lines state another.
    fn drop_feed_modes(&self, block: usize, out: &mut Refitted) {
        let others: &[f64] = match self.settings.carrier {
            Carrier::G93 => &[94.0, 95.0],
            Carrier::G94 => &[93.0, 95.0],
            Carrier::Keep => &[],
        };
        let words = self.part.program.block_words(block).iter();
        for word in words.filter(|word| word.is(b'G') && others.contains(&word.value)) {
            let blank = Span { start: word.span.end, end: word.span.end + 1 };
            let end = if self.part.program.text(blank) == b" " { blank.end } else { word.span.end };
            out.edits.replace(Span { start: word.span.start, end }, "");
        }
    }

    /// The line that states the path tolerance before a move, and the one that puts the program's own back after it; `None` where the
    /// program's own will do. Without merging: a control that merges points of nearly straight lines loses their times.
    fn tolerance(&self, step: &Move) -> Result<Option<[String; 2]>> {
        let Some(wanted_mm) = self.settings.path_tolerance_mm.filter(|_| self.part.options.dialect == Dialect::LinuxCnc) else {
            return Ok(None);
        };
        let modal = self.part.toolpath.modal(step);
        let length = |mm: f64| format_number(mm / modal.units.mm(), 6);
        let own = match modal.path {
            PathMode::Continuous { tolerance_mm: Some(own), merge_mm: Some(0.0) } if own <= wanted_mm => return Ok(None),
            PathMode::Default => String::new(),
            PathMode::ExactPath => "G61".to_owned(),
            PathMode::ExactStop => "G61.1".to_owned(),
            PathMode::Continuous { tolerance_mm, merge_mm } => {
                let mut own = "G64".to_owned();
                for (letter, value) in [('P', tolerance_mm), ('Q', merge_mm)] {
                    if let Some(value) = value {
                        own.push_str(&format!("{letter}{}", length(value)?));
                    }
                }
                own
            }
        };
        Ok(Some([format!("G64P{}Q0", length(wanted_mm)?), own]))
    }

    /// A move after the stretch that relies on a motion code which the stretch no longer leaves behind gets it stated.
    fn restore_motion_code(&self, last: usize, out: &mut Refitted) {
        let moves = &self.part.toolpath.moves;
        let Some(next) = moves.get(last + 1) else { return };
        if next.explicit_motion || self.part.is_shiftable(next) {
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

    /// Arc length at which a piece begins, mm.
    fn start_of(&self, piece: usize) -> f64 {
        piece.checked_sub(1).map_or(0.0, |before| self.part.plan.piece_ends_mm[before])
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

    /// Time at which the plan leaves an arc length, s: the end of the rest where it rests there.
    fn departure(&self, position_mm: f64) -> f64 {
        let still = self.part.plan.samples.partition_point(|sample| sample.position_mm <= position_mm + POINT_MM);
        let period = self.part.plan.desired.trajectory().period_s();
        self.time_at(position_mm).max(still.saturating_sub(1) as f64 * period)
    }

    /// The correction at a time, mm and rad.
    fn shift_at(&self, time_s: f64) -> Vec6 {
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
        let (from_mm, to_mm) = (self.start_of(piece), plan.piece_ends_mm[piece]);
        let (from_s, to_s) = (self.departure(from_mm), self.time_at(to_mm));
        let length = (to_mm - from_mm).max(1e-12);
        // Points of the original geometry, at the share of its length that the plan has passed.
        let way_at = |time_s: f64| {
            let index = (time_s / period) as usize;
            let samples = &plan.samples;
            let (a, b) = (samples[index.min(samples.len() - 1)], samples[(index + 1).min(samples.len() - 1)]);
            let position = a.position_mm + (b.position_mm - a.position_mm) * (time_s / period - index as f64);
            ((position - from_mm) / length).clamp(0.0, 1.0)
        };
        let corrected = |time_s: f64| {
            let share = way_at(time_s);
            let [x, y, z] = step.point_mm(share);
            let turned = coordinates(&step.start).lerp(&coordinates(&step.end), share);
            Vec6::new(x, y, z, turned[3], turned[4], turned[5]) + self.shift_at(time_s)
        };
        let end = Target { point: coordinates(&step.end) + self.shift_at(to_s), time_s: to_s, way: 1.0 };
        let mut targets = Vec::new();
        let mut start = (from_s, coordinates(&step.start) + self.shift_at(from_s));
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
                targets.push(Target { point, time_s: at(i), way: way_at(at(i)) });
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

/// Lever at which a rotary axis's distance from a line counts, mm.
const LEVER_MM: f64 = 100.0;

/// Distance of a point from the line between two others, mm.
fn off_line(point: Vec6, start: Vec6, end: Vec6) -> f64 {
    let at_lever = Vec6::new(1.0, 1.0, 1.0, LEVER_MM, LEVER_MM, LEVER_MM);
    let (chord, off) = ((end - start).component_mul(&at_lever), (point - start).component_mul(&at_lever));
    let length_squared = chord.norm_squared();
    if length_squared < 1e-24 { off.norm() } else { (off - chord * (off.dot(&chord) / length_squared)).norm() }
}

/// Which of A, B, C a part's machine turns.
fn turning_axes(part: &Part) -> [bool; 3] {
    let kinematics = part.plan.desired.kinematics();
    ["a", "b", "c"].map(|name| kinematics.turns() && kinematics.axes().iter().any(|axis| axis.name == name))
}

/// Writes lines in the program's own units and modes.
struct Writer<'a> {
    part: &'a Part,
    settings: &'a RefitSettings,
    /// Where the written lines have led, program coordinates as rounded: mm, rad.
    written: Vec6,
    /// Which of A, B, C the machine turns.
    turns: [bool; 3],
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
            written: coordinates(&first.start),
            turns: turning_axes(part),
            mode: modal.feed_mode,
            g1_active: false,
            feed: first.feed_word,
        }
    }

    /// The line to `target`, which takes this `share` of its move's way.
    fn line(&mut self, owner: usize, first_of_block: bool, target: &Target, before_s: f64, share: f64) -> Result<String> {
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
        let before = self.written;
        let mut moves = false;
        let decimals = self.settings.decimals + usize::from(modal.units == Units::Inch);
        for axis in (0..6).filter(|axis| *axis < 3 || self.turns[axis - 3]) {
            let Some(value) = self.part.toolpath.programmed(step, axis, self.written[axis], target.point[axis]) else { continue };
            let number = match axis {
                0..3 => format_coordinate(value, modal.units, decimals)?,
                _ => format_angle(value, self.settings.decimals)?,
            };
            // What a control reads back, so that incremental programs gather no rounding.
            let read: f64 = number.parse::<f64>().unwrap_or_default();
            let read = if axis < 3 { read * modal.units.mm() } else { read.to_radians() };
            let reached = self.written[axis]
                + (read - self.part.toolpath.programmed(step, axis, self.written[axis], self.written[axis]).unwrap_or_default());
            // A line needs an axis word, or it is no move.
            let last_chance = !moves && axis == 2;
            if (reached - self.written[axis]).abs() > 0.0 || (axis == 0 && self.settings.carrier != Carrier::Keep) || last_chance
            {
                text.push(['X', 'Y', 'Z', 'A', 'B', 'C'][axis]);
                text.push_str(&number);
                self.written[axis] = reached;
                moves = true;
            }
        }
        let duration = (target.time_s - before_s).max(1e-5);
        match self.settings.carrier {
            Carrier::G93 => text.push_str(&format!("F{}", format_number(60.0 / duration, 4)?)),
            Carrier::G94 => {
                // F is the speed of the linear axes; where none of them moves, of the rotary ones in degrees.
                let way = self.written - before;
                let length = way.fixed_rows::<3>(0).norm() / modal.units.mm();
                let length = if length > 0.0 { length } else { way.fixed_rows::<3>(3).norm().to_degrees() };
                let feed = length.max(1e-6) / duration * 60.0;
                text.push_str(&format!("F{}", format_number(feed.max(1e-4), 4)?));
            }
            // Inverse time holds for one line: the parts of a move share its time. One that only the correction moves gets a hundredth.
            Carrier::Keep if self.mode == FeedMode::InverseTime && share < 1.0 => {
                let Some(word) = step.feed_word else { anyhow::bail!("a move in inverse time has no F") };
                text.push_str(&format!("F{}", format_number(word * factor / share.max(0.01), 4)?));
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
