//! A program file with the places that jumps and calls lead to.

use std::borrow::Cow;
use std::ops::Range;
use std::rc::Rc;

use super::hash::Map;
use super::statement::{Keyword, Label, Statement};
use crate::program::Program;
use crate::word::{Word, WordKind};

/// A file.
#[derive(Debug)]
pub(super) struct Source<'a> {
    /// File name; empty for the main program.
    pub name: String,
    pub program: Cow<'a, Program>,
    /// How each block is executed.
    kinds: Vec<BlockKind>,
    /// Flow statements by their blocks.
    statements: Map<usize, Rc<Statement>>,
    /// O-words of each label, in order.
    labels: Map<Vec<u8>, Vec<(usize, Keyword)>>,
    /// DO and END of each Fanuc loop.
    loops: Map<usize, usize>,
    /// Blocks of each sequence number N.
    sequence: Map<u32, Vec<usize>>,
    /// Program numbers `O1234`, in order.
    numbers: Vec<(u32, usize)>,
    /// Bodies of subprograms with their names, inner ones after outer ones.
    bodies: Vec<(Range<usize>, String)>,
}

/// How a block is executed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum BlockKind {
    Empty,
    /// Comments alone.
    Comment,
    /// Words that need no evaluation and no control of the execution.
    Inert,
    Active,
}

impl BlockKind {
    fn of(words: &[Word]) -> Self {
        match words {
            [] => Self::Empty,
            _ if words.iter().all(|word| word.kind == WordKind::Comment) => Self::Comment,
            _ if words.iter().all(is_inert) => Self::Inert,
            _ => Self::Active,
        }
    }
}

/// Whether a word needs no evaluation and no control of the execution.
fn is_inert(word: &Word) -> bool {
    match word.kind {
        WordKind::Comment => true,
        WordKind::Number => match word.letter {
            b'M' => !ACTIVE_M.contains(&word.value),
            b'G' => word.value != 65.0 && word.value != 66.0,
            _ => true,
        },
        _ => false,
    }
}

/// M codes that end a program, call or return, and M73, which acts at a return.
const ACTIVE_M: [f64; 7] = [2.0, 30.0, 73.0, 97.0, 98.0, 99.0, 198.0];

impl<'a> Source<'a> {
    pub fn new(name: String, program: Cow<'a, Program>) -> Self {
        let mut source = Self {
            name,
            program,
            kinds: Vec::new(),
            statements: Map::default(),
            labels: Map::default(),
            loops: Map::default(),
            sequence: Map::default(),
            numbers: Vec::new(),
            bodies: Vec::new(),
        };
        let mut open: Vec<(u32, usize)> = Vec::new();
        for block in 0..source.program.blocks().len() {
            source.note_numbers(block);
            source.kinds.push(BlockKind::of(source.program.block_words(block)));
            let Some(word) = source.flow_word(block) else { continue };
            let statement = Statement::read(source.program.text(source.program.words()[word].span));
            match &statement {
                Statement::OWord { label: Label::Fixed(label), keyword, .. } => {
                    source.labels.entry(label.clone()).or_default().push((block, *keyword));
                }
                Statement::While { number, .. } | Statement::Do { number } => open.push((*number, block)),
                Statement::End { number } => {
                    if let Some(at) = open.iter().rposition(|(opened, _)| opened == number) {
                        source.loops.insert(open[at].1, block);
                        source.loops.insert(block, open[at].1);
                        open.truncate(at);
                    }
                }
                _ => {}
            }
            source.statements.insert(block, Rc::new(statement));
        }
        source.bodies = source.find_bodies();
        source
    }

