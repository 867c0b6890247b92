//! Parameters of the servo model of an axis.

use serde::{Deserialize, Serialize};

use crate::scales::{COUNT, ELEMENTS, LUGRE_SHARES, PLACES, SCALARS, SCALES, Scale, USUAL_DELAY_S, index};

/// Parameters of the servo model: position loop over velocity loop, friction before and during sliding, backlash.
///
/// Lengths in mm (a rotary axis: mm on a lever arm), times in s. Friction is stated as the
/// deflection of the loops without integrators, `F / (M ω_b K_v)`: positions alone show neither forces nor masses.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
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
    /// Time constant of a first-order lag of the command, s.
    pub command_lag_s: f64,
    /// Deflection of the contacts of an axis at rest before it moves, as a multiple of the presliding distance.
    pub start_deflection: f64,
    /// Command less actual position at such a rest, mm.
    pub start_error_mm: f64,
    /// Mean speed of the vibrations under which contacts at rest give way, mm/s.
    #[serde(default)]
    pub creep_mm_s: f64,
    /// Share of the viscous friction that acts on the table.
    #[serde(default)]
    pub table_viscous: f64,
    /// Damping of the contacts at the Stribeck velocity, as a multiple of Coulomb friction. Like the static friction it vanishes at larger speeds.
    #[serde(default)]
    pub contact_damping: f64,
    /// Whether the contacts are elements that slip one after the other (Maxwell slip) instead of LuGre's.
    pub slips: bool,
    /// Whether the motor encoder closes the loop and is logged: the table behind screw and backlash is felt, not seen.
    #[serde(default)]
    pub hides_table: bool,
    /// Share of each element in the friction; only their ratios count.
    pub shares: [f64; ELEMENTS],
    /// First place of the friction level, mm.
    pub first_place_mm: f64,
    /// Distance of the places, mm; 0 where friction is the same everywhere.
    pub place_spacing_mm: f64,
    /// Friction at each place over that elsewhere.
    pub levels: [f64; PLACES],
}

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
            command_lag_s: 0.0,
            start_deflection: 0.0,
            start_error_mm: 0.0,
            creep_mm_s: 0.0,
            table_viscous: 0.0,
            contact_damping: 0.0,
            slips: false,
            hides_table: false,
            shares: LUGRE_SHARES,
            first_place_mm: 0.0,
            place_spacing_mm: 0.0,
            levels: [1.0; PLACES],
        }
    }

    /// The fitted coordinates before logarithms, in the order of [`index`]. The lag of the loop stands for the feed-forward: it is certain
    /// where gain and feed-forward are not, and the valley that they lie in is straight in it.
    #[must_use]
    fn to_array(self) -> [f64; COUNT] {
        let scalars: [f64; SCALARS] = [
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
            self.command_lag_s,
            self.start_deflection,
            self.start_error_mm,
            self.creep_mm_s,
            self.table_viscous,
            self.contact_damping,
        ];
        let mut all = [0.0; COUNT];
        all[..SCALARS].copy_from_slice(&scalars);
        all[index::SHARES].copy_from_slice(&self.shares);
        all[index::LEVELS].copy_from_slice(&self.levels);
        all
    }

    /// The parameters with those of `all`.
    fn with_array(self, all: &[f64; COUNT]) -> Self {
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
            command_lag_s: all[23],
            start_deflection: all[24],
            start_error_mm: all[25],
            creep_mm_s: all[26],
            table_viscous: all[27],
            contact_damping: all[28],
            shares: std::array::from_fn(|element| all[index::SHARES.start + element]),
            levels: std::array::from_fn(|place| all[index::LEVELS.start + place]),
            ..self
        }
    }

    /// The parameters with one moved by `by` in its fitted coordinate, within its range.
    #[must_use]
    pub fn moved(self, parameter: usize, by: f64) -> Self {
        let mut all = self.to_array();
        let Scale { logarithmic, range: (low, high), .. } = SCALES[parameter];
        let moved = if logarithmic { all[parameter] * by.exp() } else { all[parameter] + by };
        all[parameter] = moved.clamp(low, high);
        self.with_array(&all)
    }

    /// A parameter in its fitted coordinate.
    #[must_use]
    pub fn coordinate(&self, parameter: usize) -> f64 {
        let value = self.to_array()[parameter];
        if SCALES[parameter].logarithmic { value.ln() } else { value }
    }

    /// Acceleration per deflection of the loops without integrator, 1/s².
    pub(crate) fn stiffness_1_s2(&self) -> f64 {
        self.bandwidth_1_s * self.position_gain_1_s
    }

    /// Time by which the axis lags at constant speed, s: `e = v · lag`.
    ///
    /// With an integrator in the velocity loop `(1 − k_ff) / K_v`; without one viscous friction adds its part; with one in the position loop
    /// the loop itself leaves none. A delay of the channels, half the window of a moving average and a lag of the command add to each.
    #[must_use]
    pub fn lag_s(&self) -> f64 {
        let in_loop = if self.position_integral_1_s > 0.0 {
            0.0
        } else {
            let viscous = if self.integral > 0.0 { 0.0 } else { self.viscous };
            (1.0 + viscous - self.feed_forward) / self.position_gain_1_s
        };
        in_loop + self.channel_delay_s + 0.5 * self.command_average_s + self.command_lag_s
    }

    /// The friction of this axis with the loops, delays and smoothing of another one.
    #[must_use]
    pub fn with_loops_of(&self, other: &Self) -> Self {
        Self {
            position_gain_1_s: other.position_gain_1_s,
            feed_forward: other.feed_forward,
            bandwidth_1_s: other.bandwidth_1_s,
            integral: other.integral,
            loop_delay_s: other.loop_delay_s,
            acceleration_feed_forward: other.acceleration_feed_forward,
            channel_delay_s: other.channel_delay_s,
            command_average_s: other.command_average_s,
            position_integral_1_s: other.position_integral_1_s,
            velocity_per_acceleration_s: other.velocity_per_acceleration_s,
            command_lag_s: other.command_lag_s,
            ..*self
        }
    }

    /// The axis without friction, backlash and constant force.
    #[must_use]
    pub fn linear(&self) -> Self {
        // The loop stays closed by its own sensor.
        let outer_backlash_mm = if self.outer_backlash_mm > 0.0 { f64::MIN_POSITIVE } else { 0.0 };
        Self { coulomb_mm: 0.0, backlash_mm: 0.0, outer_backlash_mm, offset_mm: 0.0, ..*self }
    }

    /// The axis with the same friction everywhere: for a run whose place on the machine is not known.
    #[must_use]
    pub fn without_places(&self) -> Self {
        Self { place_spacing_mm: 0.0, ..*self }
    }

    /// The axis with places for a friction level over the positions `low` to `high`, mm.
    #[must_use]
    pub fn with_places(&self, low: f64, high: f64) -> Self {
        let place_spacing_mm = (high - low) / (PLACES - 1) as f64;
        Self { first_place_mm: low, place_spacing_mm, levels: [1.0; PLACES], ..*self }
    }

    /// Friction at a position over that elsewhere: linear between places, and 1 from one spacing beyond the first and the last.
    #[must_use]
    pub fn level(&self, position_mm: f64) -> f64 {
        if self.place_spacing_mm <= 0.0 {
            return 1.0;
        }
        let steps = ((position_mm - self.first_place_mm) / self.place_spacing_mm).clamp(-1.0, PLACES as f64);
        let before = steps.floor();
        let level = |place: f64| if (0.0..PLACES as f64).contains(&place) { self.levels[place as usize] } else { 1.0 };
        let share = steps - before;
        (1.0 - share) * level(before) + share * level(before + 1.0)
    }

    /// Checks that every number is finite and within the range that a fit would give it.
    ///
    /// # Errors
    /// Says which is not.
    pub fn check(&self) -> Result<(), String> {
        let all = self.to_array();
        for (parameter, (value, scale)) in all.iter().zip(SCALES.iter()).enumerate() {
            let (low, high) = scale.range;
            let slack = 1e-9 * (high - low);
            let absent = OPTIONAL.contains(&parameter) && *value == 0.0;
            if !absent && !(low - slack..=high + slack).contains(value) {
                return Err(format!("parameter {parameter} of the servo model is {value}: it must be {low} to {high}"));
            }
        }
        let places = [self.first_place_mm, self.place_spacing_mm];
        if !(places.iter().all(|value| value.abs() < LARGEST_MM) && self.place_spacing_mm >= 0.0) {
            return Err("places of the servo model's friction level are out of range".into());
        }
        Ok(())
    }
}

