//! Machine files from the settings of controls, from logs and from options.

use crate::common::Folder;

const INI: &str = "[EMC]\nMACHINE = Old mill\n[TRAJ]\nCOORDINATES = X Y Z A\nLINEAR_UNITS = inch\nMAX_LINEAR_VELOCITY = 2 # in/s\n\
                   [EMCMOT]\nSERVO_PERIOD = 500000\n[AXIS_X]\nMAX_VELOCITY = 3\nMAX_ACCELERATION = 20\nMIN_LIMIT = -10\nMAX_LIMIT = 10\n\
                   [JOINT_0]\nMAX_VELOCITY = 2\nMIN_LIMIT = -9\nMAX_LIMIT = 11\n[AXIS_Y]\nMAX_VELOCITY = 3\nMAX_ACCELERATION = 20\n\
                   [AXIS_Z]\nMAX_VELOCITY = 1\nMAX_ACCELERATION = 10\n[AXIS_A]\nMAX_VELOCITY = 90\nMAX_ACCELERATION = 360\n";
const GRBL: &str = "$11=0.02 (junction deviation, mm)\r\n$110=6000.000\r\n$111=6000.000\r\n$112=600.000\r\n$120=500.000\r\n$121=400.000\r\n\
                    $122=100.000\r\n$130=300.000\r\n[VER:1.1h.20190830:]\r\n[OPT:V,15,128]\r\n";
const KLIPPER: &str = "[printer]\nkinematics: corexy\nmax_velocity: 300\nmax_accel: 3000\nmax_z_velocity: 15\nsquare_corner_velocity: 6\n\
                       [stepper_x]\nposition_max: 235\n[input_shaper]\nshaper_freq_x: 50\n";

/// Number at a dotted path of a machine file.
fn number(file: &toml::Value, path: &str) -> f64 {
    let at = path.split('.').fold(file, |value, key| match key.parse::<usize>() {
        Ok(index) => &value[index],
        Err(_) => &value[key],
    });
    at.as_float().or(at.as_integer().map(|whole| whole as f64)).unwrap()
}

fn machine_file(folder: &Folder, words: &[&str]) -> toml::Value {
    let said = folder.prints(&[&["init"], words, &["-o", "m.toml"]].concat());
    assert!(said.contains("machine file of "), "{said}");
    let text = folder.read("m.toml");
    assert!(text.starts_with("# Machine file, from ") && text.contains("docs/machine-file.md"), "{text}");
    // What it wrote is a machine that can be used.
    folder.figures(&["excite", "--machine", "m.toml", "--seconds", "5", "--travel", "5", "-o", "excitation"]);
    toml::from_str(&text).unwrap()
}

#[test]
fn settings_of_controls_become_machine_files() {
    let folder = Folder::new();
    folder.write("mill.ini", INI);
    folder.write("grbl.txt", GRBL);
    folder.write("printer.cfg", KLIPPER);
    let mill = machine_file(&folder, &["mill.ini"]);
    assert_eq!((mill["name"].as_str(), mill["controller"]["dialect"].as_str()), (Some("Old mill"), Some("linuxcnc")));
    for (path, value) in [
        ("sampling_period_ms", 0.5),
        ("path.velocity_mm_s", 50.8),
        // What the axes allow together: √(508² + 508² + 254²).
        ("path.acceleration_mm_s2", 762.0),
        ("path.jerk_mm_s3", 1_524_000.0),
        ("path.centripetal_mm_s2", 0.866 * 508.0),
        ("path.arc_acceleration_mm_s2", 508.0),
        ("path.short_line_acceleration", 0.5),
        // The narrower of axis and joint.
        ("axes.0.velocity_mm_s", 50.8),
        ("axes.0.acceleration_mm_s2", 508.0),
        ("axes.0.travel_mm.0", -228.6),
        ("axes.0.travel_mm.1", 254.0),
        ("axes.3.velocity_rad_s", std::f64::consts::FRAC_PI_2),
    ] {
        assert!((number(&mill, path) / value - 1.0).abs() < 1e-5, "{path}: {}", number(&mill, path));
    }
    let router = machine_file(&folder, &["grbl.txt", "--period", "2", "--travel", "z=-80..0"]);
    for (path, value) in [
        ("axes.0.velocity_mm_s", 100.0),
        ("axes.1.acceleration_mm_s2", 400.0),
        ("axes.0.travel_mm.0", -300.0),
        ("axes.2.travel_mm.0", -80.0),
        ("control.corners.junction_deviation_mm", 0.02),
        // `$I` counts the present line.
        ("control.look_ahead_lines", 14.0),
    ] {
        assert!((number(&router, path) / value - 1.0).abs() < 1e-5, "{path}");
    }
    let printer = machine_file(&folder, &["printer.cfg", "--period", "1"]);
    let expected = 36.0 * (std::f64::consts::SQRT_2 - 1.0) / 3000.0;
    assert!((number(&printer, "control.corners.junction_deviation_mm") / expected - 1.0).abs() < 1e-5);
    assert_eq!(number(&printer, "axes.2.velocity_mm_s"), 15.0);
}

