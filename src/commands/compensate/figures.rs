//! Figures of a compensation as JSON.

use pipeline::model_based_ilc::{LawName, Outcome};
use pipeline::{Expectation, Input, Output};
use serde_json::{Value, json};

use crate::print::compensation as print;
use crate::print::figures::{contour_json, orientation_json};
use crate::print::written;

/// What a compensation by `law` came to.
pub(super) fn outcome_json(
    law: LawName,
    input: &Input,
    outcome: &Outcome,
    output: &Output,
    expected: Option<&Expectation>,
) -> Value {
    let format = output.format.filter(|_| outcome.gained || output.setpoints.is_some());
    let setpoints = output.setpoints.as_ref().map(written::setpoints_json);
    let [before, after] = outcome.figures();
    json!({
        "changed": outcome.gained,
        "unchanged_because": (!outcome.gained).then(|| print::why_unchanged(input.part(), outcome)),
        "law": law,
        "updates": outcome.updates,
        "ended": outcome.ended.map(|ended| ended.to_string()),
        "largest_shift_um": output.largest_shift_mm * 1e3,
        "predicted_contour_um": {
            "before": contour_json(&before.tip),
            "after": contour_json(&after.tip),
        },
        "predicted_orientation_urad": {
            "before": orientation_json(before.orientation.as_ref()),
            "after": orientation_json(after.orientation.as_ref()),
        },
        "against_recorded_corners_um": outcome.of_program.map(|_| json!({
            "before": contour_json(&outcome.before.tip),
            "after": contour_json(&outcome.after.tip),
        })),
        "expected_contour_um": expected.map(print::expectation_json),
        "expected_orientation_urad": print::expected_orientation_json(expected),
        "beside_unchanged": outcome.beside_unchanged.map(|beside| json!({
            "line": beside.line, "max_um": beside.max_mm * 1e3, "elsewhere_max_um": beside.elsewhere_mm * 1e3,
        })),
        "left_alone": input.part().map(|part| json!({ "moves": part.fixed_moves(), "feed_length_share": part.fixed_share() })),
        "cycle_s": outcome.cycle_s.map(|(before, after)| json!({ "before": before, "after": after })),
        "format": format,
        // The key of before.
        "carrier": format,
        "setpoints": setpoints,
        "rows": setpoints,
        "warnings": print::warnings(input.part(), outcome),
    })
}

/// The keys of both.
pub(crate) fn merged(mut figures: Value, beside: Value) -> Value {
    if let (Value::Object(figures), Value::Object(beside)) = (&mut figures, beside) {
        figures.extend(beside);
    }
    figures
}
