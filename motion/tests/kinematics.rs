//! Five-axis kinematics: against its definition, against hand-computed poses, round trips, and
//! along smooth motions.

use std::f64::consts::{FRAC_PI_2, PI};

use motion::{Axis, FiveAxis, Kinematics, MotionError, Pose, RotaryJoint, RotaryMount, Vec3};
use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

use RotaryMount::{Head, Table};

const TOOL_MM: f64 = 80.0;
const NO_TRAVEL: [Option<[f64; 2]>; 3] = [None; 3];

fn joint(axis: &str, mount: RotaryMount, direction: [f64; 3], pivot: [f64; 3]) -> RotaryJoint {
    RotaryJoint { axis: axis.into(), mount, direction: direction.into(), pivot_mm: pivot.into(), travel_rad: None }
}

fn within(mut joint: RotaryJoint, low: f64, high: f64) -> RotaryJoint {
    joint.travel_rad = Some([low.to_radians(), high.to_radians()]);
    joint
}

/// Axes `x`, `y`, `z` and those of the joints, in that order.
fn machine(joints: &[RotaryJoint]) -> FiveAxis {
    let names = ["x", "y", "z"].into_iter().chain(joints.iter().map(|joint| joint.axis.as_str()));
    FiveAxis::new(names.map(Axis::named).collect(), joints.to_vec(), TOOL_MM, NO_TRAVEL).unwrap()
}

const X: [f64; 3] = [1.0, 0.0, 0.0];
const Y: [f64; 3] = [0.0, 1.0, 0.0];
const Z: [f64; 3] = [0.0, 0.0, 1.0];

/// The usual machines, with pivots off every axis, and some unusual ones.
fn machines() -> Vec<(&'static str, Vec<RotaryJoint>)> {
    let back = |[x, y, z]: [f64; 3]| [-x, -y, -z];
    vec![
        ("BC table", vec![joint("b", Table, Y, [12.0, 3.0, -55.0]), joint("c", Table, Z, [7.0, -4.0, 2.0])]),
        ("AC table", vec![joint("a", Table, X, [5.0, 20.0, -60.0]), joint("c", Table, Z, [-3.0, 11.0, 0.0])]),
        ("B head, C table", vec![joint("b", Head, Y, [4.0, -2.0, 150.0]), joint("c", Table, Z, [30.0, 40.0, -10.0])]),
        ("CA head", vec![joint("c", Head, Z, [9.0, 8.0, 0.0]), joint("a", Head, X, [1.0, -6.0, 120.0])]),
        ("XYZAC trunnion", vec![joint("a", Table, back(X), [0.0, 20.0, 10.0]), joint("c", Table, back(Z), [0.0, 0.0, 0.0])]),
        ("XYZBC trunnion", vec![joint("b", Table, back(Y), [-20.0, 0.0, -10.0]), joint("c", Table, back(Z), [0.0, 0.0, 0.0])]),
        ("nutating head", vec![joint("c", Head, Z, [0.0, 2.0, 10.0]), joint("b", Head, [0.0, 3.0, 3.0], [0.0, -5.0, 90.0])]),
        (
            "skewed",
            vec![joint("b", Table, [0.1, 1.0, -0.2], [1.0, 2.0, 3.0]), joint("c", Head, [0.9, 0.3, 0.6], [3.0, 2.0, 1.0])],
        ),
        ("lone A table", vec![joint("a", Table, X, [5.0, 20.0, -60.0])]),
        ("lone C table", vec![joint("c", Table, Z, [5.0, 20.0, -60.0])]),
        ("no rotary axis", vec![]),
    ]
}

