//! Machine files: reading, writing, errors.

use machine::{
    AxisSpec, BUILTIN_MACHINES, KinematicsSpec, MachineError, MachineSpec, Mount, ProgramWords, RotaryPreslidingSpec,
    SimulatedMachine,
};
use motion::AxisFilter;

const BALLSCREW: &str = BUILTIN_MACHINES[0].1;
const BC: &str = BUILTIN_MACHINES[3].1;

/// A real machine: limits only.
const REAL: &str = r#"
name = "mill"
sampling_period_ms = 1.0
path = { velocity_mm_s = 100.0, acceleration_mm_s2 = 1000.0, jerk_mm_s3 = 5e4, centripetal_mm_s2 = 700.0 }
[[axes]]
name = "x"
kind = "linear"
velocity_mm_s = 100.0
acceleration_mm_s2 = 1000.0
jerk_mm_s3 = 5e4
[[axes]]
name = "c"
kind = "rotary"
velocity_rad_s = 6.0
acceleration_rad_s2 = 60.0
jerk_rad_s3 = 3e3
"#;

#[test]
fn built_in_machines_read_write_and_read_again() {
    for (name, _) in BUILTIN_MACHINES {
        let spec = MachineSpec::builtin(name).unwrap();
        assert_eq!(spec.name, name);
        assert_eq!(MachineSpec::from_toml(&spec.to_toml().unwrap()).unwrap(), spec);
        assert!(spec.limits().check().is_ok());
        assert!(SimulatedMachine::new(&spec, 0).is_ok());
    }
    let error = MachineSpec::builtin("lathe").unwrap_err().to_string();
    assert!(error.contains("lathe") && error.contains("ballscrew, maxwell, worn, bc, xyzac"));
}

#[test]
fn axis_values_override_common_ones() {
    let spec = MachineSpec::from_toml(BALLSCREW).unwrap();
    let leads: Vec<f64> = spec.axes.iter().filter_map(|a| a.drive()).map(|d| d.screw.lead_mm).collect();
    assert_eq!(leads, [5.0; 3]);
    let worn = MachineSpec::builtin("worn").unwrap();
    let leads: Vec<f64> = worn.axes.iter().filter_map(|a| a.drive()).map(|d| d.screw.lead_mm).collect();
    assert_eq!(leads, [6.0, 10.0, 14.0]);
}

#[test]
fn a_machine_without_drives_has_limits_but_cannot_be_simulated() {
    let spec = MachineSpec::from_toml(REAL).unwrap();
    assert_eq!(spec.kinematics, KinematicsSpec::Cartesian);
    assert!(matches!(spec.axes[1], AxisSpec::Rotary(_)));
    assert_eq!(spec.limits().axes[1].jerk, 3e3);
    assert_eq!(spec.kinematics().unwrap().axes(), spec.motion_axes());
    let error = SimulatedMachine::new(&spec, 0).unwrap_err().to_string();
    assert!(error.contains("axis `x` has no `drive`"), "{error}");
}

