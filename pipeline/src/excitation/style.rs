//! How the programs of an excitation are written: in the words of a control, under a work offset, with a header for the operator.

use gcode::{Dialect, Options, format_number};
use machine::WORK_SYSTEMS;
use motion::{Axis, MotionError, Trajectory};

use crate::error::ProgramFault;
use crate::refit::{RefitSettings, TimeEncoding};
use crate::setup::Setup;
use crate::units::in_programs;

/// Feed of the descent to the first point, mm/min: slow enough to be stopped by hand.
const PLUNGE_MM_MIN: f64 = 600.0;
/// Dwell before and after the motion, s, so that every axis is at standstill when the run begins.
pub(super) const WAIT_S: f64 = 0.5;
/// Path tolerance on LinuxCNC where the machine file states none, mm: that of the built-in profile.
const PATH_TOLERANCE_MM: f64 = 0.001;
/// Default longest time between points on LinuxCNC, s. Under its path tolerance, points every 8 ms, the spacing of
/// compensated programs, extend a run of 7 s to 10.1 s; points every 4 ms extend it to 7.6 s (`excite --controller
/// linuxcnc`, `simulate 01-full.nc`).
const LINUXCNC_SPACING_S: f64 = 0.004;
/// Decimals of feeds and of inverse times.
pub(super) const FEED_DECIMALS: usize = 4;
/// Number of the first program on controls with program numbers: below the range that machine builders protect.
const FIRST_NUMBER: usize = 7001;

/// Output style of an excitation program.
#[derive(Debug, Clone)]
pub struct Style {
    /// Dialect; `None` uses words that most controls share.
    pub dialect: Option<Dialect>,
    /// Time encoding of lines; `Keep` writes a feed per minute on every line.
    pub encoding: TimeEncoding,
    /// Decimals of coordinates, mm and degrees.
    pub decimals: usize,
    /// Longest time between points, s.
    pub spacing_s: f64,
    /// Path tolerance of `G64 P…`, mm; `None` where the control has none.
    pub path_tolerance_mm: Option<f64>,
    /// Name of the machine.
    pub machine: String,
    /// Work offset under which the programs run, machine minus program coordinates, mm: that of G54 in the machine file, else zero.
    pub origin_mm: [f64; 3],
    /// Feed of the descent to the first point, mm/min.
    pub(super) plunge_mm_min: f64,
}

impl Style {
    /// Style for the control of `setup`, from `settings`; `spacing_s` replaces the time between points. Inverse time
    /// becomes a feed on every line where the dialect is not stated.
    #[must_use]
    pub fn of(settings: &RefitSettings, spacing_s: Option<f64>, setup: &Setup) -> Self {
        let dialect = setup.dialect;
        let encoding = match settings.encoding {
            TimeEncoding::G93 if dialect.is_some() => TimeEncoding::G93,
            _ => TimeEncoding::G94,
        };
        let of_linuxcnc = dialect == Some(Dialect::LinuxCnc);
        let axes = setup.kinematics.axes().iter().zip(&setup.limits.axes);
        let z_mm_s = axes.filter(|(axis, _)| axis.name == "z").map(|(_, limits)| limits.velocity).next().unwrap_or(f64::INFINITY);
        Self {
            dialect,
            encoding,
            decimals: settings.decimals,
            spacing_s: spacing_s.unwrap_or(settings.spacing_s.min(if of_linuxcnc { LINUXCNC_SPACING_S } else { f64::INFINITY })),
            path_tolerance_mm: of_linuxcnc.then(|| settings.path_tolerance_mm.unwrap_or(PATH_TOLERANCE_MM)),
            machine: setup.name.clone(),
            origin_mm: setup.work_offsets.get(WORK_SYSTEMS[0]).copied().unwrap_or_default(),
            plunge_mm_min: PLUNGE_MM_MIN.min(0.5 * 60.0 * z_mm_s),
        }
    }

