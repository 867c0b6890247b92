//! Networks on the simulated machine: trained on random motion, tested on planned curves.

use std::sync::Arc;

use datasets::{ExcitationPlan, excite};
use machine::{MachineSpec, SimulatedMachine};
use motion::curves::library::{CROWN, FLOWER, SPIRAL, random_nurbs};
use motion::{Curve, PlanSettings, Trajectory, plan_curve};
use training::network::{AxisRuns, NetworkKind, NetworkRecipe, held_out_error, train, train_axes};
use training::staged::AxisRun;

/// Excitation for training, more for validation, and unseen curves, axis by axis.
struct Recorded {
    axes: Vec<AxisRuns>,
    curves: Vec<(&'static str, Vec<AxisRun>)>,
}

fn record(seconds: f64) -> Recorded {
    let spec = MachineSpec::builtin("ballscrew").expect("it is built in");
    let mut machine = SimulatedMachine::new(&spec, 1).expect("it is sound");
    let mut run = |reference: &Trajectory| -> Vec<AxisRun> {
        let actual = machine.run_full(reference).expect("a run").motor;
        let columns = reference.columns().iter().zip(actual.columns());
        columns.map(|(r, x)| AxisRun::new(r.clone(), x.clone(), reference.period_s())).collect()
    };
    let period_s = spec.sampling_period_s();
    let axes = spec.motion_axes();
    let travel = vec![(-60.0, 60.0); axes.len()];
    let mut recorded = Recorded { axes: vec![AxisRuns::default(); axes.len()], curves: Vec::new() };
    // Only the limits of the axes: with path limits, random motion in three axes seldom brings each
    // axis to its top speed.
    let mut limits = spec.limits();
    limits.path_velocity_mm_s *= 1.8;
    limits.path_acceleration_mm_s2 *= 1.8;
    limits.path_jerk_mm_s3 *= 1.8;
    limits.centripetal_mm_s2 *= 1.8;
    let mut add = |seconds: f64, seed: u64, held_out: bool| {
        let plan = ExcitationPlan::of_seconds(seconds);
        for (_, reference) in excite(&plan, &limits, &axes, &travel, period_s, seed).expect("sound limits") {
            for (runs, run) in recorded.axes.iter_mut().zip(run(&reference)) {
                if held_out { runs.held_out.push(run) } else { runs.training.push(run) }
            }
        }
    };
    add(seconds, 11, false);
    add(seconds / 3.0, 12, true);
    let nurbs = random_nurbs(20, 20.0, 3, 5).expect("a curve");
    let curves: [(&'static str, Arc<dyn Curve>); 4] =
        [("crown", Arc::new(CROWN)), ("spiral", Arc::new(SPIRAL)), ("flower", Arc::new(FLOWER)), ("nurbs", Arc::new(nurbs))];
    for (name, curve) in curves {
        let settings = PlanSettings { period_s, ..PlanSettings::default() };
        let path = plan_curve(curve, 80.0, &spec.limits(), &settings).expect("a plan");
        recorded.curves.push((name, run(path.trajectory())));
    }
    recorded
}

#[test]
fn a_quarter_of_a_minute_teaches_a_small_lstm_one_axis() {
    let recorded = record(15.0);
    let recipe = NetworkRecipe { hidden: 32, epochs: 60, drop_every: 16, ..NetworkRecipe::quick(NetworkKind::Lstm) };
    let AxisRuns { training, held_out } = &recorded.axes[2];
    let trained = train(training, held_out, &recipe, 1, &mut |_| ()).expect("the runs are sound");
    println!("held out {:.3} µm", trained.held_out_rms * 1e3);
    for (name, runs) in &recorded.curves {
        let rms_mm = held_out_error(trained.predictor.as_ref(), &runs[2..]);
        println!("{name}: {:.3} µm", rms_mm * 1e3);
        assert!(rms_mm < 2e-3, "{name}: {rms_mm} mm");
    }
}

#[test]
#[ignore = "takes a minute or two: run with --ignored (training/README.md)"]
fn the_quick_recipe_predicts_unseen_curves_to_less_than_a_micrometre() {
    let recorded = record(60.0);
    let start = std::time::Instant::now();
    let recipe = NetworkRecipe::quick(NetworkKind::Lstm);
    let trained = train_axes(&recorded.axes, &recipe, 1, &|_, _| ()).expect("the runs are sound");
    println!(
        "{} samples an axis, {:.1} s",
        recorded.axes[0].training.iter().map(|run| run.reference.len()).sum::<usize>(),
        start.elapsed().as_secs_f64()
    );
    for (axis, trained) in trained.iter().enumerate() {
        println!(
            "axis {axis}: held out {:.3} µm, best after {} of {} epochs",
            trained.held_out_rms * 1e3,
            trained.best_epoch,
            trained.epochs
        );
        for (name, runs) in &recorded.curves {
            let rms_mm = held_out_error(trained.predictor.as_ref(), &runs[axis..=axis]);
            println!("    {name}: {:.3} µm", rms_mm * 1e3);
            assert!(rms_mm < 0.7e-3, "{name}: {rms_mm} mm");
        }
    }
}