#[test]
fn unsound_files_are_refused_with_key_and_remedy() {
    let cases: [(&str, &str, &[&str]); 19] = [
        ("lead_mm = 5.0", "lead_mm = -5.0", &["`drive.screw.lead_mm`", "-5", "positive"]),
        ("lead_mm = 5.0", "lead_mm = nan", &["`drive.screw.lead_mm`", "NaN", "finite"]),
        ("lead_mm = 5.0", "lead = 5.0", &["lead"]),
        ("sampling_period_ms = 2.0", "sampling_period_ms = 0.0", &["sampling_period_ms", "positive"]),
        ("sampling_period_ms = 2.0", "sampling_period_ms = 2.5", &["sampling_period_ms", "position_period_ms", "multiple"]),
        ("centripetal_mm_s2 = 565.0", "centripetal_mm_s2 = 565.0\nsmoothing_ms = -1.0", &["path.smoothing_ms", "zero or more"]),
        (
            "centripetal_mm_s2 = 565.0",
            "centripetal_mm_s2 = 565.0\nshort_line_acceleration = 1.5",
            &["path.short_line_acceleration", "1.5", "at most 1"],
        ),
        (
            "centripetal_mm_s2 = 565.0",
            "centripetal_mm_s2 = 565.0\narc_acceleration_mm_s2 = 500.0",
            &["path.arc_acceleration_mm_s2", "500", "above `path.centripetal_mm_s2`, 565"],
        ),
        ("jerk_mm_s3 = 80000.0", "jerk_mm_s3 = 100.0", &["path.jerk_mm_s3", "at least 160", "5000 sampling periods"]),
        ("integration_step_us = 25.0", "integration_step_us = 30.0", &["integration_step_us", "multiple"]),
        ("integration_step_us = 25.0", "integration_step_us = 250.0", &["integration_step_us", "at most"]),
        ("torque_limit_n_m = 8.0", "torque_limit_n_m = 0.0", &["torque_limit_n_m", "positive"]),
        ("motor_share = 0.4", "motor_share = 1.4", &["motor_share", "between 0 and 1"]),
        ("coulomb_n = 200.0, static_n = 280.0", "coulomb_n = 200.0, static_n = 180.0", &["static_n", "180", "coulomb_n"]),
        ("waves = [{ amplitude = 0.12", "waves = [{ amplitude = 0.97", &["waves", "lower"]),
        ("model = \"lugre\"", "model = \"dahl\"", &["dahl", "lugre", "maxwell"]),
        ("kind = \"cartesian\"", "kind = \"hexapod\"", &["hexapod", "cartesian"]),
        ("name = \"y\"", "name = \"x\"", &["`x` is described twice"]),
        ("format = \"keep\"", "format = \"g95\"", &["g95", "g93", "g94", "keep"]),
    ];
    for (from, to, words) in cases {
        assert!(BALLSCREW.contains(from), "{from}");
        let error = MachineSpec::from_toml(&BALLSCREW.replacen(from, to, 1)).unwrap_err();
        assert!(matches!(error, MachineError::BadFile(_)), "{error}");
        for word in words {
            assert!(error.to_string().contains(word), "{to}: {error} lacks `{word}`");
        }
    }
    for text in ["", "name = ", "drive = 3", "axes = []"] {
        assert!(MachineSpec::from_toml(text).is_err(), "{text}");
    }
    let extra = format!("unheard_of = 1\n{REAL}");
    assert!(MachineSpec::from_toml(&extra).unwrap_err().to_string().contains("unheard_of"));
    let extra = REAL.replace("velocity_rad_s", "velocity_deg_s");
    assert!(MachineSpec::from_toml(&extra).unwrap_err().to_string().contains("velocity_deg_s"));
}

#[test]
fn maxwell_elements_are_checked() {
    let text = BUILTIN_MACHINES[1].1;
    for (from, to, word) in
        [("0.10, 0.14", "0.10, 0.24", "sum"), ("[0.8, 1.8", "[1.8", "slip_um"), ("[0.8, 1.8", "[0.0, 1.8", "positive")]
    {
        let error = MachineSpec::from_toml(&text.replacen(from, to, 1)).unwrap_err().to_string();
        assert!(error.contains(word), "{error}");
    }
}