    /// Dwell block. Without a dialect the unit is seconds: a control that counts milliseconds then dwells too briefly
    /// rather than for minutes.
    pub(super) fn dwell(&self, seconds: f64) -> Result<String, ProgramFault> {
        Ok(match self.dialect {
            Some(Dialect::Fanuc) => format!("G4 P{:.0}", seconds * 1e3),
            Some(Dialect::Sinumerik) => format!("G4 F{}", format_number(seconds, 4)?),
            _ => format!("G4 P{}", format_number(seconds, 4)?),
        })
    }

    /// Codes that the program begins with.
    pub(super) fn first_block(&self) -> Result<String, ProgramFault> {
        let mut block = match self.dialect {
            Some(Dialect::Sinumerik) => "G710 G90 G17 G40 G94".to_owned(),
            _ => "G21 G90 G17 G40 G49 G80 G94".to_owned(),
        };
        if let Some(tolerance_mm) = self.path_tolerance_mm {
            block += &format!(" G64 P{} Q0", format_number(tolerance_mm, 6)?);
        }
        Ok(block + "\n")
    }

    /// A comment block.
    pub(super) fn comment(&self, line: &str) -> String {
        let is_plain = |c: &char| (c.is_ascii_graphic() || *c == ' ') && !"()%;".contains(*c);
        let plain: String = line.chars().map(|c| if is_plain(&c) { c } else { ' ' }).collect();
        let plain = plain.to_ascii_uppercase();
        // The comments of a SINUMERIK program follow a semicolon.
        if self.dialect == Some(Dialect::Sinumerik) { format!("; {plain}\n") } else { format!("({plain})\n") }
    }

    /// The program with the index `number`: `header` as comments, `motion`, and the end.
    pub(super) fn framed(&self, number: usize, header: &[String], motion: &str) -> String {
        let header: String = header.iter().map(|line| self.comment(line)).collect();
        match self.dialect {
            Some(Dialect::Fanuc) => format!("%\nO{}\n{header}{motion}M30\n%\n", FIRST_NUMBER + number),
            // A SINUMERIK program has a name outside of its text.
            Some(Dialect::Sinumerik) => format!("{header}{motion}M30\n"),
            _ => format!("%\n{header}{motion}M2\n%\n"),
        }
    }

    pub(super) fn options(&self, program: &gcode::Program) -> Options {
        self.dialect.unwrap_or_else(|| Dialect::detect(program)).into()
    }
}

/// Positions under the work offset of `style`.
pub(super) fn in_work_coordinates(reference: &Trajectory, style: &Style) -> Result<Trajectory, MotionError> {
    let columns = reference.axes().iter().zip(reference.columns()).map(|(axis, column)| {
        let by = axis.slot().and_then(|slot| style.origin_mm.get(slot)).copied().unwrap_or_default();
        column.iter().map(|position| position - by).collect()
    });
    reference.with_columns(columns.collect())
}

/// Header for the operator, one line each. `ranges` are the lowest and highest positions of the axes, mm or rad.
pub(super) fn header(
    name: &str,
    (axes, ranges): (&[Axis], &[[f64; 2]]),
    seconds: f64,
    style: &Style,
    feeds: Option<(f64, f64)>,
) -> Vec<String> {
    let mut lines = vec![
        format!("precomp excitation {name} for machine {}", style.machine),
        "Run from a clear start: no tool, no part".to_owned(),
    ];
    for (axis, range) in axes.iter().zip(ranges) {
        let (scale, unit) = in_programs(axis.kind);
        let [low, high] = range.map(|position| position * scale);
        lines.push(format!("{} {low:.3} to {high:.3} {unit}", axis.name));
    }
    if style.origin_mm == [0.0; 3] {
        lines.push(
            "Origin: the active work offset, G54. Coordinates are machine coordinates where all offsets are zero,".to_owned(),
        );
        lines.push("else machine coordinates shifted by them. The axes move within these ranges about that origin".to_owned());
    } else {
        let [x, y, z] = style.origin_mm.map(|offset| format!("{offset:.3}"));
        lines.push(format!("Origin: the active work offset, G54, with X {x} Y {y} Z {z}. With another one"));
        lines.push("the axes move elsewhere: within these ranges about that origin".to_owned());
    }
    if let Some((slowest, fastest)) = feeds {
        lines.push(format!("Feed {slowest:.1} to {fastest:.1} mm/min, {seconds:.1} s"));
    }
    lines
}
