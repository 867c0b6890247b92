//! What the tests of the staged predictor share.
#![allow(dead_code)] // Each test file uses a part of it.

use models::staged::StagedPredictor;
use models::{AxisPredictor, AxisSignal};
use training::staged::AxisRun;

/// Rows of numbers of a shared log, or `None` where the shared folder is missing (an error under continuous integration).
pub fn shared_log(name: &str) -> Option<Vec<Vec<f64>>> {
    let path = format!("{}/../../shared/data/logs/{name}", env!("CARGO_MANIFEST_DIR"));
    match std::fs::read_to_string(&path) {
        Ok(text) => {
            Some(text.lines().skip(1).map(|line| line.split(',').map(|field| field.parse().unwrap()).collect()).collect())
        }
        Err(_) => {
            assert!(std::env::var("CI").as_deref() != Ok("true"), "../shared is not there");
            println!("skipped: ../shared is not there");
            None
        }
    }
}

/// One axis of some rows of a log.
pub fn run_of(rows: &[Vec<f64>], command: usize, actual: usize, period_s: f64) -> AxisRun {
    AxisRun::new(rows.iter().map(|row| row[command]).collect(), rows.iter().map(|row| row[actual]).collect(), period_s)
}

/// Prediction errors on a run.
pub fn residual(predictor: &dyn AxisPredictor, run: &AxisRun) -> Vec<f64> {
    let predicted = predictor.predict(&AxisSignal::uncompensated(&run.reference, run.period_s));
    run.reference.iter().zip(&run.actual).zip(predicted).map(|((r, x), e)| r - x - e).collect()
}

/// The first pass only: the linear law, or a simpler one.
pub fn first_pass(predictor: &StagedPredictor) -> StagedPredictor {
    predictor.linear_part()
}

/// Root mean square.
pub fn rms(values: impl IntoIterator<Item = f64>) -> f64 {
    let (sum, count) = values.into_iter().fold((0.0, 0_usize), |(sum, count), x| (sum + x * x, count + 1));
    (sum / count.max(1) as f64).sqrt()
}
