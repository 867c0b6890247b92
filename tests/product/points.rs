//! Points and segments of a compensated program: as few as the forecast needs, and none where it gains nothing.

use serde_json::Value;

use crate::common::{Folder, csv_files, text};

/// A wave of lines of about this length at 50 mm/s, as CAM systems write it.
fn wave(step_mm: f64) -> String {
    let mut text = String::from("G21 G90 G94 G17\nG0 X0 Y0 Z0\nG1 F3000\n");
    for k in 1..=(45.0 / step_mm) as u32 {
        let x = step_mm * f64::from(k);
        text += &format!("X{x:.3} Y{:.3}\n", 3.0 * (0.4 * x).sin());
    }
    text + "M2\n"
}

fn compensate(folder: &Folder, name: &str, more: &[&str]) -> Value {
    folder.figures(&[&["compensate", name, "-m", "machine.model", "-o", "out.nc"][..], more].concat())
}

fn number(figures: &Value, pointer: &str) -> f64 {
    figures.pointer(pointer).and_then(Value::as_f64).unwrap_or_else(|| panic!("{pointer} in {figures}"))
}

fn slowdown(figures: &Value) -> f64 {
    number(figures, "/cycle_s/after") / number(figures, "/cycle_s/before") - 1.0
}

#[test]
fn the_points_of_a_program_follow_from_its_forecast_and_its_cycle() {
    let folder = Folder::with_model();
    folder.write("wave.nc", wave(0.9));
    let dense = compensate(&folder, "wave.nc", &["--spacing", "1"]);
    let own = compensate(&folder, "wave.nc", &[]);
    let rms = |figures: &Value, at: &str| number(figures, &format!("/predicted_contour_um/{at}/rms"));
    assert!(number(&own, "/program/lines_out") < 0.8 * number(&dense, "/program/lines_out"), "{own}");
    // Dense points take a quarter of the cycle more.
    assert!(slowdown(&own) <= 0.01 && slowdown(&dense) > 0.1, "{own} beside {dense}");
    assert!(rms(&own, "after") < 0.6 * rms(&own, "before"), "{own}");
    assert_eq!(number(&dense, "/program/spacing_ms"), 1.0);
}

#[test]
fn a_cycle_may_become_longer_only_where_that_is_allowed() {
    let folder = Folder::with_model();
    folder.write("wave.nc", wave(0.15));
    let within = |percent: &str| compensate(&folder, "wave.nc", &["--spacing", "1", "--cycle-limit", percent]);
    let (none, free) = (within("0%"), within("1000"));
    assert_eq!(none["changed"], false, "{none}");
    let words = ["compensate", "wave.nc", "-m", "machine.model", "-o", "out.nc", "--spacing", "1", "--cycle-limit", "0"];
    assert!(folder.prints(&words).contains("% longer, which --cycle-limit does not allow"));
    assert!(slowdown(&free) > 0.0, "short lines cost time on this machine: {free}");
}

#[test]
fn a_slow_machine_gets_a_smoother_correction_within_the_cycle() {
    let folder = Folder::new();
    folder.train_on("random:9", "20", "linear");
    folder.write("wave.nc", wave(0.45));
    // At 40 Hz every choice of points takes more than 1 % longer.
    let figures = compensate(&folder, "wave.nc", &["--work-offset", "0,0,0"]);
    let rms = |at: &str| number(&figures, &format!("/predicted_contour_um/{at}/rms"));
    assert!(slowdown(&figures) <= 0.01, "{figures}");
    assert!(rms("after") < 0.7 * rms("before"), "{figures}");
    let measured = |program: &str| {
        let run =
            ["simulate", program, "--machine", "random:9", "--against", "wave.nc", "--work-offset", "0,0,0", "-o", "run.csv"];
        number(&folder.figures(&run), "/contour_um/rms")
    };
    assert!(measured("out.nc") < 0.9 * measured("wave.nc"));
}

#[test]
fn a_segment_without_gain_keeps_every_byte() {
    let folder = Folder::with_model();
    let slow = "G1 X20 F60\nX25\n";
    let fast = "G1 X10 Y8 F3000\nG3 X-10 Y8 I-10 J4\nG1 X0 Y0\n";
    folder.write("two.nc", format!("G21 G90 G94 G17\nG0 X0 Y0 Z0\n{slow}G0 Z5\nX0\nZ0\n{fast}M2\n"));
    let figures = compensate(&folder, "two.nc", &[]);
    let out = folder.read("out.nc");
    assert!(out.contains(slow) && !out.contains(fast), "{out}");
    let left = figures.pointer("/program/without_gain").and_then(Value::as_array).unwrap();
    assert_eq!(left.len(), 1, "{figures}");
    assert_eq!(left[0]["lines"], serde_json::json!([3, 4]));
    let share = number(&figures, "/program/without_gain_share");
    assert!(share > 0.1 && share < 0.5, "{share}");
}

#[test]
fn strict_refuses_what_would_be_left_alone() {
    let folder = Folder::with_model();
    folder.write("whole.nc", wave(0.9));
    folder.write("unknown.nc", "G21 G90 G94 G17\nG0 X0. Y0. Z0.\nG1 X10. F1000\nM428\nG1 X20. Y30.\nG0 X0. Y0.\nG1 Y9.\nM2\n");
    let strict = |name: &str| folder.precomp(&["compensate", name, "-m", "machine.model", "-o", "out.nc", "--strict"]);
    let refused = strict("unknown.nc");
    let said = text(&refused.stderr);
    assert_eq!(refused.status.code(), Some(1), "{said}");
    assert!(said.contains("unknown.nc:5") && said.contains("not known") && said.contains("--strict"), "{said}");
    assert!(!folder.path("out.nc").exists());
    assert_eq!(strict("whole.nc").status.code(), Some(0));
}

