//! Units in column names.

use motion::AxisKind;

/// Quantity of a unit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// Internal unit s.
    Time,
    /// Internal unit mm.
    Length,
    /// Internal unit rad.
    Angle,
}

impl Quantity {
    /// That of the positions of an axis.
    #[must_use]
    pub fn of(kind: AxisKind) -> Self {
        match kind {
            AxisKind::Linear => Self::Length,
            AxisKind::Rotary => Self::Angle,
        }
    }
}

/// The unit with this factor to s, mm or rad; the factor itself where it is no unit's.
pub(crate) fn unit_name(scale: f64, quantity: Quantity) -> String {
    let (units, internal): (&[(f64, &str)], &str) = match quantity {
        Quantity::Time => (&[(1.0, "s"), (1e-3, "ms"), (1e-6, "µs"), (1e-9, "ns"), (60.0, "min")], "s"),
        Quantity::Length => {
            (&[(1.0, "mm"), (1e3, "m"), (10.0, "cm"), (1e-3, "µm"), (1e-6, "nm"), (25.4, "in"), (0.0254, "mil")], "mm")
        }
        Quantity::Angle => (
            &[
                (1.0, "rad"),
                (1e-3, "mrad"),
                (1e-6, "µrad"),
                (std::f64::consts::PI / 180.0, "deg"),
                (std::f64::consts::PI / 648_000.0, "arcsec"),
            ],
            "rad",
        ),
    };
    let known = units.iter().find(|(known, _)| (scale / known - 1.0).abs() < 1e-9);
    known.map_or_else(|| format!("× {scale} {internal}"), |(_, name)| (*name).to_owned())
}

/// A unit: its quantity and its factor to the internal unit (s, mm, rad).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Unit {
    /// Quantity.
    pub quantity: Quantity,
    /// Factor to s, mm or rad.
    pub scale: f64,
}

/// Units that are known, for messages.
pub(super) const UNITS: &str = "s, ms, us, ns, min; mm, m, cm, um, nm, in, mil; rad, mrad, urad, deg, arcsec";

impl Unit {
    /// A unit by its word, with or without brackets: `s ms us ns min`, `mm m cm um µm nm in inch mil`, `rad mrad urad deg ° arcsec`, or its name.
    #[must_use]
    pub fn named(word: &str) -> Option<Self> {
        let word = word.trim().trim_matches(['[', ']', '(', ')']).trim().to_lowercase();
        let (quantity, scale) = match word.as_str() {
            "s" | "sec" | "second" | "seconds" => (Quantity::Time, 1.0),
            "ms" | "msec" | "millis" | "millisecond" | "milliseconds" => (Quantity::Time, 1e-3),
            "us" | "µs" | "μs" | "usec" | "microsecond" | "microseconds" => (Quantity::Time, 1e-6),
            "ns" | "nanosecond" | "nanoseconds" => (Quantity::Time, 1e-9),
            "min" => (Quantity::Time, 60.0),
            "mm" | "millimeter" | "millimeters" | "millimetre" | "millimetres" => (Quantity::Length, 1.0),
            "m" | "meter" | "meters" | "metre" | "metres" => (Quantity::Length, 1e3),
            "cm" => (Quantity::Length, 10.0),
            "um" | "µm" | "μm" | "micron" | "microns" | "micrometer" | "micrometers" | "micrometre" | "micrometres" => {
                (Quantity::Length, 1e-3)
            }
            "nm" => (Quantity::Length, 1e-6),
            "in" | "inch" | "inches" => (Quantity::Length, 25.4),
            "mil" | "mils" | "thou" => (Quantity::Length, 0.0254),
            "rad" | "radian" | "radians" => (Quantity::Angle, 1.0),
            "mrad" => (Quantity::Angle, 1e-3),
            "urad" | "µrad" | "μrad" => (Quantity::Angle, 1e-6),
            "deg" | "degree" | "degrees" | "°" => (Quantity::Angle, std::f64::consts::PI / 180.0),
            "arcsec" => (Quantity::Angle, std::f64::consts::PI / 648_000.0),
            _ => return None,
        };
        Some(Self { quantity, scale })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_are_known_by_sign_and_name() {
        for (word, quantity, scale) in [
            ("[microns]", Quantity::Length, 1e-3),
            ("(Millimeters)", Quantity::Length, 1.0),
            ("mil", Quantity::Length, 0.0254),
            ("milliseconds", Quantity::Time, 1e-3),
            ("arcsec", Quantity::Angle, std::f64::consts::PI / 180.0 / 3600.0),
        ] {
            let unit = Unit::named(word).unwrap_or_else(|| panic!("{word}"));
            assert!(unit.quantity == quantity && (unit.scale / scale - 1.0).abs() < 1e-12, "{word}");
        }
        assert_eq!(Unit::named("counts"), None);
        assert_eq!(unit_name(0.0254, Quantity::Length), "mil");
    }
}
