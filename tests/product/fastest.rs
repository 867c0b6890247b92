//! The shortest cycle within a tolerance, the least error within a cycle time, and the trade-off between both.

use serde_json::Value;

use crate::common::Folder;

/// Runs `part.nc` compensated into `out` with these options; its figures.
fn compensate(folder: &Folder, out: &str, more: &[&str]) -> Value {
    folder.figures(&[&["compensate", "part.nc", "-m", "machine.model", "-o", out][..], more].concat())
}

fn figure(of: &Value, name: &str) -> f64 {
    of[name].as_f64().unwrap_or_else(|| panic!("{name} in {of}"))
}

/// All F words in lines with a motion, in their order: those of canned cycles, and lines that only restore the feed, are left out.
fn feeds(program: &str) -> Vec<f64> {
    let cuts = program.lines().filter(|line| line.contains(['X', 'Y', 'Z']) && !line.contains("G81") && !line.contains('('));
    cuts.filter_map(|line| line.split_once('F')?.1.split(|c: char| !c.is_ascii_digit() && c != '.').next()?.parse().ok())
        .collect()
}

#[test]
fn the_shortest_cycle_runs_within_the_error_of_the_uncompensated_program() {
    let folder = Folder::with_model_and_part();
    let raw = folder.figures(&["simulate", "part.nc", "-o", "raw.csv"]);
    let raw_um = raw["contour_um"]["max"].as_f64().unwrap();
    let tolerance = format!("{}um", 0.8 * raw_um);
    let made = compensate(&folder, "fast.nc", &["--tolerance", &tolerance, "--fastest", "--may-exceed-feed", "100"]);
    let chosen = &made["feeds"];
    assert_eq!((&chosen["goal"], chosen["lines_above"].as_array().unwrap().len()), (&"fastest".into(), 0), "{chosen}");
    assert!(figure(chosen, "max_after_um") <= 0.8 * raw_um, "{chosen}");
    // Rounded by the points, corners may be passed a little faster than in the plan of the program.
    assert!(figure(chosen, "cycle_after_s") >= 0.97 * figure(&chosen["cycle_without_tolerance_s"], "allowed"), "{chosen}");
    // What a run comes to, in both figures.
    let cut = folder.figures(&["simulate", "fast.nc", "--against", "part.nc", "-o", "cut.csv"]);
    assert!(cut["contour_um"]["max"].as_f64().unwrap() <= raw_um, "{cut} against {raw}");
    assert!(figure(&cut, "seconds") <= 0.7 * figure(&raw, "seconds"), "{cut} against {raw}");
    // Feeds are at most twice those of the program, and chips are spoken of.
    let most = feeds(&folder.read("fast.nc")).into_iter().fold(0.0, f64::max);
    assert!(most > 2400.0 && most <= 4800.0, "F{most}");
    assert_eq!(chosen["chip_loads"][0]["tool"], 1, "{chosen}");
    assert!(figure(&chosen["chip_loads"][0], "feed_after_mm_min") <= 4800.0 + 1e-6, "{chosen}");
}

#[test]
fn feeds_stay_below_the_programmed_ones_unless_they_may_exceed_them_and_below_the_largest() {
    let folder = Folder::with_model_and_part();
    let most = |out: &str, more: &[&str]| {
        compensate(&folder, out, &[&["--tolerance", "20um", "--fastest"][..], more].concat());
        feeds(&folder.read(out)).into_iter().fold(0.0, f64::max)
    };
    assert_eq!(most("own.nc", &[]), 2400.0);
    let bounded = most("bounded.nc", &["--may-exceed-feed", "100", "--max-feed", "3000"]);
    assert!(bounded > 2400.0 && bounded <= 3000.0, "F{bounded}");
    let slow = most("slow.nc", &["--max-feed", "1200"]);
    assert!(slow <= 1200.0, "F{slow}");
}

#[test]
fn only_the_named_lines_and_tools_change_their_feeds() {
    let folder = Folder::with_model_and_part();
    let all = ["--tolerance", "20um", "--fastest", "--may-exceed-feed", "100"];
    // Line 9 of the file is N70, the first half circle.
    let made = compensate(&folder, "some.nc", &[&all[..], &["--lines", "9-9"]].concat());
    assert_eq!(made["feeds"]["faster_moves"], 1, "{}", made["feeds"]);
    let program = folder.read("some.nc");
    let at = |line: &str| program.find(line).unwrap_or_else(|| panic!("{line} in {program}"));
    let raised: Vec<f64> = feeds(&program[at("N70")..at("N80")]);
    assert!(raised.iter().any(|feed| *feed > 2400.0), "{program}");
    let before = feeds(&program[..at("N70")]);
    assert!(before.iter().all(|feed| *feed <= 2400.0), "{program}");
    // The feed of the program is in force again behind it.
    assert_eq!(feeds(&program[at("N80")..]).first(), Some(&2400.0), "{program}");
    let said =
        folder.fails(1, &[&["compensate", "part.nc", "-m", "machine.model", "-o", "x.nc"][..], &all, &["--tools", "7"]].concat());
    assert!(said.contains("--tools"), "{said}");
}

#[test]
fn a_given_cycle_time_is_kept_with_less_error_than_a_shorter_one() {
    let folder = Folder::with_model_and_part();
    let made = |out: &str, change: &str| {
        let words = ["--max-time", change, "--may-exceed-feed", "100"];
        compensate(&folder, out, &words)["feeds"].clone()
    };
    let (same, short) = (made("same.nc", "+60%"), made("short.nc", "-40%"));
    for (feeds, change) in [(&same, 0.6), (&short, -0.4)] {
        assert!(figure(feeds, "cycle_after_s") <= (1.0 + change) * figure(feeds, "cycle_before_s") * 1.002, "{feeds}");
    }
    assert!(figure(&same, "max_after_um") < figure(&short, "max_after_um"), "{same} against {short}");
}

#[test]
fn the_trade_off_falls_in_error_as_it_grows_in_time() {
    let folder = Folder::with_model_and_part();
    let made = compensate(&folder, "own.nc", &["--pareto", "--may-exceed-feed", "100"]);
    let pareto = &made["feeds"]["pareto"];
    let points: Vec<(f64, f64)> =
        pareto["points"].as_array().unwrap().iter().map(|point| (figure(point, "cycle_s"), figure(point, "max_um"))).collect();
    assert!((3..=10).contains(&points.len()), "{pareto}");
    assert!(points.windows(2).all(|pair| pair[0].0 < pair[1].0 && pair[0].1 > pair[1].1), "{pareto}");
    assert!(points[0].0 < figure(&pareto["programmed"], "cycle_s"), "{pareto}");
    // Without a goal the program keeps its feeds.
    compensate(&folder, "plain.nc", &[]);
    assert!(folder.read("own.nc") == folder.read("plain.nc"), "the trade-off changes the program");
}

#[test]
fn limits_of_feeds_without_a_goal_are_refused() {
    let folder = Folder::with_model_and_part();
    for words in [&["--may-exceed-feed", "10"][..], &["--max-feed", "900"], &["--lines", "3-9"], &["--tools", "1"]] {
        let said = folder.fails(2, &[&["compensate", "part.nc", "-m", "machine.model", "-o", "x.nc"], words].concat());
        assert!(said.contains("--max-time"), "{said}");
    }
    for words in
        [&["--fastest"][..], &["--tolerance", "5um", "--fastest", "--keep-time"], &["--tolerance", "5um", "--max-time", "1%"]]
    {
        folder.fails(2, &[&["compensate", "part.nc", "-m", "machine.model", "-o", "x.nc"], words].concat());
    }
}