#[test]
fn logs_and_options_make_a_machine_file() {
    let folder = Folder::with_model();
    folder.figures(&["simulate", "curve:crown", "--machine", "ballscrew", "-o", "run.csv"]);
    let of_log = machine_file(&folder, &["--log", "run.csv"]);
    assert_eq!(number(&of_log, "sampling_period_ms"), 2.0);
    assert!(number(&of_log, "axes.0.velocity_mm_s") > 1.0);
    let stated = machine_file(&folder, &["--axes", "xz", "--velocity", "250", "--acceleration", "1500", "--period", "4"]);
    assert_eq!((stated["axes"].as_array().map(Vec::len), number(&stated, "axes.1.velocity_mm_s")), (Some(2), 250.0));
}

#[test]
fn all_that_is_missing_is_named_at_once() {
    let folder = Folder::new();
    folder.write("grbl.txt", GRBL.replace("$121=400.000\r\n", ""));
    let said = folder.fails(2, &["init", "grbl.txt", "-o", "m.toml"]);
    assert!(said.contains("sampling period") && said.contains("--period") && said.contains("acceleration of y"), "{said}");
    folder.write("bad.txt", GRBL.replace("6000.000", "fast"));
    let said = folder.fails(1, &["init", "bad.txt", "-o", "m.toml"]);
    assert!(said.contains("bad.txt:2: $110 is `fast`"), "{said}");
    folder.write("other.txt", "hello\n");
    let said = folder.fails(1, &["init", "other.txt", "-o", "m.toml"]);
    assert!(said.contains("LinuxCNC INI") && !folder.0.path().join("m.toml").exists(), "{said}");
    folder.fails(2, &["init", "--axes", "xq", "-o", "m.toml"]);
}

