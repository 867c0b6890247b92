//! Words: the smallest parts of a block, each with its byte range.

use std::ops::Range;

use crate::sinumerik::names::Name;

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

    /// Whether the span is empty.
    pub fn is_empty(self) -> bool {
        self.end <= self.start
    }
}

/// Kind of a word.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum WordKind {
    /// A letter and a number: `X1.5`, `G 1`, `N10`, `O1234`; in SINUMERIK programs also `X=1.5`, `CR=5` (as R), `RND=2` (no letter).
    Number,
    /// A letter and a parameter or an expression: `X#101`, `X[#1+2]`, `Z-#<depth>`, `X=R1+2`, `X=IC(5)`.
    Expression,
    /// An assignment: `#501=1`, `#<name> = [#1*2]`, `R1=5`, `$P_UIFR[1,X,TR]=10`.
    Assignment,
    /// A flow statement up to the end of its line: `o100 sub`, `O<f> call [1]`, `IF[#1EQ0]GOTO10`, `WHILE[1]DO1`,
    /// `IF R1>5 GOTOF END`.
    Flow,
    /// A comment, in parentheses (perhaps unclosed) or after a semicolon.
    Comment,
    /// Block delete: `/` or `/2` at the start of a block.
    BlockDelete,
    /// The tape mark `%`.
    Percent,
    /// A word of a positioning block of dialogue whose name is no single letter: `L`, `DR+`, `IX-5`, `FMAX`.
    Motion,
    /// Another word of dialogue: `TOOL`, `CYCL`, `"MILL"`, `7.1`; a name of SINUMERIK: `TRANS`, `SUPA`, `CYCLE81(…)`, `LABEL:`.
    Keyword,
    /// Anything else, kept unchanged.
    Unknown,
}

/// One word of a block.
#[derive(Clone, Copy, Debug)]
pub struct Word {
    /// Every byte of the word: letter, blanks inside, value.
    pub span: Span,
    /// Offset of the first byte of the value (the number or the expression after the letter).
    pub value_start: u32,
    /// Kind of the word.
    pub kind: WordKind,
    /// Address letter in upper case, 0 for words without one.
    pub letter: u8,
    /// Value, correctly rounded. For a [`WordKind::Expression`] that of its first execution, if the program was evaluated and the value is
    /// known. NaN otherwise, and for words of dialogue without a number.
    pub value: f64,
    /// What a word of SINUMERIK names besides its letter.
    pub(crate) name: Name,
}

impl Word {
    /// Value of a word such as `X1.5`, or of an expression whose value is known. `None` for comments and other kinds.
    pub fn number(&self) -> Option<f64> {
        (matches!(self.kind, WordKind::Number | WordKind::Expression) && !self.value.is_nan()).then_some(self.value)
    }

    /// The bytes of the value alone. An edit of a coordinate replaces them.
    pub fn value_span(&self) -> Span {
        Span { start: self.value_start, end: self.span.end }
    }

    /// Whether the word is a label, a message or another name of SINUMERIK without effect on path and frame.
    pub fn is_silent(&self) -> bool {
        matches!(self.name, Name::Silent | Name::Holds | Name::Label)
    }

    /// Whether the word has this address letter (upper case) and a value.
    pub fn is(&self, letter: u8) -> bool {
        self.letter == letter && matches!(self.kind, WordKind::Number | WordKind::Expression)
    }
}

/// Offset of the byte `at` of a line that begins at `base`. It fits: a program is split only up to `u32::MAX` bytes.
pub(crate) fn offset(base: u32, at: usize) -> u32 {
    base.saturating_add(u32::try_from(at).unwrap_or(u32::MAX))
}

/// A word without a letter and a value, from `at` to `end` of a line that begins at `base`.
pub(crate) fn plain(kind: WordKind, at: usize, end: usize, base: u32) -> Word {
    let span = Span { start: offset(base, at), end: offset(base, end) };
    Word { span, value_start: span.start, kind, letter: 0, value: f64::NAN, name: Name::None }
}
