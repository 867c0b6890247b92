//! Names of SINUMERIK words by their effect on path and frame.
//!
//! Source: SINUMERIK 840D sl/828D and SINUMERIK ONE, "NC programming" (formerly "Fundamentals" and "Job planning"): chapters "Tables", list of
//! the operations, and the chapters named below. What stands in no list here is not known.

/// A section in which nothing is changed, by what opens it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Section {
    /// TRAORI, TRANSMIT, TRACYL, TRAANG, TRACON; ended by TRAFOOF ("Transformations").
    Transformation,
    /// CYCLE800 with arguments; ended by CYCLE800() ("Swiveling").
    Swivel,
    /// ROT, SCALE, MIRROR and their additive forms, G58, G59; ended by TRANS, which deletes the programmable frame ("Frames").
    Frame,
    /// TOFRAME, TOROT; ended by TOROTOF.
    ToolFrame,
    /// PAROT; ended by PAROTOF.
    PartFrame,
    /// DIAMON, DIAM90; ended by DIAMOF.
    Diameter,
    /// MCALL with a name; ended by MCALL.
    ModalCall,
    /// PTP; ended by CP.
    PointToPoint,
    /// G291, ISO dialect; ended by G290.
    Iso,
    /// FGROUP with other axes than X, Y and Z; ended by FGROUP() ("Feedrate").
    FeedGroup,
    /// FLIN, FCUB: F is reached at the end of its block, so that the parts of a split block would not run at the feeds of the whole; ended by FNORM
    /// ("Non-modal feedrate, feed profiles").
    FeedProfile,
}

/// What a word names besides its letter.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Name {
    /// Nothing.
    #[default]
    None,
    /// A value in AC( ).
    Absolute,
    /// A value in IC( ).
    Incremental,
    /// TURN: full circles besides the arc.
    Turn,
    /// A jump target.
    Label,
    /// No effect on path and frame.
    Silent,
    /// No effect on path and frame, but the path waits for it: SPOS, STOPRE, WAITM, WAITS.
    Holds,
    /// FZ: feed a tooth.
    ToothFeed,
    /// Smooths points within a tolerance: COMPON, COMPCURV, COMPCAD, COMPSURF, CYCLE832.
    Compressor,
    /// TRANS.
    Translate,
    /// ATRANS.
    AddTranslate,
    /// ROT, SCALE, MIRROR and what resembles them; they delete the frame before.
    Replace,
    /// AROT, ASCALE, AMIRROR and what resembles them.
    Add,
    /// RPL: angle of a rotation.
    Angle,
    /// SUPA: machine coordinates in this block.
    MachineFrame,
    /// A modal path that is not interpreted: splines, POLY, involutes.
    Curve,
    /// CIP: a circle through an intermediate point.
    CircleThroughPoint,
    /// CT: a circle that continues the element before it.
    TangentialCircle,
    /// I1, J1, K1: coordinate of the intermediate point of CIP along X, Y, Z (0, 1, 2).
    Intermediate(u8),
    /// Part of this move is computed by the control, or holds for its block alone: FB, FRC.
    OwnBlock,
    /// The control computes the corner to the next move: RND, CHF, CHR.
    Corner,
    /// The same for all corners until RNDM=0.
    AllCorners,
    /// Opens a section.
    Opens(Section),
    /// Ends a section.
    Closes(Section),
    /// CYCLE800 for a plane without shift or angle. The axes may move.
    Untilted,
    /// A cycle that moves and leaves path and frame as they were.
    Cycle,
    /// AP: polar angle.
    PolarAngle,
    /// RP: polar radius.
    PolarRadius,
    /// Part of a position that is not interpreted: ANG, A3, X1.
    Geometry,
    /// Speed of a spindle with a number: S1.
    Spindle,
}

impl Name {
    /// Whether the word is part of a position, and no letter states that.
    pub(crate) fn is_coordinate(self) -> bool {
        matches!(self, Self::Geometry | Self::Intermediate(_) | Self::PolarAngle | Self::PolarRadius)
    }
}

