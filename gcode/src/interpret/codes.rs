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
    /// Known motion along a path that is not interpreted.
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
        Code::Silent if tenths == 220 || (tenths == 51 && has(b'Q')) => AxisWords::Data,
        Code::Silent | Code::ModalMacroOff => AxisWords::Unknown,
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

/// The meaning of a G code. `has`: whether a word with this letter stands in the block.
pub(super) fn classify(tenths: u16, dialect: Dialect, has: impl Fn(u8) -> bool) -> Code {
    use Code::*;
    match tenths {
        0 => Motion(self::Motion::Rapid),
        10 => Motion(self::Motion::Line),
        20 => Motion(self::Motion::ArcClockwise),
        30 => Motion(self::Motion::ArcCounterClockwise),
        330 => Motion(self::Motion::Thread),
        331 => Motion(self::Motion::RigidTap),
        382..=385 => Motion(self::Motion::Probe),
        40 => OneShot(self::OneShot::Dwell),
        100 => OneShot(self::OneShot::SetData),
        280 | 300 => OneShot(self::OneShot::Home),
        520 => OneShot(self::OneShot::LocalShift),
        920 => OneShot(self::OneShot::SetPosition),
        921 => ClearPositionShift,
        922 => SuspendPositionShift,
        923 => RestorePositionShift,
        530 => MachineCoordinates,
        170 => Plane(self::Plane::Xy),
        180 => Plane(self::Plane::Zx),
        190 => Plane(self::Plane::Yz),
        200 => Units(self::Units::Inch),
        210 => Units(self::Units::Mm),
        400 => Cutter(CutterCompensation::Off),
        410 | 411 => Cutter(CutterCompensation::Left),
        420 | 421 => Cutter(CutterCompensation::Right),
        431 | 432 if dialect == Dialect::LinuxCnc => OneShot(self::OneShot::ToolOffset),
        430 | 431 | 432 | 440 => ToolLength(self::ToolLength::On),
        434 | 435 => ToolLength(self::ToolLength::TipControl),
        490 => ToolLength(self::ToolLength::Off),
        // Fanuc: `G54 P2` is `G54.1 P2` (GSK 980MDc, "Additional workpiece coordinate system").
        540 | 550 | 560 | 570 | 580 | 590 if dialect == Dialect::Fanuc && has(b'P') => ExtendedWorkOffset,
        540 | 550 | 560 | 570 | 580 | 590 => WorkOffset(self::WorkOffset::Standard(((tenths - 530) / 10) as u8)),
        591..=593 => WorkOffset(self::WorkOffset::Standard((tenths - 584) as u8)),
        541 => ExtendedWorkOffset,
        610 => Path(PathCode::ExactPath),
        611 => Path(PathCode::ExactStop),
        640 => Path(PathCode::Continuous),
        730 | 740 | 760 | 810 | 820 | 830 | 840 | 850 | 860 | 870 | 880 | 890 => Cycle(tenths / 10),
        800 => CancelCycle,
        900 => Distance(self::Distance::Absolute),
        910 => Distance(self::Distance::Incremental),
        901 => ArcDistance(self::Distance::Absolute),
        911 => ArcDistance(self::Distance::Incremental),
        930 => FeedMode(self::FeedMode::InverseTime),
        940 => FeedMode(self::FeedMode::PerMinute),
        950 => FeedMode(self::FeedMode::PerRevolution),
        960 => SurfaceSpeed(true),
        970 => SurfaceSpeed(false),
        980 => ReturnLevel(self::ReturnLevel::Initial),
        990 => ReturnLevel(self::ReturnLevel::Retract),
        _ => match dialect {
            Dialect::Fanuc => classify_fanuc(tenths, has),
            Dialect::LinuxCnc => classify_linuxcnc(tenths),
            // Has a table of its own.
            Dialect::Sinumerik => Unknown,
        },
    }
}

/// Words of the lathe cycles G70 to G72.
const LATHE_CYCLE: &[u8] = b"DEPQRUW";