/// The definition: tables rotate by −θ and carry the workpiece, heads by +θ and carry the tool, all
/// in the machine frame.
fn defined(joints: &[RotaryJoint], positions: &[f64]) -> Pose {
    let slide = Vec3::new(positions[0], positions[1], positions[2]);
    let about = |point: Vec3, direction: Vec3, angle: f64| {
        let turn = UnitQuaternion::from_scaled_axis(direction.normalize() * angle);
        Translation3::from(point) * turn * Translation3::from(-point)
    };
    let (mut table, mut head) = (Isometry3::identity(), Isometry3::identity());
    for (joint, angle) in joints.iter().zip(&positions[3..]) {
        match joint.mount {
            Table => table *= about(joint.pivot_mm, joint.direction, -angle),
            Head => head *= about(slide + Vec3::z() * TOOL_MM + joint.pivot_mm, joint.direction, *angle),
        }
    }
    let tool_in_work = table.inverse() * head;
    Pose { tip: (tool_in_work * Point3::from(slide)).coords, tool: tool_in_work * Vec3::z() }
}

fn assert_close(actual: &Pose, expected: &Pose, tip_mm: f64, tool_rad: f64, what: &str) {
    let (tip, tool) = ((actual.tip - expected.tip).norm(), actual.angle_to(expected));
    assert!(tip <= tip_mm && tool <= tool_rad, "{what}: tip off by {tip:e} mm, tool by {tool:e} rad");
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 3000, rng_seed: RngSeed::Fixed(23), failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn forward_is_as_defined_and_inverse_undoes_it(
        slide in prop::array::uniform3(-500.0..500.0),
        angles in prop::array::uniform2(-7.0..7.0),
        offsets in prop::array::uniform2(-0.3..0.3),
        other_near in prop::array::uniform2(-20.0..20.0),
    ) {
        for (name, joints) in machines() {
            let machine = machine(&joints);
            let count = joints.len();
            let positions = [&slide[..], &angles[..count]].concat();
            let pose = machine.forward(&positions);
            assert_close(&pose, &defined(&joints, &positions), 1e-9, 1e-12, name);
            prop_assert!((pose.tool.norm() - 1.0).abs() < 1e-14);

            // From any start the pose is reproduced.
            let far = [&[1.0, 2.0, 3.0], &other_near[..count]].concat();
            let found = machine.inverse(&pose, &far).unwrap();
            assert_close(&machine.forward(&found), &pose, 1e-9, 1e-12, name);
            for (axis, near) in far.iter().enumerate().skip(3) {
                prop_assert!((found[axis] - near).abs() <= PI + 1e-9, "{name}: a turn too many");
            }

            // From a near start the positions are reproduced too, if the two branches are apart.
            let columns = machine.jacobian(&positions);
            if count == 2 && columns[3][1].cross(&columns[4][1]).norm() > 0.35 {
                let mut near = positions.clone();
                near[3] += offsets[0];
                near[4] += offsets[1];
                let found = machine.inverse(&pose, &near).unwrap();
                for (axis, (found, position)) in found.iter().zip(&positions).enumerate() {
                    let bound = if axis < 3 { 1e-9 } else { 1e-12 };
                    prop_assert!((found - position).abs() < bound, "{name}, axis {axis}: {found} for {position}");
                }
            }
        }
    }

    #[test]
    fn place_at_moves_the_tip_to_its_target(
        tip in prop::array::uniform3(-300.0..300.0),
        rotary in prop::array::uniform3(-7.0..7.0),
    ) {
        let tip = Vec3::from(tip);
        for (name, joints) in machines() {
            let machine = machine(&joints);
            let placed = machine.place(&tip, &rotary, &vec![0.0; machine.axes().len()]).unwrap();
            prop_assert!((machine.forward(&placed).tip - tip).norm() < 1e-9, "{name}");
            for (axis, position) in machine.axes().iter().zip(&placed).skip(3) {
                let index = ["a", "b", "c"].iter().position(|name| *name == axis.name).unwrap();
                prop_assert_eq!(*position, rotary[index]);
            }
        }
    }

    #[test]
    fn jacobian_agrees_with_differences(slide in prop::array::uniform3(-100.0..100.0), angles in prop::array::uniform2(-4.0..4.0)) {
        for (name, joints) in machines() {
            let machine = machine(&joints);
            let positions = [&slide[..], &angles[..joints.len()]].concat();
            let h = 1e-5;
            for (axis, [tip, tool]) in machine.jacobian(&positions).into_iter().enumerate() {
                let at = |step: f64| {
                    let mut moved = positions.clone();
                    moved[axis] += step;
                    machine.forward(&moved)
                };
                let (before, after) = (at(-h), at(h));
                prop_assert!(((after.tip - before.tip) / (2.0 * h) - tip).norm() < 1e-6, "{name}, tip by axis {axis}");
                prop_assert!(((after.tool - before.tool) / (2.0 * h) - tool).norm() < 1e-9, "{name}, tool by axis {axis}");
            }
        }
    }

    #[test]
    fn axes_may_come_in_any_order(angles in prop::array::uniform2(-3.0..3.0)) {
        let (_, joints) = machines().swap_remove(0);
        let names = ["c", "z", "u", "x", "b", "y"];
        let shuffled = FiveAxis::new(names.map(Axis::named).to_vec(), joints.clone(), TOOL_MM, NO_TRAVEL).unwrap();
        let positions = [angles[1], 3.0, 17.0, 1.0, angles[0], 2.0];
        let plain = machine(&joints).forward(&[1.0, 2.0, 3.0, angles[0], angles[1]]);
        prop_assert_eq!(shuffled.forward(&positions), plain);
        prop_assert_eq!(shuffled.jacobian(&positions)[2], [Vec3::zeros(); 2]);
        let found = shuffled.inverse(&plain, &positions).unwrap();
        prop_assert_eq!(found[2], 17.0);
        assert_close(&shuffled.forward(&found), &plain, 1e-9, 1e-12, "shuffled");
    }
}

