//! When the words beside a feed move act: before its motion, or after it.
//!
//! | | before the motion | after the motion | source |
//! |---|---|---|---|
//! | LinuxCNC | every word but those on the right | M0 M1 M2 M30 M60 M98 M99 | G-Code Overview, "G-Code Order of Execution"; RS274NGC (NISTIR 6556), 3.8 |
//! | SINUMERIK | S, M3 M4 M7 M8, G codes | M0 M1 M2 M5 M9 M17 M30 | SINUMERIK "NC programming", "M functions", "Spindle speed (S), spindle direction of rotation (M3, M4, M5)" |
//! | Fanuc | S, M3 M4 M7 M8 M13 M14, G codes | M0 M1 M2 M5 M9 M30 M60 M97 M98 M99 M198 | Fanuc 0i-F Operator's Manual (B-64604EN), "Auxiliary Function"; Haas Mill Operator's Manual, "M-Codes" |
//!
//! Dialogue counts as Fanuc (TNC 640 Klartext manual, "M functions": M5 and M9 act at the end of the block, M3 and M8 at its start).
//! SINUMERIK may switch M5 before the motion too (machine data); with the last of several lines it stops no earlier than it did.
//! On Fanuc and SINUMERIK controls the builder decides about the other M codes: they act with the motion or after it.

use crate::dialect::Dialect;
use crate::program::{Language, Program};
use crate::sinumerik::names::Name;
use crate::word::{Word, WordKind};

/// Letters that describe a motion.
const MOTION_LETTERS: &[u8] = b"XYZABCIJKRF";
/// G codes of a feed block that take no P.
const WITHOUT_P: [f64; 15] = [0.0, 1.0, 2.0, 3.0, 17.0, 18.0, 19.0, 20.0, 21.0, 40.0, 90.0, 91.0, 93.0, 94.0, 95.0];
/// The same, of arc centres.
const CENTRE_MODES: [f64; 2] = [90.1, 91.1];
const LINUX_CNC_AFTER: [f64; 7] = [0.0, 1.0, 2.0, 30.0, 60.0, 98.0, 99.0];
/// With P: outputs that switch as the motion begins, on LinuxCNC and the controls that follow it.
const SWITCHED: [f64; 4] = [62.0, 63.0, 64.0, 65.0];
const FANUC_BEFORE: [f64; 6] = [3.0, 4.0, 7.0, 8.0, 13.0, 14.0];
const FANUC_AFTER: [f64; 11] = [0.0, 1.0, 2.0, 5.0, 9.0, 30.0, 60.0, 97.0, 98.0, 99.0, 198.0];
const SINUMERIK_BEFORE: [f64; 4] = [3.0, 4.0, 7.0, 8.0];
const SINUMERIK_AFTER: [f64; 7] = [0.0, 1.0, 2.0, 5.0, 9.0, 17.0, 30.0];
/// Comments that LinuxCNC acts on (G-Code Overview, "Messages", "Probe Logging", "Debug Messages").
const ACTIVE_COMMENTS: [&[u8]; 8] = [b"MSG", b"DEBUG", b"PRINT", b"LOG", b"PROBEOPEN", b"PROBECLOSE", b"ABORT", b"PY"];

/// When a word acts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Acting {
    /// Part of the motion.
    Motion,
    /// Belongs to another word, or does nothing.
    Indifferent,
    Before,
    After,
    /// The builder of the machine decides.
    Unclear,
}

/// Whether a word belongs to the motion of a feed move: G0-G3, axis, arc and feed words; in dialogue also path function, direction and radius
/// compensation.
pub fn is_motion_word(word: &Word) -> bool {
    match word.kind {
        WordKind::Number | WordKind::Expression if word.letter == b'G' => [0.0, 1.0, 2.0, 3.0].contains(&word.value),
        WordKind::Number | WordKind::Expression => MOTION_LETTERS.contains(&word.letter) || word.name == Name::Turn,
        WordKind::Motion => true,
        _ => false,
    }
}

/// Whether another word of the block than an arc may take its P.
pub(crate) fn takes_p(words: &[Word]) -> bool {
    let takes = |word: &Word| match word.letter {
        b'M' => true,
        b'G' => !(WITHOUT_P.contains(&word.value) || CENTRE_MODES.contains(&word.value)),
        _ => false,
    };
    words.iter().any(takes)
}

