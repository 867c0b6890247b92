//! Random machines: structure and parameters by a seed.
//!
//! They test whether a method holds on any machine. Nothing below is fitted to a particular
//! machine. `U(a, b)` is uniform, `L(a, b)` uniform in the logarithm, `p` a probability.
//!
//! | of the machine | drawn from |
//! |---|---|
//! | logging period | 1, 2 or 4 ms, equally |
//! | position loop | P over velocity PI (cascade) p = 0.6; PID over velocity P p = 0.4 |
//! | position gain `Kv` | `L(20, 120)` 1/s |
//! | bandwidth of the velocity loops | `Kv·L(3, 10)` |
//! | a PID's integral time, derivative gain | `L(40, 300)` ms; 0 with p = 0.5, else `U(0, 0.2)` |
//! | velocity feed-forward | cascade: 0 with p = 0.25, else `U(0, 1)`; PID: `U(0.8, 1)` |
//! | acceleration feed-forward | 0 with p = 0.5, else `U(0, 1)` |
//! | command smoothing | none p = 0.35, a moving average p = 0.4, a first-order lag p = 0.25, of `L(1, 30)` ms |
//! | loop delay | 0 with p = 0.4, else 1 to 5 periods (1 ms) of the position loop |
//! | drive train | elastic screw (two masses) p = 0.55, stiff screw (one mass) p = 0.2, linear motor p = 0.25 |
//! | sensor | motor p = 0.6, table p = 0.4 |
//! | encoder step | `L(0.001, 1)` µm |
//! | friction model | LuGre p = 0.35, Maxwell-slip p = 0.35, Coulomb p = 0.15, Stribeck p = 0.15 (both LuGre with a presliding distance of `U(0.5, 1)` µm) |
//! | warming up | none p = 0.5, else by `U(0.02, 0.08)` within `L(100, 1500)` s |
//! | largest speed `v` | `L(40, 150)` mm/s, but no more than half a second of the largest acceleration |
//! | largest acceleration `a` | `2·L(0.01, 0.06) mm / T²`, in 100…2500 mm/s²: the linear lag leaves so much on a circle; `T² = (1.04 − ff²)/Kv²` (PID: at least `2·(1 − ff)·T_i/Kv`) plus the lag's squared time constant, or a twelfth of the average's squared window |
//! | largest jerk | `a·Kv·L(0.3, 1.2)` |
//!
//! | of each axis | drawn from |
//! |---|---|
//! | `Kv` | the machine's × `U(0.99, 1.01)`: unequal lags of the axes distort every contour |
//! | velocity feed-forward | the machine's + `U(−0.01, 0.01)`, not below 0 |
//! | velocity loop | bandwidth the machine's × `U(0.95, 1.05)`; a cascade's integral time `L(4, 15)` over the bandwidth |
//! | current loop's lag | `L(0.2, 0.8)` ms |
//! | table | `L(10, 200)` kg, viscous friction `L(10, 500)` N·s/m |
//! | lead | `U(4, 20)` mm |
//! | motor, at the table | `L(0.5, 8)` × the table of a screw; 0.1 × of a linear motor; viscous friction as the table's; torque: four times the demand of acceleration and friction |
//! | resonance of table and screw | `L(25, 150)` Hz, damping ratio `L(0.02, 0.1)` |
//! | backlash of an elastic screw | none p = 0.35, else `L(0.5, 20)` µm |
//! | Coulomb friction `F_c` | the force that deflects the loops without integrators by `L(1, 20)` µm; `U(0.2, 0.8)` of it on the motor's side |
//! | static friction | `F_c` (Coulomb), `F_c·U(1.2, 1.6)` (Stribeck), else `F_c·U(1, 1.5)`; Stribeck velocity `L(0.5, 10)` mm/s |
//! | presliding | LuGre: a distance of `L(2, 20)` µm; Maxwell: four elements of `L(1, 30)` µm; damping ratio against the table `U(0.02, 0.15)` |
//! | asymmetry of the directions | `U(−0.12, 0.12)` |
//! | position-dependent friction | 0 to 2 waves of up to 0.12 and 15 to 80 mm; 0 to 2 patches of −0.25…0.6, 3 to 12 mm wide, within ±50 mm; screws up to 0.08 a turn |
//! | ripple, cogging | up to 0.01 of the torque six times a turn; up to 0.05 × the friction twelve times (a linear motor: every 30 mm and 15 mm) |
//! | run-to-run noise | level `U(0, 0.04)`, drift `U(0, 0.04)` of `L(1, 10)` s, force `L(0.005, 0.05)·F_c` of 10 ms on both sides |
//!
//! An axis must follow a there-and-back motion at its limits with a bounded tracking error and
//! stand still after it, with its drawn position gain and with a gain a third higher. Otherwise it
//! is redrawn. After eight failures in a row, all axes are redrawn with the machine's `Kv` lowered
//! by a tenth, not below 20 1/s.

