//! Durations of the flags after reversals and starts (`n1`, `n2` of Paper D, eq. 11-12), identified
//! from the runs.

use models::features::{EventKind, events, velocity};
use nalgebra::{DMatrix, DVector};

use crate::AxisRun;

/// Velocities on either side that the linear law uses, samples.
const REACH: usize = 25;
/// Ridge of the linear law, as a share of the mean diagonal.
const RIDGE: f64 = 1e-6;
/// Shortest and longest window, s.
const RANGE_S: (f64, f64) = (0.002, 0.150);
/// Default window where there are too few events, s.
const DEFAULT_S: f64 = 0.05;
/// Minimum number of events.
const EVENTS: usize = 8;

/// Lengths of the two flags, samples after the event.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FlagWindows {
    /// `n1`, after a reversal.
    pub backlash: usize,
    /// `n2`, after a start from a standstill.
    pub start: usize,
}

impl FlagWindows {
    /// The windows that best fit the residual of a linear law of the velocity after reversals and
    /// starts. With `p(m)` the mean residual `m` samples after the event, in the new direction, `n`
    /// maximises `(Σ_{m≤n} p(m))²/(n+1)`: the reduction of the squared residual by a flag of that
    /// length. With too few events the window is 50 ms.
    #[must_use]
    pub fn identify(runs: &[AxisRun]) -> Self {
        let period_s = runs.first().map_or(f64::NAN, |run| run.period_s);
        let samples = |seconds: f64| (seconds / period_s).round().clamp(1.0, 1e5) as usize;
        let range = (samples(RANGE_S.0), samples(RANGE_S.1));
        let residuals = residuals(runs);
        let window = |kind| {
            residuals
                .as_ref()
                .and_then(|residuals| profile(runs, residuals, kind, range.1))
                .and_then(|profile| best(&profile, range))
                .unwrap_or_else(|| samples(DEFAULT_S))
        };
        Self { backlash: window(EventKind::Reversal), start: window(EventKind::Start) }
    }
}

/// Residual of a linear law on `v(k−25…k+25)` for each run; `None` if the equations have no
/// solution.
fn residuals(runs: &[AxisRun]) -> Option<Vec<Vec<f64>>> {
    let columns = 2 * REACH + 2;
    let mut gram = DMatrix::<f64>::zeros(columns, columns);
    let mut right = DVector::<f64>::zeros(columns);
    let cut: Vec<(Vec<f64>, Vec<f64>)> = runs.iter().map(|run| (surrounded(run), run.tracking_error())).collect();
    for ((v, error), run) in cut.iter().zip(runs) {
        for block in run.scored().into_iter().flatten().collect::<Vec<_>>().chunks(512) {
            let rows = DMatrix::from_fn(block.len(), columns, |i, j| if j == 0 { 1.0 } else { v[block[i] + j - 1] });
            let errors = DVector::from_fn(block.len(), |i, _| error[block[i]]);
            gram += rows.tr_mul(&rows);
            right += rows.tr_mul(&errors);
        }
    }
    let ridge = RIDGE * gram.trace() / columns as f64;
    for i in 0..columns {
        gram[(i, i)] += ridge;
    }
    let law = gram.cholesky()?.solve(&right);
    let residual = |(v, error): &(Vec<f64>, Vec<f64>)| -> Vec<f64> {
        let predicted =
            v.windows(columns - 1).map(|window| law[0] + window.iter().zip(law.iter().skip(1)).map(|(v, w)| v * w).sum::<f64>());
        error.iter().zip(predicted).map(|(error, predicted)| error - predicted).collect()
    };
    Some(cut.iter().map(residual).collect())
}

/// Velocity with [`REACH`] samples of standstill on either side.
fn surrounded(run: &AxisRun) -> Vec<f64> {
    let mut v = vec![0.0; REACH];
    v.extend(velocity(&run.reference, run.period_s));
    v.resize(v.len() + REACH, 0.0);
    v
}

/// Mean residual after events of one kind, in the new direction, each up to the next event; `None`
/// if there are too few.
fn profile(runs: &[AxisRun], residuals: &[Vec<f64>], kind: EventKind, longest: usize) -> Option<Vec<f64>> {
    let mut sums = vec![(0.0, 0_usize); longest + 1];
    for (run, residual) in runs.iter().zip(residuals) {
        let all = events(&velocity(&run.reference, run.period_s));
        for (index, event) in all.iter().enumerate().filter(|(_, event)| event.kind == kind) {
            let Some(rows) = run.rows.iter().find(|rows| rows.contains(&event.sample)) else { continue };
            let end = all.get(index + 1).map_or(residual.len(), |next| next.sample).min(rows.end);
            for (r, sum) in residual[event.sample..end].iter().zip(&mut sums) {
                *sum = (sum.0 + event.sign * r, sum.1 + 1);
            }
        }
    }
    let told = sums.into_iter().take_while(|(_, count)| *count >= EVENTS);
    let profile: Vec<f64> = told.map(|(sum, count)| sum / count as f64).collect();
    (!profile.is_empty()).then_some(profile)
}

/// The window within `range` that reduces the squared residual most.
fn best(profile: &[f64], range: (usize, usize)) -> Option<usize> {
    let mut sum = 0.0;
    let gains = profile.iter().enumerate().map(|(n, p)| {
        sum += p;
        (n, sum * sum / (n + 1) as f64)
    });
    gains.filter(|(n, _)| (range.0..=range.1).contains(n)).max_by(|a, b| a.1.total_cmp(&b.1)).map(|(n, _)| n)
}
