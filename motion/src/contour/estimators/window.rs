//! Search window on the path, which follows the lag of the machine.

use crate::contour::spline::{PathPoint, Pieces, first_where};
use crate::{MotionError, Vec3};

/// Gain of the moving average of the lead over the time match, per foot point.
const LEAD_SHARE: f64 = 1.0 / 16.0;
/// Expected indices closer than this, samples, are searched once.
const SAME_INDEX: f64 = 0.5;
/// Largest backward step of a foot point, as a fraction of the distance to the expected one. Below
/// 1: otherwise it could run backwards without end on the first leg of a hairpin while the sample
/// moves away on the second.
const BACK_SHARE: f64 = 0.5;

/// Samples over which a path stands, or creeps towards a stop, that moves by no more than noise a sample.
const STANDS_SAMPLES: f64 = 4.0;

/// Largest half-width that can be set, samples.
const MAX_SAMPLES: usize = 1_000_000;

/// Search range around the expected foot point.
///
/// Paper C's adaptive window, `n = |P_d P_a| / |P_a P_{a−1}|` samples on either side, excludes the
/// other branch of a hairpin. Around the time-matched sample it must be as wide as the tracking
/// error. This window lies around the *expected* foot point (the last one advanced by the elapsed
/// time) and around the point with the usual lag, so it is only as wide as the contour error. Only
/// the first sample is searched around its time match. Foot points move forward except for noise.
/// If a foot point was lost, its distance and with it the window grow until the path is found
/// again.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Window {
    /// Half-width along `to` in multiples of the noise and of the distance between the sample and
    /// the expected foot point.
    pub margin: f64,
    /// Smallest half-width in samples of `to`.
    pub min_samples: usize,
    /// Largest half-width in samples of `to`, and the largest lag or lead that is tracked.
    pub max_samples: usize,
    /// Amplitude of noise along the path, mm.
    pub noise_mm: f64,
}

impl Default for Window {
    fn default() -> Self {
        Self { margin: 3.0, min_samples: 1, max_samples: 256, noise_mm: 0.002 }
    }
}

impl Window {
    pub(in crate::contour) fn check(&self) -> Result<(), MotionError> {
        for (name, value) in [("the window's margin", self.margin), ("the window's noise, mm,", self.noise_mm)] {
            if !(value.is_finite() && value >= 0.0) {
                return Err(MotionError::BadSetting { name, value, remedy: "it must be finite and not negative" });
            }
        }
        if self.max_samples < self.min_samples.max(1) || self.max_samples > MAX_SAMPLES {
            return Err(MotionError::BadSetting {
                name: "the window's largest half-width, samples,",
                value: self.max_samples as f64,
                remedy: "it must be at least 1, at least the smallest, and at most a million",
            });
        }
        Ok(())
    }

    /// Samples on either side of a time match that the search can reach: the expected foot point
    /// may be one window away, and the search extends one window further.
    pub(in crate::contour) fn span(&self) -> usize {
        2 * self.max_samples + 2
    }

    /// Foot point of `p` on `source`, expected at `due`.
    #[inline]
    pub(in crate::contour) fn nearest(&self, source: &impl PathSource, due: &Due, p: &Vec3) -> PathPoint {
        let pieces = source.pieces();
        let mut look = self.around(source, due.moved_on, p);
        if (due.usual - due.moved_on).abs() > SAME_INDEX {
            let other = self.around_too(source, due.usual, p);
            let nearer = if other.squared < look.squared { &other } else { &look };
            look = Look { from: look.from.min(other.from), to: look.to.max(other.to), ..*nearer };
        }
        let (back, _) = source.locate(due.back - self.min_samples as f64);
        if back > look.from && !self.stands(source, due.matched) {
            let slack_mm = self.noise_mm + BACK_SHARE * look.squared.sqrt();
            look.from = walk_back(pieces, back, look.from, pieces.arc(back) - slack_mm);
            look.to = look.to.max(look.from + 1);
            if look.seed.0 < look.from {
                look.seed = (look.from, 0.0);
            }
        }
        let found = pieces.nearest(look.from, look.to, look.seed, p);
        let (piece, t) = source.locate(due.matched);
        // No foot point is farther away than the point at the same time: one that is lies on a branch that the path has left.
        let is_lost = found.distance > self.noise_mm && (pieces.cubic(piece).point(t) - p).norm() < found.distance;
        if is_lost { self.found_again(source, due.matched, p) } else { found }
    }