/// When a word of `block` acts.
pub(crate) fn acting(program: &Program, block: usize, word: &Word, dialect: Dialect) -> Acting {
    match word.kind {
        WordKind::Comment if dialect == Dialect::LinuxCnc && is_active(program.text(word.span)) => Acting::Before,
        WordKind::Comment => Acting::Indifferent,
        _ if is_motion_word(word) => Acting::Motion,
        WordKind::Keyword if word.name == Name::Label => Acting::Indifferent,
        // The control waits for the spindle at the end of the block.
        _ if word.name == Name::Holds => Acting::Unclear,
        // Auxiliary functions of the builder; calls.
        _ if dialect == Dialect::Sinumerik && b"HLP".contains(&word.letter) => Acting::Unclear,
        WordKind::Number | WordKind::Expression => match word.letter {
            b'P' if !takes_p(program.block_words(block)) => Acting::Motion,
            b'N' | b'P' | b'L' | b'Q' => Acting::Indifferent,
            b'M' if SWITCHED.contains(&word.value) && program.find(block, b'P').is_some() => Acting::Before,
            b'M' if program.language() == Language::Dialogue => code(word.value, Dialect::Fanuc),
            b'M' => code(word.value, dialect),
            _ => Acting::Before,
        },
        _ => Acting::Before,
    }
}

/// Whether an M code acts at the same time in the dialects that share their codes. M5 and M9 do not.
pub(crate) fn acts_alike(program: &Program, block: usize, word: &Word) -> bool {
    let when = |dialect| acting(program, block, word, dialect);
    !word.is(b'M') || when(Dialect::Fanuc) == when(Dialect::LinuxCnc)
}

fn code(number: f64, dialect: Dialect) -> Acting {
    match dialect {
        Dialect::LinuxCnc if LINUX_CNC_AFTER.contains(&number) => Acting::After,
        Dialect::LinuxCnc => Acting::Before,
        Dialect::Fanuc if FANUC_BEFORE.contains(&number) => Acting::Before,
        Dialect::Fanuc if FANUC_AFTER.contains(&number) => Acting::After,
        Dialect::Sinumerik if SINUMERIK_BEFORE.contains(&number) => Acting::Before,
        Dialect::Sinumerik if SINUMERIK_AFTER.contains(&number) => Acting::After,
        Dialect::Fanuc | Dialect::Sinumerik => Acting::Unclear,
    }
}

fn is_active(comment: &[u8]) -> bool {
    let text = comment.trim_ascii_start().strip_prefix(b"(").unwrap_or(comment).trim_ascii_start();
    let starts = |word: &&[u8]| text.len() >= word.len() && text[..word.len()].eq_ignore_ascii_case(word);
    ACTIVE_COMMENTS.iter().any(starts)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parse;

    fn of(text: &str, dialect: Dialect) -> Vec<Acting> {
        let program = parse(text);
        program.block_words(0).iter().map(|word| acting(&program, 0, word, dialect)).collect()
    }

    #[test]
    fn spindle_and_coolant_stop_before_the_motion_on_linuxcnc_and_after_it_on_fanuc() {
        use Acting::*;
        for (code, linux_cnc, fanuc) in
            [("M5", Before, After), ("M9", Before, After), ("M3", Before, Before), ("M0", After, After), ("M62", Before, Unclear)]
        {
            assert_eq!(of(code, Dialect::LinuxCnc), [linux_cnc], "{code}");
            assert_eq!(of(code, Dialect::Fanuc), [fanuc], "{code}");
        }
    }

    #[test]
    fn the_turns_of_an_arc_belong_to_its_motion() {
        use Acting::*;
        assert_eq!(of("G3 X1 P2", Dialect::LinuxCnc), [Motion, Motion, Motion]);
        assert_eq!(of("G3 X1 M62 P2", Dialect::LinuxCnc), [Motion, Motion, Before, Indifferent]);
        assert_eq!(of("G64 P.1 X1", Dialect::LinuxCnc), [Before, Indifferent, Motion]);
    }

    #[test]
    fn messages_act_and_remarks_do_not() {
        assert_eq!(of("(msg, turn it)", Dialect::LinuxCnc), [Acting::Before]);
        assert_eq!(of("(a message)", Dialect::LinuxCnc), [Acting::Indifferent]);
        assert_eq!(of("(msg, turn it)", Dialect::Fanuc), [Acting::Indifferent]);
    }
}
