//! Blocks that others name by their numbers, to repeat them or to jump there, in ways that are not interpreted: NUM `G77 N60 N70`, Fagor `G25 N60.70.2`
//! and `#RPT[N60,N70,2]`, MAHO `G14 N1=60 N2=70`, Selca `RPT 2 N60 N70`; or by labels, as contours of cycles: SINUMERIK `CYCLE72("FROM:TO",…)` and
//! `CYCLE62(,2,"FROM","TO")` (SINUMERIK ONE, "NC programming", "Technology cycles"), Heidenhain `CYCL DEF 14.1 CONTOUR LABEL 1 /2` and
//! `CONTOUR DEF P1 = LBL 1` (TNC 640, "Cycle programming", "SL cycles").
//!
//! The number of a block that is split stays with its first line: what ends there would end within its move.

use std::collections::HashMap;
use std::sync::Arc;

use crate::dialect::{Dialect, Options};
use crate::program::{Language, Program};
use crate::word::{Word, WordKind};

/// Ranges of blocks, first and last, that another block names.
#[derive(Clone, Debug, Default)]
pub(crate) struct NamedBlocks(Arc<[(usize, usize)]>);

impl NamedBlocks {
    /// The ranges of a program that may be of a control with such blocks.
    pub fn of(program: &Program, options: &Options) -> Self {
        match program.language() {
            Language::Dialogue => return Self(contours_of_dialogue(program).into()),
            Language::Sinumerik => return Self(contours_of_sinumerik(program).into()),
            Language::Rs274 if options.dialect != Dialect::Fanuc => return Self::default(),
            Language::Rs274 => {}
        }
        let blocks = 0..program.blocks().len();
        let named: Vec<Vec<u32>> =
            blocks.clone().map(|block| named_in(program, block)).filter(|named| !named.is_empty()).collect();
        if named.is_empty() {
            return Self::default();
        }
        let numbers: HashMap<u32, usize> = blocks.filter_map(|block| Some((number_of(program, block)?, block))).collect();
        let range = |named: Vec<u32>| {
            let found = || named.iter().filter_map(|number| numbers.get(number).copied());
            Some((found().min()?, found().max()?))
        };
        Self(named.into_iter().filter_map(range).collect())
    }

    /// Whether a block is within one of the ranges.
    pub fn hold(&self, block: usize) -> bool {
        self.0.iter().any(|(first, last)| (*first..=*last).contains(&block))
    }
}

/// The text of every block in capitals, without what stands behind `;`.
fn texts(program: &Program) -> impl Iterator<Item = (usize, String)> {
    program.blocks().iter().enumerate().map(|(index, block)| {
        let text = String::from_utf8_lossy(program.text(block.span)).to_uppercase();
        (index, text.split(';').next().unwrap_or_default().to_owned())
    })
}

/// Cycles whose contour may lie between labels of the program.
const CONTOUR_CYCLES: [&str; 5] = ["CYCLE62", "CYCLE63", "CYCLE64", "CYCLE72", "CYCLE73"];

/// The contours between two labels that a cycle of SINUMERIK names in quotes.
fn contours_of_sinumerik(program: &Program) -> Vec<(usize, usize)> {
    let calls: Vec<Vec<String>> = texts(program)
        .filter(|(_, text)| CONTOUR_CYCLES.iter().any(|cycle| text.contains(cycle)))
        .map(|(_, text)| {
            text.split('"').skip(1).step_by(2).flat_map(|name| name.split(':')).map(|name| name.trim().to_owned()).collect()
        })
        .collect();
    if calls.is_empty() {
        return Vec::new();
    }
    let label = |text: &str| {
        let (before, after) = text.split_once(':')?;
        let name = before.split_whitespace().last()?;
        (!after.starts_with('=')).then(|| name.to_owned())
    };
    let labels: HashMap<String, usize> = texts(program).filter_map(|(block, text)| Some((label(&text)?, block))).collect();
    let range = |names: Vec<String>| {
        let found = || names.iter().filter_map(|name| labels.get(name).copied());
        Some((found().min()?, found().max()?))
    };
    calls.into_iter().filter_map(range).collect()
}

/// The contours from a label to the end of its subprogram that a cycle of Heidenhain names.
fn contours_of_dialogue(program: &Program) -> Vec<(usize, usize)> {
    let is_sign = |sign: char| sign.is_whitespace() || matches!(sign, '/' | '=' | ',' | '"');
    let words = |text: &str| text.split(is_sign).filter(|word| !word.is_empty()).map(str::to_owned).collect::<Vec<_>>();
    let lines: Vec<Vec<String>> = texts(program).map(|(_, text)| words(&text)).collect();
    let named = |words: &Vec<String>| -> Vec<String> {
        if let Some(at) = words.iter().position(|word| word == "14.1") {
            return words[at + 1..].iter().filter(|word| word.parse::<u32>().is_ok()).cloned().collect();
        }
        let is_contour = words.windows(2).any(|pair| pair[0] == "CONTOUR" && pair[1] == "DEF");
        words.windows(2).filter(|pair| is_contour && pair[0] == "LBL").map(|pair| pair[1].clone()).collect()
    };
    let named: Vec<String> = lines.iter().flat_map(named).collect();
    let label = |words: &Vec<String>| match words.as_slice() {
        [word, name, ..] if word == "LBL" => Some(name.clone()),
        [first, word, name, ..] if word == "LBL" && first != "CALL" => Some(name.clone()),
        _ => None,
    };
    let begins = |block: &usize| label(&lines[*block]).is_some_and(|name| named.contains(&name));
    let ends = |from: usize| (from + 1..lines.len()).find(|block| label(&lines[*block]).is_some_and(|name| name == "0"));
    (0..lines.len()).filter(begins).map(|from| (from, ends(from).unwrap_or(lines.len()))).collect()
}

