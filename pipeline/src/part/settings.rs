//! Settings for reading a program, and what they mean on a setup.

use gcode::{ArcCentres, DecimalPoint, Dialect, Macros, Options, PassiveCodes, Program, WorkOffset};

use super::faults::render;
use super::offsets::{GivenOffset, WorkOffsets};
use super::subprograms::Subprograms;
use crate::error::{Error, Result};
use crate::setup::Setup;

/// Settings for reading and planning a program.
///
/// Defaults: no work offset, `at_zero: false`, corner tolerance of the setup, dialect of the setup or found from the program. Without a work offset
/// the forecast lacks the position-dependent terms; see [`PositionTerms::of`](crate::PositionTerms::of). On a simulated machine set `at_zero`.
#[derive(Debug, Clone, PartialEq)]
pub struct ReadSettings {
    /// Dialect of the program; `None` takes that of the setup unless the program is plainly of another, else detects it.
    pub dialect: Option<Dialect>,
    /// M codes that change neither path nor coordinate system on this machine.
    pub passive: PassiveCodes,
    /// Whether the control skips blocks that begin with `/`. With `None` these blocks and all that depends on them are
    /// not compensated.
    pub block_delete: Option<bool>,
    /// What is known after macros and subprograms that are not found.
    pub macros: Macros,
    /// Whether a program is written without parameters, loops and subprograms first, one block for every executed one. Without it programs are
    /// refused whose feed moves run several times.
    pub expand: bool,
    /// Files of subprograms.
    pub subprograms: Subprograms,
    /// Reading of coordinates without a decimal point; `None` takes that of the setup, else refuses a program that depends on it.
    pub decimal_point: Option<DecimalPoint>,
    /// How I, J, K state the centres of arcs until the program says it.
    pub arc_centres: ArcCentres,
    /// Work offsets, machine minus program coordinates, mm; they complement or replace those of the setup.
    pub work_offsets: Vec<GivenOffset>,
    /// Tool length, mm, where the Z offsets do not contain it.
    pub tool_length_mm: f64,
    /// Whether coordinate systems without an offset lie at 0,0,0, as on a simulated machine.
    pub at_zero: bool,
    /// Corner tolerance where the program states none, mm; 0 plans a stop at every corner. `None` takes that of the setup.
    pub corner_tolerance_mm: Option<f64>,
}

impl Default for ReadSettings {
    fn default() -> Self {
        Self {
            dialect: None,
            passive: PassiveCodes::default(),
            block_delete: None,
            macros: Macros::Unknown,
            expand: false,
            subprograms: Subprograms::default(),
            decimal_point: None,
            arc_centres: ArcCentres::Auto,
            work_offsets: Vec::new(),
            tool_length_mm: 0.0,
            at_zero: false,
            corner_tolerance_mm: None,
        }
    }
}

impl ReadSettings {
    /// The first work offset (G54), machine minus program coordinates, mm; `None` where neither these settings nor the machine file state it.
    #[must_use]
    pub fn first_offset(&self, setup: &Setup) -> Option<[f64; 3]> {
        WorkOffsets::new(&self.work_offsets, &setup.work_offsets, 0.0).of(WorkOffset::Standard(1)).map(Into::into)
    }

    /// Work offsets for a program on this setup.
    pub(super) fn offsets(&self, setup: &Setup) -> WorkOffsets {
        let given = WorkOffsets::new(&self.work_offsets, &setup.work_offsets, self.tool_length_mm);
        if self.at_zero { given.or_zero() } else { given }
    }

    /// Options of the interpreter for a program.
    ///
    /// # Errors
    /// [`Error::ToolLengthOfTurningMachine`], and [`Error::Program`] where coordinates without a decimal point can be read in two ways.
    pub(super) fn options(&self, name: &str, program: &Program, setup: &Setup) -> Result<Options> {
        if setup.kinematics.has_rotary_axes() && self.tool_length_mm != 0.0 {
            return Err(Error::ToolLengthOfTurningMachine);
        }
        let of_setup = setup.dialect.filter(|dialect| !dialect.is_ruled_out(program));
        let stated_dialect = self.dialect.or(of_setup);
        let (is_dialect_stated, dialect) = (stated_dialect.is_some(), stated_dialect.unwrap_or_else(|| Dialect::detect(program)));
        let stated = self.decimal_point.or(setup.decimal_point);
        let decimal_point = stated.unwrap_or_default();
        let Self { passive, block_delete, macros, arc_centres, .. } = *self;
        let slots: Vec<usize> = setup.kinematics.axes().iter().filter_map(motion::Axis::slot).collect();
        let rotary_axes = std::array::from_fn(|axis| slots.contains(&(3 + axis)));
        let options = Options {
            is_dialect_stated,
            passive,
            block_delete,
            macros,
            decimal_point,
            arc_centres,
            rotary_axes,
            ..dialect.into()
        };
        let open = match (self.decimal_point, stated) {
            (Some(_), _) => None,
            // The description of a machine may stand for another control than that of the program.
            (None, Some(DecimalPoint::Unit)) => gcode::oversized_point(program, &options),
            (None, Some(DecimalPoint::LeastIncrement)) => None,
            (None, None) => gcode::undecided_point(program, &options),
        };
        if let Some(open) = open {
            let diagnostics = vec![open];
            return Err(Error::Program { text: render(&diagnostics, program, name), diagnostics });
        }
        Ok(options)
    }
}