mod axis;
mod common;
mod draw;
mod stable;

use crate::spec::{AxisSpec, ControllerSpec, KinematicsSpec, LinearAxis, MachineSpec, PathSpec, ProfileFormat};
use crate::{MachineError, Sensor};
use axis::AxisDraw;
use common::{Common, POSITION_GAIN_1_S};
use draw::Draw;

/// Draws of an axis per position gain. Then the factor on that gain, for all axes, and the maximum
/// number of reductions: from 120 to 20 1/s takes 17.
const DRAWS: u64 = 8;
const LOWER_GAIN: f64 = 0.9;
const LOWERINGS: u64 = 24;

impl MachineSpec {
    /// The three-axis machine of `seed`: structure and parameters by the table in
    /// `machine/src/random.rs`. The same seed gives the same machine. Every machine is stable.
    ///
    /// # Errors
    /// If no stable axis was found. No such seed is known.
    pub fn random(seed: u64) -> Result<Self, MachineError> {
        let mut draw = Draw::new(seed, 0);
        let sampling_period_ms = *draw.one_of(&[1.0, 2.0, 4.0]);
        let sensor = if draw.chance(0.6) { Sensor::Motor } else { Sensor::Table };
        let common = Common::of(&mut draw);
        let Common { velocity_mm_s, acceleration_mm_s2, jerk_mm_s3, .. } = common;
        let mut spec = Self {
            name: format!("random-{seed}"),
            sampling_period_ms,
            sensor,
            path: PathSpec {
                velocity_mm_s,
                acceleration_mm_s2,
                jerk_mm_s3,
                // With the same acceleration along the path, the total stays at that of an axis.
                centripetal_mm_s2: acceleration_mm_s2 * std::f64::consts::FRAC_1_SQRT_2,
                smoothing_ms: 20.0,
                short_line_acceleration: 1.0,
                arc_acceleration_mm_s2: None,
            },
            kinematics: KinematicsSpec::Cartesian,
            control: None,
            controller: Some(ControllerSpec { format: ProfileFormat::Keep, ..ControllerSpec::default() }),
            work_offsets: Default::default(),
            axes: Vec::new(),
        };
        for lowered in 0..LOWERINGS {
            let gain = common.position_gain_1_s * LOWER_GAIN.powi(lowered as i32);
            let common = Common { position_gain_1_s: gain.max(POSITION_GAIN_1_S[0]), ..common };
            if let Some(axes) = stable_axes(&spec, &common, seed, lowered)? {
                spec.axes = axes;
                spec.check()?;
                return Ok(spec);
            }
        }
        Err(MachineError::BadDescription(format!("no stable axes were found for the random machine {seed}; take another seed")))
    }
}

/// The first stable x, y and z of their streams. `None` if one of them has none.
fn stable_axes(machine: &MachineSpec, common: &Common, seed: u64, lowered: u64) -> Result<Option<Vec<AxisSpec>>, MachineError> {
    let mut axes = Vec::new();
    for name in ["x", "y", "z"] {
        let first = 1 + (3 * lowered + axes.len() as u64) * DRAWS;
        let mut found = None;
        for stream in first..first + DRAWS {
            let axis = LinearAxis {
                name: name.to_owned(),
                velocity_mm_s: common.velocity_mm_s,
                acceleration_mm_s2: common.acceleration_mm_s2,
                jerk_mm_s3: common.jerk_mm_s3,
                travel_mm: None,
                filters_ms: None,
                time_constant_ms: None,
                drive: Some(Box::new(AxisDraw { common: *common, draw: &mut Draw::new(seed, stream) }.drive())),
            };
            if stable::is_stable(machine, &axis)? {
                found = Some(axis);
                break;
            }
        }
        let Some(axis) = found else { return Ok(None) };
        axes.push(AxisSpec::Linear(axis));
    }
    Ok(Some(axes))
}