/// Parameters with a logarithm that are 0 where the axis has no such part.
const OPTIONAL: [usize; 3] = [index::INTEGRAL, index::COULOMB, index::TABLE_PULSATION];

/// Bound of positions, mm.
const LARGEST_MM: f64 = 1e7;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_are_linear_between_places_and_one_beyond() {
        let mut servo = Servo::usual(50.0, 0.5).with_places(-10.0, 36.0);
        servo.levels[0] = 1.4;
        servo.levels[1] = 1.0;
        servo.levels[PLACES - 1] = 0.5;
        assert!((servo.level(-9.0) - 1.2).abs() < 1e-12 && (servo.level(-11.0) - 1.2).abs() < 1e-12);
        assert!((servo.level(36.0) - 0.5).abs() < 1e-12 && (servo.level(37.0) - 0.75).abs() < 1e-12);
        for far in [-12.0, -1e9, 38.0, 1e9] {
            assert_eq!(servo.level(far), 1.0);
        }
        assert_eq!(servo.without_places().level(-10.0), 1.0);
    }

    #[test]
    fn every_parameter_moves_alone_and_within_its_range() {
        let servo = Servo { table_pulsation_1_s: 500.0, ..Servo::usual(50.0, 0.5) };
        for parameter in 0..COUNT {
            let moved = servo.moved(parameter, SCALES[parameter].step);
            for other in 0..COUNT {
                let change = (moved.coordinate(other) - servo.coordinate(other)).abs();
                assert!((change > 1e-9) == (other == parameter), "{parameter} moves {other} by {change}");
            }
            assert_eq!(servo.moved(parameter, 1e9).check(), Ok(()));
        }
        assert!(servo.check().is_ok());
        assert!(Servo { bandwidth_1_s: f64::NAN, ..servo }.check().is_err());
        assert!(Servo { first_place_mm: f64::INFINITY, ..servo }.check().is_err());
        let shares: f64 = LUGRE_SHARES.iter().sum();
        assert!((shares - 1.0).abs() < 1e-9);
    }
}
