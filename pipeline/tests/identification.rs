//! Controls of several structures, identified from logs of known programs.

use machine::{ControlSpec, CornerRule, MachineSpec};
use motion::AxisLimits;
use pipeline::excitation::{self, Style};
use pipeline::identification::{Fidelity, Identified, KnownRun, agreement, identify};
use pipeline::{Error, Input, Log, OutputSettings, Part, ReadSettings, SILENT, Setup};

/// The control test of the product for the machine as it is known before the control is: limits, and 60 mm of travel.
fn control_test() -> String {
    let machine = MachineSpec::builtin("ballscrew").unwrap();
    let setup = Setup::new(&machine, None).unwrap();
    let style = Style::of(&OutputSettings::new(&setup, None, None, None).refit(), None, &setup);
    excitation::control_test(0, &setup, &[(-30.0, 30.0); 3], &style, 1).unwrap().unwrap().text
}

const POCKET: &str = "G21 G90 G94 G17\nG0 X0 Y0 Z2\nG4 P0.1\nG1 Z0 F600\nG1 X30 F3000\nG3 X34 Y4 J4\nG1 Y20\nG3 X30 Y24 I-4\nG1 X4\nG3 X0 Y20 J-4\nG1 Y4\n\
G3 X4 Y0 I4\nG1 X5 Y5\nX29\nY19\nX5\nY5\nX10 Y10\nX24\nY14\nX10\nY10\nG0 Z2\nM30\n";

/// Rows of short lines over a wave.
fn finishing(step_mm: f64, feed: u32) -> String {
    let mut text = format!("G21 G90 G94 G17\nG0 X0 Y0 Z0\nG4 P0.1\nG1 F{feed}\n");
    let steps = (30.0 / step_mm) as u32;
    for row in 0..6 {
        for k in 0..=steps {
            let x = step_mm * f64::from(if row % 2 == 0 { k } else { steps - k });
            text += &format!("X{x:.4} Y{:.4} Z{:.4}\n", 0.4 * f64::from(row), 1.5 * (0.35 * x).sin());
        }
    }
    text + "M30\n"
}

/// A contour of lines with corners of many angles.
fn contour() -> String {
    let mut text = String::from("G21 G90 G94 G17\nG0 X0 Y0 Z0\nG4 P0.1\nG1 F3600\n");
    for (x, y) in [(12, 3), (25, 0), (22, 9), (30, 14), (20, 17), (24, 28), (13, 20), (11, 27), (5, 18), (-4, 22), (2, 9), (0, 0)]
    {
        text += &format!("X{x} Y{y}\n");
    }
    text + "M30\n"
}

/// Small letters of lines and arcs, with retracts.
fn engraving() -> String {
    let mut text = String::from("G21 G90 G94 G17\nG0 X0 Y0 Z1\nG4 P0.1\n");
    for k in 0..8 {
        let x = 4.0 * f64::from(k);
        text += &format!(
            "G0 X{x} Y0\nG1 Z0 F300\nG1 Y3 F900\nG2 X{:.1} Y4 I1 J0\nG1 X{:.1}\nY2\nX{x}\nY0.5\nX{:.1} Y0\nG0 Z1\n",
            x + 1.0,
            x + 2.4,
            x + 2.0
        );
    }
    text + "M30\n"
}

fn control(corners: CornerRule, filters_ms: [f64; 2], change: impl Fn(&mut MachineSpec)) -> MachineSpec {
    let mut machine = MachineSpec::builtin("ballscrew").unwrap();
    machine.control = Some(ControlSpec { corners, filters_ms, ..Default::default() });
    change(&mut machine);
    machine
}

fn log_of(name: &str, program: &str, machine: &MachineSpec) -> Log {
    let setup = Setup::new(machine, None).unwrap();
    let part =
        Part::read(name, program.as_bytes().to_vec(), &setup, &ReadSettings { at_zero: true, ..Default::default() }).unwrap();
    let command = Input::from(part).command().clone();
    Log::new(name, command.clone(), command).unwrap()
}

