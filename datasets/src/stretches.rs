//! Stretches of long logs that show what the whole shows.

use std::ops::Range;

use crate::{DatasetError, Log, Recording};

/// Length of a stretch, s: many times the memory of an axis, so that little of it is lost at its start.
const STRETCH_S: f64 = 10.0;
/// Classes of position within the range of an axis, of its speed below the largest (each half of the one above), and of its acceleration.
const PLACES: usize = 16;
const HALVINGS: usize = 8;
/// Classes of one axis: position, speed in either direction, acceleration in either direction.
const CLASSES: usize = PLACES + 4 * HALVINGS;

/// Motion before a stretch, s: the memory of an axis and more.
const LEAD_S: f64 = 2.0;

/// A stretch of a long log.
#[derive(Debug, Clone, PartialEq)]
pub struct Stretch {
    /// The stretch, behind up to two seconds of what came before it.
    pub log: Log,
    /// Its own rows.
    pub rows: Range<usize>,
}

/// Extremes of an axis: lowest and highest position, speed, acceleration.
const EXTREMES: usize = 4;

/// Share of the range, the largest speed or the largest acceleration of an axis within which a piece shows that extreme.
const NEAR: f64 = 0.02;

/// A piece of a log with what it shows.
struct Piece {
    recording: usize,
    rows: Range<usize>,
    /// Seconds of every class of every axis.
    shown_s: Vec<f64>,
    /// Whether it shows each of the extremes of every axis.
    reaches: Vec<bool>,
}

/// Stretches of `recordings` of together at most about `most` samples, in their order; those beside each other are one. `None` where the
/// recordings hold no more than that. A file is read once to choose, and its chosen stretches once more.
///
/// Chosen one by one, each time the stretch that adds most to the sum of ln(1 + seconds) over classes of position, speed and
/// acceleration of every axis, so that rare motion comes before more of the same. Before them come stretches that show both ends of the
/// travel, the largest speed and the largest acceleration of every axis, as far as half of the samples hold them: where a model has seen less than
/// the log shows, corrections fade.
///
/// # Errors
/// When a file cannot be read.
pub fn stretches(recordings: &[Recording], most: usize) -> Result<Option<Vec<Stretch>>, DatasetError> {
    if recordings.iter().map(Recording::len).sum::<usize>() <= most {
        return Ok(None);
    }
    let runs = chosen(cut(recordings)?, most);
    let mut out = Vec::new();
    for (index, from) in recordings.iter().enumerate() {
        let rows = runs.iter().filter(|(recording, _)| *recording == index).map(|(_, rows)| rows.clone());
        let lead = (LEAD_S / from.period_s()).ceil() as usize;
        from.read(rows, lead, |mut log, rows| {
            log.name = format!("{} from {:.0} s", log.name, log.start_s + rows.start as f64 * log.period_s());
            out.push(Stretch { log, rows });
            Ok(())
        })?;
    }
    Ok(Some(out))
}

/// The rows that are taken of every recording, in order.
fn chosen(pieces: Vec<Piece>, most: usize) -> Vec<(usize, Range<usize>)> {
    let mut left = pieces;
    let classes = left.first().map_or(0, |stretch| stretch.shown_s.len());
    let (mut shown_s, mut samples) = (vec![0.0; classes], 0);
    let mut chosen: Vec<Piece> = Vec::new();
    let mut extremes = 0..left.first().map_or(0, |stretch| stretch.reaches.len());
    let mut unseen = move |chosen: &[Piece]| extremes.find(|extreme| !chosen.iter().any(|piece| piece.reaches[*extreme]));
    loop {
        let extreme = if 2 * samples < most { unseen(&chosen) } else { None };
        let best = best_of(&left, &shown_s, |piece| extreme.is_none_or(|extreme| piece.reaches[extreme]));
        let best = match best {
            Some(best) if samples + left[best].rows.len() <= most || chosen.is_empty() => best,
            _ if extreme.is_some() => continue,
            _ => break,
        };
        let stretch = left.swap_remove(best);
        samples += stretch.rows.len();
        shown_s.iter_mut().zip(&stretch.shown_s).for_each(|(sum, own)| *sum += own);
        chosen.push(stretch);
    }
    chosen.sort_by_key(|stretch| (stretch.recording, stretch.rows.start));
    let mut runs: Vec<(usize, Range<usize>)> = Vec::new();
    for stretch in chosen {
        match runs.last_mut() {
            Some((recording, rows)) if *recording == stretch.recording && rows.end == stretch.rows.start => {
                rows.end = stretch.rows.end;
            }
            _ => runs.push((stretch.recording, stretch.rows)),
        }
    }
    runs
}

