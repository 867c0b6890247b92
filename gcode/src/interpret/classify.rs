//! The table of G codes of Fanuc and LinuxCNC. That of SINUMERIK is in `sinumerik_codes.rs`.

use super::codes::{self, Code, OneShot, PathCode};
use crate::dialect::Dialect;
use crate::modal::{self, CutterCompensation};

/// The meaning of a G code. `has`: whether a word with this letter stands in the block.
pub(super) fn classify(tenths: u16, dialect: Dialect, has: impl Fn(u8) -> bool) -> Code {
    use Code::*;
    match tenths {
        0 => Motion(codes::Motion::Rapid),
        10 => Motion(codes::Motion::Line),
        20 => Motion(codes::Motion::ArcClockwise),
        30 => Motion(codes::Motion::ArcCounterClockwise),
        // GSK 980MD: a rectangular pocket has the words of one.
        330 if dialect == Dialect::Fanuc && [b'D', b'L', b'R'].into_iter().any(&has) => OneShot(codes::OneShot::Unread),
        330 => Motion(codes::Motion::Thread),
        331 => Motion(codes::Motion::RigidTap),
        382..=385 => Motion(codes::Motion::Probe),
        40 => OneShot(codes::OneShot::Dwell),
        100 => OneShot(codes::OneShot::SetData),
        280 | 300 => OneShot(codes::OneShot::Home),
        520 => OneShot(codes::OneShot::LocalShift),
        920 => OneShot(codes::OneShot::SetPosition),
        921 => ClearPositionShift,
        922 => SuspendPositionShift,
        923 => RestorePositionShift,
        530 => MachineCoordinates,
        170 => Plane(modal::Plane::Xy),
        180 => Plane(modal::Plane::Zx),
        190 => Plane(modal::Plane::Yz),
        200 => Units(modal::Units::Inch),
        210 => Units(modal::Units::Mm),
        400 => Cutter(CutterCompensation::Off),
        410 | 411 => Cutter(CutterCompensation::Left),
        420 | 421 => Cutter(CutterCompensation::Right),
        431 | 432 if dialect == Dialect::LinuxCnc => OneShot(codes::OneShot::ToolOffset),
        430 | 431 | 432 | 440 => ToolLength(modal::ToolLength::On),
        434 | 435 => ToolLength(modal::ToolLength::TipControl),
        490 => ToolLength(modal::ToolLength::Off),
        // Fanuc: `G54 P2` is `G54.1 P2` (GSK 980MDc, "Additional workpiece coordinate system").
        540 | 550 | 560 | 570 | 580 | 590 if dialect == Dialect::Fanuc && has(b'P') => ExtendedWorkOffset,
        540 | 550 | 560 | 570 | 580 | 590 => WorkOffset(modal::WorkOffset::Standard(((tenths - 530) / 10) as u8)),
        591..=593 => WorkOffset(modal::WorkOffset::Standard((tenths - 584) as u8)),
        541 => ExtendedWorkOffset,
        610 => Path(PathCode::ExactPath),
        611 => Path(PathCode::ExactStop),
        640 => Path(PathCode::Continuous),
        730 | 740 | 760 | 810 | 820 | 830 | 840 | 850 | 860 | 870 | 880 | 890 => Cycle(tenths / 10),
        800 => CancelCycle,
        900 => Distance(modal::Distance::Absolute),
        910 => Distance(modal::Distance::Incremental),
        901 => ArcDistance(modal::Distance::Absolute),
        911 => ArcDistance(modal::Distance::Incremental),
        930 => FeedMode(modal::FeedMode::InverseTime),
        940 => FeedMode(modal::FeedMode::PerMinute),
        950 => FeedMode(modal::FeedMode::PerRevolution),
        960 => SurfaceSpeed(true),
        970 => SurfaceSpeed(false),
        980 => ReturnLevel(modal::ReturnLevel::Initial),
        990 => ReturnLevel(modal::ReturnLevel::Retract),
        _ => match dialect {
            Dialect::Fanuc => classify_fanuc(tenths, has),
            Dialect::LinuxCnc => classify_linuxcnc(tenths),
            // Has a table of its own.
            Dialect::Sinumerik => Unknown,
        },
    }
}

/// Words of the lathe cycles G70 to G72; beside T a D is the tool's.
const LATHE_CYCLE: &[u8] = b"EPQRUW";

