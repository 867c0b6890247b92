//! Feeds of written lines: slow zones before stops, and lines with times of their own.

use machine::MachineSpec;
use motion::Trajectory;
use pipeline::part::WorkOffsets;
use pipeline::refit::{RefitSettings, SlowStop, TimeEncoding, write_program};
use pipeline::{Part, Setup};

const SLOW: SlowStop = SlowStop { length_mm: 0.05, time_s: 0.1 };

/// Every path by 5 µm towards X and Y, with the taper of the part.
const SHIFT_MM: [f64; 3] = [5e-3, 5e-3, 0.0];

fn corrected(part: &Part, shift_mm: [f64; 3]) -> Trajectory {
    let path = part.plan.desired.trajectory();
    let columns = path.columns().iter().zip(shift_mm);
    let columns = columns.map(|(column, by)| column.iter().zip(part.taper()).map(|(x, weight)| x + by * weight).collect());
    path.with_columns(columns.collect()).unwrap()
}

fn written_with(text: &str, settings: RefitSettings) -> String {
    written_by(text, settings, SHIFT_MM)
}

fn planned(text: &str) -> Part {
    let setup = Setup::new(&MachineSpec::builtin("ballscrew").unwrap(), None).unwrap();
    let (program, options) = (gcode::parse(text), gcode::Dialect::LinuxCnc.into());
    let part = Part::planned("part.nc", program, options, &WorkOffsets::default().or_zero(), &setup, &setup.plan_settings());
    part.unwrap()
}

fn written_by(text: &str, settings: RefitSettings, shift_mm: [f64; 3]) -> String {
    let part = planned(text);
    let (bytes, _) = write_program(&part, &corrected(&part, shift_mm), &settings, 0.1, None).unwrap();
    String::from_utf8(bytes).unwrap()
}

fn settings() -> RefitSettings {
    RefitSettings { slow_stop: Some(SLOW), ..RefitSettings::of(TimeEncoding::Keep, None, None, None) }
}

fn written(text: &str) -> String {
    written_with(text, settings())
}

/// Feeds of a written program that are not its own, and the line after each.
fn slow_lines<'a>(text: &'a str, own: &[&str]) -> Vec<(f64, &'a str)> {
    let mut lines = text.lines().peekable();
    let mut found = Vec::new();
    while let Some(line) = lines.next() {
        let Some((_, feed)) = line.split_once('F') else { continue };
        let feed = feed.split_whitespace().next().unwrap();
        if !own.contains(&feed.trim_end_matches('.')) {
            found.push((feed.parse().unwrap(), lines.peek().copied().unwrap_or_default()));
        }
    }
    found
}

#[test]
fn the_zone_before_a_stop_is_slow_and_the_feed_comes_back() {
    let text = written("G21 G90\nG0 X0 Y0 Z0\nG1 X20 F3000\nG0 Z5\nG0 X40 Y0\nG0 Z0\nG1 X60\nM2\n");
    let slow = slow_lines(&text, &["3000"]);
    assert_eq!(slow.len(), 2, "{text}");
    // 30 mm/min; the correction moves the beginning of the zone by up to 5 µm.
    assert!(slow.iter().all(|(feed, next)| (feed - 30.0).abs() < 3.1 && *next == "F3000."), "{text}");
    for (end, before) in [("X20.Y0.F", 19.95), ("X60.Y0.F", 59.95)] {
        let lines: Vec<&str> = text.lines().collect();
        let line = lines.iter().position(|line| line.starts_with(end)).unwrap();
        let start: f64 = lines[line - 1].split('Y').next().unwrap()[1..].parse().unwrap();
        assert!((start - before).abs() < 0.0051, "{text}");
    }
}

#[test]
fn short_lines_and_arcs_are_slow_within_the_zone_only() {
    let short: String = (1..=200).map(|k| format!("X{:.3}\n", 10.0 + 0.02 * f64::from(k))).collect();
    let text = written(&format!("G21 G90\nG0 X0 Y0 Z0\nG1 X10 F3000\n{short}G0 Z5\nM2\n"));
    // 0.05 mm are half a line of 0.02 mm and two whole ones.
    let slow = slow_lines(&text, &["3000"]);
    assert_eq!(slow.len(), 3, "{text}");
    assert!(slow.iter().all(|(feed, _)| (feed - 30.0).abs() < 6.0) && slow[2].1 == "F3000.", "{text}");
    let arc = written("G21 G90 G17\nG0 X0 Y0 Z0\nG2 X10 Y0 I5 J0 F3000\nG0 Z5\nM2\n");
    assert!(arc.contains("G1X10.Y0.F") && slow_lines(&arc, &["3000"]).len() == 1, "{arc}");
}

