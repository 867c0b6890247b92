//! Units in reports: errors in µm and µrad, positions in mm and degrees.

use models::AxisManifest;
use motion::{Axis, AxisKind};

/// A length in mm as text in µm, three decimals.
#[must_use]
pub fn um(value_mm: f64) -> String {
    format!("{:.3}", value_mm * 1e3)
}

/// Factor from mm or rad to the unit of positions in programs and tables, and that unit.
#[must_use]
pub fn in_programs(kind: AxisKind) -> (f64, &'static str) {
    match kind {
        AxisKind::Linear => (1.0, "mm"),
        AxisKind::Rotary => (1.0_f64.to_degrees(), "deg"),
    }
}

/// Unit of errors in reports, by the kind of axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ErrorUnit {
    /// Unit of linear axes, whose errors are in mm.
    Micrometre,
    /// Unit of rotary axes, whose errors are in rad.
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
    /// Value in this unit of an error in mm or rad.
    #[must_use]
    pub fn value(self, error: f64) -> f64 {
        match self {
            Self::Micrometre => error * 1e3,
            Self::Microradian => error * 1e6,
        }
    }

    /// Unit symbol: `µm` or `µrad`.
    #[must_use]
    pub fn sign(self) -> &'static str {
        match self {
            Self::Micrometre => "µm",
            Self::Microradian => "µrad",
        }
    }

    /// An error in mm or rad as text in this unit, without the unit.
    #[must_use]
    pub fn number(self, error: f64) -> String {
        format!("{:.3}", self.value(error))
    }

    /// An error in mm or rad as text with its unit: `1.284 µm`.
    #[must_use]
    pub fn text(self, error: f64) -> String {
        format!("{} {}", self.number(error), self.sign())
    }

    /// Row label of an axis in tables, with the unit: `x (µm)`.
    #[must_use]
    pub fn label(self, axis: &str) -> String {
        format!("{axis} ({})", self.sign())
    }

    /// Key of a JSON figure, which ends in the unit: `rms_um`, `rms_urad`.
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
