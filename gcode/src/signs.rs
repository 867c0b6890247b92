//! Signs of a dialect: codes and forms that only one of Fanuc and LinuxCNC has. Each kind counts once, whatever its number of occurrences.

use crate::program::Program;
use crate::word::{Word, WordKind};

/// Weight of a form that the other control refuses.
const STRONG: i32 = 3;
/// Weight of a code that the other control lacks, or reads in another way.
const WEAK: i32 = 1;
/// Least lead that leaves no doubt.
pub(crate) const CERTAIN: i32 = 2;

/// LinuxCNC: spindle-synchronized motion, probing, tool offset, work offsets 7 to 9, exact stop, restored offset.
const LINUX_CNC_G: [f64; 9] = [33.1, 38.2, 38.3, 43.1, 59.1, 59.2, 59.3, 61.1, 92.3];
/// Fanuc: look-ahead, more work offsets, macros, units of older controls.
const FANUC_G: [f64; 6] = [8.0, 54.1, 65.0, 66.0, 70.0, 71.0];
/// Fanuc: subprograms, rigid tapping.
const FANUC_M: [f64; 3] = [29.0, 98.0, 99.0];
/// LinuxCNC: outputs and inputs, with the number of the pin in P or E.
const PIN_M: std::ops::RangeInclusive<f64> = 62.0..=68.0;

/// The kinds of signs that a program holds.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Signs {
    /// `o100 sub`, `o<name> call`.
    o_words: bool,
    /// `#<depth>`.
    named_parameters: bool,
    /// `G64 P0.01`: on other controls G64 takes no words.
    tolerance: bool,
    linux_cnc_codes: i32,
    /// `G5.1 X1 Y1 I1 J1`: a spline.
    splines: bool,
    pins: bool,
    /// `O1234`: LinuxCNC refuses an O without a keyword.
    program_number: bool,
    /// `G5.1 Q1`.
    contour_control: bool,
    /// `IF[#1EQ0]GOTO10`.
    macro_statements: bool,
    /// `$H`, `$X`: commands of Grbl. Its codes are read as Fanuc's, but M5 and M9 act before the motion as on LinuxCNC, so that a doubt stays.
    grbl_commands: bool,
    fanuc_codes: i32,
}

impl Signs {
    pub fn of(program: &Program) -> Self {
        let mut signs = Self::default();
        let (mut linux_cnc, mut fanuc) = ([false; LINUX_CNC_G.len()], [false; FANUC_G.len() + FANUC_M.len()]);
        for block in 0..program.blocks().len() {
            let words = program.block_words(block);
            for word in words {
                signs.note(program.text(word.span), word, words);
                if word.kind == WordKind::Number && b"GM".contains(&word.letter) {
                    mark(&mut linux_cnc, &LINUX_CNC_G, word, b'G');
                    mark(&mut fanuc[..FANUC_G.len()], &FANUC_G, word, b'G');
                    mark(&mut fanuc[FANUC_G.len()..], &FANUC_M, word, b'M');
                }
            }
        }
        let count = |found: &[bool]| found.iter().map(|found| i32::from(*found)).sum();
        Self { linux_cnc_codes: count(&linux_cnc), fanuc_codes: count(&fanuc), ..signs }
    }

    fn note(&mut self, text: &[u8], word: &Word, block: &[Word]) {
        let has = |letters: &[u8]| block.iter().any(|word| letters.iter().any(|letter| word.is(*letter)));
        match (word.kind, word.letter) {
            (WordKind::Flow, _) if text.first().is_some_and(|b| b.eq_ignore_ascii_case(&b'o')) => self.o_words = true,
            (WordKind::Flow, _) => self.macro_statements = true,
            (WordKind::Unknown, _) if text.first() == Some(&b'$') => self.grbl_commands = true,
            (WordKind::Assignment | WordKind::Expression, _) if text.contains(&b'<') => self.named_parameters = true,
            (WordKind::Number, b'O') => self.program_number = true,
            (WordKind::Number, b'G') if word.value == 64.0 => self.tolerance |= has(b"PQ"),
            (WordKind::Number, b'G') if word.value == 5.1 => {
                self.contour_control |= has(b"Q");
                self.splines |= has(b"IJ") && !has(b"Q");
            }
            (WordKind::Number, b'M') if PIN_M.contains(&word.value) => self.pins |= has(b"PE"),
            _ => {}
        }
    }

    fn linux_cnc(&self) -> i32 {
        let strong = [self.o_words, self.named_parameters, self.tolerance].map(i32::from).iter().sum::<i32>();
        STRONG * strong + WEAK * (self.linux_cnc_codes + i32::from(self.pins) + i32::from(self.splines))
    }

    fn fanuc(&self) -> i32 {
        let strong = [self.program_number, self.macro_statements].map(i32::from).iter().sum::<i32>();
        STRONG * strong + WEAK * (self.fanuc_codes + i32::from(self.contour_control) + i32::from(self.grbl_commands))
    }

    /// By how much the signs of LinuxCNC outweigh those of Fanuc; negative where those of Fanuc do.
    pub fn lead_of_linux_cnc(&self) -> i32 {
        self.linux_cnc() - self.fanuc()
    }
}

fn mark(found: &mut [bool], codes: &[f64], word: &Word, letter: u8) {
    if let Some(index) = codes.iter().position(|code| word.letter == letter && *code == word.value) {
        found[index] = true;
    }
}

#[cfg(test)]
mod tests {
    use crate::{Dialect, parse};

    #[test]
    fn a_sign_counts_once() {
        let dwells = "%\nO01234 (HAAS)\nG4 P0.5\nG4 P0.5\nG4 P0.5\nM30\n%\n";
        let pins = "%\nO1\nM68 E0 Q1\nM68 E0 Q2\nM68 E0 Q3\nM68 E0 Q4\nM30\n";
        for text in [dwells, pins] {
            assert_eq!(Dialect::detect(&parse(text)), Dialect::Fanuc, "{text}");
            assert!(Dialect::Fanuc.is_certain(&parse(text)), "{text}");
        }
    }

    #[test]
    fn seconds_with_decimals_and_codes_of_the_builder_say_nothing() {
        let program = parse("G0 X1\nG4 P0.3\nM68\nM2");
        assert_eq!(Dialect::detect(&program), Dialect::Fanuc);
        assert!(!Dialect::Fanuc.is_certain(&program));
    }

    #[test]
    fn the_words_beside_g5_1_decide() {
        assert_eq!(Dialect::detect(&parse("G5.1 X1 Y1 I1 J0\nG1 X2 F100")), Dialect::LinuxCnc);
        assert_eq!(Dialect::detect(&parse("G43.1 Z5\nG5.1 Q3 X0 Y0\nM98 P1")), Dialect::Fanuc);
    }

    #[test]
    fn commands_of_grbl_leave_a_doubt() {
        let program = parse("$H\nG21 G90\nG38.2 Z-10 F50\nG1 X2 F100");
        assert_eq!(Dialect::detect(&program), Dialect::Fanuc);
        assert!(!Dialect::Fanuc.is_certain(&program));
    }

    #[test]
    fn a_single_code_leaves_a_doubt() {
        let program = parse("G43.1 Z5\nG1 X1 F100\nM2");
        assert_eq!(Dialect::detect(&program), Dialect::LinuxCnc);
        assert!(!Dialect::LinuxCnc.is_certain(&program));
        assert!(Dialect::LinuxCnc.is_certain(&parse("G64 P0.01\nG1 X1 F100\nM2")));
    }
}
