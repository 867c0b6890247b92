//! Machine axes: a name and a kind.

use std::fmt;

/// Whether an axis is linear or rotary.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum AxisKind {
    /// Positions in mm.
    Linear,
    /// Positions in rad.
    Rotary,
}

impl AxisKind {
    /// Internal unit of positions.
    #[must_use]
    pub fn unit(self) -> &'static str {
        match self {
            Self::Linear => "mm",
            Self::Rotary => "rad",
        }
    }
}

/// A machine axis.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Axis {
    /// Lower-case name, `x` or `j1`.
    pub name: String,
    /// Linear or rotary.
    pub kind: AxisKind,
}

impl Axis {
    /// An axis from its name: `a`, `b`, `c` and joints `j…` are rotary, all others linear. The name
    /// is lower-cased.
    #[must_use]
    pub fn named(name: &str) -> Self {
        let name = name.to_ascii_lowercase();
        let joint = name.len() > 1 && name.starts_with('j') && name[1..].bytes().all(|byte| byte.is_ascii_digit());
        let kind = if joint || matches!(name.as_str(), "a" | "b" | "c") { AxisKind::Rotary } else { AxisKind::Linear };
        Self { name, kind }
    }

    /// Index among X, Y, Z, A, B, C, if it is one of them.
    #[must_use]
    pub fn slot(&self) -> Option<usize> {
        ["x", "y", "z", "a", "b", "c"].iter().position(|name| *name == self.name)
    }

    /// The axes `x`, `y`, `z`.
    #[must_use]
    pub fn xyz() -> Vec<Self> {
        ["x", "y", "z"].map(Self::named).to_vec()
    }
}

impl fmt::Display for Axis {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.name)
    }
}
