//! Machines with rotary axes under the workpiece or above the tool.

use nalgebra::Rotation3;

use super::orientation::{Branch, REACH_RAD, angle, one_joint, two_joints, unwound};
use super::{Kinematics, rotary_index};
use crate::{Axis, MotionError, Pose, Vec3};

/// A linear axis may leave its travel by this much, mm: less than a program can say.
const TRAVEL_MM: f64 = 1e-9;

/// Joints whose directions differ by less than this count as parallel, rad.
const PARALLEL_RAD: f64 = 1e-6;

/// What a rotary joint turns.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum RotaryMount {
    /// The table with the workpiece.
    Table,
    /// The head with the tool.
    Head,
}

/// A rotary axis and where it sits.
#[derive(Debug, Clone, PartialEq)]
pub struct RotaryJoint {
    /// Name of the axis: `a`, `b` or `c`.
    pub axis: String,
    /// What it turns.
    pub mount: RotaryMount,
    /// Direction of the axis in the machine frame with all rotary axes at zero; its length does not matter. A positive angle
    /// turns the tool right-handed about it as seen from the workpiece (ISO 841), so a table itself turns left-handed. For a
    /// control that counts the other way, LinuxCNC's `xyzac-trt` unless its `conventional-directions` is set for one, reverse it.
    pub direction: Vec3,
    /// A point on the axis with all rotary axes at zero, mm, machine frame: of a table joint from workpiece zero, of a head joint
    /// from the spindle nose.
    pub pivot_mm: Vec3,
    /// Travel `[lowest, highest]`, rad, where it is limited.
    pub travel_rad: Option<[f64; 2]>,
}

/// A joint as the chain from workpiece to tool meets it.
#[derive(Debug, Clone, PartialEq)]
struct Link {
    /// Index among the axes.
    axis: usize,
    /// Unit vector.
    direction: Vec3,
    /// From workpiece zero, or from the tool tip for a head joint, mm.
    pivot: Vec3,
}

/// A frame inside another: `p ↦ rotation·p + origin`.
struct Frame {
    rotation: Rotation3<f64>,
    origin: Vec3,
}

impl Frame {
    fn at_rest() -> Self {
        Self { rotation: Rotation3::identity(), origin: Vec3::zeros() }
    }

    fn point(&self, point: &Vec3) -> Vec3 {
        self.rotation * point + self.origin
    }

    /// Appends a turn about a joint.
    fn turn(&mut self, link: &Link, angle_rad: f64) {
        let pivot = self.point(&link.pivot);
        self.rotation *= Rotation3::from_scaled_axis(link.direction * angle_rad);
        self.origin = pivot - self.rotation * link.pivot;
    }
}

/// Three perpendicular linear axes and up to two rotary ones, each under the workpiece or above the tool.
///
/// With all rotary axes at zero the tool points along `+Z` and its tip is at the positions of `x`, `y`, `z` from workpiece zero.
/// A table turns the workpiece under the tool, `p_w = T₂⁻¹·T₁⁻¹·p_m` with `Tᵢ` the turn of table joint `i` by `−θᵢ` about its
/// axis; a head turns the tip about pivots that lie by the tool length higher above it than above the spindle nose. The tool
/// axis in the workpiece frame is `o = Π R(directionᵢ, +θᵢ)·z`, from the workpiece to the tool: table joints last to first, then
/// head joints first to last.
///
/// Near a pole, where the tool lies along the joint next to the workpiece, poses still come out to 1e-12 rad but that joint's
/// angle only to about 1e-16 rad over the distance to the pole.
#[derive(Debug, Clone, PartialEq)]
pub struct FiveAxis {
    axes: Vec<Axis>,
    /// From the workpiece to the tool.
    chain: Vec<Link>,
    /// How many links of the chain are under the workpiece.
    tables: usize,
    /// Indices of `x`, `y`, `z` among the axes.
    linear: [usize; 3],
    /// One an axis.
    travel: Vec<Option<[f64; 2]>>,
}

