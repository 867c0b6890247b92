//! The built-in five-axis machines: Paper C's errors on its saddle, and settling loops.

mod common;

use std::f64::consts::{PI, TAU};

use common::{PERIOD_S, peak, rms};
use machine::{Machine, MachineSpec, SimulatedMachine, SimulationOptions};
use motion::{Pose, Trajectory, Vec3};

/// Height of the workpiece's origin above the B axis, mm.
const PIVOT_MM: f64 = 50.0;

/// The saddle at `u`, with the tool along the surface normal.
fn saddle(u: f64) -> Pose {
    let (x, y) = (40.0 * u.cos(), 40.0 * u.sin());
    Pose { tip: Vec3::new(x, y, (x * x - y * y) / 160.0), tool: Vec3::new(-x / 80.0, y / 80.0, 1.0).normalize() }
}

fn about_z(v: Vec3, angle: f64) -> Vec3 {
    let (s, c) = angle.sin_cos();
    Vec3::new(c * v.x - s * v.y, s * v.x + c * v.y, v.z)
}

fn about_y(v: Vec3, angle: f64) -> Vec3 {
    let (s, c) = angle.sin_cos();
    Vec3::new(c * v.x + s * v.z, v.y, c * v.z - s * v.x)
}

/// Axis positions of a pose: `tool = (cos C sin B, sin C sin B, cos B)`, with the solution for C
/// nearest to `near`.
fn joints(pose: &Pose, near: f64) -> [f64; 5] {
    let b = pose.tool.x.hypot(pose.tool.y).atan2(pose.tool.z);
    let c = pose.tool.y.atan2(pose.tool.x);
    let c = c + TAU * ((near - c) / TAU).round();
    let pivot = Vec3::new(0.0, 0.0, -PIVOT_MM);
    let at = about_y(about_z(pose.tip, -c) - pivot, -b) + pivot;
    [at.x, at.y, at.z, b, c]
}

fn pose(joints: &[f64]) -> Pose {
    let pivot = Vec3::new(0.0, 0.0, -PIVOT_MM);
    let at = Vec3::new(joints[0], joints[1], joints[2]);
    let tip = about_z(about_y(at - pivot, joints[3]) + pivot, joints[4]);
    Pose { tip, tool: about_z(about_y(Vec3::z(), joints[3]), joints[4]) }
}

/// One lap of the saddle at `feed` mm/s from standstill to standstill, each ramp 0.2 s long.
fn reference(spec: &MachineSpec, feed: f64) -> Trajectory {
    let count = 40_000;
    let mut length = vec![0.0];
    let at = |i: usize| saddle(TAU * i as f64 / count as f64);
    for i in 0..count {
        length.push(length[i] + (at(i + 1).tip - at(i).tip).norm());
    }
    let (total, ramp) = (length[count], 0.2);
    let end = total / feed + ramp;
    // Path length of the speed (1 − cos(π t/ramp))/2.
    let risen = |t: f64| 0.5 * t - 0.5 * ramp / PI * (PI * t / ramp).sin();
    let mut columns = vec![Vec::new(); 5];
    let mut c = 0.0;
    for k in 0..((end + 0.2) / PERIOD_S) as usize {
        let t = (k as f64 * PERIOD_S - 0.1).clamp(0.0, end);
        let arc_length = if t < ramp {
            feed * risen(t)
        } else if t > end - ramp {
            total - feed * risen(end - t)
        } else {
            feed * (t - 0.5 * ramp)
        };
        let i = length.partition_point(|l| *l <= arc_length).clamp(1, count);
        let fraction = (arc_length - length[i - 1]) / (length[i] - length[i - 1]);
        let u = TAU * (i as f64 - 1.0 + fraction) / count as f64;
        let joints = joints(&saddle(u), if k == 0 { PI } else { c });
        c = joints[4];
        for (column, joint) in columns.iter_mut().zip(joints) {
            column.push(joint);
        }
    }
    Trajectory::new(PERIOD_S, spec.motion_axes(), columns).unwrap()
}

fn poses(trajectory: &Trajectory) -> Vec<Pose> {
    (0..trajectory.len()).map(|k| pose(&trajectory.at(k).collect::<Vec<_>>())).collect()
}

