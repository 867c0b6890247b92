//! Nothing imports upward: every crate uses only crates of lower floors, and only the crates that should know burn, Parquet or the
//! terminal do.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Floor of every crate, and what it may use of the house.
const FLOORS: [(&str, &[&str]); 7] = [
    ("gcode", &[]),
    ("motion", &[]),
    ("machine", &["motion"]),
    ("compensation", &["motion", "machine"]),
    ("datasets", &["motion", "machine"]),
    ("models", &["motion", "machine"]),
    ("training", &["motion", "machine", "datasets", "models"]),
];

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

fn dependencies(manifest: &Path) -> Vec<String> {
    let text = std::fs::read_to_string(manifest).unwrap();
    let table: toml::Table = text.parse().unwrap();
    table["dependencies"].as_table().unwrap().keys().cloned().collect()
}

#[test]
fn crates_use_only_what_their_floor_allows() {
    let house: Vec<&str> = FLOORS.iter().map(|(name, _)| *name).collect();
    for (name, allowed) in FLOORS {
        for used in dependencies(&root().join(name).join("Cargo.toml")) {
            if house.contains(&used.as_str()) {
                assert!(allowed.contains(&used.as_str()), "{name} must not use {used}");
            }
            let only = BTreeMap::from([
                ("parquet", vec!["datasets"]),
                ("burn", vec!["models", "training"]),
                ("clap", vec![]),
                ("indicatif", vec![]),
            ]);
            if let Some(owners) = only.get(used.as_str()) {
                assert!(owners.contains(&name), "{name} must not know {used}");
            }
        }
    }
}

fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            sources(&path, found);
        } else if path.extension().is_some_and(|ending| ending == "rs") {
            found.push(path);
        }
    }
}

#[test]
fn only_the_product_prints_reads_the_clock_or_exits() {
    for (name, _) in FLOORS {
        let mut files = Vec::new();
        sources(&root().join(name).join("src"), &mut files);
        assert!(!files.is_empty());
        for file in files {
            let text = std::fs::read_to_string(&file).unwrap();
            let code = text.split("#[cfg(test)]").next().unwrap();
            for (number, line) in code.lines().enumerate() {
                let line = line.trim_start();
                if line.starts_with("//") {
                    continue;
                }
                for word in ["println!", "eprintln!", "print!(", "Instant::now", "SystemTime::now", "process::exit"] {
                    assert!(!line.contains(word), "{}:{}: {word}", file.display(), number + 1);
                }
            }
        }
    }
}