#[test]
fn five_axis_machines_read_as_written() {
    let spec = MachineSpec::builtin("bc").unwrap();
    let KinematicsSpec::FiveAxis(five) = &spec.kinematics else { panic!("{:?}", spec.kinematics) };
    assert_eq!(five.rotary.iter().map(|joint| joint.axis.as_str()).collect::<Vec<_>>(), ["b", "c"]);
    assert!(five.rotary.iter().all(|joint| joint.mount == Mount::Table));
    assert_eq!(five.programs, ProgramWords::Axes);
    assert_eq!(spec.axes[0].travel(), Some([-250.0, 250.0]));
    assert_eq!(spec.axes[3].travel(), Some([-110.0_f64, 110.0].map(f64::to_radians)));
    assert_eq!(spec.axes[4].travel(), None);
    let counts: Vec<f64> = spec.axes.iter().filter_map(|axis| axis.rotary_drive()).map(|d| d.motor.counts_per_turn).collect();
    assert_eq!(counts, [32768.0; 2]);
    assert!(spec.axes[3].drive().is_none() && spec.axes[0].rotary_drive().is_none());

    let spec = MachineSpec::builtin("xyzac").unwrap();
    let KinematicsSpec::FiveAxis(five) = &spec.kinematics else { panic!("{:?}", spec.kinematics) };
    assert_eq!(five.programs, ProgramWords::Tip);
    let presliding = spec.axes[3..].iter().filter_map(|axis| axis.rotary_drive()).map(|drive| &drive.friction.presliding);
    let lugre: Vec<bool> = presliding.map(|model| matches!(model, RotaryPreslidingSpec::Lugre { .. })).collect();
    assert_eq!(lugre, [true, false]);

    let silent = MachineSpec::from_toml(&BC.replace("programs = \"axes\"\n", "")).unwrap();
    assert_eq!(silent, MachineSpec::builtin("bc").unwrap());
}

#[test]
fn invalid_rotary_axes_are_refused_with_rotary_keys() {
    let cases: [(&str, &str, &[&str]); 26] = [
        ("turns_per_turn = 90.0", "turns_per_turn = 0.0", &["axes.b.drive.gear.turns_per_turn", "is 0", "positive"]),
        ("turns_per_turn = 90.0", "ratio = 90.0", &["ratio", "turns_per_turn"]),
        ("turns_per_turn = 90.0", "lead_mm = 5.0", &["lead_mm"]),
        ("stiffness_n_m_rad = 1.5e6", "stiffness_n_m_rad = -1.0", &["axes.b.drive.gear.stiffness_n_m_rad", "positive"]),
        (
            "backlash_half_width_urad = 20.0",
            "backlash_half_width_urad = -3.0",
            &["gear.backlash_half_width_urad", "-3", "zero or more"],
        ),
        ("inertia_kg_m2 = 1.2", "inertia_kg_m2 = 0.0", &["axes.b.drive.table.inertia_kg_m2", "positive"]),
        ("inertia_kg_m2 = 1.2", "mass_kg = 1.2", &["mass_kg", "inertia_kg_m2"]),
        ("torque_noise_n_m = 0.3", "torque_noise_n_m = nan", &["table.torque_noise_n_m", "NaN"]),
        ("scale_resolution_urad = 1.0", "scale_resolution_urad = 0.0", &["table.scale_resolution_urad", "positive"]),
        ("coulomb_n_m = 30.0", "coulomb_n_m = 50.0", &["axes.b.drive.friction.static_n_m", "42", "friction.coulomb_n_m"]),
        ("stribeck_rad_s = 0.04", "stribeck_rad_s = -0.04", &["friction.stribeck_rad_s", "-0.04", "positive"]),
        ("stiffness_n_m_rad = 6e5", "stiffness_n_m_rad = 0.0", &["friction.presliding.stiffness_n_m_rad", "positive"]),
        ("stiffness_n_m_rad = 6e5", "stiffness_n_m = 6e5", &["stiffness_n_m_rad"]),
        ("period_rad = 1.57", "period_rad = -1.57", &["friction.waves[0].period_rad", "-1.57", "positive"]),
        ("motor_waves = [{ amplitude = 0.08", "motor_waves = [{ amplitude = 0.9", &["friction.motor_waves", "lower"]),
        ("[rotary_drive.loops]", "[rotary_drive.loop]", &["loop", "loops"]),
        ("kind = \"five-axis\"", "kind = \"six-axis\"", &["six-axis", "cartesian", "five-axis"]),
        ("mount = \"table\"", "mount = \"bed\"", &["bed", "table", "head"]),
        ("programs = \"axes\"", "programs = \"part\"", &["part", "axes", "tip"]),
        ("tool_length_mm = 80.0", "tool_length_mm = -1.0", &["kinematics.tool_length_mm", "zero or more"]),
        ("axis = \"b\"", "axis = \"a\"", &["kinematics.rotary[0].axis", "`a`", "[[axes]]"]),
        ("axis = \"b\"", "axis = \"x\"", &["kinematics.rotary[0].axis", "`x`", "rotary"]),
        ("axis = \"b\"", "axis = \"c\"", &["kinematics.rotary", "`c`", "twice"]),
        (
            "direction = [0.0, 1.0, 0.0]",
            "direction = [0.0, 0.0, 0.0]",
            &["kinematics.rotary[0].direction", "zero", "[0.0, 1.0, 0.0]"],
        ),
        ("pivot_mm = [0.0, 0.0, -50.0]", "pivot_mm = [0.0, inf, -50.0]", &["kinematics.rotary[0].pivot_mm[1]", "finite"]),
        ("name = \"z\"", "name = \"w\"", &["linear axis `z`", "[[axes]]"]),
    ];
    for (from, to, words) in cases {
        assert!(BC.contains(from), "{from}");
        let error = MachineSpec::from_toml(&BC.replacen(from, to, 1)).unwrap_err();
        assert!(matches!(error, MachineError::BadFile(_)), "{error}");
        for word in words {
            assert!(error.to_string().contains(word), "{to}: {error} lacks `{word}`");
        }
    }
    let third = "[[kinematics.rotary]]\naxis = \"c\"\nmount = \"head\"\ndirection = [1.0, 0.0, 0.0]\npivot_mm = [0.0, 0.0, 0.0]\n\n[drive.loops]";
    let error = MachineSpec::from_toml(&BC.replacen("[drive.loops]", third, 1)).unwrap_err().to_string();
    assert!(error.contains("3 axes") && error.contains("one or two"), "{error}");
    let none = format!("{REAL}\n[kinematics]\nkind = \"five-axis\"\ntool_length_mm = 0.0\n");
    assert!(MachineSpec::from_toml(&none).unwrap_err().to_string().contains("linear axis `y`"));
    // Keys of another kind would have no effect without an error.
    let upright = format!("{REAL}\n[kinematics]\nkind = \"cartesian\"\ntool_length_mm = 80.0\n");
    assert!(MachineSpec::from_toml(&upright).unwrap_err().to_string().contains("tool_length_mm"));
    let error = MachineSpec::from_toml(&format!("rotary_drive = 3\n{REAL}")).unwrap_err().to_string();
    assert!(error.contains("`rotary_drive` is not a table"), "{error}");
}

