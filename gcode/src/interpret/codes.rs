//! Meaning of each G code in each dialect.

use crate::dialect::Dialect;
use crate::modal::{CutterCompensation, Distance, FeedMode, Plane, ReturnLevel, ToolLength, Units, WorkOffset};
use crate::sinumerik::names::Section;

/// A motion code of modal group 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Motion {
    Rapid,
    Line,
    ArcClockwise,
    ArcCounterClockwise,
    Thread,
    RigidTap,
    Probe,
    /// CIP of SINUMERIK: a circle through an intermediate point.
    CircleThroughPoint,
    /// CT of SINUMERIK: a circle that continues the element before it.
    TangentialCircle,
    /// A path that is not interpreted.
    Curve,
}

impl Motion {
    /// Whether it moves along its path in the programmed frame, and nothing but the program decides where it ends.
    pub(super) fn is_of_frame(self) -> bool {
        !matches!(self, Self::Thread | Self::RigidTap | Self::Probe)
    }

    /// The number of the code, for G0 to G3.
    pub(super) fn number(self) -> Option<u8> {
        match self {
            Self::Rapid => Some(0),
            Self::Line => Some(1),
            Self::ArcClockwise => Some(2),
            Self::ArcCounterClockwise => Some(3),
            Self::Thread | Self::RigidTap | Self::Probe => None,
            Self::CircleThroughPoint | Self::TangentialCircle | Self::Curve => None,
        }
    }
}

/// Path mode of the control, before its words are read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum PathCode {
    ExactPath,
    ExactStop,
    Continuous,
}

/// What the coordinates of a pole are measured from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum PoleFrom {
    /// G110: the last programmed position.
    Position,
    /// G111: the zero of the workpiece.
    Zero,
    /// G112: the last pole.
    Pole,
}

/// Codes that use the axis words of the block and hold for that block alone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum OneShot {
    Dwell,
    SetData,
    Home,
    LocalShift,
    SetPosition,
    MacroCall,
    ToolOffset,
    /// Limits of SINUMERIK: no motion.
    Data,
    /// A pole of SINUMERIK.
    Pole(PoleFrom),
    /// Holes on a circle, an arc or a line at which the active cycle works.
    HolePattern,
    /// A pocket along a path that the control computes.
    Pocket,
    /// A move, or several, along a path that is not interpreted.
    Unread,
}

/// What axis words are beside a code that does not use them as a coordinate of its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum AxisWords {
    /// The target of a move in the active motion mode.
    Target,
    /// Data of the code; no axis moves.
    Data,
    /// Not known.
    Unknown,
}

/// One G code.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Code {
    Motion(Motion),
    Cycle(u16),
    CancelCycle,
    OneShot(OneShot),
    ClearPositionShift,
    SuspendPositionShift,
    RestorePositionShift,
    MachineCoordinates,
    Units(Units),
    Distance(Distance),
    ArcDistance(Distance),
    FeedMode(FeedMode),
    Plane(Plane),
    WorkOffset(WorkOffset),
    ExtendedWorkOffset,
    Cutter(CutterCompensation),
    ToolLength(ToolLength),
    Path(PathCode),
    ReturnLevel(ReturnLevel),
    /// Rotation, scaling, mirror, polar, diameter: programmed coordinates differ from path
    /// coordinates.
    TransformOn,
    TransformOff,
    /// Mapping of an axis onto a cylinder: the other words of the block begin or end it.
    CylinderMapping,
    ModalMacroOn,
    ModalMacroOff,
    /// Constant surface speed: S is no longer rev/min.
    SurfaceSpeed(bool),
    /// Exact stop at the end of this block alone.
    ExactStopHere,
    /// Known, no influence on geometry.
    Silent,
    /// A cycle of lathes.
    UnsupportedMotion,
    /// Opens a section of SINUMERIK.
    Opens(Section),
    /// Ends a section of SINUMERIK.
    Closes(Section),
    Unknown,
}

/// A code in tenths: 911 for G91.1. `None` if the number is no code.
pub(super) fn tenths(value: f64) -> Option<u16> {
    let scaled = value * 10.0;
    let rounded = scaled.round();
    ((scaled - rounded).abs() < 1e-6 && (0.0..10_000.0).contains(&rounded)).then_some(rounded as u16)
}

/// Code as text: `G91.1`.
pub(super) fn written(tenths: u16) -> String {
    match tenths % 10 {
        0 => format!("G{}", tenths / 10),
        part => format!("G{}.{part}", tenths / 10),
    }
}

/// Whether the code `off` ends the transformation started by `on` (both in tenths). G50.1 is not among them: it ends the mirror images of the
/// axes that it names.
pub(super) fn cancels(off: u16, on: u16) -> bool {
    match off {
        80 => on == 70,
        100 => matches!(on, 110 | 120 | 130),
        131 | 1130 => matches!(on, 121 | 1120),
        150 => on == 160,
        500 => on == 510,
        670 => matches!(on, 660 | 661),
        690 => matches!(on, 680..=689 | 1680),
        1690 => on == 1680,
        2550 => on == 2540,
        2690 => on == 2680,
        _ => false,
    }
}

/// Whether the axis words beside a transformation (in tenths) are its centre, its axes or its factors, not the target of a move.
pub(super) fn has_axis_words(on: u16) -> bool {
    matches!(on, 510 | 511 | 680..=689 | 1680 | 2680)
}

/// What the axis words of a block are that holds this code (number in tenths); `states_motion`: a motion code stands in the block; `has`: whether
/// a word with this letter does.
///
/// A code that is missing here is one beside which the manuals write moves: LinuxCNC, "G-Codes"; Fanuc 0i-F Operator's Manual (B-64604EN),
/// "Preparatory Function (G Function)": the modal groups of planes, units, distances, feeds, offsets, compensations and path modes.
pub(super) fn axis_words(code: Code, tenths: u16, dialect: Dialect, states_motion: bool, has: impl Fn(u8) -> bool) -> AxisWords {
    match code {
        _ if dialect == Dialect::Sinumerik => AxisWords::Target,
        // Fanuc 0i-F: "Stored Stroke Check" (G22); 30i, "Smoothing" (G5.1 Q3). Without Q, G5.1 is LinuxCNC's quadratic spline.
        // Beside a motion code it is open which of them has the words.
        Code::Silent if !states_motion && (tenths == 220 || (tenths == 51 && has(b'Q'))) => AxisWords::Data,
        Code::Silent | Code::ModalMacroOff => AxisWords::Unknown,
        // Okuma's G71 states the return level of cycles.
        Code::Units(_) if matches!(tenths, 700 | 710) && !states_motion => AxisWords::Unknown,
        // LinuxCNC has them as modal codes. Fanuc's G92.1 presets the frame of the axes named.
        Code::ClearPositionShift | Code::SuspendPositionShift | Code::RestorePositionShift => AxisWords::Unknown,
        Code::TransformOff if dialect == Dialect::Fanuc => AxisWords::Unknown,
        // Others are refused.
        Code::Unknown => AxisWords::Unknown,
        // Fanuc 30i: G91.1 sets the largest increment that is accepted.
        Code::ArcDistance(_) if dialect == Dialect::Fanuc && !states_motion => AxisWords::Unknown,
        _ => AxisWords::Target,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_are_exact_tenths() {
        assert_eq!(tenths(91.1), Some(911));
        assert_eq!(tenths(0.0), Some(0));
        assert_eq!(tenths(1.55), None);
        assert_eq!(tenths(-1.0), None);
        assert_eq!(tenths(f64::NAN), None);
        assert_eq!(written(911), "G91.1");
        assert_eq!(written(540), "G54");
    }
}
