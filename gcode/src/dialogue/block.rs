//! The words of one block by name.

use crate::program::Program;
use crate::word::{Span, Word, WordKind};

/// Words of a block without its number and comments.
#[derive(Debug)]
pub(super) struct Block<'a> {
    program: &'a Program,
    pub words: Vec<Word>,
    /// Whether a switch may skip the block.
    pub is_optional: bool,
}

impl<'a> Block<'a> {
    pub fn of(program: &'a Program, block: usize) -> Self {
        let all = program.block_words(block);
        let is_content = |word: &&Word| !matches!(word.kind, WordKind::Comment | WordKind::BlockDelete) && !word.is(b'N');
        let words = all.iter().filter(is_content).copied().collect();
        Self { program, words, is_optional: all.iter().any(|word| word.kind == WordKind::BlockDelete) }
    }

    /// The block without its first `count` words.
    pub fn without(&self, count: usize) -> Self {
        Self { words: self.words.iter().skip(count).copied().collect(), ..*self }
    }

    /// Name of a word in upper case: the letters before its value. Empty for numbers.
    pub fn name(&self, word: &Word) -> Vec<u8> {
        self.program.text(Span { start: word.span.start, end: word.value_start }).to_ascii_uppercase()
    }

    /// Text of a word in upper case.
    pub fn text(&self, word: &Word) -> Vec<u8> {
        self.program.text(word.span).to_ascii_uppercase()
    }

    /// Whether the block begins with these words.
    pub fn begins(&self, names: &[&str]) -> bool {
        names.len() <= self.words.len() && self.words.iter().zip(names).all(|(word, name)| self.text(word) == name.as_bytes())
    }

    /// Whether the block has the word `name` without a value.
    pub fn has(&self, name: &str) -> bool {
        self.words.iter().any(|word| self.text(word) == name.as_bytes())
    }

    /// Value of the word `name`, if it is a number.
    pub fn value(&self, name: &str) -> Option<f64> {
        self.words.iter().find(|word| self.name(word) == name.as_bytes()).map(|word| word.value).filter(|value| value.is_finite())
    }

    /// The whole number at a place among the words.
    pub fn number_at(&self, index: usize) -> Option<u32> {
        let value = self.words.get(index).map(|word| word.value).filter(|value| (0.0..=1e6).contains(value))?;
        Some(value as u32)
    }
}

/// Whether a line belongs to the block of the line before it, which ends in `~`.
pub(super) fn continues(program: &Program, block: usize) -> bool {
    let Some(before) = block.checked_sub(1).and_then(|before| program.blocks().get(before)) else { return false };
    let numbered = program.block_words(block).first().is_some_and(|word| word.is(b'N'));
    !numbered && program.text(before.span).trim_ascii_end().ends_with(b"~")
}