#[test]
fn travels_are_checked() {
    let travels: [(&str, &str, &[&str]); 5] = [
        (
            "travel_mm = [-250.0, 250.0]",
            "travel_mm = [250.0, -250.0]",
            &["axes.x.travel_mm[1]", "-250", "above 250", "[low, high]"],
        ),
        ("travel_deg = [-110.0, 110.0]", "travel_deg = [110.0, 110.0]", &["axes.b.travel_deg[1]", "above 110"]),
        ("travel_deg = [-110.0, 110.0]", "travel_deg = [-inf, 110.0]", &["axes.b.travel_deg[0]", "finite"]),
        ("travel_deg = [-110.0, 110.0]", "travel_mm = [-110.0, 110.0]", &["travel_mm"]),
        ("travel_deg = [-110.0, 110.0]", "travel_deg = [110.0]", &["array of length 2"]),
    ];
    for (from, to, words) in travels {
        assert!(BC.contains(from), "{from}");
        let error = MachineSpec::from_toml(&BC.replacen(from, to, 1)).unwrap_err().to_string();
        for word in words {
            assert!(error.contains(word), "{to}: {error} lacks `{word}`");
        }
    }
}

#[test]
fn a_rotary_axis_needs_a_drive_to_be_simulated() {
    let start = BC.find("[rotary_drive.loops]").unwrap();
    let end = BC.find("[[axes]]").unwrap();
    let mut spec = MachineSpec::from_toml(BC).unwrap();
    for axis in &mut spec.axes {
        if let AxisSpec::Rotary(axis) = axis {
            axis.drive = None;
        }
    }
    let error = SimulatedMachine::new(&spec, 0).unwrap_err().to_string();
    assert!(error.contains("axis `b` has no `drive`") && error.contains("[axes.drive]"), "{error}");
    // Without the common values those of the axes are incomplete.
    let error = MachineSpec::from_toml(&format!("{}{}", &BC[..start], &BC[end..])).unwrap_err().to_string();
    assert!(error.contains("is missing"), "{error}");
}

