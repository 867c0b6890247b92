//! A program file with the places that jumps, loops and calls lead to.

use std::borrow::Cow;
use std::ops::Range;
use std::rc::Rc;

use super::statement::{Direction, Statement, program_name};
use crate::evaluate::hash::Map;
use crate::program::Program;
use crate::sinumerik::names::Name;
use crate::word::WordKind;

/// A file.
#[derive(Debug)]
pub(super) struct Source<'a> {
    /// File name; empty for the main program.
    pub name: String,
    pub program: Cow<'a, Program>,
    statements: Map<usize, Rc<Statement>>,
    /// Blocks with PROC, in order.
    procedures: Vec<usize>,
    /// Blocks of labels and of block numbers (`N10`), in upper case.
    places: Map<String, Vec<usize>>,
    /// From IF to ELSE or ENDIF, from ELSE to ENDIF, between the ends of a loop.
    partners: Map<usize, usize>,
    /// Programs of an archive by name, with their blocks.
    programs: Vec<(String, Range<usize>)>,
}

impl<'a> Source<'a> {
    pub fn new(name: String, program: Cow<'a, Program>) -> Self {
        let mut source = Self {
            name,
            program,
            statements: Map::default(),
            procedures: Vec::new(),
            places: Map::default(),
            partners: Map::default(),
            programs: Vec::new(),
        };
        let mut heads = Vec::new();
        for block in 0..source.program.blocks().len() {
            source.note_words(block, &mut heads);
        }
        // The first program may have no head.
        let is_code = |block: usize| source.program.block_words(block).iter().any(|word| word.kind != WordKind::Comment);
        if heads.first().is_some_and(|(_, first): &(String, usize)| (0..*first).any(is_code)) {
            heads.insert(0, (String::new(), 0));
        }
        let ends = heads.iter().skip(1).map(|(_, block)| *block).chain([source.program.blocks().len()]);
        source.programs = heads.iter().zip(ends).map(|((name, block), end)| (name.clone(), *block..end)).collect();
        source.pair();
        source
    }

    fn note_words(&mut self, block: usize, heads: &mut Vec<(String, usize)>) {
        for word in self.program.block_words(block) {
            let text = self.program.text(word.span);
            let upper = || String::from_utf8_lossy(text).to_ascii_uppercase();
            match word.kind {
                WordKind::Flow => {
                    let statement = Statement::read(text);
                    if statement == Statement::Procedure {
                        self.procedures.push(block);
                    }
                    self.statements.insert(block, Rc::new(statement));
                }
                WordKind::Keyword if word.name == Name::Label => {
                    self.places.entry(upper().trim_end_matches(':').to_owned()).or_default().push(block);
                }
                WordKind::Number if word.letter == b'N' => {
                    let number = format!("N{}", word.value);
                    self.places.entry(number).or_default().push(block);
                }
                WordKind::Percent => heads.push((program_name(upper().trim_start_matches('%').trim()), block)),
                _ => {}
            }
        }
    }

    /// Finds the ends of branches and loops.
    fn pair(&mut self) {
        let mut blocks: Vec<usize> = self.statements.keys().copied().collect();
        blocks.sort_unstable();
        let mut open: Vec<usize> = Vec::new();
        for block in blocks {
            let own = &self.statements[&block];
            let closes = |head: &Statement| match **own {
                Statement::Else => matches!(head, Statement::If { .. }),
                Statement::EndIf => matches!(head, Statement::If { .. } | Statement::Else),
                Statement::EndWhile => matches!(head, Statement::While { .. }),
                Statement::EndFor => matches!(head, Statement::For { .. }),
                Statement::EndLoop => matches!(head, Statement::Loop),
                Statement::Until { .. } => matches!(head, Statement::Repeat),
                _ => false,
            };
            if let Some(head) = open.last().copied().filter(|head| closes(&self.statements[head])) {
                open.pop();
                self.partners.insert(head, block);
                self.partners.insert(block, head);
            }
            if matches!(
                **own,
                Statement::If { .. }
                    | Statement::Else
                    | Statement::While { .. }
                    | Statement::For { .. }
                    | Statement::Loop
                    | Statement::Repeat
            ) {
                open.push(block);
            }
        }
        // An ELSE leads to its ENDIF, not back to its IF.
        for (block, statement) in &self.statements {
            if **statement == Statement::Else && self.partners.get(block).is_some_and(|partner| partner < block) {
                self.partners.remove(block);
            }
        }
    }

    pub fn blocks(&self) -> usize {
        self.program.blocks().len()
    }

    pub fn statement(&self, block: usize) -> Option<&Statement> {
        self.statements.get(&block).map(|statement| &**statement)
    }

    /// The same, to be executed while the execution changes.
    pub fn shared_statement(&self, block: usize) -> Option<Rc<Statement>> {
        self.statements.get(&block).cloned()
    }

    /// The first block of `range` with PROC.
    pub fn procedure(&self, range: &Range<usize>) -> Option<usize> {
        let first = self.procedures.partition_point(|block| *block < range.start);
        self.procedures.get(first).copied().filter(|block| range.contains(block))
    }

    /// Index of the flow word of a block.
    pub fn flow_word(&self, block: usize) -> Option<usize> {
        self.program.word_range(block).find(|index| self.program.words()[*index].kind == WordKind::Flow)
    }

    /// The other end of the branch or loop.
    pub fn partner(&self, block: usize) -> Option<usize> {
        self.partners.get(&block).copied()
    }

    /// The block with a label or a block number within `range`, seen from `block`.
    pub fn place(&self, target: &str, block: usize, direction: Direction, range: &Range<usize>) -> Option<usize> {
        let number = target.strip_prefix('N').and_then(|digits| digits.parse::<u64>().ok());
        let key = number.filter(|_| !self.places.contains_key(target)).map(|number| format!("N{number}"));
        let all = self.places.get(key.as_deref().unwrap_or(target))?;
        let own = || all.iter().copied().filter(|at| range.contains(at));
        match direction {
            Direction::Forward => own().find(|at| *at > block),
            Direction::Backward => own().rfind(|at| *at < block),
            Direction::Both => own().find(|at| *at > block).or_else(|| own().next()),
        }
    }

    /// Blocks of the program of this name; in a file without heads those of the file, if it has the name.
    pub fn program_named(&self, name: &str) -> Option<Range<usize>> {
        self.programs.iter().find(|(known, _)| known == name).map(|(_, range)| range.clone())
    }

    /// Blocks of the first program.
    pub fn first_program(&self) -> Range<usize> {
        match self.programs.as_slice() {
            [_, (_, next), ..] => 0..next.start,
            _ => 0..self.blocks(),
        }
    }

    /// Name of the program that holds `block`; empty in the first.
    pub fn program_around(&self, block: usize) -> &str {
        let found = self.programs.iter().skip(1).find(|(_, range)| range.contains(&block));
        found.map_or("", |(name, _)| name.as_str())
    }
}
