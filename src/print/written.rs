//! What was written, and what stays as it is.

use std::collections::BTreeMap;
use std::path::Path;

use pipeline::Part;
use pipeline::model_based_ilc::{Outcome, WithoutGain};
use pipeline::part::FixedMoves;
use pipeline::refit::{RefitSettings, SlowStop};
use pipeline::setpoints::{SetpointsWritten, TOLERANCE_MM};
use pipeline::units::um;
use serde_json::{Value, json};

use super::program::dialect_name;

/// Units of a written reference, whatever those of the one that was read.
pub const UNITS: &str = "its times are in s, its positions in mm and rad";

/// What was written.
pub fn written(largest_shift_mm: f64, out: &Path) -> String {
    format!("largest shift {} µm; written to {}", um(largest_shift_mm), out.display())
}

/// The setpoints in words, and what is wrong with it.
pub fn setpoints(written: &SetpointsWritten) -> Vec<String> {
    let SetpointsWritten { count, interval_s, off_mm, .. } = written;
    let within = um(TOLERANCE_MM);
    let mut lines = vec![format!(
        "{count} setpoints, one every {:.3} ms; between them an axis is at most {} µm from the compensated path",
        interval_s * 1e3,
        um(*off_mm)
    )];
    if *off_mm > TOLERANCE_MM {
        lines.push(match written.finer_s {
            Some(finer_s) => format!(
                "warning: that is more than {within} µm: the interval is too coarse for this path; --spacing {:.3} is not",
                finer_s * 1e3
            ),
            None => format!("warning: that is more than {within} µm whatever the interval: write more --decimals"),
        });
    }
    lines
}

/// The same as JSON.
pub fn setpoints_json(written: &SetpointsWritten) -> Value {
    json!({
        "count": written.count,
        "interval_ms": written.interval_s * 1e3,
        "off_um": written.off_mm * 1e3,
        "tolerance_um": TOLERANCE_MM * 1e3,
        "finer_interval_ms": written.finer_s.map(|finer_s| finer_s * 1e3),
    })
}

/// Moves that stay as they are for one reason, with the line of the first one.
pub fn counted(why: &str, fixed: FixedMoves) -> String {
    let from = if fixed.moves > 1 { "from line" } else { "line" };
    format!("{} {why} ({from} {})", fixed.moves, fixed.first_line)
}

/// Which moves of a program stay as they are, if any do.
pub fn left_alone(fixed: &BTreeMap<&'static str, FixedMoves>, share: f64) -> Option<String> {
    let fixed: Vec<String> = fixed.iter().map(|(why, fixed)| counted(why, *fixed)).collect();
    let share = 100.0 * share;
    (!fixed.is_empty()).then(|| format!("moves left as they are: {}; {share:.1} % of the feed length", fixed.join(", ")))
}

/// Segments without gain that are named one by one.
const SEGMENTS_NAMED: usize = 5;

/// Segments that are not changed because the forecast gains nothing by it, the longest ones by their lines.
pub fn without_gain(left: &[WithoutGain]) -> Option<String> {
    let mut longest: Vec<&WithoutGain> = left.iter().collect();
    longest.sort_by(|a, b| b.length_mm.total_cmp(&a.length_mm));
    let named: Vec<String> = longest.iter().take(SEGMENTS_NAMED).map(|segment| segment_without_gain(segment)).collect();
    let more = if left.len() > named.len() { format!(" and {} shorter ones", left.len() - named.len()) } else { String::new() };
    (!left.is_empty())
        .then(|| format!("segments left as they are, because the forecast gains nothing: {}{more}", named.join(", ")))
}

fn segment_without_gain(of: &WithoutGain) -> String {
    let ((first, last), (before, after)) = (of.lines, (of.before_mm, of.after_mm));
    let lines = if first == last { format!("line {first}") } else { format!("lines {first} to {last}") };
    format!("{lines} ({} → {} µm RMS, {} → {} µm MAX)", um(before.0), um(after.0), um(before.1), um(after.1))
}

/// Shares of the feed length of a program, 0…1; the rest is compensated.
pub struct Shares {
    pub without_gain: f64,
    pub left_alone: f64,
}

/// What became of the feed length of a program, and how it grew. `points` are its finest and coarsest ones.
pub fn summary(
    shares: &Shares,
    points: Option<(RefitSettings, RefitSettings)>,
    slow_stop: Option<SlowStop>,
    lines: (usize, usize),
) -> String {
    let points = points.filter(|(finest, _)| finest.spacing_s.is_finite()).map_or(String::new(), |(finest, coarsest)| {
        let both = |a: f64, b: f64| if a == b { a.to_string() } else { format!("{a} to {b}") };
        let spacing_ms = both(finest.spacing_s * 1e3, coarsest.spacing_s * 1e3);
        let chord_um = both(finest.chord_tolerance_mm * 1e3, coarsest.chord_tolerance_mm * 1e3);
        format!(", with points at least {spacing_ms} ms apart and lines within {chord_um} µm of the corrected curve")
    });
    let stops = slow_stop.map_or(String::new(), |SlowStop { length_mm, time_s }| {
        let time_ms = time_s * 1e3;
        format!("\nstops: the last {length_mm:.3} mm before them take {time_ms:.0} ms, for less error there (--keep-stops: as programmed)")
    });
    let share = |share: f64| format!("{:.1} %", 100.0 * share);
    let Shares { without_gain, left_alone } = shares;
    format!(
        "feed length: {} compensated, {} without gain, {} left alone; {} lines in, {} out{points}{stops}",
        share((1.0 - without_gain - left_alone).max(0.0)),
        share(*without_gain),
        share(*left_alone),
        lines.0,
        lines.1
    )
}

/// The same as JSON.
pub fn summary_json(part: &Part, outcome: &Outcome, lines: (usize, usize)) -> Value {
    json!({
        "dialect": dialect_name(&part.program, &part.options),
        "lines_in": lines.0,
        "lines_out": lines.1,
        "without_gain": without_gain_json(&outcome.without_gain),
        "without_gain_share": part.share(outcome.without_gain.iter().map(|left| left.length_mm).sum()),
        "spacing_ms": outcome.written.map(|written| written.spacing_s * 1e3),
        "chord_tolerance_um": outcome.written.map(|written| written.chord_tolerance_mm * 1e3),
        "slow_stop": outcome.written.and_then(|written| written.slow_stop).map(slow_stop_json),
    })
}

/// A slow zone before stops as JSON.
pub fn slow_stop_json(SlowStop { length_mm, time_s }: SlowStop) -> Value {
    json!({ "length_mm": length_mm, "time_ms": time_s * 1e3 })
}

/// Segments without gain as JSON.
pub fn without_gain_json(left: &[WithoutGain]) -> Value {
    let one = |left: &WithoutGain| {
        json!({
            "lines": [left.lines.0, left.lines.1],
            "length_mm": left.length_mm,
            "before_um": { "rms": left.before_mm.0 * 1e3, "max": left.before_mm.1 * 1e3 },
            "after_um": { "rms": left.after_mm.0 * 1e3, "max": left.after_mm.1 * 1e3 },
        })
    };
    left.iter().map(one).collect()
}
