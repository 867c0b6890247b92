//! Feeds reduced where the forecast exceeds a tolerance.

use serde_json::Value;

use crate::common::{Folder, text};

/// Compensates `part.nc`; the figures of its feeds.
fn compensate(folder: &Folder, out: &str, more: &[&str]) -> Value {
    folder.figures(&[&["compensate", "part.nc", "-m", "machine.model", "-o", out][..], more].concat())["feeds"].clone()
}

fn figure(feeds: &Value, name: &str) -> f64 {
    feeds[name].as_f64().unwrap()
}

/// A folder with the model and `part.nc`; the largest error at the programmed feeds, µm, and a tolerance of 0.4 times that.
fn folder_with_tight_tolerance() -> (Folder, f64, String) {
    let folder = Folder::with_model_and_part();
    let max = figure(&compensate(&folder, "wide.nc", &["--tolerance", "1mm"]), "max_before_um");
    (folder, max, format!("{}um", 0.4 * max))
}

#[test]
fn a_tolerance_that_is_kept_anyway_changes_nothing() {
    let folder = Folder::with_model_and_part();
    let wide = compensate(&folder, "wide.nc", &["--tolerance", "1mm"]);
    assert_eq!(wide["slower_moves"], 0);
    compensate(&folder, "out.nc", &[]);
    assert!(folder.read("wide.nc") == folder.read("out.nc"), "a tolerance that is kept changes the program");
}

#[test]
fn moves_beyond_the_tolerance_are_slower() {
    let (folder, max, tight) = folder_with_tight_tolerance();
    let slow = compensate(&folder, "slow.nc", &["--tolerance", &tight]);
    assert!(figure(&slow, "slower_moves") >= 1.0, "{slow}");
    // A move whose error is none of speed keeps its feed, and the largest error may be one of those.
    assert!(figure(&slow, "max_after_um") <= max, "{slow}");
    assert!(figure(&slow, "cycle_after_s") > figure(&slow, "cycle_before_s"), "{slow}");
}

#[test]
fn keep_time_costs_less_cycle_time_than_slower_moves_alone() {
    let (folder, _, tight) = folder_with_tight_tolerance();
    let slow = compensate(&folder, "slow.nc", &["--tolerance", &tight]);
    let kept = compensate(&folder, "kept.nc", &["--tolerance", &tight, "--keep-time"]);
    assert!(figure(&kept, "cycle_after_s") < figure(&slow, "cycle_after_s"), "{kept} against {slow}");
}

#[test]
fn a_slower_program_keeps_its_cycles_and_can_be_run() {
    let (folder, _, tight) = folder_with_tight_tolerance();
    compensate(&folder, "slow.nc", &["--tolerance", &tight]);
    compensate(&folder, "out.nc", &[]);
    // The last feed move leaves the programmed feed in force, and rapids and cycles stay.
    let slow = folder.read("slow.nc");
    assert!(slow.contains("N120 G81 X0. Y0. Z-5. R2. F100\r\n"));
    assert_ne!(slow, folder.read("out.nc"));
    assert!(folder.figures(&["simulate", "slow.nc", "--against", "part.nc", "-o", "slow.csv"])["seconds"].as_f64().is_some());
}

#[test]
fn a_tolerance_without_unit_and_keep_time_without_tolerance_are_refused() {
    let folder = Folder::with_model_and_part();
    folder.fails(2, &["compensate", "part.nc", "-m", "machine.model", "-o", "x.nc", "--tolerance", "2"]);
    folder.fails(2, &["compensate", "part.nc", "-m", "machine.model", "-o", "x.nc", "--keep-time"]);
}

#[test]
fn a_reference_trajectory_takes_no_tolerance() {
    let folder = Folder::with_model();
    folder.figures(&["simulate", "curve:circle", "-o", "cut.csv"]);
    let reference = folder.precomp(&["compensate", "cut.csv", "-m", "machine.model", "-o", "x.csv", "--tolerance", "2um"]);
    assert_eq!(reference.status.code(), Some(2));
    assert!(text(&reference.stderr).contains("only part programs"), "{}", text(&reference.stderr));
}
