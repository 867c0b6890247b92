//! A run that ends before its time leaves the old output, and nothing else.

use std::collections::BTreeSet;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use crate::common::Folder;

const OLD: &str = "(OLD)\n";

/// Circles of 500 lines.
fn long_program() -> String {
    let line = |k: u32| {
        let angle = 0.05 * f64::from(k);
        format!("G1 X{:.4} Y{:.4} F3000\n", 20.0 * angle.cos() - 20.0, 20.0 * angle.sin())
    };
    format!("G21 G90 G17\nG54 G0 X0. Y0. Z0.\nG1 Z-1. F600\n{}M2\n", (0..500).map(line).collect::<String>())
}

fn names(folder: &Folder) -> BTreeSet<String> {
    let names = std::fs::read_dir(folder.0.path()).unwrap().map(|entry| entry.unwrap().file_name());
    names.map(|name| name.to_string_lossy().into_owned()).collect()
}

fn start(folder: &Folder) -> Child {
    let words = ["compensate", "part.nc", "-m", "machine.model", "-o", "out.nc", "--iterations", "2"];
    let mut command = Command::new(env!("CARGO_BIN_EXE_precomp"));
    command.args(words).current_dir(folder.0.path()).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap()
}

#[cfg(unix)]
#[test]
fn a_run_that_is_stopped_leaves_the_old_output_and_nothing_else() {
    let folder = Folder::with_model();
    folder.write("part.nc", long_program());
    folder.write("out.nc", OLD);
    let before = names(&folder);
    let started = Instant::now();
    assert!(start(&folder).wait().unwrap().success());
    let whole = started.elapsed();
    let new = folder.read("out.nc");
    for signal in ["-INT", "-KILL", "-TERM"] {
        for share in [0.0, 0.3, 0.7] {
            folder.write("out.nc", OLD);
            let mut run = start(&folder);
            std::thread::sleep(Duration::from_millis(5) + whole.mul_f64(share));
            let stopped = Command::new("kill").args([signal, &run.id().to_string()]).status().unwrap();
            assert!(stopped.success(), "{signal} after {share} of the time");
            run.wait().unwrap();
            assert!([OLD, &new].contains(&&*folder.read("out.nc")), "{signal} after {share} of the time");
            assert_eq!(names(&folder), before, "{signal} after {share} of the time");
        }
    }
}

#[test]
fn two_runs_into_one_output_leave_one_of_them() {
    let folder = Folder::with_model();
    folder.write("part.nc", long_program());
    folder.write("out.nc", OLD);
    let before = names(&folder);
    let mut runs = [start(&folder), start(&folder)];
    assert!(runs.iter_mut().all(|run| run.wait().unwrap().success()));
    assert!(folder.read("out.nc").starts_with("(PRECOMP ") && folder.read("out.nc").ends_with("M2\n"));
    assert_eq!(names(&folder), before);
}

#[cfg(unix)]
#[test]
fn an_output_that_finds_no_room_leaves_the_old_one() {
    let folder = Folder::with_model_and_part();
    folder.write("out.nc", OLD);
    let before = names(&folder);
    // No file may grow beyond 512 bytes, as on a full disk.
    let script = "trap '' XFSZ; ulimit -f 1; exec \"$0\" \"$@\"";
    let mut command = Command::new("sh");
    command.args(["-c", script, env!("CARGO_BIN_EXE_precomp"), "compensate", "part.nc", "-m", "machine.model", "-o", "out.nc"]);
    let output = command.current_dir(folder.0.path()).output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.code() == Some(1) && said.contains("cannot write") && said.contains("out.nc"), "{said}");
    assert_eq!((folder.read("out.nc"), names(&folder)), (OLD.into(), before));
}
