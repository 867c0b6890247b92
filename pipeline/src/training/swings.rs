//! How fast a command changes its acceleration, from its positions alone.

use motion::PlanSettings;

/// Half-widths of the differences from which a jerk is taken, s. Short ones show it whole, long ones in spite of rounded positions.
const SPANS_S: [f64; 6] = [0.01, 0.014, 0.02, 0.028, 0.04, 0.056];
/// Share of the samples up to whose jerk the command counts.
const MOST_SAMPLES: f64 = 0.999;
/// A difference has to be so many times what rounding may make of it.
const ABOVE_ROUNDING: f64 = 4.0;
/// Share of the jerk from which on an acceleration counts as changing.
const LEAST_SHARE: f64 = 1e-2;
/// Ratio of a jerk to what the share [`MOST_SAMPLES`] of the samples stays below, from which on it is a jump.
const JUMP: f64 = 10.0;
/// Swings are as large as the largest from this share on, and the sharpest after this share of them. Chosen on the excitation logs of `random:462` to `465`, whose windows
/// of 31.5, 204.4, 27.5 and 37.8 ms are found as 36 to 39, 163 to 206, 30 to 32 and 38 to 40 ms.
const LARGE_SWING: f64 = 0.5;
const SHARP_SWINGS: f64 = 0.1;
/// Number of swings that are kept.
const MOST_SWINGS: usize = 512;
/// Shortest and longest window that the planner gets, s.
const WINDOWS_S: [f64; 2] = [1e-3, 1.0];

/// A change of an axis's acceleration in one direction: from one limit to the other where it brakes and starts the other way.
#[derive(Debug, Clone, Copy)]
struct Swing {
    /// By how much the acceleration changes, mm/s² or rad/s².
    change: f64,
    /// Largest jerk in it, mm/s³ or rad/s³, from differences over `span_s`.
    jerk: f64,
    span_s: f64,
}

impl Swing {
    /// Swings of a command; none where its positions are too coarse to show a jerk.
    fn all(command: &[f64], period_s: f64) -> Vec<Self> {
        let third =
            |k: usize, span: usize| (command[k] - command[k - 3 * span]) - 3.0 * (command[k - span] - command[k - 2 * span]);
        let most = |span: usize| {
            motion::quantile(&mut (3 * span..command.len()).map(|k| third(k, span).abs()).collect::<Vec<_>>(), MOST_SAMPLES)
        };
        let spans = SPANS_S.into_iter().map(|span_s| (span_s / period_s).round().max(1.0) as usize).filter(|span| *span > 1);
        let shown = |rounding: f64| {
            spans.filter_map(|span| Some((span, most(span)?))).find(|(_, most)| *most > ABOVE_ROUNDING * rounding)
        };
        let Some((rounding, (span, most))) = most(1).and_then(|rounding| Some((rounding, shown(rounding)?))) else {
            return Vec::new();
        };
        let (span_s, least) = (span as f64 * period_s, rounding.max(LEAST_SHARE * most));
        let jerks: Vec<f64> = (3 * span..command.len()).map(|k| third(k, span)).collect();
        let runs = jerks.chunk_by(|one, other| one.signum() == other.signum() && one.abs().min(other.abs()) > least);
        let swing = |run: &[f64]| {
            // The differences overlap: every span-th of them makes up the change.
            let change = run.iter().sum::<f64>().abs() / span as f64;
            let jerk = run.iter().map(|jerk| jerk.abs()).fold(0.0, f64::max);
            Self { change: change / (span_s * span_s), jerk: jerk / span_s.powi(3), span_s }
        };
        // A jump of a single position is no swing.
        runs.map(swing).filter(|swing| swing.jerk > 0.0 && swing.jerk * span_s.powi(3) <= JUMP * most).collect()
    }

    /// Windows of the planner, s, whose command would show the same swing: first that of its jerk limit, and the usual second one, which is shorter where
    /// the command is sharper than it allows.
    fn windows_s(self) -> [f64; 2] {
        let shown = |[first, second]: [f64; 2]| self.change * centre([first, second, self.span_s, self.span_s, self.span_s]);
        let usual = PlanSettings::default().smoothing_s;
        let [shortest, longest] = WINDOWS_S;
        let solved = |windows: &dyn Fn(f64) -> [f64; 2], longest: f64| {
            let (mut low, mut high) = (shortest, longest);
            for _ in 0..40 {
                let middle = 0.5 * (low + high);
                if shown(windows(middle)) > self.jerk { low = middle } else { high = middle }
            }
            windows(high)
        };
        if shown([shortest, usual]) > self.jerk {
            solved(&|first| [first, usual], longest)
        } else {
            solved(&|second| [shortest, second], usual)
        }
    }
}

/// Largest value of averages of these widths, s, one after the other, of an impulse of area 1, 1/s.
fn centre<const N: usize>(widths_s: [f64; N]) -> f64 {
    let order = N as i32 - 1;
    let of_signs = |signs: usize| {
        let minus = |index: usize| signs >> index & 1 == 1;
        let at: f64 = (0..N).map(|index| if minus(index) { -0.5 * widths_s[index] } else { 0.5 * widths_s[index] }).sum();
        let sign = if signs.count_ones() % 2 == 1 { -1.0 } else { 1.0 };
        sign * at.max(0.0).powi(order)
    };
    let factorial: f64 = (1..N).map(|k| k as f64).product();
    (0..1 << N).map(of_signs).sum::<f64>() / (factorial * widths_s.iter().product::<f64>())
}