/// The word with the number of a block.
fn own_number(program: &Program, block: usize) -> Option<&Word> {
    let mut words = program.block_words(block).iter().filter(|word| word.kind != WordKind::BlockDelete);
    words.next().filter(|word| word.is(b'N'))
}

fn number_of(program: &Program, block: usize) -> Option<u32> {
    let number = own_number(program, block)?.number()?;
    (number >= 0.0 && number.fract() == 0.0 && number <= f64::from(u32::MAX)).then_some(number as u32)
}

/// The block numbers behind the own one of a block: up to two for every N.
fn named_in(program: &Program, block: usize) -> Vec<u32> {
    let own = own_number(program, block).map(|word| word.span.start);
    let words = program.block_words(block).iter();
    let rest = words.filter(|word| word.kind != WordKind::Comment && Some(word.span.start) != own);
    // Hardly any block has an N but its own.
    if !rest.clone().any(|word| program.text(word.span).iter().any(|byte| matches!(byte, b'N' | b'n'))) {
        return Vec::new();
    }
    let text: Vec<u8> = rest.flat_map(|word| program.text(word.span)).copied().filter(|byte| *byte != b' ').collect();
    let begins = |at: &usize| text[*at].eq_ignore_ascii_case(&b'N') && (*at == 0 || !text[*at - 1].is_ascii_alphabetic());
    let numbers = |at: usize| {
        let is_of_number = |byte: &&u8| byte.is_ascii_digit() || matches!(byte, b'.' | b'=');
        let value: Vec<u8> = text[at + 1..].iter().take_while(is_of_number).copied().collect();
        // `N1=60`: the name of a parameter.
        let value = value.rsplit(|byte| *byte == b'=').next().unwrap_or_default().to_owned();
        let parts = value.split(|byte| *byte == b'.').take(2);
        parts.filter_map(|part| std::str::from_utf8(part).ok()?.parse().ok()).collect::<Vec<u32>>()
    };
    (0..text.len()).filter(begins).flat_map(numbers).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn named(statement: &str) -> Vec<u32> {
        let program = crate::parse(format!("N10 G1 X5\nN20 {statement}\n"));
        named_in(&program, 1)
    }

    #[test]
    fn numbers_are_read_in_every_form() {
        for statement in ["G77 N60 N70", "G77N60N70", "G25 N60.70.2", "#RPT[N60,N70,2]", "G14 N1=60 N2=70 J2", "RPT 2 N60 N70"] {
            assert_eq!(named(statement), [60, 70], "{statement}");
        }
        for statement in ["G1 X5", "X20 (AS IN N60)", "M98 P60", "#NAME=60", "T1 M6"] {
            assert_eq!(named(statement), [], "{statement}");
        }
    }

    #[test]
    fn contours_between_labels_are_held() {
        let cycle = "G71\nN10 KA: G1 X30 F2400\nG1 Y30\nKE: G1 X0\nG0 Z5\nCYCLE72(\"KA:KE\",10,0,1)\n";
        assert_eq!(contours_of_sinumerik(&crate::parse(cycle)), [(1, 3)]);
        let call = "CYCLE62(,2,\"ka\",\"ke\")\nKA:\nG1 X30\nKE:\nG0 Z5\nMSG(\"KA\")\n";
        assert_eq!(contours_of_sinumerik(&crate::parse(call)), [(1, 3)]);
        assert_eq!(contours_of_sinumerik(&crate::parse("KA: G1 X30\nKE: G1 X0\nREPEAT KA KE\n")), []);
        let dialogue = "0 BEGIN PGM A MM\n1 CYCL DEF 14.1 KONTURLABEL 1 /3\n2 LBL 1\n3 L X+30\n4 LBL 0\n5 LBL 2\n6 LBL 0\n7 LBL 3\n8 L X+0\n9 LBL 0\n";
        assert_eq!(contours_of_dialogue(&crate::parse(dialogue)), [(2, 4), (7, 9)]);
        let named = "0 BEGIN PGM A MM\n1 CONTOUR DEF P1 = LBL \"OUT\" I2 = LBL 4\n2 LBL \"OUT\"\n3 L X+30\n4 LBL 0\n";
        assert_eq!(contours_of_dialogue(&crate::parse(named)), [(2, 4)]);
    }
}
