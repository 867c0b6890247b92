//! Machines with rotary axes under the workpiece or above the tool.

mod chain;
mod inverse;

use chain::{Frame, Link};

use super::orientation::{REACH_RAD, TwoJoints};
use super::{Kinematics, rotary_index};
use crate::{Axis, MotionError, Pose, Vec3};

/// Tolerance on the travel of linear axes, mm: below the resolution of a program.
const TRAVEL_MM: f64 = 1e-9;

/// Joints whose directions differ by less than this count as parallel, rad.
const PARALLEL_RAD: f64 = 1e-6;

/// Mounting of a rotary joint.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum RotaryMount {
    /// The table with the workpiece.
    Table,
    /// The head with the tool.
    Head,
}

/// A rotary axis and its geometry.
#[derive(Debug, Clone, PartialEq)]
pub struct RotaryJoint {
    /// Name of the axis: `a`, `b` or `c`.
    pub axis: String,
    /// Mounting.
    pub mount: RotaryMount,
    /// Direction of the axis in the machine frame with all rotary axes at zero, any length. A
    /// positive angle rotates the tool right-handed about it as seen from the workpiece (ISO 841),
    /// so a table itself rotates left-handed. Reverse it for a control with the opposite sign, such
    /// as LinuxCNC's `xyzac-trt` without `conventional-directions`.
    pub direction: Vec3,
    /// A point on the axis with all rotary axes at zero, mm, machine frame: of a table joint from workpiece zero, of a head joint
    /// from the spindle nose.
    pub pivot_mm: Vec3,
    /// Travel `[lowest, highest]`, rad, if limited.
    pub travel_rad: Option<[f64; 2]>,
}

/// Angles of the links of a chain, in chain order, rad. Zero for missing links.
type Angles = [f64; 2];

/// Three perpendicular linear axes and up to two rotary ones, each under the workpiece or above the
/// tool.
///
/// With all rotary axes at zero the tool points along `+Z` and its tip is at the positions of `x`,
/// `y`, `z` from workpiece zero. A table rotates the workpiece under the tool, `p_w =
/// T₂⁻¹·T₁⁻¹·p_m` with `Tᵢ` the rotation of table joint `i` by `−θᵢ` about its axis. A head rotates
/// the tip about pivots, whose height above the tip is that above the spindle nose plus the tool
/// length. The tool axis in the workpiece frame is `o = Π R(directionᵢ, +θᵢ)·z`, from the workpiece
/// to the tool: table joints last to first, then head joints first to last.
///
/// Near a pole the tool is parallel to the joint next to the workpiece. Poses there still have an
/// accuracy of 1e-12 rad. The accuracy of that joint's angle is about 1e-16 rad divided by the
/// distance to the pole.
#[derive(Debug, Clone, PartialEq)]
pub struct FiveAxis {
    axes: Vec<Axis>,
    /// From the workpiece to the tool.
    chain: Vec<Link>,
    /// Number of links under the workpiece.
    tables: usize,
    /// The chain, where it has two links.
    pair: Option<TwoJoints>,
    /// Indices of the axes called A, B or C, each with its index among these.
    rotary: Vec<(usize, usize)>,
    /// Indices of `x`, `y`, `z` among the axes.
    linear: [usize; 3],
    /// Travel, one entry per axis.
    travel: Vec<Option<[f64; 2]>>,
}

