//! Causes of open sections in dialogue programs.

/// A function whose effect is not interpreted, until its own end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Cause {
    /// CYCL DEF 7 from a table or a parameter, or within another frame.
    Shift,
    /// CYCL DEF 8.
    Mirror,
    /// CYCL DEF 10.
    Rotation,
    /// CYCL DEF 11.
    Scaling,
    /// PLANE.
    Plane,
    /// An M function with the number of the one that ends it.
    EndedBy(u16),
    /// M128 or FUNCTION TCPM.
    ToolCentrePoint,
    /// Without a known end.
    Lasting,
}
