//! Blocks of a compensated program, in its own units.

use gcode::{
    ANGLE_INCREMENT, DecimalPoint, Distance, FeedMode, Modal, Move, Units, append_number, format_number, is_integer_program,
    length_increment,
};
use motion::Vec6;

use super::arc::ElementArc;
use super::element::{Element, Target};
use super::notation::Notation;
use super::settings::{INCREMENT_DECIMALS, RefitSettings, SlowStop, TimeEncoding};
use crate::error::{Error, Result};
use crate::part::{Part, coordinates};

/// Axes that lines may state: those of the part's machine that its program names.
pub(super) fn stated_axes(part: &Part) -> Vec<usize> {
    let kinematics = part.plan.desired.kinematics();
    let turns = |name: &str| kinematics.has_rotary_axes() && kinematics.axes().iter().any(|axis| axis.name == name);
    let named = part.named_axes();
    (0..6).filter(|axis| named[*axis] && (*axis < 3 || turns(["a", "b", "c"][*axis - 3]))).collect()
}

/// Largest inverse time of Fanuc's controls and its step, 1/min (B-62764EN, G93). A shorter line takes 6 ms.
const FANUC_INVERSE_TIME: f64 = 9999.999;
const FANUC_INVERSE_TIME_STEP: f64 = 1e-3;

/// Whether lines state whole increments, without a decimal point, as all coordinates of the program do.
fn counts_increments(part: &Part) -> bool {
    part.options.decimal_point == DecimalPoint::LeastIncrement
        && part.section.as_ref().map_or_else(|| is_integer_program(&part.program), |section| section.whole.is_integer)
}

/// Least decimals of written coordinates in mm.
pub(super) fn decimals(part: &Part, settings: &RefitSettings) -> usize {
    let own = settings.increment_decimals.map_or(settings.decimals, |decimals| decimals.min(settings.decimals));
    if counts_increments(part) { INCREMENT_DECIMALS } else { own }
}

/// Appends a word whose `value` is a whole number of increments. Returns the value that a control reads from it.
fn append_increments(text: &mut String, letter: char, value: f64, increment: f64) -> Result<f64> {
    text.push(letter);
    let count = append_number(text, value / increment, 0)?;
    text.truncate(text.trim_end_matches('.').len());
    Ok(count * increment)
}

/// Distance from its programmed end up to which an axis counts as not shifted, mm or rad: the rounding of sums of numbers.
const UNSHIFTED: f64 = 1e-9;
/// Least share of a line in the time of its move: none has a length of zero.
const LEAST_SHARE: f64 = 1e-6;
/// G codes that state or cancel a motion.
const MOTION_GROUP: [f64; 5] = [0.0, 1.0, 2.0, 3.0, 80.0];
/// Decimals that no program exceeds.
const PROGRAM_DECIMALS: usize = 8;

/// Usual largest length of a line, bytes.
const LINE: usize = 96;

/// Writes lines in the program's own units and modes.
pub(super) struct Writer<'a> {
    part: &'a Part,
    settings: &'a RefitSettings,
    notation: Notation,
    /// End of the last written line in program coordinates as rounded, mm and rad.
    written: Vec6,
    /// Axes that lines may state.
    axes: &'a [usize],
    /// Whether lines state whole increments.
    counts: bool,
    mode: FeedMode,
    /// Motion code in force; `None` before the first line.
    code: Option<&'static str>,
    /// Feed word in force where feeds change.
    feed: Option<f64>,
}

impl<'a> Writer<'a> {
    pub(super) fn new(part: &'a Part, settings: &'a RefitSettings, axes: &'a [usize], first: &Move) -> Self {
        let modal = part.toolpath.modal(first);
        let notation = Notation::of(&part.program);
        Self {
            part,
            settings,
            notation,
            written: coordinates(&first.start),
            axes,
            counts: counts_increments(part),
            mode: modal.feed_mode,
            code: None,
            // In dialogue the feed in force may be that of the tool call: the first line states it.
            feed: first.feed_word.filter(|_| notation == Notation::Rs274),
        }
    }

    /// Share of each line in the length of the lines to `targets`, at least [`LEAST_SHARE`].
    pub(super) fn shares(&self, targets: &[Target]) -> Vec<f64> {
        let starts = std::iter::once(&self.written).chain(targets.iter().map(|target| &target.element.point));
        let lengths: Vec<f64> = starts.zip(targets).map(|(start, target)| target.element.length(*start)).collect();
        let total: f64 = lengths.iter().sum();
        lengths.iter().map(|length| if total > 0.0 { (length / total).max(LEAST_SHARE) } else { 1.0 }).collect()
    }