#[test]
fn rotary_friction_has_patches_and_maxwell_elements() {
    let own = "friction = { coulomb_n_m = 18.0, static_n_m = 25.0";
    let with = |more: &str| MachineSpec::from_toml(&BC.replacen(own, &format!("{own}, {more}"), 1));
    assert!(with("patches = [{ amplitude = 0.3, centre_rad = 1.0, width_rad = 0.2 }]").is_ok());
    let error = with("patches = [{ amplitude = 0.3, centre_rad = 1.0, width_rad = 0.0 }]").unwrap_err().to_string();
    assert!(error.contains("axes.c.drive.friction.patches[0].width_rad"), "{error}");
    let text = BUILTIN_MACHINES[4].1;
    for (from, to, words) in [
        ("[0.2, 0.2, 0.2", "[0.2, 0.2, 0.3", ["axes.c.drive.friction.presliding.shares: sum", "1"]),
        ("[5.0, 12.0", "[12.0", ["axes.c.drive.friction.presliding.slip_urad", "one of each"]),
        ("[5.0, 12.0", "[0.0, 12.0", ["presliding.slip_urad[0]", "positive"]),
    ] {
        let error = MachineSpec::from_toml(&text.replacen(from, to, 1)).unwrap_err().to_string();
        assert!(words.iter().all(|word| error.contains(word)), "{error}");
    }
}

/// Path of every number in a TOML value, as keys and indices.
fn numbers(value: &toml::Value, at: &[String], found: &mut Vec<Vec<String>>) {
    let below = |name: String| at.iter().cloned().chain([name]).collect::<Vec<_>>();
    match value {
        toml::Value::Float(_) | toml::Value::Integer(_) => found.push(at.to_vec()),
        toml::Value::Array(values) => {
            values.iter().enumerate().for_each(|(i, value)| numbers(value, &below(i.to_string()), found))
        }
        toml::Value::Table(table) => table.iter().for_each(|(key, value)| numbers(value, &below(key.clone()), found)),
        _ => {}
    }
}

fn set(value: &mut toml::Value, at: &[String], number: f64) {
    let Some((first, rest)) = at.split_first() else {
        *value = toml::Value::Float(number);
        return;
    };
    let inner = match value {
        toml::Value::Array(values) => first.parse::<usize>().ok().and_then(|i| values.get_mut(i)),
        toml::Value::Table(table) => table.get_mut(first),
        _ => None,
    };
    set(inner.unwrap(), rest, number);
}

#[test]
fn no_number_is_taken_out_of_its_range() {
    let mut refused = 0;
    for (machine, _) in BUILTIN_MACHINES {
        // With the complete drive of every axis and the optional keys.
        let text = MachineSpec::builtin(machine).unwrap().to_toml().unwrap();
        let whole: toml::Value = toml::from_str(&text).unwrap();
        let mut paths = Vec::new();
        numbers(&whole, &[], &mut paths);
        for (key_path, number) in
            paths.iter().flat_map(|key_path| [1e300, 1e-300, -1.0, 0.0, f64::NAN, f64::INFINITY].map(|n| (key_path, n)))
        {
            let mut changed = whole.clone();
            set(&mut changed, key_path, number);
            let key = key_path.iter().rfind(|part| part.parse::<usize>().is_err()).unwrap();
            match MachineSpec::from_toml(&toml::to_string(&changed).unwrap()) {
                // Some values may be zero or nearly zero.
                Ok(_) => assert!(number.abs() <= 1.0, "{machine}: {key_path:?} = {number}"),
                Err(error) => {
                    assert!(error.to_string().contains(key.as_str()), "{machine}: {key_path:?} = {number}: {error}");
                    refused += 1;
                }
            }
        }
    }
    assert!(refused > 1000, "{refused}");
}

