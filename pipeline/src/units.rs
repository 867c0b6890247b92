//! Units of what is shown: errors in µm and µrad, positions as programs state them.

use models::AxisManifest;
use motion::{Axis, AxisKind};

/// Micrometres of a length in mm, as printed.
#[must_use]
pub fn um(value_mm: f64) -> String {
    format!("{:.3}", value_mm * 1e3)
}

/// How programs and tables state positions of an axis: what its mm or rad are multiplied by, and the unit.
#[must_use]
pub fn in_programs(kind: AxisKind) -> (f64, &'static str) {
    match kind {
        AxisKind::Linear => (1.0, "mm"),
        AxisKind::Rotary => (1.0_f64.to_degrees(), "deg"),
    }
}

/// The unit in which errors of one kind of axis are shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ErrorUnit {
    /// Of linear axes, whose errors are in mm.
    Micrometre,
    /// Of rotary axes, whose errors are in rad.
    Microradian,
}

impl From<AxisKind> for ErrorUnit {
    fn from(kind: AxisKind) -> Self {
        match kind {
            AxisKind::Linear => Self::Micrometre,
            AxisKind::Rotary => Self::Microradian,
        }
    }
}

impl From<&Axis> for ErrorUnit {
    fn from(axis: &Axis) -> Self {
        axis.kind.into()
    }
}

impl From<&AxisManifest> for ErrorUnit {
    fn from(axis: &AxisManifest) -> Self {
        if axis.rotary { Self::Microradian } else { Self::Micrometre }
    }
}

impl ErrorUnit {
    /// An error of the axis, mm or rad, in this unit.
    #[must_use]
    pub fn value(self, error: f64) -> f64 {
        match self {
            Self::Micrometre => error * 1e3,
            Self::Microradian => error * 1e6,
        }
    }

    /// The unit's sign: `µm` or `µrad`.
    #[must_use]
    pub fn sign(self) -> &'static str {
        match self {
            Self::Micrometre => "µm",
            Self::Microradian => "µrad",
        }
    }

    /// An error of the axis, mm or rad, as a number in this unit.
    #[must_use]
    pub fn number(self, error: f64) -> String {
        format!("{:.3}", self.value(error))
    }

    /// An error of the axis, mm or rad, as a number with its unit: `1.284 µm`.
    #[must_use]
    pub fn text(self, error: f64) -> String {
        format!("{} {}", self.number(error), self.sign())
    }

    /// An axis with the unit of the numbers in its row of a table: `x (µm)`.
    #[must_use]
    pub fn label(self, axis: &str) -> String {
        format!("{axis} ({})", self.sign())
    }

    /// A key of JSON figures with the unit at its end: `rms_um`, `rms_urad`.
    #[must_use]
    pub fn key(self, quantity: &str) -> String {
        match self {
            Self::Micrometre => format!("{quantity}_um"),
            Self::Microradian => format!("{quantity}_urad"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_thousandth_of_a_radian_is_a_thousand_microradians() {
        let (x, c) = (ErrorUnit::from(&Axis::named("x")), ErrorUnit::from(&Axis::named("c")));
        assert_eq!((x.text(1e-3), c.text(1e-3)), ("1.000 µm".to_owned(), "1000.000 µrad".to_owned()));
        assert_eq!((x.key("rms"), c.key("rms")), ("rms_um".to_owned(), "rms_urad".to_owned()));
        assert_eq!((x.label("x"), c.label("c")), ("x (µm)".to_owned(), "c (µrad)".to_owned()));
    }
}
