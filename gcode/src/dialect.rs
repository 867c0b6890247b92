//! Control dialects and the settings that the program text does not state.

use std::f64::consts::SQRT_2;

use crate::arc::ArcTolerance;
use crate::modal::Units;
use crate::passive::PassiveCodes;
use crate::program::{Language, Program};
use crate::signs::{CERTAIN, Signs};
use crate::sinumerik::signs::is_of_another;

/// RS-274 dialect of the control.
///
/// | | `Fanuc` (and most others) | `LinuxCnc` |
/// |---|---|---|
/// | `G4 P` | milliseconds, seconds with a decimal point (`X`, `U`: seconds) | seconds |
/// | after `G80` | the last of `G0`-`G3` is active again | no motion code is active |
/// | `G43` without a tool-axis word | the tip coordinate does not change | the coordinate changes by the offset: unknown |
/// | arc `P` | left alone, but P1 | number of turns |
/// | `G52` | local shift beside `G92` | the same store as `G92` |
/// | return level `G98` | where the cycle began | the same, or R where that is higher |
/// | flow | `IF`, `GOTO`, `WHILE`, `M98`, `G65` | O-words |
/// | `G5`, `G7`, `G8` | look-ahead switches (`G7` refused) | splines (refused), lathe diameter mode (left alone) |
/// | `G70`, `G71` without P, Q | inch, mm | lathe cycles: refused |
/// | `G33` lead | F | K |
///
/// The codes of `Sinumerik` are its own: see the README of this crate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Dialect {
    /// Fanuc and compatible controls: Haas, Mach3, most hobby controls.
    #[default]
    Fanuc,
    /// LinuxCNC 2.9.
    LinuxCnc,
    /// SINUMERIK 840D, 828D, 808D, ONE, in its own dialect (G290).
    Sinumerik,
}

/// Interpretation of I, J, K before the program states G90.1 or G91.1.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum ArcCentres {
    /// From the start of the arc. Absolute, with a warning, if incremental centres fit no circle
    /// and absolute centres fit every arc.
    #[default]
    Auto,
    /// From the start of the arc (G91.1).
    Incremental,
    /// From the program's zero (G90.1).
    Absolute,
}

/// Reading of a coordinate without a decimal point.
///
/// Fanuc controls read it by parameter 3401, bit 0 (DPI): in least input increments, or in units ("calculator-type
/// input"; 0i-F Operator's Manual, "Decimal Point Programming"). LinuxCNC, Grbl and SINUMERIK read units.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum DecimalPoint {
    /// `X50` is 50 mm.
    #[default]
    Unit,
    /// `X50` is 0.050 mm or 0.0050 in, `A50` is 0.050° (increment system IS-B).
    LeastIncrement,
}

/// What is known after a call of a macro or subprogram that is not found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Macros {
    /// Nothing: moves are left alone until the modes and the position are stated again.
    #[default]
    Unknown,
    /// Modes and coordinate system are as they were; the position is unknown.
    Keep,
}

/// Interpreter settings that the program does not state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// The control.
    pub dialect: Dialect,
    /// Whether the dialect is stated. Else one that the program does not show without doubt is a guess, and what Fanuc's controls and LinuxCNC do otherwise is
    /// not known. What a third control of the same dialect may do otherwise is doubted either way.
    pub is_dialect_stated: bool,
    /// Units before the first G20 or G21.
    pub units: Units,
    /// Meaning of I, J, K before the first G90.1 or G91.1.
    pub arc_centres: ArcCentres,
    /// Whether the block-delete switch is on, so that `/` blocks are skipped. `None`: they may run
    /// or not.
    pub block_delete: Option<bool>,
    /// Reading of coordinates without a decimal point. See [`undecided_point`](crate::undecided_point).
    pub decimal_point: DecimalPoint,
    /// Position at the start of the program, mm, if known.
    pub start_mm: Option<[f64; 3]>,
    /// Tolerance on arc radii. `None`: that of the control, [`Dialect::arc_tolerance`].
    pub arc_tolerance: Option<ArcTolerance>,
    /// M codes of this machine that change neither path nor frame.
    pub passive: PassiveCodes,
    /// Whether the machine has the axes A, B and C. In lines of Fanuc and its like words of axes that it lacks are no positions.
    pub rotary_axes: [bool; 3],
    /// What is known after macros and subprograms that are not found. On SINUMERIK it concerns calls by L; after others nothing is known.
    pub macros: Macros,
}

impl Default for Options {
    fn default() -> Self {
        Dialect::default().into()
    }
}

impl From<Dialect> for Options {
    fn from(dialect: Dialect) -> Self {
        Self {
            dialect,
            is_dialect_stated: false,
            units: Units::Mm,
            arc_centres: ArcCentres::Auto,
            block_delete: None,
            decimal_point: DecimalPoint::Unit,
            start_mm: None,
            arc_tolerance: None,
            passive: PassiveCodes::default(),
            rotary_axes: [true; 3],
            macros: Macros::Unknown,
        }
    }
}