/// The piece among those that `fit` that adds most; the first of equal ones in the logs.
fn best_of(left: &[Piece], shown_s: &[f64], fit: impl Fn(&Piece) -> bool) -> Option<usize> {
    let gain = |piece: &Piece| -> f64 {
        let each = piece.shown_s.iter().zip(shown_s).filter(|(own, _)| **own > 0.0);
        each.map(|(own, sum)| ((1.0 + sum + own) / (1.0 + sum)).ln()).sum::<f64>() / piece.rows.len() as f64
    };
    let order = |piece: &Piece| (piece.recording, piece.rows.start);
    let gains: Vec<f64> = left.iter().map(gain).collect();
    let fitting = (0..left.len()).filter(|index| fit(&left[*index]));
    fitting.max_by(|a, b| gains[*a].total_cmp(&gains[*b]).then(order(&left[*b]).cmp(&order(&left[*a]))))
}

/// All pieces of the recordings.
fn cut(recordings: &[Recording]) -> Result<Vec<Piece>, DatasetError> {
    let axes = recordings.first().map_or(0, |recording| recording.axes().len());
    let scales: Vec<Scale> = (0..axes).map(|axis| Scale::of(recordings, axis)).collect();
    let mut out = Vec::new();
    for (recording, whole) in recordings.iter().enumerate() {
        let length = ((STRETCH_S / whole.period_s()).round() as usize).max(1);
        let rows = |from: usize| from..(from + length).min(whole.len());
        let mut from = 0;
        whole.read((0..whole.len()).step_by(length).map(rows), 0, |log, own| {
            let mut shown_s = vec![0.0; axes * CLASSES];
            let columns = log.reference.columns().iter().zip(shown_s.chunks_mut(CLASSES));
            let mut reaches = Vec::with_capacity(axes * EXTREMES);
            for (scale, (column, shown_s)) in scales.iter().zip(columns) {
                scale.note(column, log.period_s(), shown_s);
                reaches.extend(scale.reached(column, log.period_s()));
            }
            out.push(Piece { recording, rows: from..from + own.len(), shown_s, reaches });
            from += own.len();
            Ok(())
        })?;
    }
    Ok(out)
}

/// Range of an axis over all recordings.
struct Scale {
    low: f64,
    span: f64,
    speed: f64,
    acceleration: f64,
}

impl Scale {
    fn of(recordings: &[Recording], axis: usize) -> Self {
        let mut scale = Self { low: f64::INFINITY, span: 0.0, speed: 0.0, acceleration: 0.0 };
        let mut high = f64::NEG_INFINITY;
        for recording in recordings {
            let Some(extent) = recording.extents().get(axis).copied() else { continue };
            let period_s = recording.period_s();
            (scale.low, high) = (scale.low.min(extent.low), high.max(extent.high));
            scale.speed = scale.speed.max(extent.two_steps / (2.0 * period_s));
            scale.acceleration = scale.acceleration.max(extent.bend / (period_s * period_s));
        }
        scale.span = (high - scale.low).max(0.0);
        scale
    }

    /// Whether `column` shows each of the extremes.
    fn reached(&self, column: &[f64], period_s: f64) -> [bool; EXTREMES] {
        let (mut low, mut high, mut speed, mut acceleration) = (f64::INFINITY, f64::NEG_INFINITY, 0.0_f64, 0.0_f64);
        for at in column {
            (low, high) = (low.min(*at), high.max(*at));
        }
        for three in column.windows(3) {
            let (v, a) = rates(three, period_s);
            (speed, acceleration) = (speed.max(v.abs()), acceleration.max(a.abs()));
        }
        let near = NEAR * self.span;
        [
            low <= self.low + near,
            high >= self.low + self.span - near,
            speed >= (1.0 - NEAR) * self.speed,
            acceleration >= (1.0 - NEAR) * self.acceleration,
        ]
    }

