//! Long programs: compensated in windows.

use anyhow::Result;
use models::Bundle;
use pipeline::model_based_ilc::LawName;
use pipeline::windows::{Joined, LongProgram, OutsideLines};
use pipeline::{OutputSettings, Setup, is_control_unknown};
use serde_json::{Value, json};

use super::{AT_BOUND, Compensate, line_count};
use crate::output::{Outputs, Printer};
use crate::print::compensation as print;
use crate::print::control::control_unknown;
use crate::print::figures::contour_json;
use crate::print::program;
use crate::print::written::{self, Shares};
use crate::read::Source;

impl Compensate {
    /// The program, where it is compensated in windows. What needs all of it at once is done without them: a picture of the forecast, other
    /// feeds, a recorded command, setpoints, the papers' laws.
    pub(super) fn long(&self, source: &Source, setup: &Setup, format: &OutputSettings) -> Result<Option<LongProgram>> {
        let whole =
            self.report.report.is_some() || self.plot.plot || self.feeds.is_used() || self.reference.is_some() || self.strict;
        if whole || format.program().is_none() || LawName::from(self.law) != LawName::ModelBased {
            return Ok(None);
        }
        source.long(setup, &self.program.settings())
    }

    pub(super) fn compensate_long(
        &self,
        long: &LongProgram,
        model: &Bundle,
        setup: &Setup,
        format: &OutputSettings,
        printer: &Printer,
    ) -> Result<()> {
        let whole = long.whole();
        if self.program.dialect.is_none() && setup.dialect.is_none() {
            program::show_dialect(printer, &whole.program, &whole.options);
        }
        self.show_control(model, true, printer);
        if self.machine.is_none() && is_control_unknown(model) {
            printer.line(control_unknown(false));
        }
        let shown = self.common.shown();
        let joined = long.compensate(model, &self.settings(), format, &|event| shown.event(event))?;
        drop(shown);
        self.show_joined(long, &joined, printer)?;
        let lines = (line_count(whole.program.bytes()), line_count(&joined.content));
        printer.line(written::summary(&shares(&joined), joined.points, joined.slow_stop, lines));
        let figures = self.joined_json(long, &joined, lines)?;
        let mut outputs = Outputs::default();
        outputs.add(&self.out, joined.content);
        outputs.write(self.common.json.as_deref(), &figures)
    }

    fn show_joined(&self, long: &LongProgram, joined: &Joined<'_>, printer: &Printer) -> Result<()> {
        let whole = long.whole();
        program::show_warnings(printer, long.warnings(), (&whole.program, &whole.name), self.common.verbose);
        if !joined.is_placed {
            printer.line("note: the work offset is not known: terms that depend on position are left out, and travel is compared with the extent of the part alone. Give --work-offset X,Y,Z");
        }
        for range in &joined.outside {
            printer.line(format!("warning: {}", outside(range)));
        }
        let how = format!("{} windows, up to {} updates on the model", joined.windows(), joined.updates);
        printer.line(print::forecast(" over feed moves", &joined.before()?, &joined.after()?, &how));
        if let Some(expected) = joined.expectation() {
            print::show_expectation(printer, &expected);
        }
        printer.line(print::cycle(joined.cycle_s));
        if let Some(left) = written::left_alone(&joined.fixed, share(joined.fixed_mm, joined)) {
            printer.line(left);
        }
        if let Some(line) = written::without_gain(&joined.without_gain) {
            printer.line(line);
        }
        if !joined.gained {
            printer.line(format!("{}: what is written is the input, unchanged", why_unchanged(joined)));
        }
        printer.line(written::written(joined.largest_shift_mm, &self.out));
        if joined.gained && joined.largest_shift_mm > AT_BOUND * joined.max_shift {
            printer.line(print::cut_off(joined.max_shift));
        }
        Ok(())
    }

    fn joined_json(&self, long: &LongProgram, joined: &Joined<'_>, lines: (usize, usize)) -> Result<Value> {
        let whole = long.whole();
        Ok(json!({
            "changed": joined.gained,
            "unchanged_because": (!joined.gained).then(|| why_unchanged(joined)),
            "law": LawName::from(self.law),
            "windows": joined.windows(),
            "updates": joined.updates,
            "largest_shift_um": joined.largest_shift_mm * 1e3,
            "predicted_contour_um": { "before": contour_json(&joined.before()?), "after": contour_json(&joined.after()?) },
            "expected_contour_um": joined.expectation().as_ref().map(print::expectation_json),
            "expected_orientation_urad": print::expected_orientation_json(joined.expectation().as_ref()),
            "left_alone": json!({ "moves": joined.fixed, "feed_length_share": share(joined.fixed_mm, joined) }),
            "cycle_s": json!({ "before": joined.cycle_s.0, "after": joined.cycle_s.1 }),
            "format": joined.points.map(|(finest, _)| finest.encoding),
            "warnings": joined.outside.iter().map(outside).collect::<Vec<String>>(),
            "program": json!({
                "dialect": program::dialect_name(&whole.program, &whole.options),
                "lines_in": lines.0,
                "lines_out": lines.1,
                "without_gain": written::without_gain_json(&joined.without_gain),
                "without_gain_share": shares(joined).without_gain,
                "spacing_ms": joined.points.map(|(finest, _)| finest.spacing_s * 1e3),
                "chord_tolerance_um": joined.points.map(|(finest, _)| finest.chord_tolerance_mm * 1e3),
                "slow_stop": joined.slow_stop.map(written::slow_stop_json),
            }),
        }))
    }
}

fn why_unchanged(joined: &Joined<'_>) -> String {
    joined.too_slow.map_or(print::NO_GAIN.to_owned(), print::too_slow)
}

fn shares(joined: &Joined<'_>) -> Shares {
    Shares { without_gain: share(joined.without_gain_mm, joined), left_alone: share(joined.fixed_mm, joined) }
}

/// Share of a length in that of all feed moves.
fn share(length_mm: f64, joined: &Joined<'_>) -> f64 {
    if joined.feed_mm > 0.0 { length_mm / joined.feed_mm } else { 0.0 }
}

fn outside(range: &OutsideLines) -> String {
    let (first, last) = range.lines;
    let place = if first == last { format!("line {first}") } else { format!("lines {first} to {last}") };
    print::outside(&place, &range.axis, range.reason, range.samples, range.fades)
}
