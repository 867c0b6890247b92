//! Standstills, in which a correction is constant.

/// Standstills in which a correction is held.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Held {
    /// Those of each axis: an axis that a program does not move keeps its shift.
    EachAxis,
    /// Those of all axes together. An axis that stands still while others move is corrected like
    /// these: friction and integrators let it creep for a second after it has come to a stop.
    AllAxes,
}

/// Intersection of lists of segments.
pub(super) fn common(mut lists: impl Iterator<Item = Vec<(usize, usize)>>) -> Vec<(usize, usize)> {
    let Some(first) = lists.next() else { return Vec::new() };
    lists.fold(first, |all, list| {
        let overlap = |a: &(usize, usize), b: &(usize, usize)| (a.0.max(b.0), a.1.min(b.1));
        let mut out: Vec<(usize, usize)> = Vec::new();
        let mut from = 0;
        for a in &all {
            from += list[from..].partition_point(|b| b.1 <= a.0);
            out.extend(list[from..].iter().take_while(|b| b.0 < a.1).map(|b| overlap(a, b)).filter(|o| o.1 > o.0));
        }
        out
    })
}

/// Standstills `(first, last)` of an axis of the desired path, shortened by `settle` samples on the
/// sides where it moves.
pub(super) fn standstills(path: &[f64], settle: usize) -> Vec<(usize, usize)> {
    let n = path.len();
    let still = |k: usize| path[k] == path[k - 1];
    let mut standstills = Vec::new();
    let mut k = 1;
    while k < n {
        let first = k - 1;
        while k < n && still(k) {
            k += 1;
        }
        let last = k - 1;
        let from = if first == 0 { 0 } else { first + settle };
        let to = if last + 1 == n { last } else { last.saturating_sub(settle) };
        if last > first && to > from {
            standstills.push((from, to));
        }
        k += 1;
    }
    standstills
}

/// Holds the correction in every standstill at the mean of the law's correction, before the first
/// motion at zero: the position before a motion differs from run to run.
pub(super) fn hold(correction: &mut [f64], standstills: &[(usize, usize)], taper: usize) {
    for &(first, last) in standstills {
        // Each end starts at the law's correction and reaches the mean within the taper, unless no
        // motion follows.
        let (leaving, coming) = (correction[first], correction[last]);
        let level = if first > 0 { mean(&correction[first..=last]) } else { 0.0 };
        correction[first..=last].fill(level);
        let share = |i: usize| 0.5 + 0.5 * (std::f64::consts::PI * i as f64 / taper as f64).cos();
        for i in 0..taper.min(last + 1 - first) {
            if first > 0 {
                correction[first + i] += (leaving - level) * share(i);
            }
            if last + 1 < correction.len() {
                correction[last - i] += (coming - level) * share(i);
            }
        }
    }
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Duration over which a correction is taken back, s.
pub(super) const TAPER_S: f64 = 0.02;

/// Whole samples of a duration, at least one.
pub(super) fn samples(seconds: f64, period_s: f64) -> usize {
    (seconds / period_s).round().max(1.0) as usize
}