#[test]
fn at_zero_the_tip_is_where_the_linear_axes_are() {
    for (name, joints) in machines() {
        let mut positions = vec![10.0, -20.0, 30.0];
        positions.resize(3 + joints.len(), 0.0);
        assert_close(&machine(&joints).forward(&positions), &Pose::upright(Vec3::new(10.0, -20.0, 30.0)), 1e-13, 0.0, name);
    }
}

#[test]
fn tool_axes_are_the_textbook_ones() {
    let (ac, bc) = (machine(&machines()[1].1), machine(&machines()[0].1));
    for i in 0..50 {
        let (tilt, c) = (0.13 * f64::from(i) - 3.0, 0.29 * f64::from(i) - 7.0);
        let of_ac = Vec3::new(c.sin() * tilt.sin(), -c.cos() * tilt.sin(), tilt.cos());
        let of_bc = Vec3::new(c.cos() * tilt.sin(), c.sin() * tilt.sin(), tilt.cos());
        assert!((ac.forward(&[1.0, 2.0, 3.0, tilt, c]).tool - of_ac).norm() < 1e-15);
        assert!((bc.forward(&[1.0, 2.0, 3.0, tilt, c]).tool - of_bc).norm() < 1e-15);
    }
    let level = ac.forward(&[0.0, 0.0, 0.0, FRAC_PI_2, 0.0]).tool;
    assert!((level + Vec3::y()).norm() < 1e-15);
}