    /// Targets of a move whose lines share its inverse time, without those of lines so short that their feed would be beyond the limit of the control: the
    /// next line covers them.
    pub(super) fn merged(&self, owner: usize, targets: Vec<Target>) -> Vec<Target> {
        let step = &self.part.toolpath.moves[owner];
        let is_timed = self.mode == FeedMode::InverseTime && self.settings.encoding == TimeEncoding::Keep;
        let Some(word) = step.feed_word.filter(|_| is_timed && self.part.counts_by_radius()) else { return targets };
        let starts = std::iter::once(self.written).chain(targets.iter().map(|target| target.element.point));
        let lengths: Vec<f64> = starts.zip(&targets).map(|(start, target)| target.element.length(start)).collect();
        let factor = self.part.feed_factors[owner];
        let least = word * factor / FANUC_INVERSE_TIME.max(word) * lengths.iter().sum::<f64>();
        let mut merged: Vec<Target> = Vec::with_capacity(targets.len());
        let mut covered = 0.0;
        for (target, length) in targets.iter().zip(lengths) {
            covered += length;
            if covered >= least {
                merged.push(*target);
                covered = 0.0;
            }
        }
        // The end of the move stays its end.
        match (merged.last_mut(), targets.last()) {
            (Some(last), Some(end)) => *last = *end,
            (None, Some(end)) => merged.push(*end),
            _ => {}
        }
        merged
    }

    /// Notes the blocks between two moves of the segment: a motion code in one of them replaces that of the last line.
    pub(super) fn pass_blocks(&mut self, last: usize, next: usize) {
        let block = |index: usize| self.part.toolpath.moves[index].block as usize;
        let mut words = (block(last) + 1..block(next)).flat_map(|block| self.part.program.block_words(block));
        if words.any(|word| word.is(b'G') && MOTION_GROUP.contains(&word.value)) {
            self.code = None;
        }
    }

    /// Line to `target`, which covers the share `share` of its move's length.
    pub(super) fn line(
        &mut self,
        owner: usize,
        first_of_block: bool,
        target: &Target,
        before_s: f64,
        share: f64,
    ) -> Result<String> {
        let step = &self.part.toolpath.moves[owner];
        let mut text = String::with_capacity(LINE);
        self.append_codes(&mut text, step, &target.element, first_of_block);
        let start = self.written;
        self.append_coordinates(&mut text, step, &target.element)?;
        if let Some(arc) = &target.element.arc {
            self.append_centre(&mut text, step, arc, start)?;
        }
        if first_of_block {
            self.notation.append_compensation_off(&mut text, &self.part.program, step);
        }
        let duration_s = target.slow_s.unwrap_or((target.time_s - before_s).max(1e-5) / self.unevenness(before_s, target.time_s));
        let per_minute = || self.length(step, &target.element, &(self.written - start)) / duration_s * 60.0;
        match (self.settings.encoding, target.slow_s) {
            (TimeEncoding::G93, _) => self.notation.append_feed(&mut text, self.inverse_time(60.0 / duration_s, 0.0))?,
            (TimeEncoding::G94, None) => self.notation.append_feed(&mut text, per_minute().max(1e-4))?,
            (TimeEncoding::G94 | TimeEncoding::Keep, Some(_)) => {
                let feed = self.slow_feed(owner, per_minute());
                self.notation.append_feed(&mut text, feed)?;
                self.feed = Some(feed);
            }
            (TimeEncoding::Keep, None) => self.append_own_feed(&mut text, owner, first_of_block, share)?,
        }
        Ok(text)
    }

    /// Largest speed of the plan between two times, over its mean: lines state the speed that the plan reaches in them. With the mean the
    /// control would take longer wherever it speeds up or brakes.
    fn unevenness(&self, from_s: f64, to_s: f64) -> f64 {
        let samples = &self.part.plan.samples;
        let index = |time_s: f64| time_s / self.part.plan.desired.trajectory().period_s();
        let first = (index(from_s).floor() as usize).min(samples.len() - 1);
        // A move of less than a point may end before its start is left.
        let last = (index(to_s).ceil() as usize).clamp(first, samples.len() - 1);
        let steps = samples[first..=last].windows(2).map(|pair| pair[1].position_mm - pair[0].position_mm);
        let mean = (samples[last].position_mm - samples[first].position_mm) / (last - first).max(1) as f64;
        if mean > 0.0 { steps.fold(mean, f64::max) / mean } else { 1.0 }
    }

