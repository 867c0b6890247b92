//! A path with rests. Works on the story's model.

use crate::common::Folder;

/// Columns of a CSV file, without the header.
fn columns(text: &str) -> Vec<Vec<f64>> {
    let rows: Vec<Vec<f64>> =
        text.lines().skip(1).map(|line| line.split(',').map(|cell| cell.parse().unwrap()).collect()).collect();
    (0..rows[0].len()).map(|column| rows.iter().map(|row| row[column]).collect()).collect()
}

pub fn nothing_winds_up_at_a_standstill(folder: &Folder) {
    folder.figures(&["excite", "-o", "rests", "--seconds", "12", "--seed", "9"]);
    let mut files: Vec<_> = std::fs::read_dir(folder.path("rests")).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    let lines = files.iter().find(|path| path.to_string_lossy().ends_with("01-full.csv")).unwrap().to_string_lossy().into_owned();
    folder.figures(&["compensate", &lines, "-m", "machine.model", "-o", "rests.csv", "--iterations", "12"]);
    let read = |path: &str| columns(&std::fs::read_to_string(folder.path(path)).unwrap());
    let (desired, learned) = (read(&lines), read("rests.csv"));
    let period = desired[0][1] - desired[0][0];
    let (before, after) = ((0.04 / period) as usize, (0.04 / period) as usize);
    let mut rests = 0;
    for (desired, learned) in desired.iter().zip(&learned).skip(1) {
        for k in before..desired.len() - after {
            // The axis has rested for a while and goes on resting: so does the reference, a little off at most.
            if desired[k - before..=k + after].iter().all(|x| *x == desired[k]) {
                rests += 1;
                assert!((learned[k] - desired[k]).abs() < 1e-3, "sample {k}: {} for {}", learned[k], desired[k]);
                assert!((learned[k] - learned[k - 1]).abs() < 1e-7, "sample {k}: {} after {}", learned[k], learned[k - 1]);
            }
        }
    }
    assert!(rests > 15, "{rests}");
    let raw = folder.figures(&["simulate", &lines, "-o", "raw-rests.csv"]);
    let cut = folder.figures(&["simulate", "rests.csv", "--against", &lines, "-o", "cut-rests.csv"]);
    let rms = |figures: &serde_json::Value| figures["contour_um"]["rms"].as_f64().unwrap();
    assert!(rms(&cut) < 0.5 * rms(&raw), "{cut} against {raw}");
}
