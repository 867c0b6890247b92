//! Setpoint tables for controls that stream buffers: one row of axis positions for each interval, with or without
//! velocities (PVT).

use gcode::{Fixed, Move, MoveKind, Shiftable};
use motion::{Axis, AxisKind, Trajectory, Vec6, cubic};
use serde::Serialize;

use crate::error::{Error, Result};
use crate::input::Input;
use crate::part::Part;
use crate::units::in_programs;

/// Largest interpolation error between setpoints, mm; the same as for the lines of programs.
pub const TOLERANCE_MM: f64 = 2e-4;
/// Lever at which the error of a rotary axis counts, mm.
const LEVER_MM: f64 = 100.0;

/// Content of a setpoint table.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum SetpointKind {
    /// A CSV table of time and axis positions instead of a program, for controls that interpolate between rows in straight lines
    Table,
    /// A CSV table of time, axis positions and velocities, for controls that interpolate by cubics (PVT)
    Pvt,
}

/// Settings of a setpoint table.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SetpointSettings {
    /// Content of the table.
    pub kind: SetpointKind,
    /// Time between setpoints, s.
    pub interval_s: f64,
    /// Decimals of positions in mm and degrees.
    pub decimals: usize,
}

/// Properties of a written setpoint table.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SetpointsWritten {
    /// Content of the table.
    pub kind: SetpointKind,
    /// Number of setpoints.
    pub count: usize,
    /// Time between setpoints, s.
    pub interval_s: f64,
    /// Largest interpolation error of an axis after rounding, mm; rotary axes at a lever of 100 mm.
    pub off_mm: f64,
    /// An interval that keeps the error within [`TOLERANCE_MM`], s; `None` where this interval does, or where none is
    /// found.
    pub finer_s: Option<f64>,
}

/// Text of a setpoint table of `reference`, the compensated path of `path`, with its properties.
///
/// # Errors
/// When the program contains a block that setpoints cannot represent.
pub fn write_setpoints(path: &Input, reference: &Trajectory, settings: &SetpointSettings) -> Result<(String, SetpointsWritten)> {
    if let Some(part) = path.part() {
        check_moves(part)?;
    }
    let wanted = programmed(path, reference)?;
    let sampled = Sampled::of(&wanted, settings);
    let off_mm = sampled.off_mm(&wanted);
    let finer_s = if off_mm > TOLERANCE_MM { finer_s(&wanted, settings) } else { None };
    let written =
        SetpointsWritten { kind: settings.kind, count: sampled.count(), interval_s: settings.interval_s, off_mm, finer_s };
    Ok((sampled.text(path.name(), settings.decimals), written))
}

/// An interval of whole sampling periods that keeps the interpolation error within the tolerance, s.
fn finer_s(wanted: &Trajectory, settings: &SetpointSettings) -> Option<f64> {
    let period_s = wanted.period_s();
    let most = (settings.interval_s / period_s).ceil() as u32;
    let fewer =
        std::iter::successors(Some(most.saturating_sub(1)), |periods| Some(periods / 2)).take_while(|periods| *periods > 0);
    let holds = |interval_s: &f64| {
        let finer = SetpointSettings { interval_s: *interval_s, ..*settings };
        Sampled::of(wanted, &finer).off_mm(wanted) <= TOLERANCE_MM
    };
    fewer.map(|periods| f64::from(periods) * period_s).find(holds)
}

/// Refuses programs with blocks that affect the part and that setpoints cannot represent.
fn check_moves(part: &Part) -> Result<()> {
    if part.placement.several() {
        return Err(Error::SetpointsInSeveralSystems { name: part.name.clone() });
    }
    let why = |of: &Move| match (of.shiftable, of.kind) {
        (Shiftable::No(Fixed::OptionalBlock), _) => Some("may be skipped by a switch"),
        (Shiftable::No(Fixed::RunTime), _) => Some("depends on what only the running program knows"),
        (Shiftable::No(Fixed::CutterCompensation), _) => Some("is shifted by the control's cutter compensation"),
        (_, MoveKind::Thread | MoveKind::Probe) => Some("goes by spindle or probe"),
        (_, MoveKind::Cycle(_)) => Some("is a canned cycle"),
        (_, MoveKind::Home) | (Shiftable::No(Fixed::MachineCoordinates), _) => {
            Some("leads to a place that only the control knows")
        }
        _ if !part.plan.desired.kinematics().has_rotary_axes() && rotates(of) => {
            Some("turns axes that the machine description does not hold")
        }
        _ => None,
    };
    match part.toolpath.moves.iter().find_map(|of| Some((of.block as usize + 1, why(of)?))) {
        Some((line, why)) => Err(Error::SetpointsCannotHold { name: part.name.clone(), line, why }),
        None => Ok(()),
    }
}