impl FiveAxis {
    /// The machine with these `axes`, `x`, `y` and `z` among them in any order, and rotary `joints`
    /// from the bed outwards: of two table joints the first carries the second, of two head joints
    /// likewise. `tool_length_mm` from spindle nose to tip. `linear_travel_mm` of `x`, `y`, `z`,
    /// `[lowest, highest]` if limited. Other axes do not move the tool.
    ///
    /// # Errors
    /// If an axis is missing or named twice, there are more than two joints, a number is invalid,
    /// or a pair of joints gives the tool only one rotational degree of freedom.
    pub fn new(
        axes: Vec<Axis>,
        joints: Vec<RotaryJoint>,
        tool_length_mm: f64,
        linear_travel_mm: [Option<[f64; 2]>; 3],
    ) -> Result<Self, MotionError> {
        if let Some((_, axis)) = axes.iter().enumerate().find(|(i, axis)| axes[..*i].iter().any(|other| other.name == axis.name))
        {
            return Err(MotionError::DuplicateAxis(axis.name.clone()));
        }
        if joints.len() > 2 {
            return Err(undefined(format!("{} rotary joints; a tool is oriented by two at most", joints.len())));
        }
        if !(tool_length_mm.is_finite() && tool_length_mm >= 0.0) {
            let remedy = "it must be finite and not negative";
            return Err(MotionError::BadSetting { name: "tool_length_mm", value: tool_length_mm, remedy });
        }
        let linear = [index_of(&axes, "x")?, index_of(&axes, "y")?, index_of(&axes, "z")?];
        let mut travel = vec![None; axes.len()];
        for (axis, range) in linear.into_iter().zip(linear_travel_mm) {
            travel[axis] = checked_travel(&axes[axis].name, range)?;
        }
        let (mut tables, mut heads): (Vec<Link>, Vec<Link>) = (Vec::new(), Vec::new());
        for joint in &joints {
            let (axis, rotary) = rotary_axis(&axes, &joint.axis)?;
            if tables.iter().chain(&heads).any(|link| link.axis == axis) {
                return Err(MotionError::DuplicateAxis(joint.axis.clone()));
            }
            let link = Link { axis, rotary, direction: direction_of(joint)?, pivot: pivot_of(joint, tool_length_mm)? };
            travel[axis] = checked_travel(&joint.axis, joint.travel_rad)?;
            match joint.mount {
                RotaryMount::Table => tables.push(link),
                RotaryMount::Head => heads.push(link),
            }
        }
        tables.reverse();
        let count = tables.len();
        let chain: Vec<Link> = tables.into_iter().chain(heads).collect();
        let pair = match chain.as_slice() {
            [outer, inner] => {
                check_pair(outer, inner, &axes)?;
                Some(TwoJoints::new(outer.direction, inner.direction))
            }
            _ => None,
        };
        let rotary = axes.iter().enumerate().filter_map(|(axis, named)| Some((axis, rotary_index(&named.name)?))).collect();
        Ok(Self { axes, chain, tables: count, pair, rotary, linear, travel })
    }

    /// Links under the workpiece, and those above the tool.
    fn links(&self) -> (&[Link], &[Link]) {
        self.chain.split_at(self.tables)
    }

    /// Angles of the links.
    fn angles(&self, of: impl Fn(&Link) -> f64) -> Angles {
        let mut angles = Angles::default();
        angles.iter_mut().zip(&self.chain).for_each(|(angle, link)| *angle = of(link));
        angles
    }

    /// Positions of `x`, `y`, `z`.
    fn slide(&self, joints: &[f64]) -> Vec3 {
        Vec3::from(self.linear.map(|axis| joints[axis]))
    }

    fn check(&self, tip: &Vec3, near: &[f64]) -> Result<(), MotionError> {
        if near.len() != self.axes.len() {
            return Err(MotionError::Mismatch(format!("{} positions for {} axes", near.len(), self.axes.len())));
        }
        if tip.iter().chain(near).any(|value| !value.is_finite()) {
            return Err(MotionError::Unreachable("a position of the tool tip or of an axis is not finite".into()));
        }
        Ok(())
    }