/// Names without effect on path and frame: messages, dynamics, feedforward, exact-stop and compensation behaviour, coordination of channels and
/// spindles, display, orientation modes (they act in a transformation only), blank and protection zones.
const SILENT: [&str; 87] = [
    "ACTBLOCNO",
    "ADIS",
    "ADISPOS",
    "ACC",
    "BRISK",
    "BRISKA",
    "CDOF",
    "CDOF2",
    "CDON",
    "CFC",
    "CFIN",
    "CFTCP",
    "CLEARM",
    "COMPOF",
    "CUT2D",
    "CUT2DF",
    "DELETE",
    "DISPLOF",
    "DISPLON",
    "DRIVE",
    "DRIVEA",
    "DYNFINISH",
    "DYNNORM",
    "DYNPOS",
    "DYNPREC",
    "DYNROUGH",
    "DYNSEMIFIN",
    "EXTERN",
    "FA",
    "FAD",
    "FENDNORM",
    "FFWOF",
    "FFWON",
    "FGREF",
    "FL",
    "FPR",
    "FRCM",
    "GROUP_ADDEND",
    "GROUP_BEGIN",
    "GROUP_END",
    "INIT",
    "KONT",
    "KONTC",
    "KONTT",
    "LIMS",
    "MSG",
    "NORM",
    "NPROT",
    "ORIAXES",
    "ORICURVE",
    "ORIEULER",
    "ORIMKS",
    "ORIPATH",
    "ORIPLANE",
    "ORIRPY",
    "ORIRPY2",
    "ORIVECT",
    "ORIVIRT1",
    "ORIVIRT2",
    "ORIWKS",
    "OSC",
    "OSD",
    "OSOF",
    "OSS",
    "OSSE",
    "OST",
    "OVR",
    "OVRRAP",
    "PREPRO",
    "RTLIOF",
    "RTLION",
    "SAVE",
    "SBLOF",
    "SBLON",
    "SCC",
    "SETAL",
    "SETM",
    "SETMS",
    "SF",
    "SOFT",
    "SOFTA",
    "SPATH",
    "SPCOF",
    "SPCON",
    "SPOSA",
    "START",
    "STARTFIFO",
];
/// More of them.
const SILENT_TOO: [&str; 19] = [
    "ATOL",
    "CTOL",
    "CTOLG0",
    "OTOL",
    "FIFOCTRL",
    "ORISOF",
    "ORISON",
    "OTOLG0",
    "STOLF",
    "STOPFIFO",
    "TMOF",
    "TMON",
    "UPATH",
    "WAITMC",
    "WAITP",
    "WALIMOF",
    "WALIMON",
    "WORKPIECE",
    "WRITE",
];
const COMPRESSORS: [&str; 5] = ["COMPCAD", "COMPCURV", "COMPON", "COMPSURF", "CYCLE832"];
const REPLACING: [&str; 5] = ["CROTS", "MIRROR", "ROT", "ROTS", "SCALE"];
const ADDING: [&str; 4] = ["AMIRROR", "AROT", "AROTS", "ASCALE"];
const CURVES: [&str; 6] = ["ASPLINE", "BSPLINE", "CSPLINE", "INVCCW", "INVCW", "POLY"];
const POSITIONS: [&str; 11] = ["ANG", "AR", "DISCL", "DISR", "LEAD", "OFFN", "PL", "PO", "POS", "POSA", "PW"];
/// How splines begin and end, until another one is stated.
const SPLINE_ENDS: [&str; 6] = ["BAUTO", "BNAT", "BTAN", "EAUTO", "ENAT", "ETAN"];
const TRANSFORMATIONS: [&str; 6] = ["TRAANG", "TRACON", "TRACYL", "TRAFOON", "TRANSMIT", "TRAORI"];
const TOOL_FRAMES: [&str; 8] = ["TOFRAME", "TOFRAMEX", "TOFRAMEY", "TOFRAMEZ", "TOROT", "TOROTX", "TOROTY", "TOROTZ"];
/// Cycles of drilling, milling and turning ("Programming technology functions (cycles)"). Measuring cycles (961 and above) may change offsets.
const CYCLES: [std::ops::RangeInclusive<u32>; 9] =
    [60..=64, 70..=79, 81..=90, 92..=99, 801..=802, 830..=830, 840..=840, 899..=899, 930..=952];
