//! Finite impulse responses, and the bases of them through which a signal acts on the tracking error.

use std::ops::Range;

use serde::{Deserialize, Serialize};

use super::taps::{Tap, add_taps};
use crate::ranges::{MOST_SAMPLES, WEIGHT, all_within, at_most};

/// Second differences below this share of the largest tap are rounding.
const ROUNDING: f64 = 1e-11;

/// A finite impulse response, `y(k) = Σ_i taps[i]·u(k + first_lag + i)`; negative lags look back.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Fir {
    /// Lag of the first tap, samples.
    pub first_lag: isize,
    /// One weight a lag.
    pub taps: Vec<f64>,
}

impl Fir {
    /// The signal itself, `lag` samples later (or earlier, where negative).
    #[must_use]
    pub fn shift(lag: isize) -> Self {
        Self { first_lag: lag, taps: vec![1.0] }
    }

    pub(super) fn check(&self) -> Result<(), String> {
        if self.taps.is_empty() {
            return Err("a response without taps".into());
        }
        at_most("first_lag without its sign", self.first_lag.unsigned_abs(), MOST_SAMPLES)?;
        at_most("number of taps", self.taps.len(), MOST_SAMPLES)?;
        all_within("taps", &self.taps, WEIGHT)
    }

    /// Lag of the last tap, samples.
    #[must_use]
    pub fn last_lag(&self) -> isize {
        self.first_lag + self.taps.len() as isize - 1
    }

    /// Adds `gain·y` to `out`, where `input[i + lag − origin]` is the signal at lag `lag` of output `i`.
    ///
    /// `origin` is the lag of `input[0]` as seen from `out[0]`; `input` has to reach from the first to the last lag.
    pub fn add_to(&self, input: &[f64], origin: isize, gain: f64, out: &mut [f64]) {
        let start = (self.first_lag - origin).max(0) as usize;
        let tap = |(offset, tap): (usize, &f64)| Tap { input: 0, offset, weight: gain * tap };
        let taps: Vec<Tap> = (start..).zip(&self.taps).map(tap).collect();
        add_taps(&taps, &[input], out);
    }

    /// Adds `y` at every so many samples to `out`: as [`Self::add_to`], where `phases[p][i]` is the signal at index `i · phases.len() + p` of its `input`, and
    /// output `i` belongs to index `i · phases.len()`.
    pub(super) fn add_thinned_to(&self, phases: &[&[f64]], origin: isize, out: &mut [f64]) {
        let start = (self.first_lag - origin).max(0) as usize;
        let tap = |(index, tap): (usize, &f64)| Tap { input: index % phases.len(), offset: index / phases.len(), weight: *tap };
        let taps: Vec<Tap> = (start..).zip(&self.taps).map(tap).collect();
        add_taps(&taps, phases, out);
    }

    /// Lags and sizes of the second differences `h(l−1) − 2h(l) + h(l+1)`, where there are any: at the corners of a response that is linear in between.
    pub(super) fn corners(&self) -> Vec<(isize, f64)> {
        let tap = |i: isize| usize::try_from(i).ok().and_then(|i| self.taps.get(i)).copied().unwrap_or(0.0);
        let largest = self.taps.iter().fold(0.0_f64, |most, tap| most.max(tap.abs()));
        (-1..=self.taps.len() as isize)
            .map(|i| (self.first_lag + i, tap(i - 1) - 2.0 * tap(i) + tap(i + 1)))
            .filter(|(_, bend)| bend.abs() > ROUNDING * largest)
            .collect()
    }
}

/// Responses whose weighted sum is the fitted response.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LagBasis {
    filters: Vec<Fir>,
}

impl LagBasis {
    /// A basis of the given responses.
    #[must_use]
    pub fn new(filters: Vec<Fir>) -> Self {
        Self { filters }
    }

    /// The present sample only.
    #[must_use]
    pub fn now() -> Self {
        Self::dense(0, 0)
    }

    /// Every lag from `first` to `last`, each on its own.
    #[must_use]
    pub fn dense(first: isize, last: isize) -> Self {
        Self::new((first..=last).map(Fir::shift).collect())
    }

