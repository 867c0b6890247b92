//! Iterative learning on a machine, one command a run.

use crate::common::{Folder, without_mark};

#[test]
fn every_run_is_learned_from_its_log() {
    let folder = Folder::new();
    let part = "G21 G90 G17\nG0 X0 Y0\nG1 X30 F2400\nG3 X30 Y20 J10\nG1 X0\nG1 Y0\nM30\n";
    std::fs::write(folder.path("part.nc"), part).unwrap();
    folder.figures(&["simulate", "part.nc", "-o", "run1.csv"]);
    let mut rms = Vec::new();
    for run in 1..4 {
        let (log, next) = (format!("run{run}.csv"), format!("run{}.nc", run + 1));
        let figures = folder.figures(&[
            "refine",
            "part.nc",
            "--machine",
            "ballscrew",
            "--log",
            &log,
            "--run",
            &run.to_string(),
            "-o",
            &next,
        ]);
        rms.push(figures["contour_um"]["rms"].as_f64().unwrap());
        let (seed, after) = (run.to_string(), format!("run{}.csv", run + 1));
        folder.figures(&["simulate", &next, "--against", "part.nc", "-o", &after, "--seed", &seed]);
    }
    assert!(rms[1] < 0.5 * rms[0] && rms[2] < 0.5 * rms[0], "{rms:?}");
    let text = without_mark(&std::fs::read_to_string(folder.path("run4.nc")).unwrap());
    assert!(text.starts_with("G21 G90 G17\nG0 X0 Y0\n") && text.ends_with("M30\n"));

    // A log of something else, or none at all, teaches nothing.
    std::fs::write(folder.path("other.nc"), part.replace("Y20", "Y24").replace("J10", "J12")).unwrap();
    assert!(
        folder
            .fails(1, &["refine", "other.nc", "--machine", "ballscrew", "--log", "run1.csv", "-o", "no.nc"])
            .contains("leaves the desired path")
    );
    folder.fails(2, &["refine", "part.nc", "--machine", "ballscrew", "--log", "none.csv", "-o", "no.nc"]);
    folder.fails(2, &["refine", "part.nc", "--machine", "ballscrew", "--log", "run1.csv", "-o", "part.nc"]);
    assert!(!folder.path("no.nc").exists());
}