/// Programs with the logs of their runs.
struct Recorded(Vec<(&'static str, String, Log)>);

impl Recorded {
    fn of(machine: &MachineSpec, programs: Vec<(&'static str, String)>) -> Self {
        Self(programs.into_iter().map(|(name, text)| (name, text.clone(), log_of(name, &text, machine))).collect())
    }

    fn runs(&self) -> Vec<KnownRun<'_>> {
        self.0
            .iter()
            .map(|(name, text, log)| KnownRun { name: (*name).into(), program: text.clone().into_bytes(), log })
            .collect()
    }
}

fn training() -> Vec<(&'static str, String)> {
    vec![("test.nc", control_test()), ("finishing.nc", finishing(0.3, 2400))]
}

/// Programs that no fit sees.
fn unseen() -> Vec<(&'static str, String)> {
    vec![
        ("pocket.nc", POCKET.into()),
        ("contour.nc", contour()),
        ("surface.nc", finishing(0.17, 1800)),
        ("engraving.nc", engraving()),
    ]
}

fn without_jerk(machine: &mut MachineSpec) {
    (machine.path.jerk_mm_s3, machine.path.smoothing_ms) = (1e10, 0.0);
    set_axes(machine, |limits| limits.jerk = 1e10);
}

fn set_axes(machine: &mut MachineSpec, change: impl Fn(&mut AxisLimits)) {
    for axis in &mut machine.axes {
        let mut limits = axis.limits();
        change(&mut limits);
        axis.set_limits(limits);
    }
}

/// Splitmix64: the same numbers everywhere.
struct Draw(u64);

impl Draw {
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Evenly in the logarithm.
    fn between(&mut self, from: f64, to: f64) -> f64 {
        from * (to / from).powf(self.unit())
    }
}

/// A control of random structure: six shapes of acceleration, three rules of corners, limits of its own for every axis.
fn random_control(seed: u64) -> MachineSpec {
    let mut draw = Draw(seed);
    let corners = match (3.0 * draw.unit()) as usize {
        0 => CornerRule::BlendMm(draw.between(0.002, 0.05)),
        1 => CornerRule::SpeedJumpMmS(draw.between(2.0, 20.0)),
        _ => CornerRule::JunctionDeviationMm(draw.between(0.003, 0.05)),
    };
    let shape = (6.0 * draw.unit()) as usize;
    let average = |draw: &mut Draw, used: bool| if used { 2.0 * (draw.between(3.0, 20.0)).round() } else { 0.0 };
    let filters_ms = [average(&mut draw, shape >= 3), average(&mut draw, shape == 4)];
    let mut machine = control(corners, filters_ms, without_jerk);
    let acceleration = draw.between(300.0, 3000.0);
    machine.path.acceleration_mm_s2 = acceleration;
    machine.path.centripetal_mm_s2 = acceleration * draw.between(0.4, 1.2);
    machine.path.velocity_mm_s = 150.0;
    let shares: Vec<f64> = machine.axes.iter().map(|_| draw.between(0.5, 1.5)).collect();
    for (axis, share) in machine.axes.iter_mut().zip(shares) {
        let limits = axis.limits();
        axis.set_limits(AxisLimits { acceleration: share * acceleration, velocity: 150.0, ..limits });
    }
    if matches!(shape, 1 | 2 | 5) {
        let rise_s = 1e-3 * average(&mut draw, true);
        machine.path.jerk_mm_s3 = 2.0 * acceleration / rise_s;
        let jerk = machine.path.jerk_mm_s3 * draw.between(0.7, 3.0);
        set_axes(&mut machine, |limits| limits.jerk = jerk);
    }
    if shape == 2 {
        machine.path.smoothing_ms = average(&mut draw, true);
    }
    machine
}

/// A random control that does something besides: a lag of every axis, filters of each axis, a short look-ahead, or a least time for a line.
fn random_control_with_more(seed: u64) -> MachineSpec {
    let mut machine = random_control(seed);
    let mut draw = Draw(seed.wrapping_add(1 << 32));
    let mut control = machine.control.unwrap();
    let mean_ms = draw.between(5.0, 30.0);
    let own_ms: Vec<f64> = machine.axes.iter().map(|_| 2.0 * (0.5 * mean_ms * draw.between(0.7, 1.4)).round()).collect();
    match (5.0 * draw.unit()) as usize {
        0 => (control.filters_ms, control.time_constant_ms) = ([0.0; 2], draw.between(3.0, 40.0)),
        1 => machine.axes.iter_mut().zip(own_ms).for_each(|(axis, own_ms)| axis.set_filters(Some([own_ms, 0.0]), None)),
        2 => {
            control.filters_ms = [0.0; 2];
            machine.axes.iter_mut().zip(own_ms).for_each(|(axis, own_ms)| axis.set_filters(None, Some(0.5 * own_ms)));
        }
        3 => control.look_ahead_lines = Some(draw.between(2.0, 60.0).round() as u32),
        _ => control.line_time_ms = draw.between(2.0, 20.0),
    }
    machine.control = Some(control);
    machine
}

fn um(mm: f64) -> f64 {
    1e3 * mm
}

/// Identifies a control and judges it on programs that it was not fitted to.
fn judged(machine: &MachineSpec) -> (Identified, Fidelity) {
    judge(machine).unwrap()
}

fn judge(machine: &MachineSpec) -> Result<(Identified, Fidelity), Error> {
    let (seen, unseen) = (Recorded::of(machine, training()), Recorded::of(machine, unseen()));
    let found = identify(&seen.runs(), None, SILENT)?;
    let fidelity = agreement(&found.machine, &unseen.runs())?;
    Ok((found, fidelity))
}

#[test]
fn a_control_with_limited_jerk_and_blends_is_found_with_its_numbers() {
    let (found, fidelity) = judged(&control(CornerRule::BlendMm(0.01), [0.0; 2], |_| {}));
    assert_eq!(found.structure, "jerk without jumps along the path; corners rounded within a tolerance");
    let value = |key: &str| found.values.iter().find(|value| value.key == key).unwrap().value;
    let expected = [
        ("path.acceleration_mm_s2", 800.0),
        ("path.rise_ms", 20.0),
        ("path.smoothing_ms", 20.0),
        ("control.corners.blend_mm", 0.01),
    ];
    for (key, expected) in expected {
        // Averages are made of whole periods of 2 ms.
        let most = if key.ends_with("_ms") { 2.0 } else { 0.1 * expected };
        assert!((value(key) - expected).abs() <= most + 1e-9, "{key}: {} for {expected}", value(key));
    }
    assert!(fidelity.path_rms_mm < 1e-3 && fidelity.cycle_share < 0.01, "{fidelity:?}");
}

#[test]
fn a_control_that_filters_its_axes_is_found_with_its_numbers() {
    let slow = |machine: &mut MachineSpec| (machine.path.acceleration_mm_s2, machine.path.centripetal_mm_s2) = (300.0, 200.0);
    let machine = control(CornerRule::BlendMm(0.01), [30.0, 0.0], slow);
    let (found, fidelity) = judged(&machine);
    let filters_ms = found.machine.control.unwrap().filters_ms;
    assert!((filters_ms[0] - 30.0).abs() <= 4.0, "{filters_ms:?}");
    assert!(fidelity.path_rms_mm < 2e-3 && fidelity.cycle_share < 0.02, "{fidelity:?}");
    // A machine description without the filter would have been told.
    let without = agreement(&MachineSpec { control: None, ..machine.clone() }, &Recorded::of(&machine, unseen()).runs()).unwrap();
    assert!(without.path_rms_mm > 3.0 * fidelity.path_rms_mm, "{without:?}");
}

#[test]
fn a_lag_and_a_least_time_for_a_line_are_found_with_their_numbers() {
    let mut machine = control(CornerRule::BlendMm(0.01), [0.0; 2], |_| {});
    let with_more = ControlSpec { time_constant_ms: 15.0, line_time_ms: 12.0, ..machine.control.unwrap() };
    machine.control = Some(with_more);
    let (found, fidelity) = judged(&machine);
    let ControlSpec { time_constant_ms, line_time_ms, .. } = found.machine.control.unwrap();
    println!("{} {time_constant_ms} {line_time_ms} {fidelity:?}", found.structure);
    assert!(found.structure.contains("a first-order lag of every axis") && found.structure.contains("a least time for a line"));
    assert!((time_constant_ms - 15.0).abs() < 1.5 && (line_time_ms - 12.0).abs() < 0.6, "{time_constant_ms} {line_time_ms}");
    assert!(fidelity.path_rms_mm < 2e-3 && fidelity.cycle_share < 0.02, "{fidelity:?}");
}

/// A control that plans as LinuxCNC does: half of the acceleration before a dwell, and in arcs 800 mm/s² along and across together.
fn as_linuxcnc_plans() -> MachineSpec {
    control(CornerRule::BlendMm(0.01), [0.0; 2], |machine| {
        without_jerk(machine);
        let path = &mut machine.path;
        (path.acceleration_mm_s2, path.centripetal_mm_s2) = (1380.0, 690.0);
        (path.arc_acceleration_mm_s2, path.short_line_acceleration) = (Some(800.0), 0.5);
    })
}

/// Asserts that the numbers of [`as_linuxcnc_plans`] were found, and that plans agree with runs.
fn assert_found(found: &Identified, fidelity: &Fidelity) {
    let path = found.machine.path;
    println!("{} {path:?} {fidelity:?}", found.structure);
    assert!(found.structure.contains("less acceleration along tight arcs"), "{}", found.structure);
    assert!((path.short_line_acceleration - 0.5).abs() < 0.03, "{path:?}");
    let along = (path.arc_acceleration_mm_s2.unwrap().powi(2) - path.centripetal_mm_s2.powi(2)).sqrt();
    assert!((along - 405.0).abs() < 40.0, "{along}");
    assert!(fidelity.path_rms_mm < 2e-3 && fidelity.cycle_share < 0.02, "{fidelity:?}");
}

/// Lines and circles from rest to rest, alone and in rows, of many sizes.
fn arcs_and_dwells(scale: f64) -> String {
    let mut text = String::from("G21 G90 G17 G94\nG0 X0 Y0 Z0\nG4 P0.2\n");
    for (size_mm, feed) in [(2.0, 1200), (6.0, 3000), (14.0, 4200), (25.0, 4800)] {
        let size_mm = scale * size_mm;
        let half_mm = 0.5 * size_mm;
        text += &format!("G1 X{size_mm:.4} Y0 F{feed}\nG4 P0.1\nG1 Y{half_mm:.4} Z{half_mm:.4}\nG4 P0.1\n");
        text += &format!("G2 I-{half_mm:.4} J0\nG4 P0.1\nG1 Y{size_mm:.4}\nG3 X0 I-{half_mm:.4} J0\n");
        text += &format!("G1 Y0\nG1 X{half_mm:.4} Y-{half_mm:.4}\nG1 X0 Y0 Z0\nG4 P0.1\n");
    }
    text + "M2\n"
}

#[test]
fn half_of_the_acceleration_before_a_dwell_and_less_in_arcs_are_found() {
    let machine = as_linuxcnc_plans();
    let of = |scale| Recorded::of(&machine, vec![("arcs.nc", arcs_and_dwells(scale))]);
    let found = identify(&of(1.0).runs(), None, SILENT).unwrap();
    assert_found(&found, &agreement(&found.machine, &of(0.8).runs()).unwrap());
}

/// The same from the control test, judged on programs of other kinds: `… --test identification from_the_control_test -- --ignored --nocapture`.
/// Its sibling that always runs is the test above.
#[test]
#[ignore = "a minute and a half"]
fn a_control_as_linuxcnc_is_found_from_the_control_test() {
    let (found, fidelity) = judged(&as_linuxcnc_plans());
    assert_found(&found, &fidelity);
}

#[test]
fn a_control_beyond_every_structure_is_told_by_its_fidelity() {
    // An average over a tenth of a second that also lets the axes swing: none of the structures does that.
    let machine = control(CornerRule::BlendMm(0.01), [0.0; 2], |_| {});
    let swinging = |mut recorded: Recorded| {
        for (_, _, log) in &mut recorded.0 {
            let columns = log.reference.columns().iter().map(|column| swung(column)).collect();
            let command = log.reference.with_columns(columns).unwrap();
            *log = Log::new(&log.name, command.clone(), command).unwrap();
        }
        recorded
    };
    let seen = vec![("contour.nc", contour()), ("engraving.nc", engraving())];
    let unseen = vec![("pocket.nc", POCKET.into()), ("surface.nc", finishing(0.17, 1800))];
    let (seen, unseen) = (swinging(Recorded::of(&machine, seen)), swinging(Recorded::of(&machine, unseen)));
    let found = identify(&seen.runs(), None, SILENT).unwrap();
    let real = agreement(&found.machine, &unseen.runs()).unwrap();
    println!("held out {:?}, unseen {real:?}", found.fidelity);
    assert!(real.path_rms_mm > 2e-3, "{real:?}");
    let ratio = found.fidelity.path_rms_mm / real.path_rms_mm;
    assert!((0.3..3.0).contains(&ratio), "{:?} {real:?}", found.fidelity);
}

/// A command behind a second-order filter of 8 Hz and a damping of 0.4.
fn swung(column: &[f64]) -> Vec<f64> {
    let (omega, damping, period_s) = (8.0 * std::f64::consts::TAU, 0.4, 0.002);
    let (mut position, mut speed) = (column[0], 0.0);
    let step = |target: &f64| {
        for _ in 0..20 {
            let acceleration = omega * omega * (target - position) - 2.0 * damping * omega * speed;
            speed += acceleration * period_s / 20.0;
            position += speed * period_s / 20.0;
        }
        position
    };
    column.iter().map(step).collect()
}

/// The blind table: `cargo test --release -p precomp-pipeline --test identification random_controls -- --ignored --nocapture`, with
/// CONTROLS=FROM..TO for other seeds. Its siblings that always run are the tests of one control each, above.
#[test]
#[ignore = "a minute a control"]
fn random_controls() {
    table(random_control, "1..21");
}

/// The same of controls that do something besides: `… --test identification random_controls_with_more -- --ignored --nocapture`. Its sibling
/// that always runs is `a_lag_and_a_least_time_for_a_line_are_found_with_their_numbers`.
#[test]
#[ignore = "a minute a control"]
fn random_controls_with_more() {
    table(random_control_with_more, "101..121");
}

fn table(control: fn(u64) -> MachineSpec, seeds: &str) {
    let range = std::env::var("CONTROLS").unwrap_or_else(|_| seeds.into());
    let (from, to) = range.split_once("..").unwrap();
    let (mut rows, mut refused) = (Vec::new(), 0);
    for seed in from.parse().unwrap()..to.parse().unwrap() {
        let machine = control(seed);
        let started = std::time::Instant::now();
        let (found, fidelity) = match judge(&machine) {
            Ok(both) => both,
            Err(error) => {
                println!("   refused: {error}");
                refused += 1;
                continue;
            }
        };
        let seconds = started.elapsed().as_secs_f64();
        let own: Vec<_> = machine.axes.iter().map(|axis| axis.filters()).collect();
        println!("{seed}: {:?} {own:?} {:?}", machine.control.unwrap(), machine.path);
        println!(
            "   {}; unseen {:.2} µm RMS {:.1} MAX, time {:.2} %, cycle {:.2} %; it says {:.2} µm RMS {:.1} MAX, cycle {:.2} %; {seconds:.0} s",
            found.structure,
            um(fidelity.path_rms_mm),
            um(fidelity.path_max_mm),
            100.0 * fidelity.time_share,
            100.0 * fidelity.cycle_share,
            um(found.fidelity.path_rms_mm),
            um(found.fidelity.path_max_mm),
            100.0 * found.fidelity.cycle_share,
        );
        rows.push((um(fidelity.path_rms_mm), 100.0 * fidelity.cycle_share));
    }
    let column = |of: fn(&(f64, f64)) -> f64| {
        let mut values: Vec<f64> = rows.iter().map(of).collect();
        values.sort_by(f64::total_cmp);
        (values[values.len() / 2], values[values.len() - 1])
    };
    let (path, cycle) = (column(|row| row.0), column(|row| row.1));
    println!("{refused} refused; path RMS µm median, worst {path:?}; cycle % median, worst {cycle:?}");
    // What a forecast stands: 2 µm and 2 % on programs that no fit saw.
    assert!(refused <= (rows.len() + refused) / 10 && path.0 < 2.0 && cycle.0 < 2.0);
}