#[test]
fn hand_computed_poses() {
    // Seen from the workpiece A at +90° rotates +Z to −Y: a tip 30 mm above the pivot moves to 30
    // mm in −Y of it.
    let a = machine(&[joint("a", Table, X, [0.0, 0.0, -20.0]), joint("c", Table, Z, [0.0; 3])]);
    let expected = Pose { tip: Vec3::new(5.0, -30.0, -20.0), tool: -Vec3::y() };
    assert_close(&a.forward(&[5.0, 0.0, 10.0, FRAC_PI_2, 0.0]), &expected, 1e-13, 1e-15, "A");
    // Another 90° of C rotate −Y to +X and +X to +Y.
    let expected = Pose { tip: Vec3::new(30.0, 5.0, -20.0), tool: Vec3::x() };
    assert_close(&a.forward(&[5.0, 0.0, 10.0, FRAC_PI_2, FRAC_PI_2]), &expected, 1e-13, 1e-15, "A and C");

    // A head with its pivot 50 mm above the nose swings a tip 130 mm below it: at 90° the tool lies along +X, tip to −X.
    let b = machine(&[joint("b", Head, Y, [0.0, 0.0, 50.0]), joint("c", Table, Z, [100.0, 0.0, 0.0])]);
    let expected = Pose { tip: Vec3::new(-130.0, 0.0, 130.0), tool: Vec3::x() };
    assert_close(&b.forward(&[0.0, 0.0, 0.0, FRAC_PI_2, 0.0]), &expected, 1e-12, 1e-15, "B");
    // C rotates the workpiece about (100, 0): the tip 230 mm in −X of it moves to −Y of it.
    let expected = Pose { tip: Vec3::new(100.0, -230.0, 130.0), tool: Vec3::y() };
    assert_close(&b.forward(&[0.0, 0.0, 0.0, FRAC_PI_2, FRAC_PI_2]), &expected, 1e-12, 1e-15, "B and C");
}

/// The trunnions of LinuxCNC's chapter on five-axis kinematics: the tilting axis is offset from the
/// rotary one by `(d, dz)`, workpiece zero is on the rotary axis, and every rotary axis has the
/// unconventional sign, LinuxCNC's default.
#[test]
fn trunnions_are_those_of_linuxcnc() {
    let (d, dz) = (20.0, 10.0);
    let ac = machine(&[joint("a", Table, [-1.0, 0.0, 0.0], [0.0, d, dz]), joint("c", Table, [0.0, 0.0, -1.0], [0.0; 3])]);
    let bc = machine(&[joint("b", Table, [0.0, -1.0, 0.0], [d, 0.0, dz]), joint("c", Table, [0.0, 0.0, -1.0], [0.0; 3])]);
    for i in 0..200 {
        let i = f64::from(i);
        let (x, y, z, tilt, c) = (40.0 * i.sin(), 30.0 * i.cos(), 20.0 * (2.0 * i).sin(), (0.7 * i).sin() * 2.0, 0.37 * i - 30.0);
        let ((s, k), (sc, cc)) = (tilt.sin_cos(), c.sin_cos());
        // R(C)·T(D)·R(tilt)·T(−D)·P, written out.
        let (u, v) = (k * (y - d) + s * (z - dz) + d, -s * (y - d) + k * (z - dz) + dz);
        let expected = Pose { tip: Vec3::new(cc * x + sc * u, -sc * x + cc * u, v), tool: Vec3::new(sc * s, cc * s, k) };
        assert_close(&ac.forward(&[x, y, z, tilt, c]), &expected, 1e-12, 1e-14, "XYZAC");
        let (u, v) = (k * (x - d) - s * (z - dz) + d, s * (x - d) + k * (z - dz) + dz);
        let expected = Pose { tip: Vec3::new(cc * u + sc * y, -sc * u + cc * y, v), tool: Vec3::new(-cc * s, sc * s, k) };
        assert_close(&bc.forward(&[x, y, z, tilt, c]), &expected, 1e-12, 1e-14, "XYZBC");
    }
}

#[test]
fn angles_follow_a_smooth_motion_over_many_turns() {
    for (name, joints) in machines().into_iter().filter(|(name, joints)| joints.len() == 2 && *name != "skewed") {
        let machine = machine(&joints);
        // The joint next to the workpiece rotates continuously, the other one tilts.
        let outer = machine.axes().iter().position(|axis| axis.name == "c").unwrap();
        let mut near: Option<Vec<f64>> = None;
        for k in 0..=5000 {
            let t = f64::from(k) / 5000.0;
            let mut truth =
                vec![100.0 * t, 50.0 * (9.0 * t).sin(), 5.0, 0.5 + 0.4 * (11.0 * t).sin(), 0.5 + 0.4 * (11.0 * t).sin()];
            truth[outer] = 1.0 + 8.0 * PI * t;
            let from = near.unwrap_or_else(|| truth.clone());
            let found = machine.inverse(&machine.forward(&truth), &from).unwrap();
            for (found, truth) in found.iter().zip(&truth) {
                assert!((found - truth).abs() < 1e-9, "{name} at {t}: {found} for {truth}");
            }
            near = Some(found);
        }
    }
}

