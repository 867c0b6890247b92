//! Contour error by axes that lag behind their command by different times.

use motion::{AxisKind, Trajectory, Vec3, lag_s};

/// Share of an error that the mismatch has to account for, at least and at most, to count as its cause. On a curve the lag that the axes have in
/// common adds to it.
const SHARE: [f64; 2] = [0.4, 1.5];

/// The lags of the linear axes of a run, and their speeds.
#[derive(Debug, Clone, PartialEq)]
pub struct LagMismatch {
    axes: Vec<Lagging>,
}

/// An axis that moves.
#[derive(Debug, Clone, PartialEq)]
struct Lagging {
    name: String,
    /// Its coordinate of the tip.
    slot: usize,
    lag_s: f64,
    /// Commanded speed at every sample, mm/s.
    speed: Vec<f64>,
}

/// Two axes, the first of which lags by so much more, s.
#[derive(Debug, Clone, PartialEq)]
pub struct Lagged {
    /// Name of the axis that lags more.
    pub slow: String,
    /// Name of the other axis.
    pub fast: String,
    /// Difference of their lags, s.
    pub by_s: f64,
}

impl LagMismatch {
    /// The lags of `actual` behind `reference`, both sampled alike; `None` where fewer than two linear axes move.
    #[must_use]
    pub fn of(reference: &Trajectory, actual: &Trajectory) -> Option<Self> {
        let period = reference.period_s();
        let columns = reference.axes().iter().zip(reference.columns().iter().zip(actual.columns()));
        let lagging = |(axis, (wanted, reached)): (&motion::Axis, (&Vec<f64>, &Vec<f64>))| {
            let slot = axis.slot().filter(|slot| *slot < 3 && axis.kind == AxisKind::Linear)?;
            let lag_s = lag_s(wanted, reached, period)?;
            let last = wanted.len().saturating_sub(1);
            let speed = |k: usize| (wanted[(k + 1).min(last)] - wanted[k.saturating_sub(1)]) / (2.0 * period);
            Some(Lagging { name: axis.name.clone(), slot, lag_s, speed: (0..wanted.len()).map(speed).collect() })
        };
        let axes: Vec<Lagging> = columns.filter_map(lagging).collect();
        (axes.len() > 1).then_some(Self { axes })
    }

    /// The axes whose different lags bring about a good part of the contour error `error` (mm) of sample `k`; `None` where something else does.
    #[must_use]
    pub fn explains(&self, k: usize, error: &Vec3) -> Option<Lagged> {
        let mut velocity = Vec3::zeros();
        let mut behind = Vec3::zeros();
        for axis in &self.axes {
            let speed = *axis.speed.get(k)?;
            velocity[axis.slot] = speed;
            behind[axis.slot] = -axis.lag_s * speed;
        }
        // What lies along the path is a delay, and no error of the contour.
        let along = velocity.try_normalize(1e-9)?;
        let across = behind - along * along.dot(&behind);
        let share = across.dot(error) / error.norm_squared();
        if !(SHARE[0]..=SHARE[1]).contains(&share) {
            return None;
        }
        let moving = || self.axes.iter().filter(|axis| axis.speed[k].abs() > 0.05 * velocity.norm());
        let slow = moving().max_by(|a, b| a.lag_s.total_cmp(&b.lag_s))?;
        let fast = moving().min_by(|a, b| a.lag_s.total_cmp(&b.lag_s))?;
        let by_s = slow.lag_s - fast.lag_s;
        (by_s > 0.0).then(|| Lagged { slow: slow.name.clone(), fast: fast.name.clone(), by_s })
    }
}

#[cfg(test)]
mod tests {
    use motion::Axis;

    use super::*;

    #[test]
    fn a_circle_of_unequal_lags_is_explained_and_another_error_is_not() {
        let (period, n) = (0.002, 3000);
        let at = |k: i32, lag: f64, turned: f64| 20.0 * (3.0 * (f64::from(k) * period - lag) + turned).cos();
        let column = |lag: f64, turned: f64| (0..n).map(|k| at(k, lag, turned)).collect::<Vec<f64>>();
        let axes = vec![Axis::named("x"), Axis::named("y")];
        let y = -std::f64::consts::FRAC_PI_2;
        let reference = Trajectory::new(period, axes.clone(), vec![column(0.0, 0.0), column(0.0, y)]).unwrap();
        let actual = Trajectory::new(period, axes, vec![column(0.0103, 0.0), column(0.0101, y)]).unwrap();
        let lags = LagMismatch::of(&reference, &actual).unwrap();
        // At 45° the difference of 0.2 ms at 42 mm/s counts in full: inwards, on both sides of the middle.
        let k = (std::f64::consts::FRAC_PI_4 / 3.0 / period).round() as usize;
        let inward = -Vec3::new(1.0, 1.0, 0.0).normalize();
        let size = 0.5 * 0.0002 * 60.0;
        for error in [inward * size, -inward * size] {
            match lags.explains(k, &error) {
                Some(found) => {
                    assert_eq!((found.slow.as_str(), found.fast.as_str()), ("x", "y"));
                    assert!((found.by_s - 0.0002).abs() < 2e-6, "{}", found.by_s);
                }
                // The mismatch points to one side alone.
                None => assert!(lags.explains(k, &-error).is_some()),
            }
        }
        assert!(lags.explains(k, &(inward * 5.0 * size)).is_none() && lags.explains(k, &(inward * -5.0 * size)).is_none());
        let one = Trajectory::new(period, vec![Axis::named("x")], vec![column(0.0, 0.0)]).unwrap();
        assert!(LagMismatch::of(&one, &one).is_none());
    }
}
