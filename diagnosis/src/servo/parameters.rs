//! Parameters of the servo model of an axis.

/// Number of parameters.
pub const COUNT: usize = 23;

/// Parameters of the servo model: position loop over velocity loop, friction before and during sliding, backlash.
///
/// Lengths in mm (a rotary axis: mm on a lever arm, see [`AxisRecord`](crate::record::AxisRecord)), times in s. Friction is stated as the
/// deflection of the loops without integrators, `F / (M ω_b K_v)`: positions alone show neither forces nor masses.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Servo {
    /// Position gain `K_v`, 1/s.
    pub position_gain_1_s: f64,
    /// Velocity feed-forward `k_ff`, as a fraction.
    pub feed_forward: f64,
    /// Bandwidth `ω_b` of the velocity loop, 1/s.
    pub bandwidth_1_s: f64,
    /// Integral of the velocity loop, as a fraction of its bandwidth: `1 / (T_i ω_b)`. 0 for a P loop.
    pub integral: f64,
    /// Delay of the velocity command, s.
    pub loop_delay_s: f64,
    /// Acceleration feed-forward, as a fraction.
    pub acceleration_feed_forward: f64,
    /// Deflection by Coulomb friction, mm.
    pub coulomb_mm: f64,
    /// Static friction over Coulomb friction, less 1.
    pub stribeck: f64,
    /// Stribeck velocity, mm/s.
    pub stribeck_mm_s: f64,
    /// Presliding distance, mm.
    pub presliding_mm: f64,
    /// Relative difference of the directions from their mean.
    pub asymmetry: f64,
    /// Width of the backlash between the motor and a table scale that closes the loop, mm.
    pub backlash_mm: f64,
    /// Viscous friction over the velocity gain, no unit.
    pub viscous: f64,
    /// Deflection by a constant force, mm.
    pub offset_mm: f64,
    /// Delay of the actual channel behind the command channel, or of the command before the loop, s.
    pub channel_delay_s: f64,
    /// Window of a moving average over the command, s.
    pub command_average_s: f64,
    /// Integral of the position loop, 1/s. 0 for a P loop.
    pub position_integral_1_s: f64,
    /// Width of the backlash between the motor encoder that closes the loop and a table scale that is logged, mm.
    pub outer_backlash_mm: f64,
    /// Share of the friction that acts on the table.
    pub table_friction: f64,
    /// Pulsation of the table on the elastic drive with the motor held, 1/s. 0 where motor and table are one mass.
    pub table_pulsation_1_s: f64,
    /// Its damping ratio.
    pub table_damping: f64,
    /// Share of the table in the moved mass.
    pub table_mass: f64,
    /// Velocity command per acceleration of the command, s (LinuxCNC: FF2).
    pub velocity_per_acceleration_s: f64,
}

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

/// Ranges that hold every feed drive; the few weak priors keep the shape of the Stribeck curve where a log does not show it.
pub const SCALES: [Scale; COUNT] = [
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
];

impl Servo {
    /// A cascade with this gain and feed-forward and usual values of the rest.
    #[must_use]
    pub fn usual(position_gain_1_s: f64, feed_forward: f64) -> Self {
        Self {
            position_gain_1_s,
            feed_forward,
            bandwidth_1_s: 6.0 * position_gain_1_s,
            integral: 0.1,
            loop_delay_s: USUAL_DELAY_S,
            acceleration_feed_forward: 0.0,
            coulomb_mm: 3e-3,
            stribeck: 0.3,
            stribeck_mm_s: 3.0,
            presliding_mm: 5e-3,
            asymmetry: 0.0,
            backlash_mm: 0.0,
            viscous: 0.0,
            offset_mm: 0.0,
            channel_delay_s: 0.0,
            command_average_s: 0.0,
            position_integral_1_s: 0.0,
            outer_backlash_mm: 0.0,
            velocity_per_acceleration_s: 0.0,
            table_friction: 0.5,
            table_pulsation_1_s: 0.0,
            table_damping: 0.05,
            table_mass: 0.3,
        }
    }

    /// The fitted coordinates before logarithms, in the order of [`index`]. The lag of the loop stands for the feed-forward: it is certain
    /// where gain and feed-forward are not, and the valley that they lie in is straight in it.
    #[must_use]
    fn to_array(self) -> [f64; COUNT] {
        [
            self.position_gain_1_s,
            (1.0 - self.feed_forward) / self.position_gain_1_s,
            self.bandwidth_1_s,
            self.integral,
            self.loop_delay_s,
            self.acceleration_feed_forward,
            self.coulomb_mm,
            self.stribeck,
            self.stribeck_mm_s,
            self.presliding_mm,
            self.asymmetry,
            self.backlash_mm,
            self.viscous,
            self.offset_mm,
            self.channel_delay_s,
            self.command_average_s,
            self.position_integral_1_s,
            self.outer_backlash_mm,
            self.velocity_per_acceleration_s,
            self.table_friction,
            self.table_pulsation_1_s,
            self.table_damping,
            self.table_mass,
        ]
    }

    #[must_use]
    fn from_array(all: [f64; COUNT]) -> Self {
        Self {
            position_gain_1_s: all[0],
            feed_forward: 1.0 - all[1] * all[0],
            bandwidth_1_s: all[2],
            integral: all[3],
            loop_delay_s: all[4],
            acceleration_feed_forward: all[5],
            coulomb_mm: all[6],
            stribeck: all[7],
            stribeck_mm_s: all[8],
            presliding_mm: all[9],
            asymmetry: all[10],
            backlash_mm: all[11],
            viscous: all[12],
            offset_mm: all[13],
            channel_delay_s: all[14],
            command_average_s: all[15],
            position_integral_1_s: all[16],
            outer_backlash_mm: all[17],
            velocity_per_acceleration_s: all[18],
            table_friction: all[19],
            table_pulsation_1_s: all[20],
            table_damping: all[21],
            table_mass: all[22],
        }
    }

    /// The parameters with one moved by `by` in its fitted coordinate, within its range.
    #[must_use]
    pub fn moved(self, parameter: usize, by: f64) -> Self {
        let mut all = self.to_array();
        let Scale { logarithmic, range: (low, high), .. } = SCALES[parameter];
        let moved = if logarithmic { all[parameter] * by.exp() } else { all[parameter] + by };
        all[parameter] = moved.clamp(low, high);
        Self::from_array(all)
    }

    /// A parameter in its fitted coordinate.
    #[must_use]
    pub fn coordinate(&self, parameter: usize) -> f64 {
        let value = self.to_array()[parameter];
        if SCALES[parameter].logarithmic { value.ln() } else { value }
    }

    /// Time by which the axis lags at constant speed, s: `e = v · lag`.
    ///
    /// With an integrator in the velocity loop `(1 − k_ff) / K_v`; without one viscous friction adds its part; with one in the position loop
    /// the loop itself leaves none. A delay of the channels and half the window of a moving average add to each.
    #[must_use]
    pub fn lag_s(&self) -> f64 {
        let in_loop = if self.position_integral_1_s > 0.0 {
            0.0
        } else {
            let viscous = if self.integral > 0.0 { 0.0 } else { self.viscous };
            (1.0 + viscous - self.feed_forward) / self.position_gain_1_s
        };
        in_loop + self.channel_delay_s + 0.5 * self.command_average_s
    }

    /// The axis without friction, backlash and constant force.
    #[must_use]
    pub fn linear(&self) -> Self {
        Self { coulomb_mm: 0.0, backlash_mm: 0.0, outer_backlash_mm: 0.0, offset_mm: 0.0, ..*self }
    }
}
