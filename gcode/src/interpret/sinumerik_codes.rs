//! Meaning of the G codes of SINUMERIK.
//!
//! Source: SINUMERIK "NC programming", "Tables", "G commands" (groups 1 to 64), and the chapters of the commands.

use super::codes::{Code, Motion, OneShot, PathCode, PoleFrom};
use crate::modal::{CutterCompensation, Distance, FeedMode, Plane, Units, WorkOffset};
use crate::sinumerik::names::Section;

/// The meaning of a G code, given in tenths; no code of SINUMERIK has decimals.
pub(super) fn classify_sinumerik(tenths: u16) -> Code {
    use Code::*;
    if !tenths.is_multiple_of(10) {
        return Unknown;
    }
    match tenths / 10 {
        0 => Motion(self::Motion::Rapid),
        1 => Motion(self::Motion::Line),
        2 => Motion(self::Motion::ArcClockwise),
        3 => Motion(self::Motion::ArcCounterClockwise),
        33..=35 | 331 | 332 => Motion(self::Motion::Thread),
        // Tapping with compensating chuck; smooth approach and retraction.
        63 | 147 | 148 | 247 | 248 | 347 | 348 => Motion(self::Motion::Curve),
        4 => OneShot(self::OneShot::Dwell),
        9 => ExactStopHere,
        17 => Plane(self::Plane::Xy),
        18 => Plane(self::Plane::Zx),
        19 => Plane(self::Plane::Yz),
        // Limits of the working area and of the spindle.
        25 | 26 => OneShot(self::OneShot::Data),
        110 => OneShot(self::OneShot::Pole(PoleFrom::Position)),
        111 => OneShot(self::OneShot::Pole(PoleFrom::Zero)),
        112 => OneShot(self::OneShot::Pole(PoleFrom::Pole)),
        40 => Cutter(CutterCompensation::Off),
        41 => Cutter(CutterCompensation::Left),
        42 => Cutter(CutterCompensation::Right),
        53 | 153 => MachineCoordinates,
        number @ 54..=57 => WorkOffset(self::WorkOffset::Standard((number - 53) as u8)),
        number @ (500 | 505..=599) => WorkOffset(self::WorkOffset::Extended(number)),
        58 | 59 => Opens(Section::Frame),
        290 => Closes(Section::Iso),
        291 => Opens(Section::Iso),
        60 => Path(PathCode::ExactStop),
        64 | 641..=645 => Path(PathCode::Continuous),
        70 | 700 => Units(self::Units::Inch),
        71 | 710 => Units(self::Units::Mm),
        74 | 75 => OneShot(self::OneShot::Home),
        90 => Distance(self::Distance::Absolute),
        91 => Distance(self::Distance::Incremental),
        93 => FeedMode(self::FeedMode::InverseTime),
        94 => FeedMode(self::FeedMode::PerMinute),
        95 => FeedMode(self::FeedMode::PerRevolution),
        // Group 15 holds the feed types and the constant cutting rate: G96 and G97 include G95, G961 and G971 include G94.
        96 | 961 | 962 => SurfaceSpeed(true),
        97 | 971 | 972 | 973 => SurfaceSpeed(false),
        // Exact-stop criteria, feed at inner corners, approach and corner behaviour of the radius compensation.
        62 | 621 | 601..=603 | 140..=143 | 340 | 341 | 450 | 451 | 460..=462 => Silent,
        _ => Unknown,
    }
}

/// Feed type that a code of the cutting rate includes.
pub(super) fn feed_mode_of_speed(tenths: u16) -> Option<FeedMode> {
    match tenths / 10 {
        96 | 97 => Some(FeedMode::PerRevolution),
        961 | 971 => Some(FeedMode::PerMinute),
        _ => None,
    }
}

/// Unit of F that a code of units sets: G70 and G71 concern lengths alone, G700 and G710 feeds too ("Inch or metric dimensions").
pub(super) fn feed_units(tenths: u16, basic: Units) -> Units {
    match tenths / 10 {
        700 => Units::Inch,
        710 => Units::Mm,
        _ => basic,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_of_other_controls_are_unknown() {
        for number in [20, 21, 28, 43, 49, 52, 61, 68, 80, 81, 92, 98, 501, 600, 646, 999] {
            assert_eq!(classify_sinumerik(number * 10), Code::Unknown, "G{number}");
        }
        assert_eq!(classify_sinumerik(541), Code::Unknown);
        assert_eq!(classify_sinumerik(6420), Code::Path(PathCode::Continuous));
        assert_eq!(classify_sinumerik(5050), Code::WorkOffset(WorkOffset::Extended(505)));
    }
}
