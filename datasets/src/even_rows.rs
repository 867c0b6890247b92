//! Even sampling behind uneven time stamps, found from the motion itself.

use crate::timing::{UNIFORM_SHARE, base_period_s, snap, uniform_period_s};
use crate::{Check, Finding, Severity};

/// Roughness of the motion over even times, as a share of that over the stamps, up to which the rows count as even.
const MUCH_SMOOTHER: f64 = 0.5;
/// The same of rows with losses, as a share of that without.
const SMOOTHER: f64 = 0.9;
/// Largest roughness of a motion over its own times. A log with 20 rows for each change of its acceleration has a tenth of it.
const SMOOTH: f64 = 0.1;
/// Parts of a log whose clocks are compared, and largest relative difference of their speeds from the mean.
const PARTS: usize = 4;
const SAME_SPEED: f64 = 0.05;
/// Deviation of stamps, as a share of the log's duration, from which on they do not tell its period.
const COARSEST: f64 = 0.01;
/// Share of a stamp's deviation that shifts the grid of the rows behind it.
const FOLLOWED: f64 = 0.05;

/// Even times in place of `times` (s, never going back), where over them the motion of `columns` is much smoother.
///
/// A motion is smooth over the times at which it was sampled. Stamps of a clock that is coarser than the sampling, or set by a busy computer
/// when it writes the row, are not these times: over them the motion shakes. Tried are rows one period apart, and rows a whole number of
/// periods apart, where some were lost.
pub(crate) fn even_times(times: &[f64], columns: &[Vec<f64>]) -> Option<(Vec<f64>, Finding)> {
    if times.windows(2).any(|pair| pair[1] < pair[0]) {
        return None;
    }
    let (first_s, period_s) = line_through(times)?;
    let off_s = times.iter().enumerate().map(|(k, time)| (time - first_s - k as f64 * period_s).abs()).fold(0.0, f64::max);
    let duration_s = times.last()? - times[0];
    if off_s <= UNIFORM_SHARE * period_s || off_s > COARSEST * duration_s {
        return None;
    }
    let without_loss = is_straight(times, period_s).then(|| {
        let period_s = uniform_period_s(snap(period_s, 1e-5, 1e-3));
        ((0..times.len()).map(|k| first_s + k as f64 * period_s).collect::<Vec<_>>(), period_s)
    });
    let rated = |(even, period_s): (Vec<f64>, f64)| Some((roughness(&even, columns)?, even, period_s));
    let best = match (without_loss.and_then(rated), counted(times).and_then(rated)) {
        (Some(even), Some(counted)) => {
            if counted.0 < SMOOTHER * even.0 {
                counted
            } else {
                even
            }
        }
        (even, counted) => even.or(counted)?,
    };
    let (rough, even, period_s) = best;
    let is_smoother = roughness(times, columns).is_none_or(|stamped| rough <= MUCH_SMOOTHER * stamped);
    if rough > SMOOTH || !is_smoother {
        return None;
    }
    let off_s = times.iter().zip(&even).map(|(time, even)| (time - even).abs()).fold(0.0, f64::max);
    let message = format!(
        "the time stamps are off by up to {:.3} ms: the motion is smooth only with a row every {:.6} ms, which was used instead",
        1e3 * off_s,
        1e3 * period_s
    );
    Some((even, Finding::new(Severity::Warn, Check::Timing, message)))
}

/// Whether every part of the times advances by about this period: no clock was set, no stretch of rows was lost.
fn is_straight(times: &[f64], period_s: f64) -> bool {
    times.chunks(times.len().div_ceil(PARTS)).all(|part| {
        let advanced_s = part[part.len() - 1] - part[0];
        (advanced_s / ((part.len() - 1) as f64 * period_s) - 1.0).abs() <= SAME_SPEED
    })
}

/// Start and slope of the straight line through times over rows; `None` where they do not advance.
fn line_through(times: &[f64]) -> Option<(f64, f64)> {
    let count = times.len() as f64;
    let middle = 0.5 * (count - 1.0);
    let mean = times.iter().map(|time| (time - times[0]) / count).sum::<f64>();
    let (mut product, mut square) = (0.0, 0.0);
    for (k, time) in times.iter().enumerate() {
        let row = k as f64 - middle;
        product += row * (time - times[0]);
        square += row * row;
    }
    let slope = product / square;
    let advances = slope.is_finite() && slope > 0.0;
    advances.then(|| (times[0] + mean - middle * slope, slope))
}

/// Times a whole number of periods apart that follow the stamps, and the period; `None` where the stamps show no period.
fn counted(times: &[f64]) -> Option<(Vec<f64>, f64)> {
    let intervals: Vec<f64> = times.windows(2).map(|pair| pair[1] - pair[0]).filter(|interval| *interval > 0.0).collect();
    if intervals.len() + 1 < times.len() {
        return None;
    }
    let period_s = uniform_period_s(base_period_s(&intervals));
    let (mut row, mut grid_s) = (0.0, times[0]);
    let counted = times.iter().enumerate().map(|(k, time)| {
        if k > 0 {
            let late_s = time - grid_s - period_s;
            let lost = (late_s / period_s).round().max(0.0);
            row += 1.0 + lost;
            grid_s += (1.0 + lost) * period_s + FOLLOWED * (late_s - lost * period_s);
        }
        times[0] + row * period_s
    });
    Some((counted.collect(), period_s))
}