/// Position patterns and the older milling cycles.
const PATTERNS: [&str; 9] = ["HOLES1", "HOLES2", "LONGHOLE", "POCKET1", "POCKET2", "POCKET3", "POCKET4", "SLOT1", "SLOT2"];

/// What a name of several letters means, in upper case. `has_arguments`: something stands in its parentheses, or behind MCALL. `None`: not known.
pub(super) fn meaning(name: &str, has_arguments: bool) -> Option<Name> {
    use Section::*;
    let listed = |list: &[&str]| list.contains(&name);
    Some(match name {
        "TRANS" => Name::Translate,
        "ATRANS" => Name::AddTranslate,
        "SUPA" => Name::MachineFrame,
        "TURN" => Name::Turn,
        "AP" => Name::PolarAngle,
        "RP" => Name::PolarRadius,
        "CIP" => Name::CircleThroughPoint,
        "CT" => Name::TangentialCircle,
        "RPL" => Name::Angle,
        "FB" | "FRC" => Name::OwnBlock,
        "RND" | "CHF" | "CHR" => Name::Corner,
        "RNDM" => Name::AllCorners,
        "TRAFOOF" => Name::Closes(Transformation),
        "TOROTOF" => Name::Closes(ToolFrame),
        "PAROT" => Name::Opens(PartFrame),
        "PAROTOF" => Name::Closes(PartFrame),
        "DIAMON" | "DIAM90" => Name::Opens(Diameter),
        "DIAMOF" => Name::Closes(Diameter),
        "PTP" | "PTPG0" => Name::Opens(PointToPoint),
        "CP" => Name::Closes(PointToPoint),
        "MCALL" if has_arguments => Name::Opens(ModalCall),
        "MCALL" => Name::Closes(ModalCall),
        "CYCLE800" if has_arguments => Name::Opens(Swivel),
        "CYCLE800" => Name::Closes(Swivel),
        // Feed along all axes of the path is the default; other groups than X, Y and Z change what F refers to.
        "FGROUP" if has_arguments => Name::Opens(FeedGroup),
        "FGROUP" => Name::Closes(FeedGroup),
        "FLIN" | "FCUB" => Name::Opens(FeedProfile),
        "FNORM" => Name::Closes(FeedProfile),
        "SPOS" | "STOPRE" | "WAITM" | "WAITS" => Name::Holds,
        "FZ" => Name::ToothFeed,
        // Without arguments it ends.
        "CYCLE832" if !has_arguments => Name::Silent,
        _ if listed(&SILENT) || listed(&SILENT_TOO) || listed(&SPLINE_ENDS) => Name::Silent,
        _ if listed(&COMPRESSORS) => Name::Compressor,
        _ if listed(&REPLACING) => Name::Replace,
        _ if listed(&ADDING) => Name::Add,
        _ if listed(&CURVES) => Name::Curve,
        _ if listed(&POSITIONS) => Name::Geometry,
        _ if listed(&TRANSFORMATIONS) => Name::Opens(Transformation),
        _ if listed(&TOOL_FRAMES) => Name::Opens(ToolFrame),
        _ if listed(&PATTERNS) || is_cycle(name) => Name::Cycle,
        _ => return None,
    })
}

fn is_cycle(name: &str) -> bool {
    let number = name.strip_prefix("CYCLE").and_then(|digits| digits.parse().ok());
    number.is_some_and(|number| CYCLES.iter().any(|range| range.contains(&number)))
}