#[test]
fn a_number_out_of_range_is_refused_with_its_range() {
    let error = MachineSpec::from_toml(&BALLSCREW.replacen("lead_mm = 5.0", "lead_mm = 1e300", 1)).unwrap_err().to_string();
    assert!(error.contains("`drive.screw.lead_mm`") && error.contains("positive and finite, from 0.01 to 1e6"), "{error}");
    let profile = "decimals = 5\nformat = \"keep\"\npoint_spacing_ms = 1e-300\n";
    let error = machine::ControllerSpec::from_toml(profile).unwrap_err().to_string();
    assert!(error.contains("controller.point_spacing_ms") && error.contains("from 0.01 to 10000"), "{error}");
}

#[test]
fn every_fault_of_a_file_is_told_at_once_with_its_place() {
    let text = "name = \"mill\"
sampling_period_ms = \"1\"
sensr = \"motor\"
[path]
velocity_mm_s = 100
acceleration_mm_s2 = 1500
jerk_mm_s3 = -5
[[axes]]
name = \"x\"
kind = \"linear\"
velocity_mm_s = 100
acceleration_mm_s2 = 1e99
jerk_mm_s3 = 5e4
[[axes]]
name = \"y\"
kind = \"linear\"
velocity_mm_s = 100
aceleration_mm_s2 = 1500
jerk_mm_s3 = 5e4
[[axes]]
name = \"c\"
velocity_rad_s = 1
[controller]
decimals = 4
format = \"g95\"
";
    let error = MachineSpec::from_toml(text).unwrap_err();
    let MachineError::BadFile(faults) = &error else { panic!("{error}") };
    let found: Vec<(usize, usize, &str)> =
        faults.all().iter().map(|fault| (fault.line, fault.column, fault.message.as_str())).collect();
    let expected = [
        (2, 1, "`sampling_period_ms`: invalid type"),
        (3, 1, "`sensr` is no key; did you mean `sensor`?"),
        (4, 2, "`path.centripetal_mm_s2` is missing"),
        (7, 1, "`path.jerk_mm_s3` is -5; it must be positive"),
        (12, 1, "`axes.x.acceleration_mm_s2` is 1e99; it must be positive and finite, from"),
        (14, 1, "`axes.y.acceleration_mm_s2` is missing"),
        (18, 1, "`axes.y.aceleration_mm_s2` is no key; did you mean `acceleration_mm_s2`?"),
        (20, 1, "`axes.c.kind` is missing; give `kind = \"linear\"`"),
        (23, 2, "`controller.point_spacing_ms` is missing"),
        (25, 1, "`controller.format`: unknown variant `g95`, expected one of"),
    ];
    assert_eq!(found.len(), expected.len(), "{error}");
    for ((line, column, message), (expected_line, expected_column, start)) in found.iter().zip(expected) {
        assert!(
            (*line, *column) == (expected_line, expected_column) && message.starts_with(start),
            "{line}:{column} {message}\n{error}"
        );
    }
    assert!(error.to_string().starts_with("10 faults\n  line 2, column 1: "), "{error}");
}

