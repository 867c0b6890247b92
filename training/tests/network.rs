//! Networks learn a toy axis. The same seed gives the same weights. Resuming a training does not
//! change the result.

mod network_common;

use std::ops::ControlFlow;

use models::{AxisSignal, NarxPredictor, load_predictor};
use network_common::{PERIOD_S, linear_rms, tiny, toy_run, toy_runs};
use training::TrainingError;
use training::network::{AxisRuns, NetworkKind, NetworkRecipe, held_out_error, train, train_axes, train_resumable};
use training::staged::AxisRun;

#[test]
fn a_tiny_lstm_learns_lag_and_backlash_better_than_a_linear_law() {
    let (runs, held_out, unseen) = (toy_runs(1, 5), toy_runs(50, 2), toy_runs(90, 2));
    let linear = linear_rms(&runs, &unseen);
    for kind in [NetworkKind::Lstm, NetworkKind::Gru] {
        let trained = train(&runs, &held_out, &tiny(kind), 7, &mut |_| ()).expect("the runs are sound");
        let network = held_out_error(trained.predictor.as_ref(), &unseen);
        println!("{kind:?}: {:.2} µm, a linear law {:.2} µm", network * 1e3, linear * 1e3);
        assert!(network < 0.5 * linear, "{kind:?}: {network} against {linear}");
    }
}

#[test]
fn the_same_seed_gives_the_same_weights_and_another_one_does_not() {
    let (runs, held_out) = (toy_runs(1, 2), toy_runs(50, 1));
    for kind in [NetworkKind::Lstm, NetworkKind::Narx] {
        let recipe = NetworkRecipe { epochs: 3, layers: 2, dropout: 0.2, ..tiny(kind) };
        let saved = |seed| train(&runs, &held_out, &recipe, seed, &mut |_| ()).expect("the runs are sound").predictor.save();
        assert_eq!(saved(3), saved(3));
        assert_ne!(saved(3), saved(4));
        // In threads beside other axes, too.
        let axis = AxisRuns { training: runs.clone(), held_out: held_out.clone() };
        let axes = train_axes(&[axis.clone(), axis], &recipe, 3, &|_, _| ()).expect("the runs are sound");
        assert_eq!(axes[0].predictor.save(), saved(3));
        assert_eq!(axes[1].predictor.save(), saved(4));
    }
}

