//! Which change is an alarm: limits from healthy days, so that false alarms come at a stated rate.

use serde::Serialize;

use crate::estimate::{Quantity, Reading};

/// Days of a month, for the rate of false alarms.
const DAYS: f64 = 30.0;
/// Weight of what is known beforehand about the spread from day to day, in days.
const PRIOR_DAYS: f64 = 6.0;

/// Spread from day to day that is expected of a quantity before a healthy day is seen: the median of the spreads on simulated machines with
/// seeds from 5000 on and a minute of log a day (fit and friction); behind reversals what keeps their healthy days without an alarm; backlash and
/// lag: a tenth of a micrometre, and what makes half a micrometre at 100 mm/s.
fn usual_spread(quantity: Quantity) -> f64 {
    match quantity {
        Quantity::Fit => 0.05,
        Quantity::Reversals => 0.12,
        Quantity::Friction => 0.012,
        Quantity::Backlash => 0.1,
        Quantity::Lag => 5.0,
    }
}

/// How many false alarms are accepted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// Expected number of false alarms of a machine in 30 days.
    pub false_alarms_per_month: f64,
}

/// The change of a quantity against healthy days.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Change {
    /// The change, in the unit of the quantity.
    pub change: f64,
    /// The change from which on it is an alarm, in the same unit.
    pub limit: f64,
}

impl Change {
    /// Whether it is an alarm.
    #[must_use]
    pub fn is_alarm(&self) -> bool {
        self.change.abs() > self.limit
    }

    /// The change over its limit: 1 and more is an alarm.
    #[must_use]
    pub fn score(&self) -> f64 {
        self.change.abs() / self.limit
    }
}

impl Limits {
    /// The change of `today` against `healthy` days, of a machine of which `tests` quantities are watched a day.
    ///
    /// Student's t of a further day: the variance from day to day is that of the healthy days and the usual one, weighted by their degrees of
    /// freedom (Smyth 2004, moderated t). A day that shows the quantity less clearly than the healthy ones has a wider limit. Without a healthy day
    /// the change is against the training.
    #[must_use]
    pub fn change(&self, quantity: Quantity, healthy: &[Reading], today: &Reading, tests: usize) -> Change {
        let days = healthy.len() as f64;
        let mean = healthy.iter().map(|reading| reading.value).sum::<f64>() / days.max(1.0);
        let squares: f64 = healthy.iter().map(|reading| (reading.value - mean).powi(2)).sum();
        let freedom = PRIOR_DAYS + (days - 1.0).max(0.0);
        let spread = ((PRIOR_DAYS * usual_spread(quantity).powi(2) + squares) / freedom).sqrt();
        let usual = healthy.iter().map(|reading| reading.deviation).sum::<f64>() / days.max(1.0);
        let less_clear = if usual > 0.0 { (today.deviation / usual).max(1.0) } else { 1.0 };
        let probability = self.false_alarms_per_month / (DAYS * tests.max(1) as f64);
        let width = limit(probability, freedom) * (1.0 + 1.0 / days.max(1.0)).sqrt();
        Change { change: today.value - mean, limit: width * spread * less_clear }
    }
}

/// The value that Student's t with `freedom` degrees exceeds in size with this probability (both sides together), to 1e-6.
#[must_use]
pub fn limit(probability: f64, freedom: f64) -> f64 {
    let wanted = probability.clamp(1e-12, 1.0);
    let (mut low, mut high) = (0.0, 1.0);
    while beyond(high, freedom) > wanted {
        high *= 2.0;
    }
    while high - low > 1e-6 * high.max(1.0) {
        let middle = 0.5 * (low + high);
        if beyond(middle, freedom) > wanted { low = middle } else { high = middle }
    }
    high
}

/// Intervals of Simpson's rule.
const INTERVALS: usize = 400;

/// Probability that Student's t exceeds `t` in size. With `t = √ν tan θ` the density is a power of the cosine: its integrals over both parts of
/// `0…π/2` give the probability without its constant.
fn beyond(t: f64, freedom: f64) -> f64 {
    let at = (t / freedom.sqrt()).atan();
    let density = |angle: f64| angle.cos().max(0.0).powf(freedom - 1.0);
    let integral = |from: f64, to: f64| {
        let step = (to - from) / INTERVALS as f64;
        let weight = |k: usize| {
            if k == 0 || k == INTERVALS {
                1.0
            } else if k % 2 == 1 {
                4.0
            } else {
                2.0
            }
        };
        (0..=INTERVALS).map(|k| weight(k) * density(from + step * k as f64)).sum::<f64>() * step / 3.0
    };
    let outside = integral(at, std::f64::consts::FRAC_PI_2);
    outside / (integral(0.0, at) + outside)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_are_those_of_the_tables_of_students_t() {
        // Two-sided, from printed tables.
        for (probability, freedom, wanted) in
            [(0.05, 5.0, 2.5706), (0.01, 10.0, 3.1693), (0.001, 12.0, 4.3178), (0.05, 30.0, 2.0423)]
        {
            let found = limit(probability, freedom);
            assert!((found - wanted).abs() < 1e-3, "{probability} {freedom}: {found}");
        }
    }

    #[test]
    fn a_day_beyond_the_spread_of_healthy_days_is_an_alarm_and_a_blurred_one_less_so() {
        let reading = |value: f64, deviation: f64| Reading { value, deviation };
        let healthy: Vec<Reading> = [0.01, -0.01, 0.02, 0.0, -0.02, 0.0, 0.01].map(|value| reading(value, 0.005)).to_vec();
        let limits = Limits { false_alarms_per_month: 0.3 };
        let change = |today: Reading| limits.change(Quantity::Friction, &healthy, &today, 12);
        assert!(change(reading(0.2, 0.005)).is_alarm() && change(reading(-0.2, 0.005)).is_alarm());
        assert!(!change(reading(0.03, 0.005)).is_alarm() && !change(reading(0.2, 0.05)).is_alarm());
        let rare = Limits { false_alarms_per_month: 0.003 }.change(Quantity::Friction, &healthy, &reading(0.2, 0.005), 12);
        assert!(rare.limit > change(reading(0.2, 0.005)).limit);
        assert!(limits.change(Quantity::Friction, &[], &reading(0.5, 0.01), 12).is_alarm());
    }
}
