//! A program: its bytes, blocks and words.

use crate::dialogue::lexer as dialogue;
use crate::execution::{Execution, Ran, Step};
use crate::lexer::lex_line;
use crate::number::is_blank;
use crate::sinumerik::lexer as sinumerik;
use crate::sinumerik::names::Name;
use crate::sinumerik::signs::is_sinumerik;
use crate::word::{Span, Word, WordKind, plain};

/// UTF-8 byte order mark. It stays at the head of the file and belongs to no block.
pub(crate) const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";

/// Language of a program.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Language {
    /// RS-274, "G-code".
    #[default]
    Rs274,
    /// Heidenhain dialogue (Klartext): programs that begin with `BEGIN PGM`.
    Dialogue,
    /// SINUMERIK: programs with its own codes or forms, such as `X=10`, `CYCLE800(…)`, `%_N_PART_MPF`.
    Sinumerik,
}

/// One line of a program.
#[derive(Clone, Copy, Debug)]
pub struct Block {
    /// The bytes of the line without its ending.
    pub span: Span,
    /// Offset past the line ending (equal to `span.end` if the last line has none).
    pub next: u32,
    first_word: u32,
}

/// A part program: unchanged bytes, split into blocks and words that refer to byte ranges.
///
/// Block `i` is line `i + 1`. Offsets have 32 bits: bytes beyond 4 GiB are kept but not split (see
/// [`Program::is_whole`]).
#[derive(Clone, Debug, Default)]
pub struct Program {
    bytes: Vec<u8>,
    language: Language,
    blocks: Vec<Block>,
    words: Vec<Word>,
    /// Number of words that stand in the program. Those behind them were executed again, with other values.
    own_words: usize,
    execution: Option<Box<Execution>>,
}

/// Splits any bytes into blocks and words. It never fails: unrecognised bytes become
/// [`WordKind::Unknown`].
///
/// Time and memory are linear in the length.
pub fn parse(bytes: impl Into<Vec<u8>>) -> Program {
    let bytes = bytes.into();
    let text = bytes.strip_prefix(BYTE_ORDER_MARK).unwrap_or(&bytes);
    let language = match text {
        text if dialogue::is_dialogue(text) => Language::Dialogue,
        text if is_sinumerik(text) => Language::Sinumerik,
        _ => Language::Rs274,
    };
    parse_in(bytes, language)
}

/// Splits a program of this language, whatever its bytes look like: a part of a program may lack the signs of its language.
pub fn parse_in(bytes: Vec<u8>, language: Language) -> Program {
    let limit = bytes.len().min(u32::MAX as usize);
    let text = &bytes[..limit];
    let mut blocks = Vec::with_capacity(limit / 24);
    let mut words = Vec::with_capacity(limit / 6);
    let mut start = if text.starts_with(BYTE_ORDER_MARK) { BYTE_ORDER_MARK.len() } else { 0 };
    let leader_end = if language == Language::Rs274 { start + leader_length(&text[start..]) } else { 0 };
    while start < limit {
        let length = text[start..].iter().position(|b| matches!(b, b'\n' | b'\r')).unwrap_or(limit - start);
        let end = start + length;
        // A file that was converted twice ends its lines with `\r\r\n`.
        let ending = match &text[end..] {
            [b'\r', b'\r', b'\n', ..] => 3,
            [b'\r', b'\n', ..] => 2,
            rest => rest.len().min(1),
        };
        let span = Span { start: start as u32, end: end as u32 };
        blocks.push(Block { span, next: (end + ending) as u32, first_word: words.len() as u32 });
        match language {
            _ if start < leader_end && length > 0 => words.push(plain(WordKind::Comment, 0, length, span.start)),
            Language::Rs274 => lex_line(&text[start..end], span.start, &mut words),
            Language::Dialogue => dialogue::lex_line(&text[start..end], span.start, &mut words),
            Language::Sinumerik => sinumerik::lex_line(&text[start..end], span.start, &mut words),
        }
        start = end + ending;
    }
    let own_words = words.len();
    Program { bytes, language, blocks, words, own_words, execution: None }
}

/// Lines of text among which the start of a program is sought.
const LEADER_LINES: usize = 200;

/// Length of the text before the program: lines of words before the first `%`, which controls skip (ISO 6983-1, "program start"). 0 where one of
/// them can be a block.
fn leader_length(text: &[u8]) -> usize {
    let mut length = 0;
    for line in text.split_inclusive(|byte| matches!(byte, b'\n' | b'\r')).take(LEADER_LINES) {
        let is_block = match line.trim_ascii() {
            [b'%', ..] => return length,
            [] | [b'(', ..] => false,
            [first, then @ ..] if first.is_ascii_alphabetic() => {
                let value = then.iter().find(|byte| !is_blank(**byte) && !b"+-".contains(byte));
                value.is_none_or(|value| !value.is_ascii_alphabetic())
            }
            [first, ..] => b"/#:;$&<[".contains(first),
        };
        if is_block {
            return 0;
        }
        length += line.len();
    }
    0
}