impl FiveAxis {
    /// The machine with these `axes`, `x`, `y` and `z` among them in any order, and rotary `joints` from the bed outwards: of
    /// two table joints the first carries the second, of two head joints likewise. `tool_length_mm` from spindle nose to tip;
    /// `linear_travel_mm` of `x`, `y`, `z`, `[lowest, highest]` where limited. Other axes do not move the tool.
    ///
    /// # Errors
    /// When an axis is missing or named twice, there are more than two joints, a number is not usable, or a pair of joints
    /// cannot turn the tool in two ways.
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
        let index = |name: &str| {
            let found = axes.iter().position(|axis| axis.name == name);
            found.ok_or_else(|| undefined(format!("there is no axis `{name}`; name it among the machine's axes")))
        };
        let linear = [index("x")?, index("y")?, index("z")?];
        let mut travel = vec![None; axes.len()];
        for (axis, range) in linear.into_iter().zip(linear_travel_mm) {
            travel[axis] = checked_travel(&axes[axis].name, range)?;
        }
        let (mut tables, mut heads) = (Vec::new(), Vec::new());
        for joint in &joints {
            let axis = index(&joint.axis)?;
            if rotary_index(&joint.axis).is_none() {
                return Err(undefined(format!("rotary joint `{}`; rotary axes are called a, b or c", joint.axis)));
            }
            if tables.iter().chain(&heads).any(|link: &Link| link.axis == axis) {
                return Err(MotionError::DuplicateAxis(joint.axis.clone()));
            }
            let Some(direction) = unit(&joint.direction) else {
                return Err(undefined(format!("the direction of `{}` is zero or not finite", joint.axis)));
            };
            if joint.pivot_mm.iter().any(|v| !v.is_finite()) {
                return Err(undefined(format!("the pivot of `{}` is not finite", joint.axis)));
            }
            travel[axis] = checked_travel(&joint.axis, joint.travel_rad)?;
            match joint.mount {
                RotaryMount::Table => tables.push(Link { axis, direction, pivot: joint.pivot_mm }),
                RotaryMount::Head => {
                    heads.push(Link { axis, direction, pivot: joint.pivot_mm + Vec3::z() * tool_length_mm });
                }
            }
        }
        tables.reverse();
        let count = tables.len();
        let chain: Vec<Link> = tables.into_iter().chain(heads).collect();
        if let [outer, inner] = chain.as_slice() {
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
        }
        Ok(Self { axes, chain, tables: count, linear, travel })
    }

    /// What the table joints at `joints` make of the machine frame, seen from the workpiece.
    fn table(&self, joints: &[f64]) -> Frame {
        turned(&self.chain[..self.tables], joints)
    }

    /// What the head joints at `joints` make of the tool's frame, seen from where its tip is with them at zero.
    fn head(&self, joints: &[f64]) -> Frame {
        turned(&self.chain[self.tables..], joints)
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

    /// Sets the linear axes so that the tip comes to `tip` with the rotary axes as they stand in `joints`.
    fn slide_to(&self, tip: &Vec3, mut joints: Vec<f64>) -> Result<Vec<f64>, MotionError> {
        let (table, head) = (self.table(&joints), self.head(&joints));
        let slide = table.rotation.inverse() * (tip - table.origin) - head.origin;
        for (axis, position) in self.linear.into_iter().zip(slide.iter()) {
            if let Some([low, high]) = self.travel[axis]
                && !(low - TRAVEL_MM..=high + TRAVEL_MM).contains(position)
            {
                let name = &self.axes[axis].name;
                return Err(MotionError::Unreachable(format!(
                    "axis `{name}` would stand at {position:.3} mm, outside its travel from {low} to {high} mm"
                )));
            }
            joints[axis] = *position;
        }
        Ok(joints)
    }

    fn beyond_travel(&self, axis: usize, angle_rad: f64) -> MotionError {
        let name = &self.axes[axis].name;
        let [low, high] = self.travel[axis].unwrap_or([f64::NEG_INFINITY, f64::INFINITY]).map(f64::to_degrees);
        let angle = angle_rad.to_degrees();
        MotionError::Unreachable(format!(
            "axis `{name}` would stand at {angle:.3}°, outside its travel from {low:.3}° to {high:.3}°"
        ))
    }

    fn unreached(&self, tool: &Vec3, miss_rad: f64) -> MotionError {
        let names: Vec<String> = self.chain.iter().map(|link| format!("`{}`", self.axes[link.axis].name)).collect();
        let who = match names.as_slice() {
            [] => "a machine without rotary axes misses".to_string(),
            [only] => format!("axis {only} alone misses"),
            _ => format!("axes {} miss", names.join(" and ")),
        };
        let (x, y, z, miss) = (tool.x, tool.y, tool.z, miss_rad.to_degrees());
        MotionError::Unreachable(format!("{who} the tool axis ({x:.6}, {y:.6}, {z:.6}) by {miss:.6}°"))
    }

    /// Angle of `link` at any whole number of turns from `angle_rad`, or where `near` is when it is free; within travel.
    fn settled(&self, link: &Link, angle_rad: Option<f64>, near: &[f64]) -> Result<f64, MotionError> {
        let (near, travel) = (near[link.axis], self.travel[link.axis]);
        match (angle_rad, travel) {
            (None, None) => Ok(near),
            (None, Some([low, high])) => Ok(near.clamp(low, high)),
            (Some(angle), _) => unwound(angle, near, travel).ok_or_else(|| {
                let angle = unwound(angle, near, None).unwrap_or(angle);
                self.beyond_travel(link.axis, angle)
            }),
        }
    }

    /// `near` with the rotary axes set so that the tool points along `tool`: the nearest way within their travel, and the other
    /// where there is one.
    fn ways_to_point(&self, tool: &Vec3, near: &[f64]) -> Result<(Vec<f64>, Option<Vec<f64>>), MotionError> {
        let missed = |miss| self.unreached(tool, miss);
        match self.chain.as_slice() {
            [outer, inner] => {
                let branches = two_joints(&outer.direction, &inner.direction, tool).map_err(missed)?;
                let settled = |(outer_angle, inner_angle): Branch| -> Result<Vec<f64>, MotionError> {
                    let mut joints = near.to_vec();
                    joints[outer.axis] = self.settled(outer, outer_angle, near)?;
                    joints[inner.axis] = self.settled(inner, Some(inner_angle), near)?;
                    Ok(joints)
                };
                let moves = |joints: &[f64]| [outer.axis, inner.axis].map(|axis| (joints[axis] - near[axis]).abs());
                match branches.map(settled) {
                    [Ok(first), Ok(second)] if nearer(moves(&second), moves(&first)) => Ok((second, Some(first))),
                    [Ok(first), Ok(second)] => Ok((first, Some(second))),
                    [Ok(only), Err(_)] | [Err(_), Ok(only)] => Ok((only, None)),
                    [Err(error), Err(_)] => Err(error),
                }
            }
            [joint] => {
                let mut joints = near.to_vec();
                joints[joint.axis] = self.settled(joint, one_joint(&joint.direction, tool).map_err(missed)?, near)?;
                Ok((joints, None))
            }
            _ => match angle(tool, &Vec3::z()) {
                miss if miss > REACH_RAD => Err(missed(miss)),
                _ => Ok((near.to_vec(), None)),
            },
        }
    }
}