#[test]
fn a_stop_is_left_as_it_is_where_a_slow_feed_would_act_elsewhere() {
    let head = "G21 G90\nG0 X0 Y0 Z0\n";
    for (what, cut) in [
        // Whatever a block calls would run at the slow feed.
        ("an M code", "G1 X20 F3000 M9"),
        // An added point would become a stop.
        ("an exact stop", "G61\nG1 X20 F3000"),
        ("inverse time", "G93\nG1 X20 F150"),
        ("a slow feed", "G1 X20 F50"),
        ("a tap that comes back", "S500 M3\nG1 Z-10 F3000\nM4\nG1 Z0\nM5"),
        ("a tap that comes back in one block", "S500 M3\nG1 Z-10 F3000\nG1 Z0 M4"),
        ("a laser", "M3 S200\nG1 X20 F3000\nM5"),
        ("a laser off in a rapid", "M4\nG1 X20 F3000 S200\nG0 Y3 S0"),
        ("an output", "M62 P1\nG1 X20 F3000\nM63 P1"),
        ("a short move", "G1 X0.09 F3000"),
    ] {
        let text = format!("{head}{cut}\nG0 Z5\nM2\n");
        assert_eq!(written(&text), written_with(&text, RefitSettings { slow_stop: None, ..settings() }), "{what}");
    }
    // Ten increments of a control with two decimals.
    let cut = format!("{head}G1 X20 F3000\nG0 Z5\nM2\n");
    let coarse = written_with(&cut, RefitSettings { decimals: 2, ..settings() });
    assert_eq!(slow_lines(&coarse, &["3000"]), [], "{coarse}");
    // Between two cuts that go on the control does not stop.
    let on = written(&format!("{head}G1 X20 F3000\nX40\nG0 Z5\nM2\n"));
    assert_eq!(slow_lines(&on, &["3000"]).len(), 1, "{on}");
}

#[test]
fn a_shift_along_the_path_makes_no_feed_above_the_programs_and_none_of_zero() {
    let slow_stop = Some(SlowStop { length_mm: 0.012, time_s: 0.1 });
    let slow = |along_mm: f64| {
        let text = written_by(
            "G21 G90\nG0 X0 Y0 Z0\nG1 X20 F16\nG0 Z5\nM2\n",
            RefitSettings { slow_stop, ..settings() },
            [along_mm, 0.0, 0.0],
        );
        slow_lines(&text, &["16"]).into_iter().map(|(feed, _)| feed).collect::<Vec<f64>>()
    };
    // The line is 32 µm long instead of 12, or the point before it lies on the end.
    assert!(slow(-0.02).is_empty());
    assert_eq!(slow(0.012), vec![1.0]);
    assert!(slow(0.001)[0] > 6.0);
}

#[test]
fn lines_with_times_of_their_own_are_slow_too() {
    let cut = "G21 G90\nG0 X0 Y0 Z0\nG1 X20 F3000\nG0 Z5\nM2\n";
    let last = |encoding: TimeEncoding| {
        let text = written_with(cut, RefitSettings { encoding, ..settings() });
        let line = text.lines().find(|line| line.starts_with("X20.Y0.F")).unwrap_or_else(|| panic!("{text}"));
        line.split_once('F').unwrap().1.parse::<f64>().unwrap()
    };
    assert_eq!(last(TimeEncoding::G93), 60.0 / SLOW.time_s);
    assert!((last(TimeEncoding::G94) - 30.0).abs() < 3.1);
}

#[test]
fn slow_stops_are_in_the_units_and_distances_of_the_program() {
    let inch = written("G20 G90\nG0 X0 Y0 Z0\nG1 X1 F100\nG0 Z0.2\nM2\n");
    let [(feed, next)] = slow_lines(&inch, &["100"])[..] else { panic!("{inch}") };
    assert!((feed * 25.4 - 30.0).abs() < 3.1 && next == "F100.", "{inch}");
    let incremental = written("G21 G90\nG0 X0 Y0 Z0\nG91\nG1 X20 F3000\nG0 Z5\nM2\n");
    let [(feed, next)] = slow_lines(&incremental, &["3000"])[..] else { panic!("{incremental}") };
    assert!((feed - 30.0).abs() < 3.1 && next == "F3000.", "{incremental}");
}

#[test]
fn lines_with_times_of_their_own_take_little_longer_where_the_plan_speeds_up_and_brakes() {
    let text = "G21 G90\nG0 X0 Y0 Z0\nG1 X20 F3000\nX20 Y10\nX0\nM2\n";
    let seconds = |text: &str| planned(text).plan.desired.trajectory().duration_s();
    for encoding in [TimeEncoding::G93, TimeEncoding::G94] {
        let text_with_times = written_with(text, RefitSettings::of(encoding, None, None, None));
        let (before, after) = (seconds(text), seconds(&text_with_times));
        // With the mean speed of each line 8.5 % longer.
        assert!(after < 1.05 * before, "{encoding:?}: {before} {after}");
        if encoding == TimeEncoding::G94 {
            // No line is faster than the program, but for the correction along it.
            assert!(slow_lines(&text_with_times, &[]).iter().all(|(feed, _)| *feed < 3010.0), "{text_with_times}");
        }
    }
}
