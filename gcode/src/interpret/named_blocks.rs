//! Blocks that others name by their numbers, to repeat them or to jump there, in ways that are not interpreted: NUM `G77 N60 N70`, Fagor `G25 N60.70.2`
//! and `#RPT[N60,N70,2]`, MAHO `G14 N1=60 N2=70`, Selca `RPT 2 N60 N70`.
//!
//! The number of a block that is split stays with its first line: what ends there would end within its move.

use std::collections::HashMap;
use std::sync::Arc;

use crate::dialect::{Dialect, Options};
use crate::program::Program;
use crate::word::{Word, WordKind};

/// Ranges of blocks, first and last, that another block names.
#[derive(Clone, Debug, Default)]
pub(super) struct NamedBlocks(Arc<[(usize, usize)]>);

impl NamedBlocks {
    /// The ranges of a program that may be of a control with such blocks.
    pub fn of(program: &Program, options: &Options) -> Self {
        if options.dialect != Dialect::Fanuc {
            return Self::default();
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
}