/// How far rows lie from the cubic through two neighbours on either side: RMS over the axes, as a share of the RMS of their steps. `None` where
/// two rows have one time or nothing moves.
fn roughness(times: &[f64], columns: &[Vec<f64>]) -> Option<f64> {
    if times.windows(2).any(|pair| pair[1] <= pair[0]) {
        return None;
    }
    let mut ratios = Vec::new();
    for column in columns {
        let (mut off, mut step) = (0.0, 0.0);
        for (times, values) in times.windows(5).zip(column.windows(5)) {
            if values[2] != values[1] || values[2] != values[3] {
                off += (values[2] - through_neighbours(times, values)).powi(2);
                step += (values[3] - values[2]).powi(2);
            }
        }
        if step > 0.0 {
            ratios.push((off / step).sqrt());
        }
    }
    let rough = (ratios.iter().map(|ratio| ratio * ratio).sum::<f64>() / ratios.len() as f64).sqrt();
    rough.is_finite().then_some(rough)
}

/// Value at the middle of five times by the cubic through the other four.
fn through_neighbours(times: &[f64], values: &[f64]) -> f64 {
    let others = [0, 1, 3, 4];
    let weight = |i: usize| {
        let factors = others.iter().filter(|j| **j != i).map(|j| (times[2] - times[*j]) / (times[i] - times[*j]));
        factors.product::<f64>()
    };
    others.iter().map(|i| weight(*i) * values[*i]).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    const PERIOD_S: f64 = 0.002;

    fn position(time_s: f64) -> f64 {
        20.0 * (7.0 * time_s).sin() + 3.0 * (31.0 * time_s).cos()
    }

    /// Pseudo-random numbers from 0 to 1.
    fn noise(k: usize) -> f64 {
        ((k as f64 * 12.9898).sin() * 43_758.547).rem_euclid(1.0)
    }

    /// A log sampled at `sampled`, s.
    fn columns(sampled: &[f64]) -> Vec<Vec<f64>> {
        vec![sampled.iter().map(|time| (position(*time) * 1e4).round() / 1e4).collect()]
    }

    fn grid(rows: usize) -> Vec<f64> {
        (0..rows).map(|k| 5.0 + PERIOD_S * k as f64).collect()
    }

    /// Largest deviation from the true times, but for a constant.
    fn off_s(found: &[f64], sampled: &[f64]) -> f64 {
        let late = found[0] - sampled[0];
        found.iter().zip(sampled).map(|(found, sampled)| (found - sampled - late).abs()).fold(0.0, f64::max)
    }

    #[test]
    fn stamps_of_a_coarse_or_a_busy_clock_are_replaced_by_even_ones() {
        let sampled = grid(5000);
        let coarse = |time: &f64| (time / 0.01).floor() * 0.01;
        let late: Vec<f64> = sampled.iter().enumerate().map(|(k, time)| time + 0.0018 * noise(k)).collect();
        let mut stuck = sampled.clone();
        stuck[300..312].iter_mut().enumerate().for_each(|(k, time)| *time = 5.6235 + 1e-5 * k as f64);
        for (name, stamps) in [("coarse", sampled.iter().map(coarse).collect()), ("late", late), ("stuck", stuck)] {
            let (even, finding) = even_times(&stamps, &columns(&sampled)).expect(name);
            assert!(off_s(&even, &sampled) < 2e-4, "{name}: {}", off_s(&even, &sampled));
            assert!(finding.message.contains("2.000"), "{name}: {}", finding.message);
        }
    }

    #[test]
    fn lost_rows_are_counted_behind_jittering_stamps() {
        let sampled: Vec<f64> = grid(5000).into_iter().enumerate().filter(|(k, _)| k % 700 < 697).map(|(_, time)| time).collect();
        let stamps: Vec<f64> = sampled.iter().enumerate().map(|(k, time)| time + 0.0006 * noise(k)).collect();
        let (even, _) = even_times(&stamps, &columns(&sampled)).unwrap();
        assert!(off_s(&even, &sampled) < 1e-9);
    }

    #[test]
    fn stamps_that_tell_when_rows_were_sampled_stay() {
        let polled: Vec<f64> = grid(5000).iter().enumerate().map(|(k, time)| time + 0.0012 * noise(k)).collect();
        assert!(even_times(&polled, &columns(&polled)).is_none());
        // Rows that neither the stamps nor any grid makes smooth, and an axis at rest.
        let stamps: Vec<f64> = grid(5000).iter().map(|time| (time / 0.01).floor() * 0.01).collect();
        assert!(even_times(&stamps, &[(0..5000).map(noise).collect()]).is_none());
        assert!(even_times(&stamps, &[vec![1.0; 5000]]).is_none());
        assert!(even_times(&grid(5000), &columns(&grid(5000))).is_none());
        // A clock that was set, forward or back, says nothing about the rows between.
        for second in [1.0, -1.0] {
            let set: Vec<f64> =
                grid(5000).iter().enumerate().map(|(k, time)| time + if k < 1500 { 0.0 } else { second }).collect();
            assert!(even_times(&set, &columns(&grid(5000))).is_none(), "{second}");
        }
    }
}