/// Tip contour error, mm, and orientation error at the foot point, rad, of every sample in motion.
fn errors(desired: &[Pose], actual: &[Pose]) -> (Vec<f64>, Vec<f64>) {
    let moving = (50..actual.len() - 51).filter(|k| (desired[k + 1].tip - desired[*k].tip).norm() > 1e-9);
    moving
        .map(|k| {
            let foot = |i: usize| {
                let (a, b) = (&desired[i], &desired[i + 1]);
                let chord = b.tip - a.tip;
                let f = ((actual[k].tip - a.tip).dot(&chord) / chord.norm_squared().max(1e-30)).clamp(0.0, 1.0);
                Pose { tip: a.tip + f * chord, tool: (a.tool + f * (b.tool - a.tool)).normalize() }
            };
            let feet = (k.saturating_sub(20)..(k + 20).min(desired.len() - 1)).map(foot);
            let distance = |pose: &Pose| (pose.tip - actual[k].tip).norm();
            let nearest = feet.min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap();
            (distance(&nearest), nearest.angle_to(&actual[k]))
        })
        .unzip()
}

#[test]
fn the_saddle_shows_errors_like_paper_c() {
    let spec = MachineSpec::builtin("bc").unwrap();
    let reference = reference(&spec, 1000.0 / 60.0);
    let desired = poses(&reference);
    let mut machine = SimulatedMachine::new(&spec, 1).unwrap();
    let runs: Vec<Trajectory> = (0..4).map(|_| machine.run(&reference).unwrap()).collect();
    for run in &runs {
        let (tip, tool) = errors(&desired, &poses(run));
        let figures = [1e3 * rms(&tip), 1e3 * peak(&tip), 1e6 * rms(&tool), 1e6 * peak(&tool)];
        println!("tip {:.2} / {:.2} µm, tool {:.0} / {:.0} µrad", figures[0], figures[1], figures[2], figures[3]);
        // Paper C: RMS and MAX of the tip, µm, and of the tool orientation, µrad.
        for (figure, printed) in figures.into_iter().zip([5.380, 8.656, 299.3, 329.0]) {
            assert!((printed / 1.25..=printed * 1.25).contains(&figure), "{figure} where {printed} is printed");
        }
    }
    let scatter: Vec<f64> = (0..5)
        .map(|a| {
            let pairs = runs.windows(2).map(|pair| rms(&pair[0].tracking_error(&pair[1]).unwrap()[a]));
            pairs.sum::<f64>() / (3.0 * 2.0_f64.sqrt())
        })
        .collect();
    println!(
        "repeats within {:.2?} µm or µrad",
        scatter.iter().enumerate().map(|(a, s)| s * if a < 3 { 1e3 } else { 1e6 }).collect::<Vec<_>>()
    );
    assert!(scatter[..3].iter().all(|mm| (0.5e-4..3e-4).contains(mm)), "{scatter:?} mm");
    assert!(scatter[3..].iter().all(|rad| (0.5e-6..1e-5).contains(rad)), "{scatter:?} rad");
}

/// Small enough to stay off the torque limit, large enough to break friction away.
const STEPS: [f64; 5] = [0.2, 0.2, 0.2, 5e-3, 5e-3];

#[test]
fn loops_are_damped() {
    for name in ["bc", "xyzac"] {
        let spec = MachineSpec::builtin(name).unwrap();
        let columns = STEPS.map(|step| (0..400).map(|k| if k < 100 { 0.0 } else { step }).collect()).to_vec();
        let step = Trajectory::new(PERIOD_S, spec.motion_axes(), columns).unwrap();
        let options = SimulationOptions { quantised: false, ..SimulationOptions::noise_free() };
        let mut machine = SimulatedMachine::new(&spec, 1).unwrap().with_options(options).unwrap();
        let run = machine.run_full(&step).unwrap();
        for (a, axis) in spec.axes.iter().enumerate() {
            let share = |k: usize, view: &Trajectory| view.columns()[a][k] / STEPS[a];
            let highest = (100..400).map(|k| share(k, &run.motor)).fold(0.0, f64::max);
            let rung = (250..399).map(|k| (share(k + 1, &run.table) - share(k, &run.table)).abs()).fold(0.0, f64::max);
            let left = (1.0 - share(399, &run.motor)).abs();
            let shown = format!("{name}, {}: highest {highest:.3}, left {left:.4}, rings {rung:.1e}", axis.name());
            println!("{shown}");
            assert!(highest < 1.1 && left < 0.02 && rung < 1e-3, "{shown}");
        }
    }
}