fn rotates(of: &Move) -> bool {
    of.start.nominal_rotary_rad() != of.end.nominal_rotary_rad()
}

/// Axis positions in program coordinates: the work offset is subtracted.
fn programmed(path: &Input, reference: &Trajectory) -> Result<Trajectory> {
    let Some(part) = path.part() else { return Ok(reference.clone()) };
    let commanded = part.commanded(reference)?;
    let offset = part.toolpath.moves.iter().find(|of| of.is_feed()).map_or_else(Vec6::zeros, |of| part.offset_of(of));
    let columns = commanded.axes().iter().zip(commanded.columns()).map(|(axis, column)| {
        let off = axis.slot().map_or(0.0, |slot| offset[slot]);
        column.iter().map(|at| at - off).collect()
    });
    Ok(commanded.with_columns(columns.collect())?)
}

/// Setpoints as written: positions and velocities, mm and mm/s, degrees and degrees/s; rounded.
struct Sampled<'a> {
    axes: &'a [Axis],
    kind: SetpointKind,
    interval_s: f64,
    positions: Vec<Vec<f64>>,
    velocities: Vec<Vec<f64>>,
}

impl<'a> Sampled<'a> {
    fn of(wanted: &'a Trajectory, settings: &SetpointSettings) -> Self {
        let SetpointSettings { kind, interval_s, decimals } = *settings;
        let (axes, period_s) = (wanted.axes(), wanted.period_s());
        // The last setpoint is at the end of the path, or within one interval after it at the same position.
        let count = (wanted.duration_s() / interval_s - 1e-9).ceil() as usize + 1;
        let unit = 10.0_f64.powi(i32::try_from(decimals).unwrap_or(i32::MAX));
        // Adding zero turns −0 into 0.
        let rounded = |value: f64| (value * unit).round() / unit + 0.0;
        let sampled = |of: &dyn Fn((f64, f64)) -> f64| -> Vec<Vec<f64>> {
            let column = |(axis, column): (&Axis, &Vec<f64>)| {
                let at = |row: usize| of(cubic(column, row as f64 * interval_s / period_s));
                (0..count).map(|row| rounded(at(row) * in_programs(axis.kind).0)).collect()
            };
            axes.iter().zip(wanted.columns()).map(column).collect()
        };
        let mut velocities = if kind == SetpointKind::Pvt { sampled(&|(_, slope)| slope / period_s) } else { Vec::new() };
        // A control stops at its last setpoint.
        velocities.iter_mut().filter_map(|column| column.last_mut()).for_each(|last| *last = 0.0);
        Self { axes, kind, interval_s, positions: sampled(&|(position, _)| position), velocities }
    }

    fn count(&self) -> usize {
        self.positions.first().map_or(0, Vec::len)
    }

    /// Position of an axis between setpoints, interpolated like the control does.
    fn between(&self, axis: usize, time_s: f64) -> f64 {
        let positions = &self.positions[axis];
        let row = ((time_s / self.interval_s) as usize).min(positions.len().saturating_sub(2));
        let (from, to) = (positions[row], positions[(row + 1).min(positions.len() - 1)]);
        let u = time_s / self.interval_s - row as f64;
        let Some(velocities) = self.velocities.get(axis) else { return from + (to - from) * u };
        let tangent = |row: usize| velocities[row.min(velocities.len() - 1)] * self.interval_s;
        let (leaving, arriving) = (tangent(row), tangent(row + 1));
        let (square, cube) = (3.0 * (to - from) - 2.0 * leaving - arriving, leaving + arriving - 2.0 * (to - from));
        from + u * (leaving + u * (square + u * cube))
    }

    /// Largest interpolation error of an axis at the samples of `wanted`, mm; rotary axes at a lever.
    fn off_mm(&self, wanted: &Trajectory) -> f64 {
        let columns = self.axes.iter().zip(wanted.columns()).enumerate();
        let of = |(index, (axis, column)): (usize, (&Axis, &Vec<f64>))| {
            let lever = if axis.kind == AxisKind::Rotary { LEVER_MM } else { 1.0 };
            let off = |(k, at): (usize, &f64)| {
                (self.between(index, k as f64 * wanted.period_s()) / in_programs(axis.kind).0 - at).abs()
            };
            lever * column.iter().enumerate().map(off).fold(0.0, f64::max)
        };
        columns.map(of).fold(0.0, f64::max)
    }

