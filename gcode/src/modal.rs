//! Modal state under which a replacement move must be written.

pub use crate::plane::Plane;
use crate::rotation::Rotation;

/// Units of length words.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Units {
    /// G21.
    Mm,
    /// G20.
    Inch,
}

impl Units {
    /// Millimetres in one unit.
    pub fn mm(self) -> f64 {
        match self {
            Units::Mm => 1.0,
            Units::Inch => 25.4,
        }
    }
}

/// Absolute or incremental: axis words (G90, G91) or arc centres (G90.1, G91.1).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Distance {
    /// From program zero.
    Absolute,
    /// From the start of the move.
    Incremental,
}

/// Unit of F.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum FeedMode {
    /// G93: inverse time, 1/min.
    InverseTime,
    /// G94: length units per minute.
    PerMinute,
    /// G95: length units per spindle revolution.
    PerRevolution,
}

/// Active work coordinate system.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum WorkOffset {
    /// 1 for G54 to 6 for G59, 7 to 9 for G59.1 to G59.3.
    Standard(u8),
    /// The P of G54.1; of SINUMERIK 505 to 599, and 500 for none.
    Extended(u16),
    /// G54.1 with a P that is no number.
    Unpredictable,
}

/// Cutter radius compensation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum CutterCompensation {
    /// G40.
    Off,
    /// G41, G41.1.
    Left,
    /// G42, G42.1.
    Right,
}

/// Tool length compensation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ToolLength {
    /// G49.
    Off,
    /// G43, G44 and related codes: a constant along the tool axis.
    On,
    /// G43.4, G43.5: tool-centre-point control. The program states the tip position.
    TipControl,
}

/// Path mode.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PathMode {
    /// Not stated.
    Default,
    /// G61.
    ExactPath,
    /// G61.1.
    ExactStop,
    /// G64, with P (path tolerance) and Q (collinear merging) in mm if stated.
    Continuous {
        /// Path tolerance, mm.
        tolerance_mm: Option<f64>,
        /// Merging tolerance, mm.
        merge_mm: Option<f64>,
    },
}

/// Return level of a canned cycle along the tool axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ReturnLevel {
    /// G98: the level before the cycles.
    Initial,
    /// G99: the R level.
    Retract,
}

/// Modal state of a move.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Modal {
    /// G20, G21; G70, G71, G700, G710 of SINUMERIK.
    pub units: Units,
    /// Length in the unit of F, mm: the unit of lengths, but under G70 and G71 of SINUMERIK that of the control, and a tenth of an inch in dialogue
    /// programs in inches.
    pub feed_unit_mm: f64,
    /// G90, G91.
    pub distance: Distance,
    /// G90.1, G91.1.
    pub arc_distance: Distance,
    /// G93, G94, G95.
    pub feed_mode: FeedMode,
    /// G17, G18, G19.
    pub plane: Plane,
    /// G54 to G59.3, G54.1.
    pub work_offset: WorkOffset,
    /// G40, G41, G42.
    pub cutter: CutterCompensation,
    /// G43, G49.
    pub tool_length: ToolLength,
    /// G61, G64.
    pub path: PathMode,
    /// G98, G99.
    pub return_level: ReturnLevel,
    /// Sum of G52 and G92, or of TRANS and ATRANS, by axis (mm; rad for A, B, C). Programmed absolute coordinate = position
    /// − shift, without a rotation.
    pub shift: [f64; 6],
    /// Known rotation of the coordinates. Its turned coordinates are programmed ones + shift.
    pub rotation: Option<Rotation>,
    /// Spindle speed, rev/min, if it is a number.
    pub spindle_rpm: Option<f64>,
    /// Last T.
    pub tool: Option<u32>,
}

impl Modal {
    /// The state before the first block.
    pub(crate) fn initial(units: Units, arc_distance: Distance) -> Self {
        Self {
            units,
            feed_unit_mm: units.mm(),
            distance: Distance::Absolute,
            arc_distance,
            feed_mode: FeedMode::PerMinute,
            plane: Plane::Xy,
            work_offset: WorkOffset::Standard(1),
            cutter: CutterCompensation::Off,
            tool_length: ToolLength::Off,
            path: PathMode::Default,
            return_level: ReturnLevel::Initial,
            shift: [0.0; 6],
            rotation: None,
            spindle_rpm: None,
            tool: None,
        }
    }
}
