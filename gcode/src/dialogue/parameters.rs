//! Q parameters that are set once, to a number.

use std::collections::BTreeMap;

use super::block::Block;
use crate::program::Program;
use crate::word::{Span, Word, WordKind};

/// Numbers of parameters, with the block that sets them.
#[derive(Debug, Default)]
pub(super) struct Constants(BTreeMap<u32, (usize, f64)>);

impl Constants {
    /// A parameter counts as constant if the only block that names it, beside positioning blocks, sets it to a number.
    pub fn of(program: &Program) -> Self {
        let mut set = BTreeMap::new();
        let mut named: BTreeMap<u32, usize> = BTreeMap::new();
        for index in 0..program.blocks().len() {
            let block = Block::of(program, index);
            if block.words.first().is_some_and(|word| word.kind == WordKind::Motion) || block.begins(&["CC"]) {
                continue;
            }
            for word in &block.words {
                if let Some(number) = number_of(program, word) {
                    *named.entry(number).or_default() += 1;
                }
            }
            if let Some((number, value)) = assignment(&block) {
                set.insert(number, (index, value));
            }
        }
        set.retain(|number, _| named.get(number) == Some(&1));
        Self(set)
    }

    /// Value of `+Q1`, `-Q1` or `Q1` in a block.
    pub fn value(&self, text: &[u8], block: usize) -> Option<f64> {
        let (sign, name) = match text {
            [b'-', rest @ ..] => (-1.0, rest),
            [b'+', rest @ ..] => (1.0, rest),
            rest => (1.0, rest),
        };
        let number = std::str::from_utf8(name.get(1..)?).ok()?.parse().ok()?;
        let is_plain = name[0].eq_ignore_ascii_case(&b'Q');
        self.0.get(&number).filter(|(set, _)| is_plain && *set < block).map(|(_, value)| sign * value)
    }
}

/// `Q1 = +5` or `FN 0: Q1 = +5`.
fn assignment(block: &Block<'_>) -> Option<(u32, f64)> {
    let words = if block.begins(&["FN", "0", ":"]) { &block.words[3..] } else { &block.words[..] };
    let [parameter, equals, number] = words else { return None };
    let is_plain = parameter.is(b'Q') && block.text(equals) == b"=" && block.name(number).is_empty();
    (is_plain && number.value.is_finite()).then_some((parameter.value as u32, number.value))
}

/// Number of the parameter that a word names.
fn number_of(program: &Program, word: &Word) -> Option<u32> {
    if word.kind == WordKind::Number && word.letter == b'Q' {
        return Some(word.value as u32);
    }
    let value = program.text(Span { start: word.value_start, end: word.span.end });
    let value = value.strip_prefix(b"+").or(value.strip_prefix(b"-")).unwrap_or(value);
    let digits = value.strip_prefix(b"Q").or(value.strip_prefix(b"q"))?;
    std::str::from_utf8(digits).ok()?.parse().ok()
}