    /// Text of the file: a comment header, the column names, the setpoints.
    fn text(&self, name: &str, decimals: usize) -> String {
        let names = |ending: &str| {
            self.axes
                .iter()
                .map(move |axis| format!(",{axis}{}", ending.replace('#', in_programs(axis.kind).1)))
                .collect::<String>()
        };
        let (between, velocity) = match self.kind {
            SetpointKind::Table => ("in straight lines", String::new()),
            SetpointKind::Pvt => ("by the cubic through positions and velocities at both ends", names("_vel_#_s")),
        };
        let mut text = format!(
            "# compensated path of {name}: axis positions in the coordinates and with the signs of the program's words\n\
             # motion alone: what else a program commands (spindle, coolant, tools) is not in it\n\
             # a row every {:.6} ms, between rows {between}\nt_s{}{velocity}\n",
            self.interval_s * 1e3,
            names("_#"),
        );
        for row in 0..self.count() {
            let values = self.positions.iter().chain(&self.velocities).map(|column| format!(",{:.decimals$}", column[row]));
            text.push_str(&format!("{:.9}{}\n", row as f64 * self.interval_s, values.collect::<String>()));
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use motion::{Cartesian, DesiredPath};

    /// A linear and a rotary axis between two standstills, one sample every 2 ms.
    fn path() -> Input {
        let ease = |k: i32| {
            let share = f64::from(k.clamp(0, 501)) / 501.0;
            share - (std::f64::consts::TAU * share).sin() / std::f64::consts::TAU
        };
        let axes = ["x", "a"].map(Axis::named).to_vec();
        let columns = [30.0, -0.2].map(|travel| (-5..=506).map(|k| travel * ease(k)).collect());
        let trajectory = Trajectory::new(0.002, axes.clone(), columns.to_vec()).unwrap();
        let desired = DesiredPath::new(trajectory, std::sync::Arc::new(Cartesian::new(axes))).unwrap();
        Input::path("path", desired, None)
    }

    fn write(kind: SetpointKind, interval_ms: f64, decimals: usize) -> (SetpointsWritten, String, Trajectory) {
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path().join("rows.csv");
        let path = path();
        let settings = SetpointSettings { kind, interval_s: interval_ms * 1e-3, decimals };
        let (text, written) = write_setpoints(&path, path.trajectory(), &settings).unwrap();
        std::fs::write(&out, &text).unwrap();
        let (read, _) = datasets::read_reference(&out, &datasets::ReadOptions::default()).unwrap();
        (written, text, read)
    }

    #[test]
    fn a_table_reads_back_as_the_path() {
        let (written, text, read) = write(SetpointKind::Table, 2.0, 6);
        let path = path();
        assert!(text.contains("\nt_s,x_mm,a_deg\n0.000000000,0.000000,0.000000\n"), "{text}");
        assert_eq!((written.count, read.len(), read.axes()), (512, 512, path.trajectory().axes()));
        assert!((read.period_s() - 0.002).abs() < 1e-12);
        for (found, wanted) in read.columns().iter().flatten().zip(path.trajectory().columns().iter().flatten()) {
            assert!((found - wanted).abs() < 6e-7, "{found} {wanted}");
        }
        assert!(written.off_mm < 2e-6 && written.finer_s.is_none());
    }

    #[test]
    fn velocities_keep_the_path_between_distant_setpoints() {
        // 1.022 s are no multiple of 20 ms: the last setpoint lies after the end, at standstill.
        let (written, text, read) = write(SetpointKind::Pvt, 20.0, 6);
        assert!(text.contains("\nt_s,x_mm,a_deg,x_vel_mm_s,a_vel_deg_s\n"), "{text}");
        assert!(text.ends_with(",30.000000,-11.459156,0.000000,0.000000\n"), "{text}");
        assert_eq!((written.count, read.len()), (53, 53));
        assert!(written.off_mm < TOLERANCE_MM && written.finer_s.is_none(), "{written:?}");
        // Linear interpolation needs a shorter interval.
        let (written, ..) = write(SetpointKind::Table, 20.0, 6);
        assert!(written.off_mm > 10.0 * TOLERANCE_MM, "{written:?}");
        assert!(write(SetpointKind::Table, written.finer_s.unwrap() * 1e3, 6).0.finer_s.is_none());
    }

    #[test]
    fn too_few_decimals_are_distinguished_from_too_few_setpoints() {
        let (written, ..) = write(SetpointKind::Pvt, 4.0, 2);
        assert!(written.off_mm > TOLERANCE_MM && written.finer_s.is_none(), "{written:?}");
    }
}
