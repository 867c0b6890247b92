//! LinuxCNC's stand-alone interpreter as an oracle: the canonical calls of a program before and after compensation.
//!
//! Skipped where `/usr/bin/rs274` is not installed (Debian: `linuxcnc-uspace`). Thousands of programs:
//!
//! ```sh
//! ORACLE_PROGRAMS=5000 cargo test --release --test oracle generated -- --nocapture
//! ```
//!
//! `ORACLE_SEED=7 ORACLE_PROGRAMS=1` runs one program and prints it. `ORACLE_FOLDER=DIR cargo test --release --test oracle others` compares the
//! programs of a folder too.

mod cases;
mod compare;
mod compensate;
mod coverage;
mod events;
mod follow;
mod generate;
mod random;
mod rs274;
mod run;

use std::path::{Path, PathBuf};

use run::{Tally, check, numbered};

/// Programs that LinuxCNC installs.
const SAMPLES: &str = "/usr/share/linuxcnc/ncfiles";
/// Programs of a run in the gate.
const PROGRAMS: u64 = 300;

fn setting(name: &str) -> Option<u64> {
    std::env::var(name).ok()?.parse().ok()
}

fn is_skipped() -> bool {
    if !rs274::is_installed() {
        println!("skipped: /usr/bin/rs274 is not installed");
    }
    !rs274::is_installed()
}

#[test]
fn control_tests_are_accepted() {
    if is_skipped() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    for machine in ["ballscrew", "bc", "xyzac"] {
        let words = ["excite", "--seconds", "10", "--controller", "linuxcnc", "--machine", machine, "-o", machine];
        let made = std::process::Command::new(env!("CARGO_BIN_EXE_precomp")).args(words).current_dir(&folder).output().unwrap();
        assert!(made.status.success(), "{machine}");
        let program = std::fs::read(folder.path().join(machine).join("control-test.nc")).unwrap();
        let calls = rs274::run(&program, false).unwrap();
        let count = |name: &str| calls.iter().filter(|call| call.name == name).count();
        assert_eq!(count("ARC_FEED"), 20, "{machine}");
        assert!(count("STRAIGHT_FEED") > 300 && count("STRAIGHT_TRAVERSE") > 30 && count("DWELL") > 80, "{machine}");
    }
}

#[test]
fn generated_programs_keep_their_calls() {
    if is_skipped() {
        return;
    }
    let (first, count) = (setting("ORACLE_SEED").unwrap_or(1), setting("ORACLE_PROGRAMS").unwrap_or(PROGRAMS));
    let tally = Tally::default();
    std::thread::scope(|scope| {
        let threads = std::thread::available_parallelism().map_or(1, usize::from) as u64;
        for thread in 0..threads {
            let tally = &tally;
            scope.spawn(move || {
                for seed in (first..first + count).skip(thread as usize).step_by(threads as usize) {
                    let program = generate::program(seed);
                    let program = if seed % 4 == 0 { program } else { numbered(&program) };
                    if count == 1 {
                        println!("{program}");
                    }
                    check(&format!("seed {seed}"), program.as_bytes(), seed, tally);
                }
            });
        }
    });
    let accepted = tally.report("generated programs");
    assert!(accepted * 2 > count as usize, "rs274 accepts too few of the generated programs");
}

/// The programs below a folder.
#[test]
fn arcs_whose_radii_differ_are_accepted_as_by_the_interpreter() {
    if is_skipped() {
        return;
    }
    let mut random = random::Random(5);
    let mut accepted = 0;
    for case in 0..100 {
        let is_inch = case % 3 == 0;
        // Around the tolerance: 0.1 % between a least and a largest difference.
        let radius = 10_f64.powf(random.between(-1.0, 3.5));
        let limit = (0.001 * radius).clamp(0.02, 2.0) * random.between(0.3, 2.5) * if random.chance(0.5) { 1.0 } else { -1.0 };
        let end = (2.0 * radius + limit).max(0.001);
        let units = if is_inch { "G20" } else { "G21" };
        let program = format!("{units} G17 G90 G94 F100\nG0 X0 Y0 Z0\nG2 X{end:.6} Y0 I{radius:.6} J0\nG1 X0 Y1\nM2\n");
        let is_accepted = rs274::run(program.as_bytes(), false).is_ok();
        let read = gcode::interpret(&gcode::parse(program.clone()), &gcode::Dialect::LinuxCnc.into());
        assert_eq!(read.is_ok(), is_accepted, "{program}");
        accepted += usize::from(is_accepted);
    }
    println!("{accepted} of 100 arcs are accepted");
    assert!((20..80).contains(&accepted), "{accepted}");
}

fn programs(folder: &Path) -> Vec<PathBuf> {
    let Ok(entries) = std::fs::read_dir(folder) else { return Vec::new() };
    let mut found: Vec<PathBuf> = entries.filter_map(|entry| Some(entry.ok()?.path())).collect();
    found.sort();
    let is_program =
        |path: &PathBuf| path.extension().is_some_and(|ending| ["ngc", "nc", "gcode"].iter().any(|known| ending == *known));
    found.iter().flat_map(|path| if path.is_dir() { programs(path) } else { vec![path.clone()] }).filter(is_program).collect()
}

#[test]
fn programs_of_others_keep_their_calls() {
    if is_skipped() {
        return;
    }
    let shared = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data/gcode");
    let tally = Tally::default();
    let own = std::env::var("ORACLE_FOLDER").map_or(Vec::new(), |folder| programs(Path::new(&folder)));
    let files = [programs(Path::new(SAMPLES)), programs(&shared), own].concat();
    std::thread::scope(|scope| {
        for half in 0..2 {
            let (files, tally) = (&files, &tally);
            scope.spawn(move || {
                for (seed, file) in files.iter().enumerate().filter(|(index, _)| index % 2 == half) {
                    let program = std::fs::read(file).unwrap();
                    let text = numbered(&String::from_utf8_lossy(&program));
                    check(&file.display().to_string(), text.as_bytes(), seed as u64, tally);
                }
            });
        }
    });
    tally.report("programs of others");
}
