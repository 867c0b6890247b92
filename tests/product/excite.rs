//! Where excitation moves.

use crate::common::Folder;

/// A machine that counts X from one end of its travel and Z downwards from the other; Y has no stated travel.
const ROUTER: &str = "name = \"router\"
sampling_period_ms = 2.0
path = { velocity_mm_s = 150.0, acceleration_mm_s2 = 1000.0, jerk_mm_s3 = 50000.0, centripetal_mm_s2 = 1000.0 }
axes = [
  { name = \"x\", kind = \"linear\", velocity_mm_s = 150.0, acceleration_mm_s2 = 1000.0, jerk_mm_s3 = 50000.0, travel_mm = [0.0, 600.0] },
  { name = \"y\", kind = \"linear\", velocity_mm_s = 150.0, acceleration_mm_s2 = 1000.0, jerk_mm_s3 = 50000.0 },
  { name = \"z\", kind = \"linear\", velocity_mm_s = 50.0, acceleration_mm_s2 = 500.0, jerk_mm_s3 = 50000.0, travel_mm = [-80.0, 0.0] },
]
";

/// Lowest and highest position of an axis in all runs of the folder `e`.
fn covered(figures: &serde_json::Value, axis: &str) -> (f64, f64) {
    let range = &figures["covered"][axis];
    (range[0].as_f64().unwrap(), range[1].as_f64().unwrap())
}

#[test]
fn motion_lies_within_the_travel_about_a_stated_origin_or_near_zero() {
    let folder = Folder::new();
    std::fs::write(folder.path("router.toml"), ROUTER).unwrap();
    let words = ["excite", "--machine", "router.toml", "-o", "e", "--seconds", "30"];

    // About zero there is no room on this machine: the motion begins at the end of the travel.
    let figures = folder.figures(&words);
    let ((x_low, x_high), (y_low, y_high), (z_low, z_high)) =
        (covered(&figures, "x"), covered(&figures, "y"), covered(&figures, "z"));
    assert!(x_low >= 30.0 && x_high <= 150.0 && x_high - x_low > 80.0, "{x_low} {x_high}");
    assert!(y_low >= -60.0 && y_high <= 60.0 && y_high - y_low > 80.0, "{y_low} {y_high}");
    assert!(z_low >= -76.0 && z_high <= -4.0 && z_high - z_low > 45.0, "{z_low} {z_high}");

    let figures = folder.figures(&[&words[..], &["--origin", "x=300,y=-200", "--origin", "z=-30", "--travel", "50"]].concat());
    let ((x_low, x_high), (y_low, y_high), (z_low, z_high)) =
        (covered(&figures, "x"), covered(&figures, "y"), covered(&figures, "z"));
    assert!(x_low >= 250.0 && x_high <= 350.0 && x_high - x_low > 60.0, "{x_low} {x_high}");
    assert!(y_low >= -250.0 && y_high <= -150.0 && y_high - y_low > 60.0, "{y_low} {y_high}");
    assert!(z_low >= -76.0 && z_high <= -4.0, "{z_low} {z_high}");
    let program = std::fs::read_to_string(folder.path("e/01-full.nc")).unwrap();
    let first_x = program.lines().find_map(|line| line.strip_prefix("G0 X")).unwrap();
    let first_x: f64 = first_x.split_whitespace().next().unwrap().parse().unwrap();
    assert!((250.0..=350.0).contains(&first_x), "{first_x}");
    // The control test keeps within the same region.
    let test = std::fs::read_to_string(folder.path("e/control-test.nc")).unwrap();
    let xs = test.lines().flat_map(|line| line.split_whitespace().find_map(|word| word.strip_prefix('X')?.parse::<f64>().ok()));
    assert!(xs.clone().count() > 20);
    xs.for_each(|x| assert!((250.0..=350.0).contains(&x), "{x}"));
}

#[test]
fn joints_that_no_program_names_get_references_alone() {
    let joint = |name: &str| {
        format!(
            "[[axes]]\nname = \"{name}\"\nkind = \"rotary\"\nvelocity_rad_s = 1.0\nacceleration_rad_s2 = 4.0\njerk_rad_s3 = 80.0\n"
        )
    };
    let path = "velocity_mm_s = 500\nacceleration_mm_s2 = 2000\njerk_mm_s3 = 20000\ncentripetal_mm_s2 = 2000\n";
    let arm = format!("name = \"arm\"\nsampling_period_ms = 8\n[path]\n{path}{}{}", joint("j1"), joint("j2"));
    let folder = Folder::new();
    folder.write("arm.toml", arm);
    let said = folder.prints(&["excite", "--machine", "arm.toml", "-o", "e", "--seconds", "20"]);
    assert!(said.contains("no program has words for j1, j2"), "{said}");
    let mut names: Vec<String> =
        std::fs::read_dir(folder.path("e")).unwrap().map(|file| file.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    assert!(names.len() == 10 && names.iter().all(|name| name.ends_with(".csv")), "{names:?}");
    let table = folder.read("e/01-full.csv");
    assert_eq!(table.lines().find(|line| !line.starts_with('#')), Some("t,j1,j2"));
}

#[test]
fn an_origin_without_room_is_refused() {
    let folder = Folder::new();
    std::fs::write(folder.path("router.toml"), ROUTER).unwrap();
    let words = ["excite", "--machine", "router.toml", "-o", "e"];
    for (origin, status, said) in [
        ("x=599", 1, "the origin of axis `x` is 599 mm; excitation keeps within 30.000 to 570.000 mm"),
        ("a=10", 1, "the origin names axis `a`, and the machine has x, y, z"),
        ("300", 2, "as in x=150"),
        ("xy=3", 2, "as in x=150"),
    ] {
        let message = folder.fails(status, &[&words[..], &["--origin", origin]].concat());
        assert!(message.contains(said), "{message}");
        assert!(!folder.path("e").exists());
    }
}

/// A slow spiral of short lines about X 70, which reverses all the time, beyond the ±60 mm of the log.
fn slow_part() -> String {
    let mut text = String::from("G21 G90 G94 G17\nG0 X70. Y0. Z0.\nG1 F600\n");
    for k in 1..=300 {
        let angle = f64::from(k) * 0.1;
        text += &format!("X{:.3} Y{:.3}\n", 70.0 + 0.02 * f64::from(k) * angle.cos(), 0.02 * f64::from(k) * angle.sin());
    }
    text + "M2\n"
}

#[test]
fn the_next_excitation_is_of_what_the_model_knows_least_on_a_part() {
    let folder = Folder::new();
    folder.train_on("ballscrew", "20", "linear");
    folder.write("part.nc", slow_part());
    let words = ["excite", "--after", "machine.model", "-o", "more", "--seconds", "20"];
    let kinds = |figures: &serde_json::Value| -> Vec<String> {
        figures["runs"].as_array().unwrap().iter().map(|run| run.as_str().unwrap()[3..].to_owned()).collect()
    };

    // In general: every axis is expected to gain, and the machine is the model's.
    let general = folder.figures(&words);
    assert!((2..=20).contains(&kinds(&general).len()), "{general}");
    assert!((14.0..=30.0).contains(&general["seconds"].as_f64().unwrap()), "{general}");
    for axis in ["x", "y", "z"] {
        let [before, after] = ["rms_before", "rms_after"].map(|key| general["expected"][axis][key].as_f64().unwrap());
        assert!(after < before && after > 0.8 * before, "{general}");
    }

    // On the part: around it, and of its many reversals.
    let of_part = folder.figures(&[&words[..], &["--for", "part.nc", "--work-offset", "0,0,0"]].concat());
    let (low, high) = covered(&of_part, "x");
    // The machine states no travel: not beyond the part, which ends at 76.
    assert!(low >= 54.0 && high <= 76.0 && high - low > 15.0, "{low} {high}");
    let sharp = |figures: &serde_json::Value| kinds(figures).iter().filter(|kind| *kind == "sharp").count();
    assert!(sharp(&of_part) > sharp(&general), "{of_part} {general}");
    for run in of_part["runs"].as_array().unwrap() {
        let name = run.as_str().unwrap();
        assert!(folder.path(&format!("more/{name}.csv")).exists() && folder.path(&format!("more/{name}.nc")).exists());
    }

    // A machine without stated travel is not sent beyond what its log shows.
    let logged = folder.figures(&["excite", "--machine", "ballscrew", "-o", "again", "--seconds", "20"]);
    let runs = logged["runs"].as_array().unwrap().iter();
    let logs: Vec<String> = runs.map(|run| format!("log-{}.csv", run.as_str().unwrap())).collect();
    let words = ["train", "--predictor", "linear", "-o", "of-log.model"];
    folder.figures(&words.into_iter().chain(logs.iter().map(String::as_str)).collect::<Vec<_>>());
    let of_log = folder.figures(&["excite", "--after", "of-log.model", "-o", "bounded", "--seconds", "20"]);
    for axis in ["x", "y", "z"] {
        let ((low, high), (lowest, highest)) = (covered(&of_log, axis), covered(&logged, axis));
        assert!(low >= lowest - 1e-6 && high <= highest + 1e-6, "{axis}: {low} {high}, {lowest} {highest}");
    }

    // Without an offset it is not known where the part lies.
    let said = folder.precomp(&["excite", "--after", "machine.model", "-o", "more", "--seconds", "20", "--for", "part.nc"]);
    assert!(crate::common::text(&said.stdout).contains("--work-offset"));
    folder.fails(2, &["excite", "--for", "part.nc", "-o", "other"]);
    folder.fails(1, &["excite", "--after", "part.nc", "-o", "other"]);
}

#[test]
fn programs_run_under_the_work_offset_of_the_machine_file() {
    let folder = Folder::new();
    let axis = |name: &str| {
        format!(
            "[[axes]]\nkind = \"linear\"\nname = \"{name}\"\nvelocity_mm_s = 200.0\nacceleration_mm_s2 = 1000.0\njerk_mm_s3 = 50000.0\ntravel_mm = [0.5, 300.0]\n"
        )
    };
    let machine = |offsets: &str| {
        format!(
            "name = \"mill\\nG0 X999\"\nsampling_period_ms = 2.0\n[path]\nvelocity_mm_s = 200.0\nacceleration_mm_s2 = 1000.0\njerk_mm_s3 = 50000.0\n\
             centripetal_mm_s2 = 1000.0\n{offsets}[kinematics]\nkind = \"cartesian\"\n{}",
            ["x", "y", "z"].map(axis).concat()
        )
    };
    // A travel without 0 is no obstacle, and a name stays within its comment.
    folder.write("zero.toml", machine(""));
    folder.write("placed.toml", machine("[work_offsets]\nG54 = [250.0, 200.0, 150.0]\n"));
    folder.figures(&["excite", "--machine", "zero.toml", "--seconds", "5", "-o", "zero"]);
    folder.figures(&["excite", "--machine", "placed.toml", "--seconds", "5", "-o", "placed"]);
    for name in ["01-full", "control-test"] {
        let [zero, placed] = ["zero", "placed"].map(|of| folder.read(&format!("{of}/{name}.nc")));
        for (letter, offset, lines) in [('X', 250.0, &zero), ('Y', 200.0, &zero), ('Z', 150.0, &zero)] {
            let [from_zero, from_offset] = [lines, &placed].map(|text| extent(text, letter));
            for (zero, placed) in from_zero.iter().zip(from_offset) {
                assert!((zero - placed - offset).abs() < 1e-3, "{name} {letter}: {zero} {placed}");
            }
            assert!(from_zero[0] >= 0.5 && from_zero[1] <= 300.0, "{from_zero:?}");
            // The header states the range in which the lines are.
            let stated = placed.lines().find(|line| line.starts_with(&format!("({letter} "))).unwrap();
            let numbers: Vec<f64> = stated.split(['(', ' ', ')']).filter_map(|word| word.parse().ok()).collect();
            assert!(numbers[0] <= from_offset[0] + 1e-3 && numbers[1] >= from_offset[1] - 1e-3, "{stated} {from_offset:?}");
            assert!(numbers[1] - numbers[0] < 1.3 * (from_offset[1] - from_offset[0]) + 1.0, "{stated} {from_offset:?}");
        }
        assert!(!placed.lines().any(|line| line.starts_with("G0 X999")), "{placed}");
        assert!(placed.contains("WITH X 250.000 Y 200.000 Z 150.000"), "{placed}");
    }
    // The references are machine coordinates either way.
    assert_eq!(folder.read("zero/01-full.csv"), folder.read("placed/01-full.csv"));
}

/// Lowest and highest word of an axis in the lines of a program that move.
fn extent(text: &str, letter: char) -> [f64; 2] {
    let lines = text.lines().filter(|line| line.starts_with(['G']) && !line.starts_with("G21"));
    let words = lines.flat_map(|line| line.split_whitespace()).filter_map(|word| word.strip_prefix(letter)?.parse::<f64>().ok());
    words.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], at| [low.min(at), high.max(at)])
}