    /// Adds the seconds of every class.
    fn note(&self, column: &[f64], period_s: f64, shown_s: &mut [f64]) {
        let halving = |value: f64, largest: f64| {
            let share = value.abs() / largest;
            let half = if share > 0.0 { -share.log2() } else { f64::INFINITY };
            (half < HALVINGS as f64).then_some(half.max(0.0) as usize + if value < 0.0 { HALVINGS } else { 0 })
        };
        for three in column.windows(3) {
            let (speed, acceleration) = rates(three, period_s);
            if self.span > 0.0 {
                let place = ((three[1] - self.low) / self.span * PLACES as f64) as usize;
                shown_s[place.min(PLACES - 1)] += period_s;
            }
            for (first, class) in
                [(PLACES, halving(speed, self.speed)), (PLACES + 2 * HALVINGS, halving(acceleration, self.acceleration))]
            {
                if let Some(class) = class {
                    shown_s[first + class] += period_s;
                }
            }
        }
    }
}

/// Speed and acceleration at the middle of three samples.
fn rates(three: &[f64], period_s: f64) -> (f64, f64) {
    ((three[2] - three[0]) / (2.0 * period_s), (three[2] - 2.0 * three[1] + three[0]) / (period_s * period_s))
}

#[cfg(test)]
mod tests {
    use motion::{Axis, Trajectory};

    use super::*;

    /// Hundred seconds of a slow sine of 10 mm, in which the axis is once, for three seconds, at 40 mm.
    fn log() -> Log {
        let column: Vec<f64> = (0..10_000)
            .map(|k| {
                let t = 0.01 * f64::from(k);
                let bump =
                    if (63.0..66.0).contains(&t) { 15.0 * (1.0 - ((t - 63.0) * std::f64::consts::TAU / 3.0).cos()) } else { 0.0 };
                10.0 * (0.7 * t).sin() + bump
            })
            .collect();
        let trajectory = || Trajectory::new(0.01, vec![Axis::named("x")], vec![column.clone()]).unwrap();
        Log::new("run", trajectory(), trajectory()).unwrap()
    }

    /// The only fast motion lasts for a tenth of a second; other stretches show more classes.
    #[test]
    fn the_fastest_motion_is_among_the_stretches() {
        let column: Vec<f64> = (0..10_000)
            .map(|k| {
                let t = 0.01 * f64::from(k);
                let slow = (1.0 + t / 20.0) * (0.7 * t).sin() + 0.3 * (5.0 * t).sin();
                slow + if t < 3.0 { 0.0 } else { 20.0 * (t - 3.0).min(0.1) }
            })
            .collect();
        let trajectory = || Trajectory::new(0.01, vec![Axis::named("x")], vec![column.clone()]).unwrap();
        let log = Log::new("run", trajectory(), trajectory()).unwrap();
        let chosen = stretches(&[Recording::from(log)], 6000).unwrap().unwrap();
        assert!(chosen.iter().map(|stretch| stretch.rows.len()).sum::<usize>() <= 6000);
        let fast = |stretch: &Stretch| {
            stretch.log.reference.columns()[0][stretch.rows.clone()].windows(2).any(|two| two[1] - two[0] > 0.15)
        };
        assert!(chosen.iter().any(fast));
    }

    #[test]
    fn rare_motion_is_among_the_stretches() {
        let log = log();
        let recordings = [Recording::from(log.clone())];
        assert_eq!(stretches(&recordings, 10_000).unwrap(), None);
        let chosen = stretches(&recordings, 3000).unwrap().unwrap();
        assert!(chosen.iter().map(|stretch| stretch.rows.len()).sum::<usize>() <= 3000);
        let column = |stretch: &Stretch| stretch.log.reference.columns()[0].clone();
        assert!(chosen.iter().any(|stretch| column(stretch)[stretch.rows.clone()].iter().any(|at| *at > 25.0)));
        // Stretches are rows of the log behind what came before them, named by their time.
        for stretch in &chosen {
            let from = (stretch.log.start_s / 0.01).round() as usize;
            assert_eq!(column(stretch), log.reference.columns()[0][from..from + stretch.log.len()]);
            assert_eq!(stretch.rows, 200.min(from + stretch.rows.start)..stretch.log.len());
            assert!(stretch.log.name.starts_with("run from "));
        }
        assert_eq!(stretches(&recordings, 3000).unwrap().unwrap(), chosen);
    }
}