    fn find_bodies(&self) -> Vec<(Range<usize>, String)> {
        let of_program = |(number, start): &(u32, usize)| (self.program_around(*start), number.to_string());
        let mut bodies: Vec<_> = self.numbers.iter().skip(usize::from(self.name.is_empty())).map(of_program).collect();
        for (label, words) in &self.labels {
            let name = String::from_utf8_lossy(label).to_lowercase();
            let ends: Vec<_> = words.iter().filter(|(_, keyword)| matches!(keyword, Keyword::Sub | Keyword::EndSub)).collect();
            let pairs = ends.windows(2).filter(|pair| pair[0].1 == Keyword::Sub && pair[1].1 == Keyword::EndSub);
            bodies.extend(pairs.map(|pair| (pair[0].0..pair[1].0, name.clone())));
        }
        bodies.sort_by_key(|(range, _)| range.start);
        bodies
    }

    fn note_numbers(&mut self, block: usize) {
        for word in self.program.block_words(block) {
            let Some(number) = word.number().filter(|n| n.fract() == 0.0 && (0.0..=f64::from(u32::MAX)).contains(n)) else {
                continue;
            };
            match word.letter {
                b'N' => self.sequence.entry(number as u32).or_default().push(block),
                b'O' => self.numbers.push((number as u32, block)),
                _ => {}
            }
        }
    }

    /// How a block is executed.
    pub fn kind(&self, block: usize) -> BlockKind {
        self.kinds.get(block).copied().unwrap_or(BlockKind::Active)
    }

    pub fn blocks(&self) -> usize {
        self.program.blocks().len()
    }

    /// Index of the flow word of a block.
    pub fn flow_word(&self, block: usize) -> Option<usize> {
        self.program.word_range(block).find(|index| self.program.words()[*index].kind == WordKind::Flow)
    }

    /// The flow statement of a block.
    pub fn statement(&self, block: usize) -> Option<Rc<Statement>> {
        self.statements.get(&block).cloned()
    }

    /// O-words with this label, in order.
    pub fn labelled(&self, label: &[u8]) -> &[(usize, Keyword)] {
        self.labels.get(label).map_or(&[], Vec::as_slice)
    }

    /// The first block after `block` with this label and one of these keywords.
    pub fn following(&self, block: usize, label: &[u8], keywords: &[Keyword]) -> Option<(usize, Keyword)> {
        let all = self.labelled(label);
        let after = &all[all.partition_point(|(at, _)| *at <= block)..];
        after.iter().find(|(_, keyword)| keywords.contains(keyword)).copied()
    }

    /// The last block before `block` with this label and one of these keywords.
    pub fn preceding(&self, block: usize, label: &[u8], keywords: &[Keyword]) -> Option<(usize, Keyword)> {
        let all = self.labelled(label);
        let before = &all[..all.partition_point(|(at, _)| *at < block)];
        before.iter().rfind(|(_, keyword)| keywords.contains(keyword)).copied()
    }

    /// The other end of the Fanuc loop that begins or ends in this block.
    pub fn loop_end(&self, block: usize) -> Option<usize> {
        self.loops.get(&block).copied()
    }

    /// The block with program number `O`.
    pub fn program_number(&self, number: u32) -> Option<usize> {
        self.numbers.iter().find(|(own, _)| *own == number).map(|(_, block)| *block)
    }

    /// Blocks of the program, among those of the file, that holds `block`.
    pub fn program_around(&self, block: usize) -> Range<usize> {
        let next = self.numbers.partition_point(|(_, start)| *start <= block);
        let start = next.checked_sub(1).map_or(0, |own| self.numbers[own].1);
        start..self.numbers.get(next).map_or(self.blocks(), |(_, start)| *start)
    }

    /// Name of the subprogram whose body holds `block`.
    pub fn body_around(&self, block: usize) -> Option<&str> {
        self.bodies.iter().rfind(|(range, _)| range.contains(&block)).map(|(_, name)| name.as_str())
    }

    /// The block with a sequence number in the program around `block`. As on the control, the search goes on from `block` and then from the
    /// start.
    pub fn sequence_number(&self, number: u32, block: usize) -> Option<usize> {
        let range = self.program_around(block);
        let all = self.sequence.get(&number)?;
        let next = |from: usize| all.get(all.partition_point(|at| *at < from)).copied().filter(|at| range.contains(at));
        next(block + 1).or_else(|| next(range.start))
    }
}