impl Program {
    /// The program's bytes, exactly as given to [`parse`].
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// The language in which the program is written.
    pub fn language(&self) -> Language {
        self.language
    }

    /// The same bytes, split as a program of this language.
    pub(crate) fn in_language(self, language: Language) -> Self {
        if self.language == language { self } else { parse_in(self.bytes, language) }
    }

    /// The blocks, one per line.
    pub fn blocks(&self) -> &[Block] {
        &self.blocks
    }

    /// All words of all blocks, in order. In an evaluated program ([`evaluate`](crate::evaluate)) the words of blocks that ran again follow.
    pub fn words(&self) -> &[Word] {
        &self.words
    }

    /// Indices into [`Program::words`] of the words of a block. Empty if the block does not exist.
    pub fn word_range(&self, block: usize) -> std::ops::Range<usize> {
        let Some(here) = self.blocks.get(block) else { return 0..0 };
        let end = self.blocks.get(block + 1).map_or(self.own_words, |next| next.first_word as usize);
        here.first_word as usize..end
    }

    /// The words of a block. Empty if the block does not exist.
    pub fn block_words(&self, block: usize) -> &[Word] {
        &self.words[self.word_range(block)]
    }

    /// Whether a word is MIRROR or AMIRROR of SINUMERIK.
    pub(crate) fn is_mirror_image(&self, word: &Word) -> bool {
        matches!(word.name, Name::Replace | Name::Add) && self.text(word.span).to_ascii_uppercase().ends_with(b"MIRROR")
    }

    /// Index of the first word of a block with this letter (upper case) and a value.
    pub fn find(&self, block: usize, letter: u8) -> Option<usize> {
        self.word_range(block).find(|index| self.words[*index].is(letter))
    }

    /// The bytes of a span. Empty if the span lies outside the program.
    pub fn text(&self, span: Span) -> &[u8] {
        self.bytes.get(span.range()).unwrap_or_default()
    }

    /// Index of the block that holds the byte at `offset`, or of the last block before it.
    pub fn block_at(&self, offset: u32) -> usize {
        self.blocks.partition_point(|block| block.span.start <= offset).saturating_sub(1)
    }