impl Kinematics for FiveAxis {
    fn axes(&self) -> &[Axis] {
        &self.axes
    }

    fn forward(&self, joints: &[f64]) -> Pose {
        let (table, head) = (self.table(joints), self.head(joints));
        Pose { tip: table.point(&(self.slide(joints) + head.origin)), tool: table.rotation * (head.rotation * Vec3::z()) }
    }

    /// Of the two ways to point the tool, and of all whole turns, that within travel whose larger rotary move from `near` is the
    /// smaller; with the tool at a pole the free axis stays. Directions within 1e-9 rad of what the joints reach count as reached.
    fn inverse(&self, pose: &Pose, near: &[f64]) -> Result<Vec<f64>, MotionError> {
        self.check(&pose.tip, near)?;
        let tool = unit(&pose.tool).ok_or_else(|| MotionError::Unreachable("the tool axis is zero or not finite".into()))?;
        let (nearest, other) = self.ways_to_point(&tool, near)?;
        let other = || other.and_then(|other| self.slide_to(&pose.tip, other).ok());
        self.slide_to(&pose.tip, nearest).or_else(|refusal| other().ok_or(refusal))
    }

    fn place(&self, tip: &Vec3, rotary: &[f64; 3], near: &[f64]) -> Result<Vec<f64>, MotionError> {
        self.check(tip, near)?;
        let mut joints = near.to_vec();
        for (axis, joint) in joints.iter_mut().enumerate() {
            let Some(index) = rotary_index(&self.axes[axis].name) else { continue };
            *joint = rotary[index];
            // Written so that NaN is refused as well.
            let [low, high] = self.travel[axis].unwrap_or([f64::MIN, f64::MAX]);
            if !(low - REACH_RAD..=high + REACH_RAD).contains(joint) {
                return Err(self.beyond_travel(axis, *joint));
            }
        }
        self.slide_to(tip, joints)
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

    fn turns(&self) -> bool {
        !self.chain.is_empty()
    }

    /// Of two joints, the one nearer to the workpiece has its direction as pole, either way. A lone joint keeps its angle to the
    /// tool, so there is none to come near to.
    fn pole_distance_rad(&self, joints: &[f64]) -> Option<f64> {
        let [outer, _] = self.chain.as_slice() else { return None };
        let tool = self.forward(joints).tool;
        Some(outer.direction.cross(&tool).norm().atan2(outer.direction.dot(&tool).abs()))
    }

    fn travel(&self, axis: usize) -> Option<[f64; 2]> {
        self.travel.get(axis).copied().flatten()
    }
}

/// The unit vector along `vector`, where it has a direction.
fn unit(vector: &Vec3) -> Option<Vec3> {
    // A norm that overflows leaves zeros, one of NaN leaves NaN.
    vector.try_normalize(0.0).filter(|unit| (unit.norm() - 1.0).abs() < 1e-9)
}

/// What `links`, one carrying the next, make of a frame.
fn turned(links: &[Link], joints: &[f64]) -> Frame {
    let mut frame = Frame::at_rest();
    links.iter().for_each(|link| frame.turn(link, joints[link.axis]));
    frame
}

/// Whether the moves `a` of two axes, rad, are the shorter ones: by the longer of both, then by their sum; rounding does not
/// decide.
fn nearer(a: [f64; 2], b: [f64; 2]) -> bool {
    let ([a_longest, b_longest], [a_sum, b_sum]) = ([a, b].map(|m| m[0].max(m[1])), [a, b].map(|m| m[0] + m[1]));
    if (a_longest - b_longest).abs() > REACH_RAD { a_longest < b_longest } else { a_sum < b_sum - REACH_RAD }
}

fn undefined(what: String) -> MotionError {
    MotionError::BadKinematics(what)
}

fn checked_travel(axis: &str, travel: Option<[f64; 2]>) -> Result<Option<[f64; 2]>, MotionError> {
    match travel {
        // Written so that NaN is refused as well.
        Some([low, high]) if low <= high && low < f64::INFINITY && high > f64::NEG_INFINITY => Ok(travel),
        Some([low, high]) => {
            Err(undefined(format!("the travel of `{axis}` goes from {low} to {high}; give the lower end first")))
        }
        None => Ok(None),
    }
}