    /// Moves `joints` so that the tip is at `tip` with the links at `angles`. Unchanged on an
    /// error.
    fn slide_to(&self, tip: &Vec3, angles: &Angles, joints: &mut [f64]) -> Result<(), MotionError> {
        let (tables, heads) = self.links();
        let (table_angles, head_angles) = angles.split_at(self.tables);
        let under = tables.iter().zip(table_angles).fold(*tip, |point, (link, angle)| link.at(-angle).point(&point));
        let above = heads.iter().zip(head_angles).rev().fold(Vec3::zeros(), |point, (link, angle)| link.at(*angle).point(&point));
        let slide = under - above;
        for (axis, position) in self.linear.into_iter().zip(slide.iter()) {
            if let Some([low, high]) = self.travel[axis]
                && !(low - TRAVEL_MM..=high + TRAVEL_MM).contains(position)
            {
                let name = &self.axes[axis].name;
                return Err(MotionError::Unreachable(format!(
                    "axis `{name}` would stand at {position:.3} mm, outside its travel from {low} to {high} mm"
                )));
            }
        }
        self.linear.into_iter().zip(slide.iter()).for_each(|(axis, position)| joints[axis] = *position);
        self.chain.iter().zip(angles).for_each(|(link, angle)| joints[link.axis] = *angle);
        Ok(())
    }
}

impl Kinematics for FiveAxis {
    fn axes(&self) -> &[Axis] {
        &self.axes
    }

    fn forward(&self, joints: &[f64]) -> Pose {
        let (tables, heads) = self.links();
        let through = |pose: Pose, link: &Link| link.at(joints[link.axis]).pose(&pose);
        let mut pose = heads.iter().rev().fold(Pose::upright(Vec3::zeros()), through);
        pose.tip += self.slide(joints);
        tables.iter().rev().fold(pose, through)
    }

    /// Of the two solutions, with all whole turns added, the one within travel with the smallest
    /// larger rotary move from `joints`. With the tool at a pole the free axis keeps its angle.
    /// Directions within 1e-9 rad of the reachable ones count as reached.
    fn reach(&self, pose: &Pose, joints: &mut [f64]) -> Result<(), MotionError> {
        self.check(&pose.tip, joints)?;
        let tool = unit(&pose.tool).ok_or_else(|| MotionError::Unreachable("the tool axis is zero or not finite".into()))?;
        if let Some(candidate) = self.direct_solution(&tool, joints)
            && self.slide_to(&pose.tip, &candidate, joints).is_ok()
        {
            return Ok(());
        }
        let (nearest, other) = self.solutions(&tool, joints)?;
        self.slide_to(&pose.tip, &nearest, joints).or_else(|refusal| match other {
            Some(other) => self.slide_to(&pose.tip, &other, joints).map_err(|_| refusal),
            None => Err(refusal),
        })
    }

    fn place_at(&self, tip: &Vec3, rotary: &[f64; 3], joints: &mut [f64]) -> Result<(), MotionError> {
        self.check(tip, joints)?;
        for &(axis, index) in &self.rotary {
            // Written so that NaN is refused too.
            let [low, high] = self.travel[axis].unwrap_or([f64::MIN, f64::MAX]);
            if !(low - REACH_RAD..=high + REACH_RAD).contains(&rotary[index]) {
                return Err(self.beyond_travel(axis, rotary[index]));
            }
        }
        self.slide_to(tip, &self.angles(|link| rotary[link.rotary]), joints)?;
        self.rotary.iter().for_each(|&(axis, index)| joints[axis] = rotary[index]);
        Ok(())
    }

    fn jacobian(&self, joints: &[f64]) -> Vec<[Vec3; 2]> {
        let pose = self.forward(joints);
        let mut columns = vec![[Vec3::zeros(); 2]; self.axes.len()];
        let mut frame = Frame::at_rest();
        let (tables, heads) = self.chain.split_at(self.tables);
        let turn = |frame: &mut Frame, link: &Link, columns: &mut Vec<[Vec3; 2]>| {
            let direction = frame.rotation * link.direction;
            let arm = pose.tip - frame.point(&link.pivot);
            columns[link.axis] = [direction.cross(&arm), direction.cross(&pose.tool)];
            frame.turn(link, joints[link.axis]);
        };
        tables.iter().for_each(|link| turn(&mut frame, link, &mut columns));
        for (coordinate, axis) in self.linear.into_iter().enumerate() {
            columns[axis][0] = frame.rotation * Vec3::ith(coordinate, 1.0);
        }
        frame.origin = frame.point(&self.slide(joints));
        heads.iter().for_each(|link| turn(&mut frame, link, &mut columns));
        columns
    }

