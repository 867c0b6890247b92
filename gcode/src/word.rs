//! Words: the smallest pieces of a block, each tied to the bytes that it was read from.

use std::ops::Range;

/// A half-open range of byte offsets into the program.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Span {
    /// Offset of the first byte.
    pub start: u32,
    /// Offset one past the last byte.
    pub end: u32,
}

impl Span {
    /// The range as array indices.
    pub fn range(self) -> Range<usize> {
        self.start as usize..self.end as usize
    }

    /// Number of bytes covered.
    pub fn len(self) -> usize {
        self.end.saturating_sub(self.start) as usize
    }

    /// Whether no byte is covered.
    pub fn is_empty(self) -> bool {
        self.end <= self.start
    }
}

/// What a word is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum WordKind {
    /// A letter and a number: `X1.5`, `G 1`, `N10`, `O1234`.
    Number,
    /// A letter and a parameter or an expression: `X#101`, `X[#1+2]`, `Z-#<depth>`.
    Expression,
    /// An assignment: `#501=1`, `#<name> = [#1*2]`.
    Assignment,
    /// A flow statement up to the end of its line: `o100 sub`, `O<f> call [1]`, `IF[#1EQ0]GOTO10`, `WHILE[1]DO1`.
    Flow,
    /// A comment, in parentheses (perhaps never closed) or after a semicolon.
    Comment,
    /// Block delete: `/` or `/2` at the head of a block.
    BlockDelete,
    /// The tape mark `%`.
    Percent,
    /// Anything else, kept as it stands.
    Unknown,
}

/// One word of a block.
#[derive(Clone, Copy, Debug)]
pub struct Word {
    /// Every byte of the word: letter, blanks inside, value.
    pub span: Span,
    /// Offset of the first byte of the value (the number or the expression after the letter).
    pub value_start: u32,
    /// What the word is.
    pub kind: WordKind,
    /// The address letter in upper case, or 0 for words without one.
    pub letter: u8,
    /// The number, correctly rounded; NaN for words that are not [`WordKind::Number`].
    pub value: f64,
}

impl Word {
    /// The number of a word such as `X1.5`; `None` for expressions, comments and the like.
    pub fn number(&self) -> Option<f64> {
        (self.kind == WordKind::Number).then_some(self.value)
    }

    /// The bytes of the value alone, which is what an edit of a coordinate replaces.
    pub fn value_span(&self) -> Span {
        Span { start: self.value_start, end: self.span.end }
    }

    /// Whether the word has this address letter (upper case) and a value.
    pub fn is(&self, letter: u8) -> bool {
        self.letter == letter && matches!(self.kind, WordKind::Number | WordKind::Expression)
    }
}
