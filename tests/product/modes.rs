//! Modes that a control's profile asks for, and the program's own. Works on the story's model.

use crate::common::Folder;

pub fn stated_for_the_control_and_put_back(folder: &Folder) {
    let part =
        "G21 G90 G17 G61\nG0 X0 Y0 Z0\nG4 P0.2\nG94 G1 X2 F1800\nX20\nG3 X20 Y20 I0 J10\nG1 X0\nG64 P0.1\nG1 Y0\nG0 Z5\nM2\n";
    std::fs::write(folder.path("modes.ngc"), part).unwrap();
    let words = ["compensate", "modes.ngc", "-m", "machine.model", "-o", "modes-c.ngc", "--controller", "linuxcnc"];
    assert_eq!(folder.figures(&words)["changed"], true);
    let out = std::fs::read_to_string(folder.path("modes-c.ngc")).unwrap();
    let lines: Vec<&str> = out.lines().collect();
    // Tolerance and inverse time hold in the stretch, whatever the program says in it, and no line contradicts itself.
    let places = |line: &str| -> Vec<usize> { (0..lines.len()).filter(|k| lines[*k] == line).collect() };
    let stated = places("G64P0.001Q0");
    assert_eq!(stated.len(), 2, "{out}");
    assert!(stated[0] == 3 && lines[stated[1] - 1] == "G64 P0.1", "{out}");
    assert!(lines.iter().all(|line| ["G93", "G94"].iter().filter(|mode| line.contains(*mode)).count() < 2), "{out}");
    // Behind it the program's own hold again.
    assert!(out.contains("G94F1800.\nG64P0.1\nG0 Z5\n"), "{out}");
    // The first line's time is its own, without the wait before it: with 0.2 s more it would be below F300.
    let first = lines[stated[0] + 1];
    let feed: f64 = first.rsplit('F').next().unwrap().parse().unwrap();
    assert!(first.starts_with("G93G1X2") && feed > 400.0, "{out}");
    // Whoever writes for another control gets none of it.
    folder.figures(&["compensate", "modes.ngc", "-m", "machine.model", "-o", "modes-k.ngc", "--controller", "generic"]);
    let out = std::fs::read_to_string(folder.path("modes-k.ngc")).unwrap();
    assert!(!out.contains("G93") && !out.contains("Q0") && out.contains("G94 "), "{out}");
}
