//! Arcs of a compensated program: they stay arcs, through the corrected points.

use std::path::Path;

use gcode::{Dialect, MoveKind};
use machine::MachineSpec;
use motion::Trajectory;
use pipeline::refit::TimeEncoding;
use pipeline::{Input, OutputFormat, OutputSettings, Part, ReadSettings, Setup};

/// Largest shift of the correction, mm.
const SHIFT_MM: f64 = 0.004;

/// The path with a smooth correction that is zero at both ends and beside moves that are left alone.
fn corrected(part: &Part, waves_rad: f64) -> Trajectory {
    let (path, taper) = (part.plan.desired.trajectory(), part.taper());
    let last = (path.len() - 1) as f64;
    let columns = path.columns().iter().enumerate().map(|(axis, column)| {
        let shift = |k: usize| {
            let share = k as f64 / last;
            SHIFT_MM * taper[k] * (std::f64::consts::PI * share).sin() * (waves_rad * share + axis as f64).sin()
        };
        column.iter().enumerate().map(|(k, at)| at + shift(k)).collect()
    });
    path.with_columns(columns.collect()).unwrap()
}

/// Lines and arcs of a program written with such a correction, read back.
fn written(text: &str) -> (usize, usize, String) {
    written_with(text, 20.0)
}

/// The same with a correction of so many waves along the path, rad.
fn written_with(text: &str, waves_rad: f64) -> (usize, usize, String) {
    let setup = Setup::new(&MachineSpec::builtin("ballscrew").unwrap(), None).unwrap();
    let settings = ReadSettings { dialect: Some(Dialect::Fanuc), ..ReadSettings::default() };
    let input = Input::from(Part::read("arcs.nc", text.as_bytes().to_vec(), &setup, &settings).unwrap());
    let format = OutputSettings::new(&setup, Some(OutputFormat::Program(TimeEncoding::Keep)), None, None);
    // The writer reads its output back and compares every point and centre.
    let output =
        input.write(&corrected(input.part().unwrap(), waves_rad), &format, 2.0 * SHIFT_MM, Path::new("arcs.nc")).unwrap();
    let program = gcode::parse(output.content.clone());
    let toolpath = gcode::interpret(&program, &Dialect::Fanuc.into()).unwrap();
    let count = |is: fn(&MoveKind) -> bool| toolpath.moves.iter().filter(|step| is(&step.kind)).count();
    let (lines, arcs) = (count(|kind| matches!(kind, MoveKind::Line)), count(|kind| matches!(kind, MoveKind::Arc(_))));
    (lines, arcs, String::from_utf8(output.content).unwrap())
}

#[test]
fn an_arc_stays_arcs_in_every_plane_unit_and_frame_of_centres() {
    for text in [
        "G21 G90 G17\nG0 X0 Y0 Z0\nG1 X10 F600\nG3 X10 Y20 I0 J10\nG1 X0\nM30\n",
        "G21 G90 G17\nG0 X0 Y0 Z0\nG1 X10 F600\nG2 X10 Y20 R10\nG1 X0\nM30\n",
        "G20 G90 G17\nG0 X0 Y0 Z0\nG1 X0.4 F24\nG3 X0.4 Y0.8 I0 J0.4\nG1 X0\nM30\n",
        "G21 G90 G17\nG0 X0 Y0 Z0\nG91 G1 X10 F600\nG3 Y20 I0 J10 Z2\nG1 X-10\nM30\n",
        "G21 G90 G90.1 G17\nG0 X0 Y0 Z0\nG1 X10 F600\nG3 X10 Y20 I10 J10\nG1 X0\nM30\n",
        "G21 G90 G18\nG0 X0 Y0 Z0\nG1 X10 F600\nG2 X10 Z20 I0 K10\nG1 X0\nM30\n",
        "G21 G90 G19\nG0 X0 Y0 Z0\nG1 Y10 F600\nG3 Y10 Z20 J0 K10\nG1 Y0\nM30\n",
        "G21 G90 G17\nG52 X3 Y4\nG0 X0 Y0 Z0\nG1 X10 F600\nG3 X10 Y0 I5 J0\nG1 X0\nM30\n",
    ] {
        let (lines, arcs, out) = written(text);
        // As lines within the same tolerance an arc of 31 mm takes more than two hundred.
        assert!((3..40).contains(&arcs) && lines < 60, "{lines} lines, {arcs} arcs of\n{text}\n{out}");
    }
}

#[test]
fn a_move_after_an_arc_that_relies_on_its_code_gets_it() {
    // The second arc is left alone, because a switch may skip it.
    let text = "G21 G90 G17\nG0 X0 Y0 Z0\nG1 X10 F600\nG3 X10 Y20 I0 J10\n/X0 Y30 I-10 J0\nG1 X0 Y0\nM30\n";
    let (_, arcs, out) = written(text);
    assert!(arcs > 3, "{out}");
    let kept = out.lines().find(|line| line.starts_with('/')).unwrap();
    let before = out.lines().take_while(|line| !line.starts_with('/')).filter(|line| line.contains('G')).last().unwrap();
    assert!(kept.contains("G3") || before.contains("G3"), "{out}");
}

#[test]
fn arcs_meet_without_a_kink() {
    // Controls slow down at kinks between arcs.
    let text = "G21 G90 G17\nG0 X0 Y0 Z0\nG1 X10 F600\nG3 X10 Y20 I0 J10\nG3 X10 Y0 I0 J-10\nG1 X0\nM30\n";
    let (_, arcs, out) = written_with(text, 300.0);
    let toolpath = gcode::interpret(&gcode::parse(out), &Dialect::Fanuc.into()).unwrap();
    let heading = |step: &gcode::Move, at_end: bool| {
        let MoveKind::Arc(arc) = step.kind else { return None };
        let radius_angle = arc.start_angle + if at_end { arc.sweep } else { 0.0 };
        Some(radius_angle + std::f64::consts::FRAC_PI_2.copysign(arc.sweep))
    };
    let joints = toolpath.moves.windows(2).filter_map(|pair| Some(heading(&pair[1], false)? - heading(&pair[0], true)?));
    let kinks: Vec<f64> = joints.map(|angle| angle.sin().abs()).collect();
    assert!(arcs > 10 && kinks.len() > 10, "{arcs} arcs");
    assert!(kinks.iter().all(|kink| *kink < 1.1e-3), "{kinks:?}");
}