    /// Whether the path stands or creeps at a time match. A sample may go back on it there, as an axis does that has passed its stop or swings at it.
    fn stands(&self, source: &impl PathSource, matched: f64) -> bool {
        let arc = |index: f64| {
            let (piece, t) = source.locate(index);
            source.pieces().arc_on(piece, t)
        };
        arc(matched) - arc(matched - STANDS_SAMPLES) <= STANDS_SAMPLES * self.noise_mm
    }

    /// Foot point around a time match.
    #[cold]
    fn found_again(&self, source: &impl PathSource, matched: f64, p: &Vec3) -> PathPoint {
        let look = self.around(source, matched, p);
        source.pieces().nearest(look.from, look.to, look.seed, p)
    }

    /// Slow path of [`Self::around`].
    #[cold]
    fn around_too(&self, source: &impl PathSource, index: f64, p: &Vec3) -> Look {
        self.around(source, index, p)
    }

    /// Search ranges around a sample index.
    #[inline(always)]
    fn around(&self, source: &impl PathSource, index: f64, p: &Vec3) -> Look {
        let pieces = source.pieces();
        let seed = source.locate(index);
        let squared = (pieces.cubic(seed.0).point(seed.1) - p).norm_squared();
        let here = pieces.arc_on(seed.0, seed.1);
        let mut from = source.before(index, seed.0, self.min_samples);
        let mut to = source.after(index, seed.0, self.min_samples) + 1;
        let least = (here - pieces.arc(from)).min(pieces.arc(to) - here);
        // `(a + b)² ≤ 2a² + 2b²` decides most cases without a square root.
        if least * least < 2.0 * self.margin * self.margin * (squared + self.noise_mm * self.noise_mm) {
            let reach_mm = self.margin * (self.noise_mm + squared.sqrt());
            from = walk_back(pieces, from, source.before(index, seed.0, self.max_samples), here - reach_mm);
            let limit = source.after(index, seed.0, self.max_samples) + 1;
            to = first_where(to..limit.max(to), |piece| pieces.arc(piece) - here >= reach_mm);
        }
        Look { from, to, seed, squared }
    }
}

/// A range of pieces to search.
#[derive(Debug, Clone, Copy)]
struct Look {
    /// First piece.
    from: usize,
    /// One past the last piece.
    to: usize,
    /// The expected point: piece and parameter.
    seed: (usize, f64),
    /// Squared distance of the sample from the expected point, mm².
    squared: f64,
}

/// Pieces and their timing.
pub(in crate::contour) trait PathSource {
    fn pieces(&self) -> &Pieces;
    /// Piece and parameter at a sample index, clamped to the range.
    fn locate(&self, index: f64) -> (usize, f64);
    /// Piece this many samples before a sample index, which lies on `piece`.
    fn before(&self, index: f64, piece: usize, samples: usize) -> usize;
    /// Piece this many samples after it.
    fn after(&self, index: f64, piece: usize, samples: usize) -> usize;
}

/// One piece per sample.
impl PathSource for Pieces {
    #[inline]
    fn pieces(&self) -> &Pieces {
        self
    }

    #[inline]
    fn locate(&self, index: f64) -> (usize, f64) {
        self.split(index)
    }

    #[inline]
    fn before(&self, _: f64, piece: usize, samples: usize) -> usize {
        piece.saturating_sub(samples).max(self.first())
    }

