//! One window: plan, learning, figures and bytes of its core.

use std::collections::BTreeMap;
use std::ops::Range;

use models::Bundle;

use crate::error::Result;
use crate::expectation::ExpectationSum;
use crate::input::Input;
use crate::model_based_ilc::{Outcome, Settings, WithoutGain, model_based_ilc};
use crate::output::OutputSettings;
use crate::part::{FixedMoves, Part, Placement, Section};
use crate::progress::SILENT;
use crate::refit::{RefitSettings, WrittenSection, write_section};
use crate::setup::Setup;
use crate::statistics::{SampleErrors, counts};
use crate::tally::Tally;
use crate::travel;

/// A window of a long program.
pub(super) struct Window<'a, 'b> {
    pub section: &'b Section,
    pub placement: &'b Placement,
    pub setup: &'b Setup,
    pub model: &'a Bundle,
    pub settings: &'b Settings,
    pub format: &'b OutputSettings,
}

/// A compensated window. All figures are those of its core.
pub(super) struct Done<'a> {
    pub written: WrittenSection,
    pub samples: usize,
    pub period_s: f64,
    pub before: Tally,
    pub after: Tally,
    pub expected: ExpectationSum<'a>,
    pub gained: bool,
    pub updates: usize,
    pub max_shift: f64,
    /// Time after compensation, s.
    pub after_s: f64,
    pub points: Option<RefitSettings>,
    pub too_slow: Option<f64>,
    pub without_gain: Vec<WithoutGain>,
    pub outside: Vec<OutsideLines>,
    /// Length of feed moves, of those that are left alone, and of segments without gain, mm.
    pub feed_mm: f64,
    pub fixed_mm: f64,
    pub without_gain_mm: f64,
    pub fixed: BTreeMap<&'static str, FixedMoves>,
}

/// Lines in which an axis leaves the operating range of the model, for one reason.
#[derive(Debug, Clone, PartialEq)]
pub struct OutsideLines {
    /// Name of the axis.
    pub axis: String,
    /// Reason.
    pub reason: models::Outside,
    /// First and last line, from 1.
    pub lines: (usize, usize),
    /// Number of samples that lie outside.
    pub samples: usize,
    /// Whether the correction fades there.
    pub fades: bool,
}

impl<'a> Window<'a, '_> {
    pub(super) fn compensate(&self) -> Result<Done<'a>> {
        let mut part = self.section.clone().part(self.placement, self.setup)?;
        self.format.prepare(&mut part);
        let input = Input::from(part);
        travel::check(&input, self.setup)?;
        let outcome = model_based_ilc(&input, self.model, self.settings, SILENT)?;
        self.done(&input, outcome)
    }

    fn done(&self, input: &Input, outcome: Outcome) -> Result<Done<'a>> {
        let part = input.program()?;
        let points = outcome.written.or(self.settings.written);
        let settings = points.ok_or(crate::error::Error::NoProgram)?;
        let reference = outcome.gained.then_some(&outcome.reference);
        let written = write_section(part, self.section, reference, &settings, outcome.max_shift)?;
        let samples = self.section.core_samples(part);
        let tally = |actual: &motion::Trajectory| -> Result<Tally> {
            let costs_mm = SampleErrors::of(input.desired(), actual)?.costs_mm();
            let mut tally = Tally::default();
            let counted = samples.clone().filter(|k| counts(Some(part), *k));
            counted.for_each(|k| tally.note(k - samples.start, costs_mm[k]));
            Ok(tally)
        };
        let expected = ExpectationSum::of(self.model, input, &outcome.reference, &outcome.forecast, samples.clone())?;
        let moves = self.section.core_moves(part);
        let (feed_mm, fixed_mm) = (length_mm(part, &moves, |_| true), length_mm(part, &moves, |k| !is_shiftable(part, k)));
        let line = |moves: &Range<usize>| {
            let at = |index: usize| part.toolpath.moves.get(index).map_or(0, |step| step.block as usize + 1);
            (at(moves.start), at(moves.end.saturating_sub(1)))
        };
        let (first, last) = line(&moves);
        let within = |lines: (usize, usize)| lines.0 <= last && lines.1 >= first;
        let without_gain: Vec<WithoutGain> = outcome.without_gain.iter().filter(|left| within(left.lines)).copied().collect();
        let left_mm = |left: &WithoutGain| {
            let inside = |k: usize| (left.lines.0..=left.lines.1).contains(&(part.toolpath.moves[k].block as usize + 1));
            length_mm(part, &moves, |k| inside(k) && is_shiftable(part, k))
        };
        let period_s = input.trajectory().period_s();
        let own_s = samples.len() as f64 * period_s;
        Ok(Done {
            samples: samples.len(),
            period_s,
            before: tally(&outcome.uncompensated)?,
            after: tally(&outcome.forecast)?,
            expected,
            gained: outcome.gained,
            updates: outcome.updates,
            max_shift: outcome.max_shift,
            after_s: outcome.cycle_s.map_or(own_s, |(before_s, after_s)| own_s * after_s / before_s),
            points: outcome.written,
            too_slow: outcome.too_slow,
            without_gain_mm: without_gain.iter().map(left_mm).sum(),
            without_gain,
            outside: outside(part, &outcome, &samples),
            feed_mm,
            fixed_mm,
            fixed: part.fixed_moves_of(&moves),
            written,
        })
    }
}

fn is_shiftable(part: &Part, index: usize) -> bool {
    part.is_shiftable(&part.toolpath.moves[index])
}

/// Length of the feed moves among `moves` that count, mm.
fn length_mm(part: &Part, moves: &Range<usize>, counts: impl Fn(usize) -> bool) -> f64 {
    let feeds = moves.clone().filter(|index| part.toolpath.moves[*index].is_feed() && counts(*index));
    feeds.filter_map(|index| part.toolpath.moves[index].length_mm()).sum()
}

/// Ranges outside of the model's operating range that reach into the core.
fn outside(part: &Part, outcome: &Outcome, core: &Range<usize>) -> Vec<OutsideLines> {
    let reaches = outcome.outside.iter().filter(|range| range.first < core.end && range.last >= core.start);
    reaches
        .map(|range| {
            let line = |sample: usize| part.line_at(sample).unwrap_or_default();
            OutsideLines {
                axis: range.axis.clone(),
                reason: range.reason,
                lines: (line(range.first.max(core.start)), line(range.last.min(core.end.saturating_sub(1)))),
                samples: range.samples.min(core.len()),
                fades: range.fades,
            }
        })
        .collect()
}