fn classify_fanuc(tenths: u16, has: impl Fn(u8) -> bool) -> Code {
    let has_any = |letters: &[u8]| letters.iter().any(|letter| has(*letter));
    match tenths {
        // Look-ahead, data input end, stroke checks, spindle checks, corner override, tapping mode.
        50 | 51 | 80 | 81 | 110 | 220 | 230 | 250 | 260 | 620 | 630 => Code::Silent,
        90 => Code::ExactStopHere,
        // Haas: look-ahead limited, smoothness.
        1030 | 1870 => Code::Silent,
        // G53.1, G53.6 (Fanuc) and G253 (Haas) turn the rotary axes until the tool is normal to a tilted plane.
        270 | 290 | 531 | 536 | 2530 => Code::OneShot(OneShot::Home),
        310 => Code::Motion(Motion::Probe),
        // Haas Mill Operator's Manual: bolt hole circle (G70), arc (G71), holes along an angle (G72).
        700 | 710 | 720 if has_any(b"IJKL") && !has_any(LATHE_CYCLE) => Code::OneShot(OneShot::HolePattern),
        700 if !has_any(LATHE_CYCLE) => Code::Units(Units::Inch),
        710 if !has_any(LATHE_CYCLE) => Code::Units(Units::Mm),
        // Haas: G112 (as G12.1), feature coordinate systems G168 and G268, dynamic work offset G254. Mazak: G68.5.
        121 | 160 | 510 | 511 | 680..=689 | 1120 | 1680 | 2540 | 2680 => Code::TransformOn,
        131 | 150 | 500 | 501 | 690 | 1130 | 1690 | 2550 | 2690 => Code::TransformOff,
        // Fanuc "Cylindrical Interpolation"; Haas "G107 Cylindrical Mapping".
        71 | 1070 => Code::CylinderMapping,
        // Haas Mill Operator's Manual: circular pockets, pocket of any shape.
        120 | 130 | 1500 => Code::OneShot(OneShot::Pocket),
        650 => Code::OneShot(OneShot::MacroCall),
        660 | 661 => Code::ModalMacroOn,
        670 => Code::ModalMacroOff,
        20..=39 | 61..=63 | 70 | 321..=322 | 340..=360 | 450..=480 | 600 | 700..=720 => Code::UnsupportedMotion,
        _ => Code::Unknown,
    }
}

fn classify_linuxcnc(tenths: u16) -> Code {
    match tenths {
        281 | 301 => Code::Silent,
        70 => Code::TransformOn,
        80 => Code::TransformOff,
        50..=53 | 700..=722 => Code::UnsupportedMotion,
        _ => Code::Unknown,
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

    #[test]
    fn the_same_code_differs_by_dialect() {
        let none = |_| false;
        assert_eq!(classify(80, Dialect::Fanuc, none), Code::Silent);
        assert_eq!(classify(80, Dialect::LinuxCnc, none), Code::TransformOff);
        assert_eq!(classify(710, Dialect::Fanuc, none), Code::Units(Units::Mm));
        assert_eq!(classify(710, Dialect::LinuxCnc, none), Code::UnsupportedMotion);
        assert_eq!(classify(593, Dialect::Fanuc, none), Code::WorkOffset(WorkOffset::Standard(9)));
        assert_eq!(classify(540, Dialect::LinuxCnc, none), Code::WorkOffset(WorkOffset::Standard(1)));
    }

    #[test]
    fn other_words_of_the_block_decide() {
        let of = |tenths, letter| classify(tenths, Dialect::Fanuc, move |other| other == letter);
        for tenths in [700, 710, 720] {
            assert_eq!(of(tenths, b'L'), Code::OneShot(OneShot::HolePattern));
            assert_eq!(of(tenths, b'P'), Code::UnsupportedMotion);
        }
        assert_eq!(of(540, b'P'), Code::ExtendedWorkOffset);
        assert_eq!(of(540, b'X'), Code::WorkOffset(WorkOffset::Standard(1)));
    }
}