    #[inline]
    fn after(&self, _: f64, piece: usize, samples: usize) -> usize {
        (piece + samples).min(self.end() - 1)
    }
}

/// Whether the path, noise aside, has not moved between a position and the expected one. Elapsed
/// time is then a better measure of progress than the nearest of the jittering samples at
/// standstill.
#[cold]
fn is_at_standstill(pieces: &Pieces, foot: &PathPoint, expected: f64, noise_mm: f64) -> bool {
    let (piece, t) = pieces.split(expected);
    let there = pieces.cubic(piece).point(t);
    (pieces.cubic(foot.piece).point(foot.t) - there).norm() <= noise_mm
}

/// The last piece from `piece` down to `limit` that starts before `arc_mm`, or `limit`.
fn walk_back(pieces: &Pieces, piece: usize, limit: usize, arc_mm: f64) -> usize {
    piece - first_where(0..piece.saturating_sub(limit), |back| pieces.arc(piece - back) <= arc_mm)
}

/// Expected index of the next foot point, in samples of `to`.
#[derive(Debug, Clone, Copy)]
pub(in crate::contour) struct Due {
    /// The last foot point, advanced by the elapsed time.
    pub moved_on: f64,
    /// The time match, shifted by the usual lead.
    usual: f64,
    /// Lower bound of the search, noise aside: paths go forward.
    back: f64,
    /// The time match.
    matched: f64,
}

/// Tracks the lead of the foot points over the time match.
#[derive(Debug, Clone, Default)]
pub(in crate::contour) struct Follower {
    track: Option<Track>,
}

#[derive(Debug, Clone, Copy)]
struct Track {
    /// Index of the last foot point.
    last: f64,
    /// Distance from the foot point before it, samples.
    step: f64,
    /// Largest index of a foot point so far.
    furthest: f64,
    /// Usual lead over the time match: a moving average.
    lead: f64,
}

impl Follower {
    pub fn reset(&mut self) {
        self.track = None;
    }

    /// Expected index of the foot point of a sample with the time match `matched`, `rate` samples
    /// of `to` after the previous one.
    #[inline]
    pub fn due(&self, window: &Window, matched: f64, rate: f64) -> Due {
        let most = window.max_samples as f64;
        let near = |index: f64| index.clamp(matched - most, matched + most);
        match self.track {
            None => Due { moved_on: matched, usual: matched, back: matched - most, matched },
            Some(track) => {
                let usual = near(matched + track.lead);
                Due {
                    moved_on: near(track.last + track.step.clamp(0.5 * rate, 1.5 * rate)),
                    usual,
                    // A foot point that once jumped ahead, for example to a spike in the log, must
                    // not hold back later ones.
                    back: usual.min(track.furthest),
                    matched,
                }
            }
        }
    }

    /// Records a foot point.
    #[inline]
    pub fn found(&mut self, matched: f64, index: f64) {
        let now = index - matched;
        self.track = Some(match self.track {
            None => Track { last: index, step: 1.0, furthest: index, lead: now },
            Some(track) => Track {
                last: index,
                step: index - track.last,
                furthest: track.furthest.max(index),
                lead: track.lead + LEAD_SHARE * (now - track.lead),
            },
        });
    }

    /// Foot point of `p` on a sampled path whose positions are sample indices.
    #[inline]
    pub fn step(&mut self, pieces: &Pieces, window: &Window, matched: f64, rate: f64, p: &Vec3) -> PathPoint {
        let due = self.due(window, matched, rate);
        let foot = window.nearest(pieces, &due, p);
        let index = foot.position();
        if (index - due.moved_on).abs() > SAME_INDEX && is_at_standstill(pieces, &foot, due.moved_on, window.noise_mm) {
            let on = self.track.map_or(index, |track| track.last + rate);
            self.found(matched, on);
        } else {
            self.found(matched, index);
        }
        foot
    }
}