    /// Sums over the present and the last `m` samples, averaged over the `m` of each group, then
    /// each of the `future` samples ahead on its own. Groups are not empty.
    ///
    /// On velocity increments the sums are `v(k) − v(k − m − 1)`. Groups of one `m` leave the
    /// response free at every lag; within a longer group it is linear.
    #[must_use]
    pub fn sums(groups: &[Range<usize>], future: usize) -> Self {
        let share = |group: &Range<usize>, lag: usize| (group.end - lag.max(group.start)) as f64 / group.len() as f64;
        let back = groups.iter().map(|group| Fir {
            first_lag: 1 - group.end as isize,
            taps: (0..group.end).rev().map(|lag| share(group, lag)).collect(),
        });
        let ahead = (1..=future).map(|m| Fir::shift(m as isize));
        Self::new(back.chain(ahead).collect())
    }

    /// Piecewise-linear hats on `knots` (strictly rising lags): a response that is linear between the knots, zero beyond them.
    #[must_use]
    pub fn hats(knots: &[isize]) -> Self {
        let hat = |i: usize| {
            let peak = knots[i];
            let left = if i == 0 { peak - 1 } else { knots[i - 1] };
            let right = knots.get(i + 1).copied().unwrap_or(peak + 1);
            let taps = (left + 1..right)
                .map(|lag| {
                    if lag <= peak {
                        (lag - left) as f64 / (peak - left) as f64
                    } else {
                        (right - lag) as f64 / (right - peak) as f64
                    }
                })
                .collect();
            Fir { first_lag: left + 1, taps }
        };
        Self::new((0..knots.len()).map(hat).collect())
    }

    /// The responses.
    #[must_use]
    pub fn filters(&self) -> &[Fir] {
        &self.filters
    }

    /// How many responses there are.
    #[must_use]
    pub fn len(&self) -> usize {
        self.filters.len()
    }

    /// Whether there is none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.filters.is_empty()
    }

    /// First and last lag of any response, samples; 0 for an empty basis.
    #[must_use]
    pub fn span(&self) -> (isize, isize) {
        self.filters.iter().fold((0, 0), |(first, last), fir| (first.min(fir.first_lag), last.max(fir.last_lag())))
    }

    /// The weighted sum of the responses, as one response over [`Self::span`].
    #[must_use]
    pub fn combine(&self, weights: &[f64]) -> Fir {
        let (first, last) = self.span();
        let mut taps = vec![0.0; (last - first + 1) as usize];
        for (fir, weight) in self.filters.iter().zip(weights) {
            let start = (fir.first_lag - first) as usize;
            for (sum, tap) in taps[start..].iter_mut().zip(&fir.taps) {
                *sum += weight * tap;
            }
        }
        Fir { first_lag: first, taps }
    }
}

#[cfg(test)]
mod tests {
    use super::super::taps::add_bent;
    use super::*;

    #[test]
    fn hats_sum_to_one_between_their_knots() {
        let basis = LagBasis::hats(&[-9, -4, -2, -1, 0, 2]);
        let sum = basis.combine(&[1.0; 6]);
        assert_eq!((sum.first_lag, sum.last_lag()), (-9, 2));
        for tap in sum.taps {
            assert!((tap - 1.0).abs() < 1e-15);
        }
    }

    #[test]
    fn a_group_of_sums_is_their_mean() {
        let input: Vec<f64> = (0..12).map(|i| (f64::from(i) * 0.7).sin()).collect();
        let through = |groups: &[Range<usize>]| -> Vec<f64> {
            let basis = LagBasis::sums(groups, 0);
            let out = basis.filters().iter().map(|fir| {
                let mut out = [0.0];
                fir.add_to(&input, -11, 1.0, &mut out);
                out[0]
            });
            out.collect()
        };
        let single: Vec<f64> = through(&[0..1, 1..2, 2..3, 3..4, 4..5]);
        assert!((single[2] - input[9..].iter().sum::<f64>()).abs() < 1e-15);
        let grouped = through(&[0..1, 1..2, 2..5]);
        assert_eq!(grouped[..2], single[..2]);
        assert!((grouped[2] - single[2..].iter().sum::<f64>() / 3.0).abs() < 1e-15);
    }