    fn has_rotary_axes(&self) -> bool {
        !self.chain.is_empty()
    }

    /// Of two joints, the one nearer to the workpiece has its direction as pole, with either sign.
    /// A single joint keeps its angle to the tool and has no pole.
    fn pole_distance_rad(&self, tool: &Vec3) -> Option<f64> {
        let [outer, _] = self.chain.as_slice() else { return None };
        Some(outer.direction.cross(tool).norm().atan2(outer.direction.dot(tool).abs()))
    }

    fn travel(&self, axis: usize) -> Option<[f64; 2]> {
        self.travel.get(axis).copied().flatten()
    }
}

/// The unit vector along `vector`, if it has a direction.
fn unit(vector: &Vec3) -> Option<Vec3> {
    // A norm that overflows gives zeros, a NaN norm gives NaN.
    vector.try_normalize(0.0).filter(|unit| (unit.norm() - 1.0).abs() < 1e-9)
}

fn undefined(what: String) -> MotionError {
    MotionError::BadKinematics(what)
}

fn index_of(axes: &[Axis], name: &str) -> Result<usize, MotionError> {
    let found = axes.iter().position(|axis| axis.name == name);
    found.ok_or_else(|| undefined(format!("there is no axis `{name}`; name it among the machine's axes")))
}

/// Index of a rotary axis among the axes, and among A, B, C.
fn rotary_axis(axes: &[Axis], name: &str) -> Result<(usize, usize), MotionError> {
    let axis = index_of(axes, name)?;
    let rotary =
        rotary_index(name).ok_or_else(|| undefined(format!("rotary joint `{name}`; rotary axes are called a, b or c")))?;
    Ok((axis, rotary))
}

fn direction_of(joint: &RotaryJoint) -> Result<Vec3, MotionError> {
    unit(&joint.direction).ok_or_else(|| undefined(format!("the direction of `{}` is zero or not finite", joint.axis)))
}

/// From workpiece zero, or from the tool tip for a head joint, mm.
fn pivot_of(joint: &RotaryJoint, tool_length_mm: f64) -> Result<Vec3, MotionError> {
    if joint.pivot_mm.iter().any(|v| !v.is_finite()) {
        return Err(undefined(format!("the pivot of `{}` is not finite", joint.axis)));
    }
    Ok(match joint.mount {
        RotaryMount::Table => joint.pivot_mm,
        RotaryMount::Head => joint.pivot_mm + Vec3::z() * tool_length_mm,
    })
}

/// Refuses two joints with only one rotational degree of freedom.
fn check_pair(outer: &Link, inner: &Link, axes: &[Axis]) -> Result<(), MotionError> {
    let [outer_name, inner_name] = [outer, inner].map(|link| &axes[link.axis].name);
    if outer.direction.cross(&inner.direction).norm() < PARALLEL_RAD {
        return Err(undefined(format!(
            "`{outer_name}` and `{inner_name}` turn about parallel directions, which tilts the tool one way only; \
             give them directions at an angle, or leave one out"
        )));
    }
    if inner.direction.cross(&Vec3::z()).norm() < PARALLEL_RAD {
        return Err(undefined(format!(
            "`{inner_name}` turns about the tool itself and leaves its direction to `{outer_name}` alone; \
             joints are listed from the bed outwards, so swap the two if their order is wrong"
        )));
    }
    Ok(())
}

fn checked_travel(axis: &str, travel: Option<[f64; 2]>) -> Result<Option<[f64; 2]>, MotionError> {
    match travel {
        // Written so that NaN is refused too.
        Some([low, high]) if low <= high && low < f64::INFINITY && high > f64::NEG_INFINITY => Ok(travel),
        Some([low, high]) => {
            Err(undefined(format!("the travel of `{axis}` goes from {low} to {high}; give the lower end first")))
        }
        None => Ok(None),
    }
}