    /// Writes the codes of feed mode and motion where they change.
    fn append_codes(&mut self, text: &mut String, step: &Move, element: &Element, first_of_block: bool) {
        if self.notation != Notation::Rs274 {
            text.push('L');
            return;
        }
        let (wanted, code) = match self.settings.encoding {
            TimeEncoding::G93 => (FeedMode::InverseTime, "G93"),
            TimeEncoding::G94 => (FeedMode::PerMinute, "G94"),
            // The program's own codes stay where they are.
            TimeEncoding::Keep => (self.part.toolpath.modal(step).feed_mode, ""),
        };
        if wanted != self.mode {
            text.push_str(code);
            (self.mode, self.feed) = (wanted, None);
        }
        let is_mirrored = self.part.toolpath.modal(step).rotation.is_some_and(|rotation| rotation.is_mirrored());
        let motion = element.arc.map_or("G1", |arc| arc.code(is_mirrored));
        if self.code != Some(motion) || (first_of_block && step.explicit_motion) {
            text.push_str(motion);
            self.code = Some(motion);
        }
    }

    /// Motion code in force after the last line.
    pub(super) fn code(&self) -> Option<&'static str> {
        self.code
    }

    /// Decimals of a coordinate.
    fn decimals(&self, modal: &Modal) -> usize {
        let own = match (modal.distance, self.settings.increment_decimals) {
            (Distance::Incremental, Some(decimals)) => decimals,
            _ => self.settings.decimals,
        };
        own + usize::from(modal.units == Units::Inch)
    }

    /// Writes the words of the axes that move, at least one.
    fn append_coordinates(&mut self, text: &mut String, step: &Move, target: &Element) -> Result<()> {
        let (toolpath, modal) = (&self.part.toolpath, self.part.toolpath.modal(step));
        let (units, start) = (modal.units, self.written);
        let mut moves = false;
        let own = self.decimals(modal);
        // In program words, which a rotation turns.
        let words = |point: Vec6| Vec6::from(toolpath.programmed(step, start.into(), point.into()));
        let (wanted, present, end) = (words(target.point), words(start), words(coordinates(&step.end)));
        let mut displacement = Vec6::zeros();
        // A line without an axis word is not a move.
        let last = self.axes.iter().rev().find(|axis| **axis < 3).or(self.axes.last()).copied();
        for (index, &axis) in self.axes.iter().enumerate() {
            let (at, value) = (start[axis], wanted[axis]);
            let before_word = text.len();
            let letter = ['X', 'Y', 'Z', 'A', 'B', 'C'][axis];
            // An end that is not shifted keeps all decimals of the program: the next move may be left alone.
            let decimals = if (value - end[axis]).abs() < UNSHIFTED { own.max(PROGRAM_DECIMALS) } else { own };
            // The value as the control reads it, so that incremental programs do not accumulate rounding errors.
            let read = match axis {
                0..3 if self.counts => append_increments(text, letter, value / units.mm(), length_increment(units))? * units.mm(),
                _ if self.counts => append_increments(text, letter, value.to_degrees(), ANGLE_INCREMENT)?.to_radians(),
                0..3 => self.notation.append_coordinate(text, letter, value / units.mm(), decimals)? * units.mm(),
                _ => self.notation.append_coordinate(text, letter, value.to_degrees(), decimals)?.to_radians(),
            };
            let by = read - present[axis];
            // Turned back and forth, a coordinate that stays differs by its rounding.
            let is_changed = if modal.rotation.is_some() { by.abs() > UNSHIFTED } else { (at + by - at).abs() > 0.0 };
            let last_chance = !moves && Some(axis) == last;
            let stated = index == 0 && self.settings.encoding != TimeEncoding::Keep;
            if is_changed || stated || last_chance {
                displacement[axis] = by;
                moves = true;
            } else {
                text.truncate(before_word);
            }
        }
        let moved = modal.rotation.map_or(displacement, |rotation| rotation.displacement(displacement.into()).into());
        self.written += moved;
        Ok(())
    }

    /// Writes the centre of an arc that begins at `start` (as rounded), in the program's own frame of centres.
    fn append_centre(&self, text: &mut String, step: &Move, arc: &ElementArc, start: Vec6) -> Result<()> {
        let modal = self.part.toolpath.modal(step);
        let [first, second, _] = arc.plane.axes();
        let mut centre = start;
        [centre[first], centre[second]] = arc.centre;
        let words = match (modal.arc_distance, modal.rotation) {
            (Distance::Incremental, None) => centre - start,
            (Distance::Incremental, Some(rotation)) => rotation.displacement_unturned((centre - start).into()).into(),
            (Distance::Absolute, None) => centre - Vec6::from(modal.shift),
            (Distance::Absolute, Some(rotation)) => Vec6::from(rotation.unturned(centre.into())) - Vec6::from(modal.shift),
        };
        for axis in [first, second] {
            let (letter, value) = (['I', 'J', 'K'][axis], words[axis] / modal.units.mm());
            if self.counts {
                append_increments(text, letter, value, length_increment(modal.units))?;
            } else {
                text.push(letter);
                append_number(text, value, self.decimals(modal))?;
            }
        }
        Ok(())
    }

    /// Length that F refers to, in units of feeds: that of the linear axes; where none of them moves, that of the rotary
    /// axes in degrees.
    fn length(&self, step: &Move, element: &Element, displacement: &Vec6) -> f64 {
        let linear_mm = element.arc.map_or_else(|| displacement.fixed_rows::<3>(0).norm(), |arc| arc.length_mm());
        let linear = linear_mm / self.part.toolpath.modal(step).feed_unit_mm;
        let length = if linear > 0.0 { linear } else { displacement.fixed_rows::<3>(3).norm().to_degrees() };
        length.max(1e-6)
    }

    /// Feed of a slow line: a shift along the path makes it longer or shorter than the zone, but the feed neither higher than the move's own nor zero.
    fn slow_feed(&self, owner: usize, feed: f64) -> f64 {
        let step = &self.part.toolpath.moves[owner];
        let least = SlowStop::LEAST_MM_S * 60.0 / self.part.toolpath.modal(step).feed_unit_mm;
        let own = step.feed_word.map_or(f64::INFINITY, |word| word * self.part.feed_factors[owner]);
        feed.max(least).min(own)
    }

    /// Writes the program's own feed word where it applies, times the factor of its move.
    fn append_own_feed(&mut self, text: &mut String, owner: usize, first_of_block: bool, share: f64) -> Result<()> {
        let (step, factor) = (&self.part.toolpath.moves[owner], self.part.feed_factors[owner]);
        // Inverse time applies to one line: the parts of a move share its time.
        if self.mode == FeedMode::InverseTime && share < 1.0 {
            let Some(word) = step.feed_word else { return Err(Error::NoInverseTime { line: step.block as usize + 1 }) };
            let wanted = self.inverse_time(word * factor / share, word);
            return self.notation.append_feed(text, wanted);
        }
        let wanted = step.feed_word.map(|feed| feed * factor);
        match step.words(&self.part.program).feed {
            Some(word) if first_of_block && factor == 1.0 => {
                let span = self.part.program.words()[word].span;
                self.notation.append_own_feed(text, &String::from_utf8_lossy(self.part.program.text(span)));
            }
            // The feed of the tool call stays the tool call's.
            None if first_of_block && factor == 1.0 && self.notation.takes_feed_of_tool(&self.part.program, step) => {
                text.push_str(" F AUTO");
            }
            _ if wanted != self.feed => {
                if let Some(feed) = wanted {
                    self.notation.append_feed(text, feed)?;
                }
            }
            _ => {}
        }
        self.feed = wanted;
        Ok(())
    }

    /// Inverse time as the control takes it, 1/min; not below `own`, that of the program.
    fn inverse_time(&self, wanted: f64, own: f64) -> f64 {
        if !self.part.counts_by_radius() {
            return wanted;
        }
        let rounded = (wanted / FANUC_INVERSE_TIME_STEP).round() * FANUC_INVERSE_TIME_STEP;
        rounded.clamp(FANUC_INVERSE_TIME_STEP, FANUC_INVERSE_TIME.max(own))
    }

    /// Line after a segment that restores the program's own feed.
    pub(super) fn restore(&self, last: &Move) -> Result<Option<String>> {
        if self.settings.encoding == TimeEncoding::Keep {
            // Inverse time holds for one line only.
            let changed = self.mode != FeedMode::InverseTime && self.feed != last.feed_word;
            return last.feed_word.filter(|_| changed).map(|feed| self.notation.feed_line(feed)).transpose();
        }
        let modal = self.part.toolpath.modal(last);
        let mode = match modal.feed_mode {
            FeedMode::InverseTime => "G93",
            FeedMode::PerMinute => "G94",
            FeedMode::PerRevolution => "G95",
        };
        let feed = match (last.feed_word, modal.feed_mode) {
            (Some(word), FeedMode::PerMinute | FeedMode::PerRevolution) => format!("F{}", format_number(word, 6)?),
            _ => String::new(),
        };
        let text = if modal.feed_mode == self.mode { feed } else { format!("{mode}{feed}") };
        Ok((!text.is_empty()).then_some(text))
    }
}