#[test]
fn an_ini_file_is_read_as_linuxcnc_reads_it() {
    let folder = Folder::new();
    let file = |traj: &str, rest: &str| {
        format!(
            "[TRAJ]\n  {traj}\n[AXIS_X]\n MAX_VELOCITY = 4\nMAX_ACCELERATION = 20\n  MIN_LIMIT = -1\nMAX_LIMIT = 10\nMAX_LIMIT = 500\n\
             [AXIS_Y]\nMAX_VELOCITY = 4\nMAX_ACCELERATION = 20\nMAX_LIMIT = 10\n[AXIS_Z]\nMAX_VELOCITY = 4\nMAX_ACCELERATION = 20\n\
             MIN_LIMIT = -1e99\nMAX_LIMIT = 1e99\n{rest}"
        )
    };
    let read = |text: String| {
        folder.write("m.ini", text);
        let said = folder.prints(&["init", "m.ini", "-o", "m.toml"]);
        (toml::from_str::<toml::Value>(&folder.read("m.toml")).unwrap(), said)
    };
    // The first of equal keys; blanks before a line; one limit alone and limits of 1e99 are no travel.
    let (mill, said) = read(file("LINEAR_UNITS = 0.03937007874", ""));
    assert!((number(&mill, "axes.0.velocity_mm_s") / 101.6 - 1.0).abs() < 1e-4);
    assert!((number(&mill, "axes.0.travel_mm.1") / 254.0 - 1.0).abs() < 1e-4);
    assert!(mill["axes"][1].get("travel_mm").is_none() && mill["axes"][2].get("travel_mm").is_none());
    assert!(said.contains("axis Y has one limit alone"), "{said}");
    // Two joints move Y; their kinematics says which.
    let joints = "[KINS]\nKINEMATICS = trivkins coordinates=XYYZ\n[JOINT_2]\nMIN_LIMIT = -9\nMAX_LIMIT = 9\nMAX_VELOCITY = 2\n\
                  [JOINT_3]\nMIN_LIMIT = -150\nMAX_LIMIT = 5\n";
    let (mill, _) = read(file("LINEAR_UNITS = mm", joints));
    assert_eq!((number(&mill, "axes.1.velocity_mm_s"), number(&mill, "axes.2.travel_mm.0")), (2.0, -150.0));
    let arm = "[KINS]\nKINEMATICS = scarakins\n[JOINT_0]\nMAX_VELOCITY = 1\n";
    let (mill, said) = read(file("LINEAR_UNITS = mm", arm));
    assert!(number(&mill, "axes.0.velocity_mm_s") == 4.0 && said.contains("its kinematics are scarakins"), "{said}");
    // Angles in radians.
    let turning = "COORDINATES = XA\nANGULAR_UNITS = radian\nLINEAR_UNITS = mm";
    let (mill, _) = read(file(turning, "[AXIS_A]\nMAX_VELOCITY = 0.5\nMAX_ACCELERATION = 2\n"));
    assert!((number(&mill, "axes.1.velocity_rad_s") / 0.5 - 1.0).abs() < 1e-5);
    // Limits in a file beside it; a file that is missing is told.
    folder.write("lim.inc", "[AXIS_Y]\nMIN_LIMIT = -3\n");
    let (mill, said) = read(file("LINEAR_UNITS = mm", "#INCLUDE lim.inc\n#INCLUDE gone.inc\n"));
    assert!(number(&mill, "axes.1.travel_mm.0") == -3.0 && said.contains("gone.inc, which m.ini includes"), "{said}");
    let said = folder.fails(2, &["init", "m.ini", "-o", "lim.inc"]);
    assert!(said.contains("lim.inc would be written over") && folder.read("lim.inc").starts_with("[AXIS_Y]"), "{said}");
    folder.write("m.ini", file("LINEAR_UNITS = cm", ""));
    let said = folder.fails(1, &["init", "m.ini", "-o", "n.toml"]);
    assert!(said.contains("m.ini:2: LINEAR_UNITS is `cm`"), "{said}");
    // Options beside settings.
    folder.write("m.ini", file("LINEAR_UNITS = mm", ""));
    let said = folder.fails(2, &["init", "m.ini", "--axes", "xy", "-o", "n.toml"]);
    assert!(!folder.0.path().join("n.toml").exists(), "{said}");
}

#[test]
fn grbl_states_where_its_travel_lies() {
    let folder = Folder::new();
    let read = |settings: &str| {
        folder.write("grbl.txt", format!("{GRBL}$131=200\r\n{settings}"));
        let said = folder.prints(&["init", "grbl.txt", "--period", "2", "-o", "m.toml"]);
        (toml::from_str::<toml::Value>(&folder.read("m.toml")).unwrap(), said)
    };
    let (router, _) = read("$22=1\r\n$23=1\r\n");
    assert_eq!(number(&router, "axes.0.travel_mm.0"), -300.0);
    // grblHAL, machine zero where it homes: X at its lower end.
    let (router, _) = read("$22=9\r\n$23=1\r\n");
    assert_eq!((number(&router, "axes.0.travel_mm.1"), number(&router, "axes.1.travel_mm.0")), (300.0, -200.0));
    let (router, said) = read("$22=8\r\n");
    assert!(router["axes"][0].get("travel_mm").is_none() && said.contains("it does not home"), "{said}");
    let (router, _) = read("[AXS:4:XYZC]\r\n$113=360\r\n$123=90\r\n");
    assert_eq!(router["axes"][3]["name"].as_str(), Some("c"));
}