#[test]
fn a_motion_through_the_pole_keeps_its_turning_axis() {
    let machine = machine(&machines()[1].1);
    let mut near = vec![0.0, 0.0, 0.0, -0.5, 0.7];
    for k in -500..=500 {
        let truth = [1.0, 2.0, 3.0, f64::from(k) * 1e-3, 0.7];
        near = machine.inverse(&machine.forward(&truth), &near).unwrap();
        assert!((near[3] - truth[3]).abs() < 1e-12 && (near[4] - 0.7).abs() < 1e-9, "{near:?}");
    }
    // At the pole any angle of C is valid, so it stays. The tip is still exact.
    let upright = Pose::upright(Vec3::new(10.0, 20.0, 30.0));
    let found = machine.inverse(&upright, &[0.0, 0.0, 0.0, 0.2, 123.0]).unwrap();
    assert_eq!((found[3], found[4]), (0.0, 123.0));
    assert_close(&machine.forward(&found), &upright, 1e-9, 1e-12, "upright");
    let down = Pose { tip: Vec3::zeros(), tool: -Vec3::z() };
    let found = machine.inverse(&down, &[0.0, 0.0, 0.0, -3.0, 1.0]).unwrap();
    assert!((found[3] + PI).abs() < 1e-12 && found[4] == 1.0);
}

#[test]
fn poses_next_to_a_pole_keep_their_digits() {
    for (name, joints) in machines().into_iter().filter(|(_, joints)| joints.len() == 2) {
        let machine = machine(&joints);
        for exponent in 1..=16 {
            let tilt = 10_f64.powi(-exponent);
            for turn in [-2.5, -0.4, 1.1, 3.0] {
                let (sin, cos) = f64::sin_cos(turn);
                let tool = Vec3::new(cos * tilt.sin(), sin * tilt.sin(), tilt.cos());
                let pose = Pose { tip: Vec3::new(1.0, 2.0, 3.0), tool };
                let found = match machine.inverse(&pose, &[0.0; 5]) {
                    Ok(found) => found,
                    Err(_) if name == "skewed" => continue,
                    Err(error) => panic!("{name} at {tilt}: {error}"),
                };
                assert_close(&machine.forward(&found), &pose, 1e-9, 2e-12, name);
            }
        }
    }
}

#[test]
fn distance_to_the_pole_is_the_tilt() {
    let rotary = machine(&machines()[0].1);
    for (tilt, distance) in [(0.3, 0.3), (-0.3, 0.3), (PI - 0.2, 0.2), (FRAC_PI_2, FRAC_PI_2), (1e-9, 1e-9)] {
        let found = rotary.pole_distance_rad(&rotary.forward(&[1.0, 2.0, 3.0, tilt, 2.0]).tool).unwrap();
        assert!((found - distance).abs() < 1e-15, "{found} for {distance}");
    }
    assert!(rotary.has_rotary_axes());
    let lone = machine(&machines()[8].1);
    assert!(lone.has_rotary_axes() && lone.pole_distance_rad(&Vec3::z()).is_none());
    let none = machine(&[]);
    assert!(!none.has_rotary_axes() && none.pole_distance_rad(&Vec3::z()).is_none());
}

fn refusal(result: Result<Vec<f64>, MotionError>) -> String {
    match result {
        Err(MotionError::Unreachable(what)) => what,
        other => panic!("not refused: {other:?}"),
    }
}

