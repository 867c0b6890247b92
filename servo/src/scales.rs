//! How a fit moves the parameters of the servo model: their order, ranges, steps, and what is known beforehand.

/// Number of parameters that are single numbers.
pub const SCALARS: usize = 29;
/// Number of elements of the contacts.
pub const ELEMENTS: usize = 7;
/// Number of places of the friction level.
pub const PLACES: usize = 24;
/// Number of all parameters.
pub const COUNT: usize = SCALARS + ELEMENTS + PLACES;

/// Slip distances of the elements over the presliding distance.
pub const SLIPS: [f64; ELEMENTS] = [0.125, 0.25, 0.5, 1.0, 2.0, 4.0, 8.0];
/// Shares of the elements that follow the curve `1 − exp(−x)` of LuGre friction: its second derivative weighs the slip distance `w` by
/// `w exp(−w)`, integrated between the geometric means of neighbours.
pub const LUGRE_SHARES: [f64; ELEMENTS] = [0.014, 0.036, 0.109, 0.253, 0.362, 0.203, 0.023];

/// Index of each parameter in a vector of all.
pub mod index {
    #![allow(missing_docs, reason = "the names are those of the parameters")]
    pub const GAIN: usize = 0;
    pub const LOOP_LAG: usize = 1;
    pub const BANDWIDTH: usize = 2;
    pub const INTEGRAL: usize = 3;
    pub const LOOP_DELAY: usize = 4;
    pub const ACCELERATION: usize = 5;
    pub const COULOMB: usize = 6;
    pub const STRIBECK: usize = 7;
    pub const STRIBECK_SPEED: usize = 8;
    pub const PRESLIDING: usize = 9;
    pub const ASYMMETRY: usize = 10;
    pub const BACKLASH: usize = 11;
    pub const VISCOUS: usize = 12;
    pub const OFFSET: usize = 13;
    pub const CHANNEL_DELAY: usize = 14;
    pub const AVERAGE: usize = 15;
    pub const POSITION_INTEGRAL: usize = 16;
    pub const OUTER_BACKLASH: usize = 17;
    pub const VELOCITY_PER_ACCELERATION: usize = 18;
    pub const TABLE_FRICTION: usize = 19;
    pub const TABLE_PULSATION: usize = 20;
    pub const TABLE_DAMPING: usize = 21;
    pub const TABLE_MASS: usize = 22;
    pub const COMMAND_LAG: usize = 23;
    pub const START_DEFLECTION: usize = 24;
    pub const START_ERROR: usize = 25;
    pub const CREEP: usize = 26;
    pub const TABLE_VISCOUS: usize = 27;
    pub const CONTACT_DAMPING: usize = 28;
    /// Shares of the elements.
    pub const SHARES: std::ops::Range<usize> = super::SCALARS..super::SCALARS + super::ELEMENTS;
    /// Friction levels by place.
    pub const LEVELS: std::ops::Range<usize> = super::SCALARS + super::ELEMENTS..super::COUNT;
}

/// Delay of a loop that is not known to have more, s: half a millisecond of the position loop's period, and the current loop.
pub const USUAL_DELAY_S: f64 = 6e-4;
/// Its standard deviation over loops of up to 2 ms, s.
pub const USUAL_DELAY_SPREAD_S: f64 = 4e-4;

/// How a parameter enters the fit.
#[derive(Debug, Clone, Copy)]
pub struct Scale {
    /// Whether the fit moves its logarithm.
    pub logarithmic: bool,
    /// Lowest and highest value.
    pub range: (f64, f64),
    /// Step of the numerical derivative, in the fitted coordinate.
    pub step: f64,
    /// Centre and standard deviation of what is known beforehand, in the fitted coordinate; an infinite deviation states nothing.
    pub prior: (f64, f64),
}

const fn linear(low: f64, high: f64, step: f64) -> Scale {
    Scale { logarithmic: false, range: (low, high), step, prior: (0.0, f64::INFINITY) }
}

const fn logarithmic(low: f64, high: f64) -> Scale {
    Scale { logarithmic: true, range: (low, high), step: 1e-3, prior: (0.0, f64::INFINITY) }
}

/// Standard deviation of the logarithm of a share, and of a friction level: where the log does not show them they stay what they are. The
/// level's lies between the two that the friction map of the least-squares stages tries.
const SHARE_SPREAD: f64 = 1.0;
const LEVEL_SPREAD: f64 = 0.2;

/// Standard deviation of the error with which an axis rests before a motion, mm: a loop without integrator rests up to its friction's deflection off
/// the command, tens of micrometres. Without it fits of logs that show no rest went to the end of the range; half a second of rest outweighs it.
const START_ERROR_SPREAD_MM: f64 = 0.03;

/// Scale of every parameter.
pub static SCALES: std::sync::LazyLock<[Scale; COUNT]> = std::sync::LazyLock::new(|| {
    std::array::from_fn(|parameter| {
        if index::SHARES.contains(&parameter) {
            let prior = (LUGRE_SHARES[parameter - index::SHARES.start].ln(), SHARE_SPREAD);
            Scale { prior, step: 1e-2, ..logarithmic(1e-4, 1.0) }
        } else if index::LEVELS.contains(&parameter) {
            Scale { prior: (1.0, LEVEL_SPREAD), ..linear(0.05, 4.0, 1e-2) }
        } else {
            SINGLE[parameter]
        }
    })
});

/// Ranges that hold every feed drive; the few weak priors keep the shape of the Stribeck curve where a log does not show it.
const SINGLE: [Scale; SCALARS] = [
    logarithmic(2.0, 1000.0),
    linear(-0.05, 0.5, 2e-6),
    logarithmic(20.0, 5000.0),
    logarithmic(1e-3, 2.0),
    Scale { prior: (5e-4, 1.5e-3), ..linear(0.0, 0.02, 2e-5) },
    linear(-1.0, 2.0, 1e-3),
    logarithmic(1e-5, 0.5),
    Scale { prior: (0.3, 1.0), ..linear(0.0, 4.0, 5e-3) },
    Scale { prior: (1.1, 1.2), ..logarithmic(0.1, 50.0) },
    Scale { prior: (-5.3, 1.5), ..logarithmic(2e-4, 0.2) },
    Scale { prior: (0.0, 0.2), ..linear(-0.5, 0.5, 5e-3) },
    linear(0.0, 0.5, 5e-5),
    linear(0.0, 0.5, 1e-3),
    linear(-0.5, 0.5, 1e-5),
    linear(-0.02, 0.2, 1e-5),
    linear(0.0, 0.1, 1e-4),
    linear(0.0, 50.0, 1e-2),
    linear(0.0, 0.5, 5e-5),
    linear(-0.1, 0.1, 1e-5),
    Scale { prior: (0.5, 0.25), ..linear(0.0, 1.0, 5e-3) },
    Scale { prior: (6.2, 0.7), ..logarithmic(60.0, 2000.0) },
    Scale { prior: (-3.0, 0.7), ..logarithmic(5e-3, 0.7) },
    Scale { prior: (0.3, 0.15), ..linear(0.03, 0.75, 5e-3) },
    linear(0.0, 0.1, 2e-5),
    Scale { prior: (0.0, 0.7), ..linear(-2.0, 2.0, 1e-2) },
    Scale { prior: (0.0, START_ERROR_SPREAD_MM), ..linear(-0.1, 0.1, 1e-5) },
    linear(0.0, 1.0, 1e-4),
    Scale { prior: (0.5, 0.3), ..linear(0.0, 1.0, 1e-2) },
    Scale { prior: (0.0, 2.0), ..linear(0.0, 20.0, 1e-2) },
];