#[test]
fn an_error_that_a_rapid_leaves_is_told_with_its_remedy() {
    let folder = Folder::with_model_and_part();
    let part = "G21 G90 G17 G94\nG0 X0 Y0 Z5\nG1 Z0 F600\nG1 X20 F1500\nG3 X20 Y20 I0 J10\nG1 X0\nG0 Z5\nG0 Y50\nG1 X1 F300\nG1 X40 F1500\nG0 \
                Z8\nM30\n";
    folder.write("rapids.nc", part);
    folder.write("dwells.nc", part.replace("G1 X1 ", "G4 P0.5\nG1 X1 "));
    let of = |name: &str| folder.figures(&["compensate", name, "-m", "machine.model", "-o", "out.nc", "--work-offset", "0,0,0"]);
    let (rapids, dwells) = (of("rapids.nc"), of("dwells.nc"));
    let max = |figures: &Value| figures["predicted_contour_um"]["after"]["max"].as_f64().unwrap();
    let told = &rapids["beside_unchanged"];
    assert_eq!(told["line"], 9, "{told}");
    assert!(
        (told["max_um"].as_f64().unwrap() - max(&rapids)).abs() < 1e-9 && told["elsewhere_max_um"].as_f64().unwrap() < 0.6,
        "{told}"
    );
    assert!(dwells["beside_unchanged"].is_null() && max(&dwells) < 0.6 * max(&rapids), "{} {}", max(&rapids), max(&dwells));
}

/// With a model of logs alone: without a machine file no control is known.
fn folder_without_control() -> Folder {
    let folder = Folder::new();
    folder.train("20", "linear");
    let paths = csv_files(folder.0.path());
    let logs: Vec<String> =
        paths.iter().map(|path| path.to_string_lossy().into_owned()).filter(|path| path.contains("log-")).collect();
    let logs: Vec<&str> = logs.iter().map(String::as_str).collect();
    folder.figures(&[&["train"], logs.as_slice(), &["--predictor", "linear", "-o", "machine.model"]].concat());
    folder
}

#[test]
fn increments_have_the_decimals_that_controls_resolve() {
    let folder = folder_without_control();
    folder.write("steps.nc", "G21 G90 G94 G17\nG0 X0 Y0 Z0\nG91\nG1 X20. Y5. F2000\nG1 X-15. Y10.\nG1 X-5. Y-15.\nM2\n");
    let said = |more: &[&str]| {
        let words = [&["compensate", "steps.nc", "-m", "machine.model", "-o", "out.nc"][..], more].concat();
        let output = folder.precomp(&words);
        assert!(output.status.success(), "{}", text(&output.stderr));
        text(&output.stdout) + &text(&output.stderr)
    };
    // Decimals of every coordinate word, and the sum of those of X.
    let written = || {
        let text = folder.read("out.nc");
        let words = text.lines().skip_while(|line| !line.starts_with("G91")).filter(|line| !line.starts_with(['(', ';']));
        let coordinates =
            words.flat_map(|line| line.split_inclusive(['X', 'Y', 'F', ' ']).collect::<Vec<_>>()).collect::<Vec<_>>();
        let number = |text: &str| text.trim_end_matches(['X', 'Y', 'F', ' ']).to_owned();
        let of =
            |letter: char| coordinates.windows(2).filter(move |pair| pair[0].ends_with(letter)).map(move |pair| number(pair[1]));
        let decimals = |value: &String| value.split_once('.').map_or(0, |(_, decimals)| decimals.len());
        let most = of('X').chain(of('Y')).map(|value| decimals(&value)).max().unwrap();
        (most, of('X').map(|value| value.parse::<f64>().unwrap()).sum::<f64>())
    };
    let note = "increments (G91, from line 4) are written with 3 decimals";
    let text = said(&[]);
    assert!(text.contains("how the control plans is not known") && text.contains(note), "{text}");
    let (most, sum) = written();
    assert!(most == 3 && sum.abs() < 1e-9, "{most} {sum}");
    assert!(!said(&["--decimals", "6"]).contains("increments (G91"));
    assert!(written().0 > 3);
}

#[test]
fn coordinates_beyond_100_mm_have_no_more_digits_than_fanuc_reads() {
    let folder = folder_without_control();
    folder.write(
        "far.nc",
        "O0001\nG21 G17 G90 G94\nG0 X112. Y-18. Z0.\nG1 X90. F1500.\nY0.\nX112.\nY18.\nG3 X104. Y26. I-8. J0.\nG1 X90.\nM30\n",
    );
    let most = |more: &[&str]| {
        let words = [&["compensate", "far.nc", "-m", "machine.model", "-o", "out.nc", "--quiet"], more].concat();
        let output = folder.precomp(&words);
        assert!(output.status.success(), "{}", text(&output.stderr));
        let written = folder.read("out.nc");
        let lines = written.lines().filter(|line| !line.starts_with('('));
        let numbers = lines.flat_map(|line| line.split(|c: char| c.is_ascii_alphabetic() || c == ' ').collect::<Vec<_>>());
        numbers.map(|number| number.bytes().filter(u8::is_ascii_digit).count()).max().unwrap()
    };
    assert_eq!(most(&[]), 8);
    assert!(most(&["--decimals", "6"]) > 8);
}