#[test]
fn faults_of_a_shared_drive_are_told_once_where_they_stand() {
    let faults = |text: &str| match MachineSpec::from_toml(text) {
        Err(MachineError::BadFile(faults)) => faults,
        other => panic!("{other:?}"),
    };
    let at = BALLSCREW.lines().position(|line| line.contains("lead_mm = 5.0")).unwrap() + 1;
    let wrong = faults(&BALLSCREW.replacen("lead_mm = 5.0", "lead_m = 5.0", 1));
    let lines: Vec<usize> = wrong.all().iter().map(|fault| fault.line).collect();
    assert!(wrong.all().len() == 2 && lines.contains(&at), "{wrong}");
    // What several values must keep together is told at the place of the first.
    let period = faults(&BALLSCREW.replacen("sampling_period_ms = 2.0", "sampling_period_ms = 2.5", 1));
    assert_eq!(period.all()[0].line, BALLSCREW.lines().position(|line| line.starts_with("sampling_period_ms")).unwrap() + 1);
    // Text that is not TOML has its place too.
    assert_eq!(faults("name = \"a\"\nsampling_period_ms = = 3\n").all()[0].line, 2);
}

#[test]
fn a_control_has_filters_for_all_axes_and_for_one_and_limits_of_lines() {
    let control = "[control]\ncorners = { blend_mm = 0.01 }\nfilters_ms = [12.0, 0.0]\ntime_constant_ms = 8.0\nlook_ahead_lines = 14\nline_time_ms = 2.0\n";
    let own = REAL.replace("name = \"c\"\n", "name = \"c\"\nfilters_ms = [0.0, 6.0]\ntime_constant_ms = 0.0\n");
    let file = own.replacen("[[axes]]", &format!("{control}[[axes]]"), 1);
    let spec = MachineSpec::from_toml(&file).unwrap();
    assert_eq!(MachineSpec::from_toml(&spec.to_toml().unwrap()).unwrap(), spec);
    let settings = spec.plan_settings();
    let of = |averages_s: [f64; 2], time_constant_s: f64| AxisFilter { averages_s, time_constant_s };
    assert_eq!(settings.filters, [of([0.012, 0.0], 0.008), of([0.0, 0.006], 0.0)]);
    assert_eq!((settings.look_ahead, settings.piece_time_s), (Some(14), 0.002));
    // An axis may state filters where the control states nothing.
    let alone = MachineSpec::from_toml(&own).unwrap().plan_settings();
    assert_eq!(alone.filters, [of([0.0; 2], 0.0), of([0.0, 0.006], 0.0)]);
    assert_eq!(alone.corner_tolerance_mm, MachineSpec::from_toml(REAL).unwrap().plan_settings().corner_tolerance_mm);
    for (from, to, key) in [
        ("look_ahead_lines = 14", "look_ahead_lines = 0", "control.look_ahead_lines"),
        ("line_time_ms = 2.0", "line_time_ms = -1.0", "control.line_time_ms"),
        ("time_constant_ms = 8.0", "time_constant_ms = 1e9", "control.time_constant_ms"),
        ("filters_ms = [0.0, 6.0]", "filters_ms = [0.0, -6.0]", "axes.c.filters_ms"),
        ("filters_ms = [12.0, 0.0]", "filters_ms = [1e8, 0.0]", "control.filters_ms"),
    ] {
        let error = MachineSpec::from_toml(&file.replace(from, to)).unwrap_err().to_string();
        assert!(error.contains(key), "{key}: {error}");
    }
    // Averages over more periods than a plan can be averaged over, the lag among them.
    let fast =
        file.replace("sampling_period_ms = 1.0", "sampling_period_ms = 0.01").replace("jerk_mm_s3 = 5e4", "jerk_mm_s3 = 1e9");
    assert!(MachineSpec::from_toml(&fast).is_ok());
    for (from, to, key) in [
        ("filters_ms = [12.0, 0.0]", "filters_ms = [45.0, 0.0]", "control.filters_ms"),
        ("filters_ms = [12.0, 0.0]\ntime_constant_ms = 8.0", "time_constant_ms = 60.0", "control.time_constant_ms"),
        ("filters_ms = [0.0, 6.0]", "filters_ms = [0.0, 60.0]", "axes.c.filters_ms"),
    ] {
        let error = MachineSpec::from_toml(&fast.replace(from, to)).unwrap_err().to_string();
        assert!(error.contains(key) && error.contains("5000 sampling periods"), "{key}: {error}");
    }
}