#[test]
fn a_training_that_was_stopped_goes_on_as_if_it_had_not_been() {
    let (runs, held_out) = (toy_runs(1, 2), toy_runs(50, 1));
    let recipe = NetworkRecipe { epochs: 8, validate_every: 3, layers: 2, dropout: 0.1, ..tiny(NetworkKind::Lstm) };
    let whole = train(&runs, &held_out, &recipe, 5, &mut |_| ()).expect("the runs are sound");
    let folder = tempfile::tempdir().expect("a temporary folder");
    // Stopped by the caller after epoch 4, then killed after 7: the checkpoint is of epoch 6.
    for last in [4, 7] {
        let mut stop = |epoch: training::network::Epoch| {
            if epoch.epoch < last { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
        };
        train_resumable(&runs, &held_out, &recipe, 5, folder.path(), &mut stop).expect("the runs are sound");
    }
    let mut seen = Vec::new();
    let resumed = train_resumable(&runs, &held_out, &recipe, 5, folder.path(), &mut |epoch| {
        seen.push(epoch.epoch);
        ControlFlow::Continue(())
    })
    .expect("the checkpoint is sound");
    assert_eq!(seen, [8]);
    assert_eq!(resumed.predictor.save(), whole.predictor.save());
    assert_eq!(resumed.held_out_rms, whole.held_out_rms);
    // Another seed is another training.
    let other = train_resumable(&runs, &held_out, &recipe, 6, folder.path(), &mut |_| ControlFlow::Continue(()));
    assert!(matches!(other, Err(TrainingError::Checkpoint(why)) if why.contains("another training")));
}

#[test]
fn training_stops_early_and_keeps_the_best_weights() {
    let (runs, held_out) = (toy_runs(1, 1), toy_runs(50, 1));
    // So high a rate that the held-out error soon stops falling.
    let recipe = NetworkRecipe {
        learning_rate: 0.3,
        drop_factor: 1.0,
        validate_every: 1,
        patience: 3,
        epochs: 200,
        ..tiny(NetworkKind::Lstm)
    };
    let mut looks = Vec::new();
    let trained = train(&runs, &held_out, &recipe, 1, &mut |epoch| looks.extend(epoch.held_out_rms)).expect("the runs are sound");
    assert!(trained.epochs < 200 && trained.epochs == trained.best_epoch + 3, "{trained:?}");
    let least = looks.iter().copied().fold(f64::INFINITY, f64::min);
    assert_eq!(trained.held_out_rms, least);
    assert_eq!(looks[trained.best_epoch - 1], least);
    assert_eq!(held_out_error(trained.predictor.as_ref(), &held_out), least);
}

#[test]
fn narx_modes_differ_and_its_free_run_stays_bounded() {
    let (runs, held_out) = (toy_runs(1, 4), toy_runs(50, 1));
    let trained = train(&runs, &held_out, &tiny(NetworkKind::Narx), 2, &mut |_| ()).expect("the runs are sound");
    let narx = NarxPredictor::from_saved(&trained.predictor.save()).expect("it is a NARX");
    let run = toy_run(90, 700);
    let signal = AxisSignal::uncompensated(&run.reference, PERIOD_S);
    let errors: Vec<f64> = run.reference.iter().zip(&run.actual).map(|(r, x)| r - x).collect();
    let rms = |predicted: &[f64]| {
        (predicted.iter().zip(&errors).map(|(p, e)| (p - e).powi(2)).sum::<f64>() / errors.len() as f64).sqrt()
    };
    let (free, one_step) =
        (rms(&trained.predictor.predict(&signal)), rms(&narx.predict_one_step(&signal, &errors).expect("same length")));
    println!("parallel {:.2} µm, one step {:.2} µm", free * 1e3, one_step * 1e3);
    assert!(one_step < free, "one step {one_step}, free {free}");
    assert!(narx.predict_one_step(&signal, &errors[1..]).is_err());
    // A thousand times faster than anything trained on, and not a number.
    let largest =
        runs.iter().flat_map(|run| run.reference.iter().zip(&run.actual)).map(|(r, x)| (r - x).abs()).fold(0.0, f64::max);
    let wild: Vec<f64> = (0..3000).map(|k| 1e3 * (f64::from(k) * 0.7).sin() + if k == 2000 { f64::NAN } else { 0.0 }).collect();
    let predicted = trained.predictor.predict(&AxisSignal::uncompensated(&wild, PERIOD_S));
    assert!(predicted.iter().all(|e| e.abs() < 4.0 * largest), "{largest}");
}

#[test]
fn saved_networks_predict_the_same_when_loaded() {
    let (runs, held_out) = (toy_runs(1, 1), toy_runs(50, 1));
    let run = toy_run(90, 700);
    let signal = AxisSignal::uncompensated(&run.reference, PERIOD_S);
    for kind in [NetworkKind::Lstm, NetworkKind::Gru, NetworkKind::Narx] {
        let recipe = NetworkRecipe { epochs: 1, ..tiny(kind) };
        let trained = train(&runs, &held_out, &recipe, 1, &mut |_| ()).expect("the runs are sound");
        let loaded = load_predictor(&trained.predictor.save()).expect("it was just saved");
        assert_eq!(loaded.kind(), trained.predictor.kind());
        assert_eq!(loaded.predict(&signal), trained.predictor.predict(&signal));
        assert_eq!(loaded.save(), trained.predictor.save());
    }
}

#[test]
fn unusable_runs_and_recipes_are_refused() {
    let (runs, held_out) = (toy_runs(1, 1), toy_runs(50, 1));
    let tiny = tiny(NetworkKind::Lstm);
    let refused =
        |runs: &[AxisRun], held_out: &[AxisRun], recipe: &NetworkRecipe| train(runs, held_out, recipe, 1, &mut |_| ()).is_err();
    assert!(refused(&[], &held_out, &tiny));
    assert!(refused(&runs, &[], &tiny));
    assert!(refused(&runs, &held_out, &NetworkRecipe { batch: 0, ..tiny.clone() }));
    assert!(refused(&runs, &held_out, &NetworkRecipe { dropout: 1.0, ..tiny.clone() }));
    let mut uneven = runs.clone();
    uneven[0].actual.pop();
    assert!(refused(&uneven, &held_out, &tiny));
    let mut still = runs;
    still[0].reference.fill(1.0);
    assert!(refused(&still, &held_out, &tiny));
}

#[test]
fn recipes_are_toml_and_drop_their_rate_in_steps() {
    for kind in [NetworkKind::Lstm, NetworkKind::Gru, NetworkKind::Narx] {
        for recipe in [NetworkRecipe::paper(kind), NetworkRecipe::quick(kind)] {
            let text = toml::to_string(&recipe).expect("a recipe is TOML");
            assert_eq!(toml::from_str::<NetworkRecipe>(&text).expect("so it can be read"), recipe);
        }
    }
    let paper = NetworkRecipe::paper(NetworkKind::Lstm);
    assert_eq!(paper.rate(124), 0.01);
    assert!((paper.rate(125) - 0.001).abs() < 1e-15 && (paper.rate(250) - 1e-4).abs() < 1e-15);
}
