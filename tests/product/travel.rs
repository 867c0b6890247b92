//! Paths that leave an axis's travel, on a machine whose axes are the coordinates of the tip.

use crate::common::{Folder, text};

/// The built-in machine with a travel of ±50 mm of its first axis.
fn folder_with_travel() -> Folder {
    let folder = Folder::new();
    let machine = include_str!("../../machine/machines/ballscrew.toml");
    let limited = machine.replacen("name = \"x\"\n", "name = \"x\"\ntravel_mm = [-50.0, 50.0]\n", 1);
    assert_ne!(limited, machine);
    std::fs::write(folder.path("short.toml"), limited).unwrap();
    std::fs::write(folder.path("part.nc"), "G21 G90 G17\nG0 X0 Y0 Z0\nG1 X20 F1200\nG1 X60\nG1 X0\nM30\n").unwrap();
    folder
}

#[test]
fn a_program_beyond_an_axis_travel_is_refused_with_its_line() {
    let folder = folder_with_travel();
    let words = ["simulate", "part.nc", "--machine", "short.toml", "-o", "run.csv"];
    let said = folder.fails(1, &words);
    assert!(said.contains("part.nc:4:1") && said.contains("axis x would be at 50.0"), "{said}");
    assert!(said.contains("-50.000 to 50.000 mm") && said.contains("--work-offset"), "{said}");
    assert!(!folder.path("run.csv").exists());
    folder.figures(&[&words[..], &["--work-offset", "-30,0,0"]].concat());
}

#[test]
fn curves_and_references_beyond_an_axis_travel_are_refused_with_their_time() {
    let folder = folder_with_travel();
    folder.figures(&["simulate", "part.nc", "-o", "long.csv"]);
    let rows = std::fs::read_to_string(folder.path("long.csv")).unwrap();
    let reference: String = rows
        .lines()
        .map(|line| line.split(',').collect::<Vec<_>>())
        .map(|cells| {
            format!(
                "{},{},{},{}\n",
                cells[0],
                cells[1].replace("_ref", ""),
                cells[3].replace("_ref", ""),
                cells[5].replace("_ref", "")
            )
        })
        .collect();
    std::fs::write(folder.path("reference.csv"), reference).unwrap();
    let said = folder.fails(1, &["simulate", "reference.csv", "--machine", "short.toml", "-o", "run.csv"]);
    assert!(said.contains("reference.csv: at t = ") && said.contains("axis x would be at 50.0"), "{said}");
    let narrow = std::fs::read_to_string(folder.path("short.toml")).unwrap().replace("[-50.0, 50.0]", "[-5.0, 5.0]");
    std::fs::write(folder.path("narrow.toml"), narrow).unwrap();
    assert!(
        folder.fails(1, &["simulate", "curve:crown", "--machine", "narrow.toml", "-o", "run.csv"]).contains("crown: at t = ")
    );
}

#[test]
fn of_a_part_without_a_place_only_the_extent_is_compared() {
    let folder = folder_with_travel();
    folder.figures(&["simulate", "curve:crown", "-o", "run.csv"]);
    folder.figures(&["train", "run.csv", "--machine", "short.toml", "--predictor", "linear", "-o", "short.model"]);
    let output = folder.precomp(&["predict", "part.nc", "-m", "short.model"]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert!(text(&output.stdout).contains("within their travel was not checked"), "{}", text(&output.stdout));
    let placed = folder.fails(1, &["predict", "part.nc", "-m", "short.model", "--work-offset", "0,0,0"]);
    assert!(placed.contains("part.nc:4:1"), "{placed}");
    let part = std::fs::read_to_string(folder.path("part.nc")).unwrap();
    std::fs::write(folder.path("large.nc"), part.replace("X60", "X101")).unwrap();
    let large = folder.fails(1, &["predict", "large.nc", "-m", "short.model"]);
    assert!(large.contains("axis x would cover 101.0") && large.contains("travel of 100.000 mm"), "{large}");
}

#[test]
fn the_machine_file_says_where_a_part_lies() {
    let folder = folder_with_travel();
    let machine = std::fs::read_to_string(folder.path("short.toml")).unwrap();
    let (head, axes) = machine.split_at(machine.find("[[axes]]").unwrap());
    let with =
        |offsets: &str| std::fs::write(folder.path("placed.toml"), format!("{head}[work_offsets]\n{offsets}\n{axes}")).unwrap();
    let words = ["simulate", "part.nc", "--machine", "placed.toml", "-o", "run.csv"];
    with("G54 = [-30.0, 0.0, 0.0]");
    folder.figures(&words);
    // The command line stands above the file.
    assert!(folder.fails(1, &[&words[..], &["--work-offset", "0,0,0"]].concat()).contains("axis x would be at 50.0"));
    with("G60 = [-30.0, 0.0, 0.0]");
    assert!(folder.fails(1, &words).contains("work_offsets.G60"));
    with("G54 = [inf, 0.0, 0.0]");
    assert!(folder.fails(1, &words).contains("work_offsets.G54[0]"));
}