#[test]
fn travel_is_kept_and_named() {
    let joints =
        vec![within(joint("a", Table, X, [0.0; 3]), -30.0, 100.0), within(joint("c", Table, Z, [0.0; 3]), -200.0, 200.0)];
    let axes = ["x", "y", "z", "a", "c"].map(Axis::named).to_vec();
    let machine = FiveAxis::new(axes, joints, TOOL_MM, [None, None, Some([-50.0, 80.0])]).unwrap();
    assert_eq!(machine.travel(2), Some([-50.0, 80.0]));
    assert_eq!(machine.travel(0), None);
    assert!((machine.travel(3).unwrap()[1].to_degrees() - 100.0).abs() < 1e-12);

    // The branch nearest to the present positions would be A −60°, out of travel: the other one is
    // taken.
    let tool = |a: f64, c: f64| Vec3::new(c.sin() * a.sin(), -c.cos() * a.sin(), a.cos());
    let pose = Pose { tip: Vec3::zeros(), tool: tool(-1.0, 0.1) };
    let found = machine.inverse(&pose, &[0.0, 0.0, 0.0, -0.5, 0.1]).unwrap();
    assert!((found[3] - 1.0).abs() < 1e-12 && (found[4] - (0.1 - PI)).abs().min((found[4] - (0.1 + PI)).abs()) < 1e-12);
    // C runs to its end, then must unwind.
    let near = [0.0, 0.0, 0.0, 1.0, 199_f64.to_radians()];
    let on = machine.inverse(&Pose { tip: Vec3::zeros(), tool: tool(1.0, 199.9_f64.to_radians()) }, &near).unwrap();
    assert!((on[4].to_degrees() - 199.9).abs() < 1e-9);
    let back = machine.inverse(&Pose { tip: Vec3::zeros(), tool: tool(1.0, 200.1_f64.to_radians()) }, &near).unwrap();
    assert!((back[4].to_degrees() + 159.9).abs() < 1e-9);

    let down = Pose { tip: Vec3::zeros(), tool: tool(2.0, 0.0) };
    let what = refusal(machine.inverse(&down, &[0.0; 5]));
    assert!(what.contains("axis `a` would stand at 114.592°") && what.contains("-30.000° to 100.000°"), "{what}");
    let what = refusal(machine.inverse(&Pose::upright(Vec3::new(0.0, 0.0, 90.0)), &[0.0; 5]));
    assert_eq!(what, "axis `z` would stand at 90.000 mm, outside its travel from -50 to 80 mm");
    assert_eq!(refusal(machine.place(&Vec3::new(0.0, 0.0, 90.0), &[0.0; 3], &[0.0; 5])), what);
    let what = refusal(machine.place(&Vec3::zeros(), &[0.0, 0.0, 4.0], &[0.0; 5]));
    assert!(what.contains("axis `c` would stand at 229.183°"), "{what}");
    // A missing B is ignored. A free rotary axis stays within its travel.
    assert!(machine.place(&Vec3::zeros(), &[0.0, 99.0, 0.0], &[0.0; 5]).is_ok());
    let upright = machine.inverse(&Pose::upright(Vec3::zeros()), &[0.0, 0.0, 0.0, 0.0, 9.0]).unwrap();
    assert!((upright[4].to_degrees() - 200.0).abs() < 1e-9);
}

#[test]
fn linear_travel_can_force_the_other_solution() {
    let joints = vec![joint("b", Head, Y, [0.0; 3]), joint("c", Table, Z, [0.0; 3])];
    let axes = ["x", "y", "z", "b", "c"].map(Axis::named).to_vec();
    let machine = FiveAxis::new(axes, joints, TOOL_MM, [Some([0.0, 500.0]), None, None]).unwrap();
    let positions = [100.0, 0.0, 0.0, 0.5, 0.0];
    let pose = machine.forward(&positions);
    let found = machine.inverse(&pose, &[0.0, 0.0, 0.0, -0.5, 3.0]).unwrap();
    assert!(found.iter().zip(&positions).all(|(found, position)| (found - position).abs() < 1e-12), "{found:?}");
    let what = refusal(machine.inverse(&Pose { tip: Vec3::new(-900.0, 0.0, 0.0), ..pose }, &[0.0, 0.0, 0.0, 0.5, 0.0]));
    assert!(what.contains("axis `x` would stand at -"), "{what}");
}

