//! Errors of rotary axes are angles, in text and in JSON of every command that prints them.

use serde_json::Value;

use crate::common::{Folder, text};

/// Runs a command; its text and its JSON figures.
fn said(folder: &Folder, words: &[&str]) -> (String, Value) {
    let output = folder.precomp(&[words, &["--json", "said.json"]].concat());
    assert!(output.status.success(), "{words:?}: {}", text(&output.stderr));
    (text(&output.stdout), serde_json::from_slice(&std::fs::read(folder.path("said.json")).unwrap()).unwrap())
}

/// Whether a table has a row of this axis that begins with this number.
fn has_row(table: &str, axis: &str, number: f64) -> bool {
    let shown = format!("{number:.3}");
    table.lines().any(|line| line.trim().strip_prefix(axis).is_some_and(|rest| rest.trim().starts_with(&shown)))
}

#[test]
fn errors_of_rotary_axes_are_microradians() {
    let folder = Folder::new();
    folder.train_on("bc", "20", "linear");
    let urad = |figures: &Value, key: &str| figures[key].as_f64().unwrap_or_else(|| panic!("{key} in {figures}"));

    let (table, figures) = said(&folder, &["predict", "curve:saddle", "--feed", "16", "-m", "machine.model"]);
    let predicted = urad(&figures["tracking_um"]["c"], "rms_urad");
    assert!(has_row(&table, "c (µrad)", predicted), "{table}");
    assert!(has_row(&table, "x (µm)", urad(&figures["tracking_um"]["x"], "rms")), "{table}");

    folder.figures(&["simulate", "curve:saddle", "--feed", "16", "--machine", "bc", "-o", "run.csv"]);
    let (table, figures) = said(&folder, &["measure", "run.csv", "-m", "machine.model"]);
    let measured = urad(&figures["tracking_um"]["c"], "rms_urad");
    assert!(has_row(&table, "c (µrad)", measured), "{table}");
    // Hundreds of microradians: the lag of a table that turns by tenths of a radian a second.
    assert!((0.5 * measured..2.0 * measured).contains(&predicted) && measured > 50.0, "{predicted} {measured}");
    let fit = urad(&figures["model"]["c"], "rms_urad");
    assert!(fit < measured && fit > 1e-3 * measured && has_row(&table, "c (µrad)", fit), "{fit}: {table}");
    assert!(figures["model"]["c"]["rms_um"].is_null() && figures["model"]["x"]["rms_um"].is_f64(), "{figures}");

    let (table, figures) = said(&folder, &["train", "log-01-full.csv", "--from", "machine.model", "-o", "adapted.model"]);
    let axes = &figures["axes"];
    assert!(axes["c"]["before_rms_um"].is_null() && axes["x"]["before_rms_um"].is_f64(), "{figures}");
    let before = urad(&axes["c"], "before_rms_urad");
    assert!(has_row(&table, "c (µrad)", before), "{table}");
    // The excitation turns the table faster than the saddle does, but not by the thousand that a wrong unit makes.
    assert!((0.1 * fit..100.0 * fit).contains(&before), "{fit} {before}");
}
