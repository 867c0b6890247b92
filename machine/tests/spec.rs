//! Machine files: read, written, refused.

use machine::{AxisSpec, BUILTIN_MACHINES, KinematicsSpec, MachineError, MachineSpec, SimulatedMachine};

const BALLSCREW: &str = BUILTIN_MACHINES[0].1;

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
    assert!(error.contains("lathe") && error.contains("ballscrew, maxwell, worn"));
}

#[test]
fn own_values_go_before_common_ones() {
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
    assert_eq!(spec.kinematics().axes(), spec.motion_axes());
    let error = SimulatedMachine::new(&spec, 0).unwrap_err().to_string();
    assert!(error.contains("axis `x` has no `drive`"), "{error}");
}

#[test]
fn unsound_files_are_refused_with_key_and_remedy() {
    let cases: [(&str, &str, &[&str]); 15] = [
        ("lead_mm = 5.0", "lead_mm = -5.0", &["axes.x.drive.screw.lead_mm", "-5", "positive"]),
        ("lead_mm = 5.0", "lead_mm = nan", &["axes.x.drive.screw.lead_mm", "NaN", "finite"]),
        ("lead_mm = 5.0", "lead = 5.0", &["lead"]),
        ("sampling_period_ms = 2.0", "sampling_period_ms = 0.0", &["sampling_period_ms", "positive"]),
        ("sampling_period_ms = 2.0", "sampling_period_ms = 2.5", &["sampling_period_ms", "position_period_ms", "multiple"]),
        ("integration_step_us = 25.0", "integration_step_us = 30.0", &["integration_step_us", "multiple"]),
        ("integration_step_us = 25.0", "integration_step_us = 250.0", &["integration_step_us", "at most"]),
        ("torque_limit_n_m = 8.0", "torque_limit_n_m = 0.0", &["torque_limit_n_m", "positive"]),
        ("motor_share = 0.4", "motor_share = 1.4", &["motor_share", "between 0 and 1"]),
        ("coulomb_n = 200.0, static_n = 280.0", "coulomb_n = 200.0, static_n = 180.0", &["static_n", "180", "coulomb_n"]),
        ("waves = [{ amplitude = 0.12", "waves = [{ amplitude = 0.97", &["waves", "lower"]),
        ("model = \"lugre\"", "model = \"dahl\"", &["dahl", "lugre", "maxwell"]),
        ("kind = \"cartesian\"", "kind = \"hexapod\"", &["hexapod", "cartesian"]),
        ("name = \"y\"", "name = \"x\"", &["`x` is described twice"]),
        ("carrier = \"keep\"", "carrier = \"g95\"", &["g95", "g93", "g94", "keep"]),
    ];
    for (from, to, words) in cases {
        assert!(BALLSCREW.contains(from), "{from}");
        let error = MachineSpec::from_toml(&BALLSCREW.replacen(from, to, 1)).unwrap_err();
        assert!(matches!(error, MachineError::BadDescription(_)));
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
