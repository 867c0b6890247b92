//! Units in column names.

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

/// A unit: its quantity and its factor to the internal unit (s, mm, rad).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Unit {
    /// Quantity.
    pub quantity: Quantity,
    /// Factor to s, mm or rad.
    pub scale: f64,
}

impl Unit {
    /// A unit by its word, with or without brackets: `s ms us ns min`, `mm m cm um µm nm in inch`, `rad mrad urad deg °`.
    #[must_use]
    pub fn named(word: &str) -> Option<Self> {
        let word = word.trim().trim_matches(['[', ']', '(', ')']).trim().to_lowercase();
        let (quantity, scale) = match word.as_str() {
            "s" | "sec" | "seconds" => (Quantity::Time, 1.0),
            "ms" | "msec" => (Quantity::Time, 1e-3),
            "us" | "µs" | "μs" | "usec" => (Quantity::Time, 1e-6),
            "ns" => (Quantity::Time, 1e-9),
            "min" => (Quantity::Time, 60.0),
            "mm" => (Quantity::Length, 1.0),
            "m" => (Quantity::Length, 1e3),
            "cm" => (Quantity::Length, 10.0),
            "um" | "µm" | "μm" | "micron" => (Quantity::Length, 1e-3),
            "nm" => (Quantity::Length, 1e-6),
            "in" | "inch" | "inches" => (Quantity::Length, 25.4),
            "rad" => (Quantity::Angle, 1.0),
            "mrad" => (Quantity::Angle, 1e-3),
            "urad" | "µrad" | "μrad" => (Quantity::Angle, 1e-6),
            "deg" | "degree" | "degrees" | "°" => (Quantity::Angle, std::f64::consts::PI / 180.0),
            _ => return None,
        };
        Some(Self { quantity, scale })
    }
}