fn classify_fanuc(tenths: u16, has: impl Fn(u8) -> bool) -> Code {
    let has_any = |letters: &[u8]| letters.iter().any(|letter| has(*letter));
    let is_lathe_cycle = || has_any(LATHE_CYCLE) || has(b'D') && !has(b'T');
    match tenths {
        // Stroke checks have axis words and I, J, K; with others G22 is a pocket of GSK or a call of Mitsubishi.
        220 if has_any(b"ADFLPQR") => Code::Unknown,
        // Look-ahead, data input end, stroke checks, spindle checks, corner override, tapping mode.
        50 | 51 | 80 | 81 | 110 | 220 | 230 | 250 | 260 | 620 | 630 => Code::Silent,
        // Hurco ISNC: data smoothing (G05.2 Q P) and surface finish (G05.3 P). With axes or alone they are NURBS of other controls.
        52 if has(b'P') && has(b'Q') && !has_any(b"XYZABC") => Code::Silent,
        53 if has(b'P') && !has_any(b"XYZABC") => Code::Silent,
        90 => Code::ExactStopHere,
        // Haas: look-ahead limited, smoothness.
        1030 | 1870 => Code::Silent,
        // G53.1, G53.6 (Fanuc) and G253 (Haas) turn the rotary axes until the tool is normal to a tilted plane.
        270 | 290 | 531 | 536 | 2530 => Code::OneShot(OneShot::Home),
        310 => Code::Motion(codes::Motion::Probe),
        // Haas Mill Operator's Manual: bolt hole circle (G70), arc (G71), holes along an angle (G72).
        700 | 710 | 720 if has_any(b"IJKL") && !is_lathe_cycle() => Code::OneShot(OneShot::HolePattern),
        700 if !is_lathe_cycle() => Code::Units(modal::Units::Inch),
        710 if !is_lathe_cycle() => Code::Units(modal::Units::Mm),
        // Haas: G112 (as G12.1), feature coordinate systems G168 and G268, dynamic work offset G254. Mazak: G68.5.
        121 | 160 | 510 | 511 | 680..=689 | 1120 | 1680 | 2540 | 2680 => Code::TransformOn,
        131 | 150 | 500 | 501 | 690 | 1130 | 1690 | 2550 | 2690 => Code::TransformOff,
        // Fanuc "Cylindrical Interpolation"; Haas "G107 Cylindrical Mapping".
        71 | 1070 => Code::CylinderMapping,
        // Haas Mill Operator's Manual: circular pockets, pocket of any shape.
        120 | 130 | 1500 => Code::OneShot(OneShot::Pocket),
        // Haas: G154 P1 to P99.
        1540 if has(b'P') => Code::ExtendedWorkOffset,
        650 => Code::OneShot(OneShot::MacroCall),
        660 | 661 => Code::ModalMacroOn,
        670 => Code::ModalMacroOff,
        // Spirals, involutes, exponential and three-dimensional arcs, NURBS.
        21..=29 | 31..=39 | 61..=63 => Code::Motion(codes::Motion::Curve),
        // Threads of variable lead and arc threads (Fanuc), patterns of holes (Mitsubishi G34 to G37), measuring of offsets (Haas G35 to G37),
        // roundings and tangential approaches (Fagor G36 to G39), engraving (Haas G47 P).
        321 | 322 | 340 | 350 | 360 | 370 | 371 | 380 | 390 => Code::OneShot(OneShot::Unread),
        470 if has(b'P') => Code::OneShot(OneShot::Unread),
        // Approach from one side.
        600 => Code::OneShot(OneShot::Unread),
        700..=720 if tenths != 720 || is_lathe_cycle() => Code::UnsupportedMotion,
        _ => Code::Unknown,
    }
}

fn classify_linuxcnc(tenths: u16) -> Code {
    match tenths {
        281 | 301 => Code::Silent,
        70 => Code::TransformOn,
        80 => Code::TransformOff,
        50..=53 => Code::Motion(codes::Motion::Curve),
        700..=722 => Code::UnsupportedMotion,
        _ => Code::Unknown,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_same_code_differs_by_dialect() {
        let none = |_| false;
        assert_eq!(classify(80, Dialect::Fanuc, none), Code::Silent);
        assert_eq!(classify(80, Dialect::LinuxCnc, none), Code::TransformOff);
        assert_eq!(classify(710, Dialect::Fanuc, none), Code::Units(modal::Units::Mm));
        assert_eq!(classify(710, Dialect::LinuxCnc, none), Code::UnsupportedMotion);
        assert_eq!(classify(593, Dialect::Fanuc, none), Code::WorkOffset(modal::WorkOffset::Standard(9)));
        assert_eq!(classify(540, Dialect::LinuxCnc, none), Code::WorkOffset(modal::WorkOffset::Standard(1)));
    }

    #[test]
    fn other_words_of_the_block_decide() {
        let of = |tenths, letter| classify(tenths, Dialect::Fanuc, move |other| other == letter);
        for tenths in [700, 710, 720] {
            assert_eq!(of(tenths, b'L'), Code::OneShot(OneShot::HolePattern));
            assert_eq!(of(tenths, b'P'), Code::UnsupportedMotion);
        }
        assert_eq!(of(540, b'P'), Code::ExtendedWorkOffset);
        assert_eq!(of(540, b'X'), Code::WorkOffset(modal::WorkOffset::Standard(1)));
    }
}