/// The largest swings of an axis; none where positions are too coarse to show one.
#[derive(Debug, Default)]
pub(super) struct Swings(Vec<Swing>);

impl Swings {
    /// Time before a piece of a command that its swings need, s.
    pub const BEFORE_S: f64 = 3.0 * SPANS_S[SPANS_S.len() - 1];

    /// Adds those of a command.
    pub fn add(&mut self, command: &[f64], period_s: f64) {
        self.0.extend(Swing::all(command, period_s));
        self.0.sort_by(|one, other| other.change.total_cmp(&one.change));
        self.0.truncate(MOST_SWINGS);
    }

    /// The planner's windows, s: those of the sharpest of the large swings, since a path may change its acceleration slower than the control does.
    pub fn windows_s(&self) -> Option<[f64; 2]> {
        let largest = self.0.first()?;
        let large = self.0.iter().take_while(|swing| swing.change > LARGE_SWING * largest.change);
        let mut windows: Vec<[f64; 2]> = large.map(|swing| swing.windows_s()).collect();
        windows.sort_by(|one, other| one[0].total_cmp(&other[0]).then(one[1].total_cmp(&other[1])));
        let sharp = (SHARP_SWINGS * windows.len() as f64) as usize;
        windows.get(sharp).copied()
    }
}

#[cfg(test)]
mod tests {
    use super::{Swing, Swings, centre};

    /// A move of 100 mm/s² whose acceleration rises and falls at `jerk`, positions rounded to `digit_mm`.
    fn command(jerk: f64, digit_mm: f64) -> Vec<f64> {
        let (period_s, rise_s) = (1e-3, 100.0 / jerk);
        let acceleration = |t: f64| -> f64 {
            let at = t % (4.0 * rise_s + 0.8);
            let bump = |at: f64| (at / rise_s).min((2.0 * rise_s + 0.4 - at) / rise_s).clamp(0.0, 1.0);
            100.0 * (bump(at) - bump(at - 2.0 * rise_s - 0.4))
        };
        let (mut speed, mut position) = (0.0, 0.0);
        let step = |k: u32| {
            speed += acceleration(f64::from(k) * period_s) * period_s;
            position += speed * period_s;
            (position / digit_mm).round() * digit_mm
        };
        (0..200_000).map(step).collect()
    }

    fn windows(command: &[f64]) -> [f64; 2] {
        let mut swings = Swings::default();
        swings.add(command, 1e-3);
        swings.windows_s().unwrap()
    }

    #[test]
    fn the_rise_of_the_acceleration_is_seen_through_rounded_positions() {
        for (jerk, digit_mm) in [(800.0, 1e-7), (800.0, 1e-4), (3000.0, 1e-3), (6000.0, 1e-6)] {
            let mut command = command(jerk, digit_mm);
            let [found, _] = windows(&command);
            assert!((0.6..1.4).contains(&(found * jerk / 200.0)), "{jerk} {digit_mm}: {found}");
            // One jump of a millimetre does not count.
            command[10_000..].iter_mut().for_each(|at| *at += 1.0);
            let [with_jump, _] = windows(&command);
            assert!((with_jump / found - 1.0).abs() < 0.2, "{jerk} {digit_mm}: {with_jump}");
        }
        assert!(Swing::all(&[0.0; 1000], 1e-3).is_empty() && Swing::all(&[0.0; 2], 1e-3).is_empty());
    }

    #[test]
    fn averages_of_an_impulse_have_the_largest_value_of_their_convolution() {
        assert!((centre([0.02, 0.05]) - 1.0 / 0.05).abs() < 1e-9);
        assert!((centre([0.02, 0.02, 0.02]) - 0.75 / 0.02).abs() < 1e-9);
        // The narrower ones do not lower the top of the widest where they fit into it.
        assert!((centre([0.1, 0.02, 0.01, 0.01, 0.01]) - 10.0).abs() < 1e-6);
    }

    /// The windows found from a step of the acceleration that these two averages have made smooth.
    fn found(windows_s: [f64; 2]) -> [f64; 2] {
        let period_s = 1e-3;
        let [first, second] = windows_s.map(|window_s| (window_s / period_s) as usize);
        let mut values: Vec<f64> = (0..40_000).map(|k| if k / 400 % 2 == 0 { 100.0 } else { -100.0 }).collect();
        for window in [first, second] {
            values = values.windows(window).map(|of| of.iter().sum::<f64>() / window as f64).collect();
        }
        for _ in 0..2 {
            let mut sum = 0.0;
            values.iter_mut().for_each(|value| {
                sum += *value * period_s;
                *value = sum;
            });
        }
        windows(&values)
    }

    #[test]
    fn windows_of_the_planner_are_those_whose_command_shows_the_jerk() {
        for first in [0.005, 0.02, 0.05, 0.2] {
            let [rise_s, smoothing_s] = found([first, 0.02]);
            assert!((rise_s / first - 1.0).abs() < 0.2 && smoothing_s == 0.02, "{first} {rise_s} {smoothing_s}");
        }
        // Sharper than the usual second average.
        let [rise_s, smoothing_s] = found([0.001, 0.008]);
        assert!(rise_s < 0.002 && (0.004..0.012).contains(&smoothing_s), "{rise_s} {smoothing_s}");
    }
}
