//! The examples do what their page says.

use std::path::Path;

use crate::common::{Folder, without_mark};

/// A folder with the example's files.
fn examples() -> Folder {
    let folder = Folder::new();
    for name in ["mill.toml", "log-1.csv", "log-2.csv", "pocket.nc", "expected.nc"] {
        folder.write(name, std::fs::read(Path::new(env!("CARGO_MANIFEST_DIR")).join("examples").join(name)).unwrap());
    }
    folder
}

/// Words of a program with their numbers: `G1X-12.5` as (`G`, 1) and (`X`, -12.5).
fn words(program: &str) -> Vec<(char, f64)> {
    let comment = |line: &str| line.split(['(', '%']).next().unwrap_or_default().to_owned();
    let text: String = program.lines().map(comment).collect();
    let starts: Vec<(usize, char)> = text.char_indices().filter(|(_, c)| c.is_ascii_alphabetic()).collect();
    let end = |word: usize| starts.get(word + 1).map_or(text.len(), |next| next.0);
    let number = |word: usize| text[starts[word].0 + 1..end(word)].trim().parse().unwrap();
    (0..starts.len()).map(|word| (starts[word].1, number(word))).collect()
}

#[test]
fn the_example_gives_what_its_page_says() {
    let folder = examples();
    folder.figures(&["train", "log-1.csv", "log-2.csv", "--machine", "mill.toml", "--predictor", "linear", "-o", "mill.model"]);
    folder.figures(&["compensate", "pocket.nc", "-m", "mill.model", "-o", "compensated.nc", "--work-offset", "0,0,0"]);
    // Other processors round the last digits differently: a tenth of a micrometre.
    let (found, expected) = (folder.read("compensated.nc"), folder.read("expected.nc"));
    let (found, expected) = (words(&without_mark(&found)), words(&without_mark(&expected)));
    assert_eq!(found.len(), expected.len());
    for (found, expected) in found.iter().zip(&expected) {
        assert!(found.0 == expected.0 && (found.1 - expected.1).abs() <= 1e-4 + 1e-9, "{found:?} {expected:?}");
    }
    let run = |program: &str| {
        let words = ["simulate", program, "--against", "pocket.nc", "--machine", "mill.toml", "-o", "run.csv"];
        folder.figures(&words)["contour_um"].clone()
    };
    let (before, after) = (run("pocket.nc"), run("compensated.nc"));
    // The figures of examples/README.md.
    let page = include_str!("../../examples/README.md");
    for figures in [&before, &after] {
        let [rms, max] = ["rms", "max"].map(|key| figures[key].as_f64().unwrap());
        assert!(page.contains(&format!("{rms:.2} µm RMS, {max:.2} µm MAX")), "{rms:.3} {max:.3}: {page}");
    }
    assert!(after["rms"].as_f64().unwrap() < 0.5 * before["rms"].as_f64().unwrap(), "{before} {after}");
}
