//! Programs whose place on the machine is known, and those whose place is not. Works on the story's part and model.

use serde_json::Value;

use crate::common::{Folder, text};

fn said(folder: &Folder, words: &[&str]) -> String {
    let output = folder.precomp(words);
    assert!(output.status.success(), "{words:?}: {}", text(&output.stderr));
    text(&output.stdout)
}

pub fn what_depends_on_position_is_left_out_where_the_part_has_no_place(folder: &Folder) {
    let predict =
        |more: &[&str]| -> Value { folder.figures(&[&["predict", "part.nc", "-m", "machine.model"][..], more].concat()) };
    let unknown = predict(&[]);
    let left_out = &unknown["left_out"];
    assert!(left_out["axes"]["x"]["rms_um"].as_f64().unwrap() > 0.01, "{unknown}");
    assert_eq!(left_out["contour_um_without"], unknown["contour_um"]);
    let at_zero = predict(&["--work-offset", "0,0,0"]);
    assert!(at_zero["left_out"].is_null(), "{at_zero}");
    assert_eq!(left_out["contour_um_at_zero"], at_zero["contour_um"]);
    assert_ne!(at_zero["contour_um"], unknown["contour_um"]);
    // Where the part lies matters once it is said, by the option, by coordinate system, and by the machine file.
    let there = predict(&["--work-offset", "1.7,-2.3,0"]);
    assert_ne!(there["contour_um"], at_zero["contour_um"]);
    assert_eq!(predict(&["--work-offset", "G54=1.7,-2.3,-4", "--tool-length", "4"]), there);
    assert!(predict(&["--work-offset", "G55=1.7,-2.3,0"])["left_out"].is_object());
    let machine = include_str!("../../machine/machines/ballscrew.toml");
    let (head, axes) = machine.split_at(machine.find("[[axes]]").unwrap());
    std::fs::write(folder.path("placed.toml"), format!("{head}[work_offsets]\nG54 = [1.7, -2.3, 0.0]\n\n{axes}")).unwrap();
    let words = ["compensate", "part.nc", "-m", "machine.model", "-o", "placed.nc"];
    assert!(folder.figures(&[&words[..], &["--machine", "placed.toml"]].concat())["left_out"].is_null());

    let unknown = said(folder, &words);
    // Why learning ended is said, in words that the JSON has too.
    let ended = folder.figures(&words)["ended"].as_str().unwrap().to_owned();
    assert!(ended.starts_with("ended ") && unknown.contains(&format!("updates on the model; {ended})")), "{unknown}");
    assert!(unknown.contains("the work offset is not known") && unknown.contains("Give --work-offset"), "{unknown}");
    // A curve is in machine coordinates, and a log of the program says where the part lies.
    assert!(predict(&["--work-offset", "0,0,0"])["left_out"].is_null());
    let curve = said(folder, &["predict", "curve:crown", "-m", "machine.model"]);
    assert!(!curve.contains("work offset"), "{curve}");
    folder.figures(&["simulate", "part.nc", "--work-offset", "1.7,-2.3,0", "-o", "placed.csv"]);
    let by_log = folder.figures(&[&words[..], &["--reference", "placed.csv"]].concat());
    assert!(by_log["left_out"].is_null(), "{by_log}");

    folder.fails(2, &[&words[..], &["--work-offset", "G60=1,2,3"]].concat());
    folder.fails(2, &[&words[..], &["--work-offset", "1,2"]].concat());
}

pub fn report_and_terminal_give_the_same_figures(folder: &Folder) {
    let words = ["compensate", "part.nc", "-m", "machine.model", "-o", "reported.nc", "--report", "forecast.html"];
    let terminal = said(folder, &words);
    let line = terminal.lines().find(|line| line.starts_with("predicted contour error over feed moves")).unwrap();
    let numbers: Vec<&str> = line.split([' ', ':', ',']).filter(|word| word.parse::<f64>().is_ok()).collect();
    let [before_rms, after_rms, before_max, after_max] = numbers[..4] else { panic!("{line}") };
    let page = std::fs::read_to_string(folder.path("forecast.html")).unwrap();
    assert!(page.contains("over feed moves"));
    for (run, rms, max) in [("uncompensated", before_rms, before_max), ("</span>compensated", after_rms, after_max)] {
        let row = page.lines().find(|line| line.contains(&format!("{run} (forecast)</td>"))).unwrap();
        assert!(row.contains(&format!("<td>{rms}</td>")) && row.contains(&format!("<td>{max}</td>")), "{row}\n{line}");
    }
}
