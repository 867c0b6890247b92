//! EMPS, a real ball-screw axis at 1 kHz (A. Janot, M. Gautier, M. Brunot, 2019), beside the published identification.

use datasets::{ReadOptions, read_log};
use diagnosis::{Quantity, Settings, diagnose};

/// Published (A. Janot, M. Gautier, M. Brunot, "Data set and reference models of EMPS", 2019): gains of the PD control and of the drive, mass,
/// Coulomb friction and viscous friction.
const POSITION_GAIN_1_S: f64 = 160.18;
const VELOCITY_GAIN_V_S_M: f64 = 243.45;
const DRIVE_GAIN_N_V: f64 = 35.15;
const MASS_KG: f64 = 95.11;
const COULOMB_N: f64 = 20.39;
const VISCOUS_N_S_M: f64 = 203.5;

#[test]
fn friction_gain_and_lag_of_emps_are_those_published() {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data/logs/emps_train_1kHz.csv");
    if !path.is_file() {
        println!("skipped: {} is not there", path.display());
        return;
    }
    let columns = Some("t=time_s,x_ref=x_cmd_mm,x_act=x_act_mm".to_owned());
    let (log, _) = read_log(&path, &ReadOptions { columns, period_s: None }).unwrap();
    let found = diagnose(&[log], &Settings::default()).unwrap();
    let stiffness = VELOCITY_GAIN_V_S_M * DRIVE_GAIN_N_V;
    let lag_ms = 1e3 * (1.0 + VISCOUS_N_S_M / stiffness) / POSITION_GAIN_1_S;
    let coulomb_um = 1e6 * COULOMB_N / (stiffness * POSITION_GAIN_1_S);
    let bandwidth = stiffness / MASS_KG;
    println!("{:?}", found.models[0]);
    println!(
        "published: gain {POSITION_GAIN_1_S} 1/s, bandwidth {bandwidth:.1} 1/s, lag {lag_ms:.3} ms, Coulomb friction {coulomb_um:.2} µm"
    );
    for quantity in [
        Quantity::VelocityGain,
        Quantity::FollowingLag,
        Quantity::CoulombFriction,
        Quantity::ChannelDelay,
        Quantity::VelocityFeedForward,
    ] {
        println!("{quantity:?} {:?}", found.finding(quantity, "x").unwrap().estimate);
    }
    let value = |quantity| found.finding(quantity, "x").unwrap().estimate.unwrap().value;
    assert!((value(Quantity::FollowingLag) - lag_ms).abs() < 0.05);
    assert!((value(Quantity::CoulombFriction) / coulomb_um - 1.0).abs() < 0.25);
    assert!((value(Quantity::VelocityGain) / POSITION_GAIN_1_S - 1.0).abs() < 0.15);
}
