//! `precomp fleet` as its user runs it: simulate, train, watch; resumed; refused.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use serde_json::Value;

/// A folder of its own for a test.
struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn precomp(&self, arguments: &str) -> Output {
        let arguments = arguments.split_whitespace();
        Command::new(env!("CARGO_BIN_EXE_precomp")).args(arguments).current_dir(self.0.path()).output().unwrap()
    }

    /// Runs a command that has to succeed, and returns its JSON.
    fn figures(&self, arguments: &str) -> Value {
        let output = self.precomp(&format!("{arguments} --json -"));
        assert!(output.status.success(), "{arguments}: {}", String::from_utf8_lossy(&output.stderr));
        serde_json::from_slice(&output.stdout).unwrap()
    }

    /// Runs a command that has to fail, and returns its status and message.
    fn refused(&self, arguments: &str) -> (i32, String) {
        let output = self.precomp(arguments);
        (output.status.code().unwrap(), String::from_utf8_lossy(&output.stderr).into_owned())
    }
}

fn files(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let mut all: Vec<_> = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap())
        .map(|entry| (entry.file_name().to_string_lossy().into_owned(), std::fs::read(entry.path()).unwrap()))
        .collect();
    all.sort();
    all
}

const SIMULATE: &str = "fleet simulate plant --machines 2 --minutes 0.25 --days 5 --seed 11 --fault 2:y:friction=60@5";
const TRAIN: &str = "fleet train plant -o models --predictor linear --days 1 --healthy-days 3";

#[test]
fn a_fault_is_found_on_its_axis_and_day_alone_and_a_stopped_training_goes_on() {
    let folder = Folder::new();
    let simulated = folder.figures(SIMULATE);
    assert_eq!(simulated["machines"], serde_json::json!(["random-11", "random-12"]));
    let first = folder.figures(&format!("{TRAIN} --only random-11"));
    assert_eq!(first["trained"].as_object().unwrap().len(), 1);
    let alone = files(&folder.path("models"));
    // A model without its baseline is not finished.
    std::fs::remove_file(folder.path("models/random-11.baseline.json")).unwrap();
    let second = folder.figures(TRAIN);
    assert_eq!((second["trained"].as_object().unwrap().len(), second["kept"].as_array().unwrap().len()), (2, 0));
    let both = files(&folder.path("models"));
    assert!(both.len() == 4 && alone.iter().all(|file| both.contains(file)), "other bytes on the second training");
    let third = folder.figures(TRAIN);
    assert_eq!((third["kept"].as_array().unwrap().len(), files(&folder.path("models"))), (2, both));

    let watched = folder.figures("fleet watch plant -m models -o watch.parquet");
    let alarms = watched["alarms"].as_array().unwrap();
    let of_friction = |alarm: &&Value| alarm["quantity"] == "friction";
    assert!(alarms.iter().any(|alarm| of_friction(&alarm) && alarm["change_share"].as_f64().unwrap() > 0.3), "{watched:#}");
    for alarm in alarms {
        assert_eq!((&alarm["machine"], &alarm["date"], &alarm["axis"]), (&"random-12".into(), &"2026-01-05".into(), &"y".into()));
    }
    assert_eq!((watched["rows"].as_u64(), watched["watched_machine_days"].as_u64()), (Some(30), Some(2)));
    let since = folder.figures("fleet watch plant -m models -o since.parquet --since 2026-01-05 --only random-12");
    assert_eq!(since["rows"], 3);
    results_hold_a_row_for_every_machine_day_and_axis(&folder.path("watch.parquet"));
}

fn results_hold_a_row_for_every_machine_day_and_axis(path: &Path) {
    let bytes = std::fs::read(path).unwrap();
    let table = datasets::formats::table_of(path, bytes).unwrap();
    assert_eq!(table.len(), 30);
    let column = |name: &str| &table.columns[table.names.iter().position(|known| known == name).unwrap()];
    assert!(column("rows").iter().zip(column("seconds")).all(|(rows, seconds)| (rows * 0.002 - seconds).abs() < 1e-6));
    for name in ["tracking_rms_um", "model_rms_um", "friction_um", "lag_ms", "model_rms_um_week"] {
        assert!(column(name).iter().all(|value| value.is_finite()), "{name}");
    }
    assert!(column("gaps").iter().chain(column("missing")).all(|count| *count == 0.0));
}

#[test]
fn what_cannot_be_done_is_refused_with_file_and_remedy() {
    let folder = Folder::new();
    let (status, text) = folder.refused("fleet train nowhere -o models");
    assert!(status == 1 && text.contains("nowhere"), "{text}");
    std::fs::create_dir_all(folder.path("plant/machine=a/date=2026-01-01")).unwrap();
    std::fs::write(folder.path("plant/machine=a/date=2026-01-01/run.parquet"), b"PAR1 no table PAR1").unwrap();
    let (status, text) = folder.refused("fleet train plant -o models");
    assert!(status == 1 && text.contains("run.parquet") && !folder.path("models").exists(), "{text}");
    let (status, text) = folder.refused("fleet watch plant -m models -o watch.parquet");
    assert!(status == 1 && text.contains("run precomp fleet train first"), "{text}");
    let (status, text) = folder.refused("fleet watch plant -m models -o plant/machine=a/date=2026-01-01/run.parquet");
    assert!(status == 2 && text.contains("would write over"), "{text}");
    let (status, text) = folder.refused("fleet train plant -o models --only b");
    assert!(status == 1 && text.contains("no machine `b`"), "{text}");
    for (fault, reason) in
        [("4:x:friction=20@1", "3 machines"), ("1:w:friction=20@1", "no linear axis"), ("x:friction", "MACHINE:AXIS")]
    {
        let (status, text) = folder.refused(&format!("fleet simulate new --machines 3 --days 2 --fault {fault}"));
        assert!(status > 0 && text.contains(reason) && !folder.path("new").exists(), "{text}");
    }
}