#[test]
fn directions_out_of_reach_are_refused() {
    let tilted = Pose { tip: Vec3::zeros(), tool: Vec3::new(0.6, 0.0, 0.8) };
    let what = refusal(machine(&[joint("a", Table, X, [0.0; 3])]).inverse(&tilted, &[0.0; 4]));
    assert!(what.contains("axis `a` alone misses the tool axis (0.600000, 0.000000, 0.800000) by 36.869898°"), "{what}");
    let what = refusal(machine(&[]).inverse(&tilted, &[0.0; 3]));
    assert!(what.contains("without rotary axes") && what.contains("36.869898°"), "{what}");
    let down = Pose { tip: Vec3::zeros(), tool: -Vec3::z() };
    let what = refusal(machine(&machines()[6].1).inverse(&down, &[0.0; 5]));
    assert!(what.contains("axes `c` and `b` miss") && what.contains("90.000000°"), "{what}");
    let what = refusal(machine(&[]).inverse(&Pose { tip: Vec3::zeros(), tool: Vec3::zeros() }, &[0.0; 3]));
    assert!(what.contains("tool axis is zero"), "{what}");
    refusal(machine(&[]).inverse(&Pose::upright(Vec3::new(f64::NAN, 0.0, 0.0)), &[0.0; 3]));
    refusal(machine(&machines()[0].1).place(&Vec3::zeros(), &[0.0, f64::NAN, 0.0], &[0.0; 5]));
    assert!(matches!(machine(&[]).inverse(&Pose::upright(Vec3::zeros()), &[0.0; 2]), Err(MotionError::Mismatch(_))));
}

#[test]
fn impossible_machines_are_refused() {
    let build = |names: &[&str], joints: Vec<RotaryJoint>, length: f64, travel| {
        FiveAxis::new(names.iter().map(|name| Axis::named(name)).collect(), joints, length, travel).unwrap_err().to_string()
    };
    let all = ["x", "y", "z", "a", "b", "c"];
    let at = |axis: &str, direction| joint(axis, Table, direction, [0.0; 3]);
    let with = |joints| build(&all, joints, TOOL_MM, NO_TRAVEL);
    assert!(with(vec![at("b", Y), at("c", [0.0, -1.0, 0.0])]).contains("parallel directions"));
    let swapped = with(vec![at("c", Z), at("b", Y)]);
    assert!(swapped.contains("`c` turns about the tool itself") && swapped.contains("swap the two"), "{swapped}");
    assert!(with(vec![at("a", X), at("b", Y), at("c", Z)]).contains("3 rotary joints"));
    assert!(with(vec![at("a", [0.0; 3])]).contains("direction of `a`"));
    assert!(with(vec![at("a", [f64::NAN, 0.0, 0.0])]).contains("direction of `a`"));
    assert!(with(vec![joint("a", Head, X, [f64::INFINITY, 0.0, 0.0])]).contains("pivot of `a`"));
    assert!(with(vec![at("a", X), at("a", Y)]).contains("`a` is named twice"));
    assert!(with(vec![at("x", X)]).contains("rotary axes are called"));
    assert!(with(vec![within(at("a", X), 10.0, -10.0)]).contains("travel of `a`"));
    assert!(build(&["x", "y", "z", "c"], vec![at("b", Y), at("c", Z)], TOOL_MM, NO_TRAVEL).contains("no axis `b`"));
    assert!(build(&["x", "z"], vec![], TOOL_MM, NO_TRAVEL).contains("no axis `y`"));
    assert!(build(&["x", "y", "z", "x"], vec![], TOOL_MM, NO_TRAVEL).contains("`x` is named twice"));
    assert!(build(&all, vec![], -1.0, NO_TRAVEL).contains("tool_length_mm is -1"));
    assert!(build(&all, vec![], 0.0, [Some([0.0, f64::NAN]), None, None]).contains("travel of `x`"));
}