    #[test]
    fn a_linear_response_is_exact_on_hats() {
        let basis = LagBasis::hats(&[-9, -4, 0]);
        let fir = basis.combine(&[18.0, 8.0, 0.0]);
        for (i, tap) in fir.taps.iter().enumerate() {
            let lag = fir.first_lag + i as isize;
            assert!((tap - -2.0 * lag as f64).abs() < 1e-12);
        }
    }

    #[test]
    fn every_output_is_the_plain_sum_to_the_last_bit() {
        let fir = Fir { first_lag: -3, taps: (0..7).map(|i| 1.0 / f64::from(3 + i)).collect() };
        let input: Vec<f64> = (0..160).map(|i| (f64::from(i) * 0.7).sin()).collect();
        for outputs in [0, 1, 31, 64, 153] {
            let mut out = vec![0.1; outputs];
            fir.add_to(&input, -4, 0.3, &mut out);
            for (k, found) in out.into_iter().enumerate() {
                let terms = fir.taps.iter().zip(&input[k + 1..]);
                assert_eq!(found, terms.fold(0.1, |sum, (tap, u)| sum + 0.3 * tap * u));
            }
        }
    }

    #[test]
    fn thinned_outputs_are_those_of_every_sample() {
        let fir = Fir { first_lag: -5, taps: (0..8).map(|i| f64::from(3 + i).recip()).collect() };
        let input: Vec<f64> = (0..100).map(|i| (f64::from(i) * 0.7).sin()).collect();
        let mut every = vec![0.0; 90];
        fir.add_to(&input, -6, 1.0, &mut every);
        for stride in [1, 2, 3, 7] {
            let phases: Vec<Vec<f64>> =
                (0..stride).map(|phase| input.iter().skip(phase).step_by(stride).copied().collect()).collect();
            let mut thinned = vec![0.0; 90 / stride];
            fir.add_thinned_to(&phases.iter().map(Vec::as_slice).collect::<Vec<_>>(), -6, &mut thinned);
            for (found, expected) in thinned.iter().zip(every.iter().step_by(stride)) {
                assert!((found - expected).abs() < 1e-14);
            }
        }
    }

    #[test]
    fn negative_lags_look_back() {
        let input = [1.0, 2.0, 4.0, 8.0, 16.0];
        let mut out = [0.0; 3];
        Fir::shift(-2).add_to(&input, -2, 1.0, &mut out);
        assert_eq!(out, [1.0, 2.0, 4.0]);
        Fir::shift(0).add_to(&input, -2, 0.5, &mut out);
        assert_eq!(out, [3.0, 6.0, 12.0]);
    }

    #[test]
    fn a_response_between_corners_is_its_bends_summed_twice() {
        let knots = [-40, -12, -9, -4, -1, 0, 3];
        let response = LagBasis::hats(&knots).combine(&[0.3, -1.0, 0.2, 2.0, 0.0, 1.0, -0.4]);
        let corners = response.corners();
        assert!(corners.len() <= knots.len() + 2, "{corners:?}");
        let input: Vec<f64> = (0..1000).map(|i| (f64::from(i) * 0.05).sin().clamp(-0.7, 0.9)).collect();
        let outputs = input.len() - 43;
        let mut plain = vec![1.0; outputs];
        response.add_to(&input, -40, 1.0, &mut plain);
        // Output k lies at input k + 40.
        let taps: Vec<Tap> =
            corners.iter().map(|(lag, weight)| Tap { input: 0, offset: (41 + lag) as usize, weight: *weight }).collect();
        let mut bends = vec![0.0; outputs - 2];
        add_taps(&taps, &[&input], &mut bends);
        let mut bent = vec![1.0; outputs];
        add_bent([plain[0] - 1.0, plain[1] - 1.0], &bends, &mut bent);
        for (plain, bent) in plain.iter().zip(&bent) {
            // The rounding of the second differences grows with the square of the distance.
            assert!((plain - bent).abs() < 1e-10, "{plain} {bent}");
        }
    }
}