impl Options {
    /// Tolerance on arc radii under `units`.
    pub(crate) fn arc_tolerance_in(&self, units: Units) -> ArcTolerance {
        self.arc_tolerance.unwrap_or_else(|| self.dialect.arc_tolerance(units))
    }
}

impl Dialect {
    /// Tolerance on arc radii. LinuxCNC's is that of its stand-alone interpreter (2.9), found by bisection over radii of 0.01 to 3000 mm
    /// and in: 0.1 % of the larger radius, but at least 0.02·√2 and at most 2·√2 mm (0.002·√2 and 0.2·√2 in under G20). That of the others
    /// is a setting that no program states: for them the rule that LinuxCNC documents, 0.1 % from 0.005 to 0.5 mm (0.0005 to 0.05 in).
    #[must_use]
    pub fn arc_tolerance(self, units: Units) -> ArcTolerance {
        let [coarse, fine] = match (self, units) {
            (Self::LinuxCnc, Units::Mm) => [2.0 * SQRT_2, 0.02 * SQRT_2],
            (Self::LinuxCnc, Units::Inch) => [0.2 * SQRT_2, 0.002 * SQRT_2],
            (_, Units::Mm) => [0.5, 0.005],
            (_, Units::Inch) => [0.05, 0.0005],
        };
        ArcTolerance { coarse_mm: coarse * units.mm(), fine_mm: fine * units.mm(), relative: 1e-3 }
    }

    /// The program, split as this control reads it. [`parse`](crate::parse) goes by the codes that it finds; SINUMERIK reads brackets, names
    /// and blanks in another way than the others. Programs of dialogue stay as they are.
    #[must_use]
    pub fn read(self, program: Program) -> Program {
        match self.language_of(&program) {
            Some(language) => program.in_language(language),
            None => program,
        }
    }

    /// Whether the program is plainly of another control: SINUMERIK knows no program numbers `O1`, no comments in parentheses and no `#1`, unless it
    /// runs in its ISO dialect.
    pub fn is_ruled_out(self, program: &Program) -> bool {
        self == Self::Sinumerik && program.language() == Language::Rs274 && is_of_another(program.bytes())
    }

    /// The language in which this control reads the program, if it was split in another.
    pub(crate) fn language_of(self, program: &Program) -> Option<Language> {
        match (program.language(), self) {
            (Language::Rs274, Self::Sinumerik) => Some(Language::Sinumerik),
            (Language::Sinumerik, Self::Fanuc | Self::LinuxCnc) => Some(Language::Rs274),
            _ => None,
        }
    }

    /// Detects the dialect from codes that only one of them has. Default: Fanuc.
    pub fn detect(program: &Program) -> Self {
        match program.language() {
            Language::Sinumerik => Self::Sinumerik,
            _ if Signs::of(program).lead_of_linux_cnc() > 0 => Self::LinuxCnc,
            _ => Self::Fanuc,
        }
    }

    /// Whether the program holds codes or forms that leave no doubt of this dialect. A program without them may be of another control, which
    /// executes some words at another time.
    pub fn is_certain(self, program: &Program) -> bool {
        let lead = || Signs::of(program).lead_of_linux_cnc();
        match (program.language(), self) {
            (Language::Sinumerik, dialect) => dialect == Self::Sinumerik,
            (_, Self::Sinumerik) => false,
            (_, Self::LinuxCnc) => lead() >= CERTAIN,
            (_, Self::Fanuc) => lead() <= -CERTAIN,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parse;

    #[test]
    fn dialects_are_detected_by_their_own_codes() {
        assert_eq!(Dialect::detect(&parse("%\nO1000\nG0 X1\nM30\n%")), Dialect::Fanuc);
        assert_eq!(Dialect::detect(&parse("o100 sub\nG0 X1\no100 endsub\nM2")), Dialect::LinuxCnc);
        assert_eq!(Dialect::detect(&parse("o100 if [1]\nG0 X1\no100 end if\nM2")), Dialect::LinuxCnc);
        assert_eq!(Dialect::detect(&parse("#<depth> = 3\nG0 X1\nM2")), Dialect::LinuxCnc);
        assert_eq!(Dialect::detect(&parse("G0 X1\nM30")), Dialect::Fanuc);
        assert_eq!(Dialect::detect(&parse("G21 G64 P0.001 Q0\nG1 X1 F100\nM2")), Dialect::LinuxCnc);
        assert_eq!(Dialect::detect(&parse("G64\nG0 X1\nG4 P300\nM2")), Dialect::Fanuc);
    }
}