    /// The line ending of inserted lines: the first one of the program, or else a line feed.
    pub fn line_ending(&self) -> &'static [u8] {
        let first = self.blocks.first().map_or(&[][..], |block| &self.bytes[block.span.end as usize..block.next as usize]);
        match first {
            [b'\r', .., b'\n'] => b"\r\n",
            b"\r" => b"\r",
            _ => b"\n",
        }
    }

    /// Whether every byte was split into blocks. True for programs below 4 GiB.
    pub fn is_whole(&self) -> bool {
        self.bytes.len() <= u32::MAX as usize
    }

    /// The program as it runs, if it was evaluated.
    pub(crate) fn execution(&self) -> Option<&Execution> {
        self.execution.as_deref()
    }

    /// Sets how the program runs: values of its own words, the words of blocks that ran again, and the order of all.
    pub(crate) fn set_execution(&mut self, values: &[(usize, f64)], again: &[Word], execution: Execution) {
        self.words.truncate(self.own_words);
        for (index, value) in values {
            if let Some(word) = self.words.get_mut(*index) {
                word.value = *value;
            }
        }
        self.words.extend_from_slice(again);
        self.execution = Some(Box::new(execution));
    }

    /// An executed block by its place in the order of execution; without evaluation that is the order of the file.
    pub(crate) fn step(&self, index: usize) -> Option<Step> {
        if let Some(execution) = &self.execution {
            return execution.steps.get(index).copied();
        }
        let words = self.blocks.get(index).map(|_| self.word_range(index))?;
        Some(Step { block: index as u32, first_word: words.start as u32, end_word: words.end as u32, ran: Ran::Once })
    }

    /// Whether a block is executed once. True for every block of a program that was not evaluated.
    pub fn runs_once(&self, block: usize) -> bool {
        self.execution.as_ref().is_none_or(|execution| execution.runs_once(block))
    }

    /// Content of a subprogram file that [`evaluate`](crate::evaluate) read.
    pub fn subprogram_file(&self, name: &str) -> Option<&[u8]> {
        let files = &self.execution.as_ref()?.files;
        files.iter().find(|(known, _)| known == name).map(|(_, content)| content.as_slice())
    }

    /// Whether a block starts with a block-delete slash.
    pub fn is_optional(&self, block: usize) -> bool {
        self.block_words(block).iter().take(2).any(|word| word.kind == WordKind::BlockDelete)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn kinds(text: &str) -> Vec<(WordKind, String)> {
        let program = parse(text);
        program.words().iter().map(|w| (w.kind, String::from_utf8_lossy(program.text(w.span)).into_owned())).collect()
    }

    fn texts(text: &str) -> Vec<String> {
        kinds(text).into_iter().map(|(_, text)| text).collect()
    }

    #[test]
    fn words_need_no_spaces_and_may_have_them_inside() {
        assert_eq!(texts("N10G1X1.5Y-.2F100."), ["N10", "G1", "X1.5", "Y-.2", "F100."]);
        assert_eq!(texts("g 1 x 1 2 .5 y+ 3"), ["g 1", "x 1 2 .5", "y+ 3"]);
        let program = parse("g 1 x 1 2 .5");
        assert_eq!(program.words()[1].letter, b'X');
        assert_eq!(program.words()[1].value, 12.5);
        assert_eq!(program.text(program.words()[1].value_span()), b"1 2 .5");
    }

    #[test]
    fn line_endings_are_distinguished() {
        let program = parse("%\r\nG0\rG1\n\nG2");
        let lines: Vec<_> = program.blocks().iter().map(|b| (program.text(b.span), b.next - b.span.end)).collect();
        assert_eq!(lines, [(&b"%"[..], 2), (b"G0", 1), (b"G1", 1), (b"", 1), (b"G2", 0)]);
        assert_eq!(program.line_ending(), b"\r\n");
        assert_eq!(program.block_at(4), 1);
        assert_eq!(parse("").blocks().len(), 0);
        let twice = parse("%\r\r\nG1\r\r\n\r\r\nG2\r\rG3");
        let texts: Vec<_> = twice.blocks().iter().map(|b| twice.text(b.span)).collect();
        assert_eq!(texts, [&b"%"[..], b"G1", b"", b"G2", b"", b"G3"]);
        assert_eq!(twice.line_ending(), b"\r\n");
    }

    #[test]
    fn a_byte_order_mark_is_kept_before_the_first_block() {
        let program = parse("\u{feff}G1 X1\nX2\n");
        assert_eq!((program.bytes().len(), program.blocks()[0].span.start), (12, 3));
        assert_eq!(program.text(program.words()[0].span), b"G1");
        assert_eq!((program.block_at(0), program.block_at(3)), (0, 0));
        assert!(parse("\u{feff}").blocks().is_empty());
    }

    #[test]
    fn text_before_the_first_percent_sign_is_no_program() {
        use WordKind::*;
        let text = "POST 4.1, part 7\r\n\r\nG-CODE FOR MILL\r\n%\r\nO1\r\nG1 X2\r\n%\r\n";
        let found: Vec<_> = kinds(text).into_iter().map(|(kind, _)| kind).collect();
        assert_eq!(found, [Comment, Comment, Percent, Number, Number, Number, Percent]);
        // Blocks that run without a first sign end at one.
        for text in ["HELLO\nG1 X2\n%\n", "X2 Y3\n%\nG1\n", "HELLO\nG1 X2\n"] {
            assert!(kinds(text).iter().all(|(kind, _)| *kind != Comment), "{text}");
        }
    }

    #[test]
    fn every_kind_of_word_is_recognised() {
        use WordKind::*;
        let cases = [
            ("%", vec![Percent]),
            ("O1234(NAME", vec![Number, Comment]),
            ("/2 N1 G1 X2 ; rest", vec![BlockDelete, Number, Number, Number, Comment]),
            ("N5/G1", vec![Number, BlockDelete, Number]),
            ("G1 / X1", vec![Number, Unknown, Number]),
            ("#501 = 1 ( SELECT )", vec![Assignment, Comment]),
            ("#1=#2*SIN[#3]-2 X#1", vec![Assignment, Expression]),
            ("#<a b>=[1+[2]] Y[#1+2]Z-#[3]", vec![Assignment, Expression, Expression]),
            ("X SIN[30] Ysqrt[4]", vec![Expression, Expression]),
            ("o100 sub", vec![Flow]),
            ("O<name> call [1] [2] (x)", vec![Flow, Comment]),
            ("N10IF[#1EQ0]GOTO20", vec![Number, Flow]),
            ("WHILE [#1 LT 3] DO1", vec![Flow]),
            ("END1", vec![Flow]),
            ("G1 X1 ,R2. !? \u{e9}", vec![Number, Number, Unknown, Unknown, Unknown]),
            ("M. HELLO Q=3", vec![Unknown, Unknown, Unknown, Unknown, Unknown]),
        ];
        for (text, expected) in cases {
            let found: Vec<_> = kinds(text).into_iter().map(|(kind, _)| kind).collect();
            assert_eq!(found, expected, "{text}");
        }
    }
}
