//! Calls and ends by codes: M98, M97, M198, G65, M99, M2, M30.

use std::borrow::Cow;

use super::control::Next;
use super::run::{Body, Run};
use super::source::Source;
use super::value::{Fault, Value};
use crate::dialect::Dialect;
use crate::program::parse;
use crate::word::Word;

/// How a block calls a subprogram.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum How {
    /// M98.
    Subprogram,
    /// M97 of Haas: a sequence number of the same program.
    Local,
    /// M198: a file.
    External,
    /// G65: a level of local parameters of its own.
    Macro,
}

/// Local parameters of the letters A to Z in a G65 (argument specification I); 0 for letters that are no arguments.
const ARGUMENTS: [u32; 26] = [1, 2, 3, 7, 8, 9, 0, 11, 4, 5, 6, 0, 13, 0, 0, 0, 17, 18, 19, 20, 21, 22, 23, 24, 25, 26];

impl Run<'_> {
    /// Executes the codes of a block whose words are evaluated.
    pub fn execute_codes(&mut self, words: Vec<Word>) -> Result<Next, Fault> {
        let has = |letter: u8, number: f64| words.iter().any(|word| word.letter == letter && word.number() == Some(number));
        if let Some(how) = self.how(&words) {
            return self.call_by_code(words, how);
        }
        if has(b'M', 99.0) && self.in_call() {
            return self.return_by_code(&words);
        }
        if has(b'M', 99.0) && words.iter().any(|word| word.letter == b'P') {
            let target = self.jump_target(value_of(&words, b'P'))?;
            self.push_others(&words);
            return Ok(Next::At(target));
        }
        if has(b'G', 66.0) {
            // The macro runs after every move and may assign any common parameter.
            self.parameters.close_global();
        }
        if !words.is_empty() {
            self.push(Some(&words), false);
        }
        if has(b'M', 73.0) {
            self.save_modes(&words);
        }
        let ends = has(b'M', 2.0) || has(b'M', 30.0) || has(b'M', 99.0);
        Ok(if ends { Next::End } else { Next::Following })
    }

    /// M73: the return from this subprogram restores the modes, as M72 does.
    fn save_modes(&mut self, words: &[Word]) {
        let saved = words.iter().find(|word| word.letter == b'M' && word.number() == Some(73.0));
        if let (Some(word), Dialect::LinuxCnc, Some(call)) = (saved, self.dialect, self.calls.last_mut()) {
            call.restores = Some((self.block, Word { value: 72.0, ..*word }));
        }
    }

    fn how(&self, words: &[Word]) -> Option<How> {
        let fanuc = self.dialect == Dialect::Fanuc;
        words.iter().find_map(|word| match (word.letter, word.number()?) {
            (b'M', 98.0) => Some(How::Subprogram),
            (b'M', 97.0) if fanuc => Some(How::Local),
            (b'M', 198.0) if fanuc => Some(How::External),
            (b'G', 65.0) if fanuc => Some(How::Macro),
            _ => None,
        })
    }

    fn call_by_code(&mut self, words: Vec<Word>, how: How) -> Result<Next, Fault> {
        let Some((body, times)) = self.body_of(&words, how)? else {
            // What is not read may assign every common parameter.
            self.note_read();
            self.push(Some(&words), false);
            self.forget_unread(how == How::Macro);
            return Ok(Next::Following);
        };
        let arguments = (how == How::Macro).then(|| arguments(&words));
        self.push_others(&words);
        self.enter(body, times, arguments)
    }

    /// A subprogram that is not read ran. Without a level of its own it may assign the local parameters of its caller.
    pub fn forget_unread(&mut self, own_level: bool) {
        self.parameters.forget_global();
        if !own_level {
            self.parameters.forget_local();
        }
    }

    /// Body and repetitions of a call; `None` if it is not found or not understood.
    fn body_of(&mut self, words: &[Word], how: How) -> Result<Option<(Body, u32)>, Fault> {
        let has = |letter: u8| words.iter().any(|word| word.letter == letter);
        let (Some(program), false) = (value_of(words, b'P').and_then(whole), has(b'Q') && how != How::Macro) else {
            return Ok(None);
        };
        let times = if has(b'L') { value_of(words, b'L').and_then(whole) } else { Some(1) };
        let Some(times) = times else { return Ok(None) };
        Ok(match how {
            How::Local => {
                let at = self.numbered_block(program);
                at.map(|block| ((self.source, block), times))
            }
            How::External => self.program_file(program).map(|body| (body, times)),
            How::Subprogram | How::Macro => {
                if let Some(body) = self.program(program) {
                    return Ok(Some((body, times)));
                }
                // The older form: up to four digits of repetitions before four of the program.
                let old = how == How::Subprogram && !has(b'L') && program > 9999;
                if old { self.program(program % 10_000).map(|body| (body, program / 10_000)) } else { None }
            }
        })
    }

    /// First block of a program by its number: in this file, in the main file, or in a file of its own.
    fn program(&mut self, number: u32) -> Option<Body> {
        let known = [self.source, 0].into_iter().find_map(|source| {
            let block = self.sources[source].program_number(number)?;
            Some((source, block + 1))
        });
        known.or_else(|| self.program_file(number))
    }

    /// Index of a subprogram file among the sources; reads it if necessary.
    pub fn file(&mut self, names: &[String]) -> Option<usize> {
        for name in names {
            if let Some(known) = self.sources.iter().position(|source| source.name == *name) {
                return Some(known);
            }
            if let Some(bytes) = self.library.read(name) {
                self.sources.push(Source::new(name.clone(), Cow::Owned(parse(bytes))));
                return Some(self.sources.len() - 1);
            }
        }
        None
    }

    fn program_file(&mut self, number: u32) -> Option<Body> {
        let mut names = Vec::new();
        for text in [format!("{number:04}"), number.to_string()] {
            for name in [format!("O{text}.nc"), format!("{text}.nc"), format!("O{text}"), format!("O{text}.NC")] {
                if !names.contains(&name) {
                    names.push(name);
                }
            }
        }
        if self.dialect == Dialect::LinuxCnc {
            names = vec![format!("{number}.ngc")];
        }
        let source = self.file(&names)?;
        let start = self.sources[source].program_number(number).map_or(0, |block| block + 1);
        Some((source, start))
    }

    /// M99 in a call.
    fn return_by_code(&mut self, words: &[Word]) -> Result<Next, Fault> {
        self.push_others(words);
        let jumps = words.iter().any(|word| word.letter == b'P');
        if words.iter().any(|word| word.letter == b'L') {
            return Err(Fault::new("M99 with L is not interpreted"));
        }
        if !jumps {
            return Ok(self.leave());
        }
        let number = value_of(words, b'P');
        if let Some(call) = self.calls.last_mut() {
            call.again = 0;
        }
        self.leave();
        self.block -= 1;
        self.block = self.jump_target(number)?;
        Ok(Next::Set)
    }

    /// The block with a sequence number.
    pub fn jump_target(&mut self, number: Option<f64>) -> Result<usize, Fault> {
        let Some(number) = number.and_then(whole) else {
            return Err(Fault::new("the target of this jump is not known before the program runs"));
        };
        let target = self.numbered_block(number);
        target.ok_or_else(|| Fault::new(format!("there is no block N{number} to jump to")))
    }

    fn numbered_block(&mut self, number: u32) -> Option<usize> {
        let target = self.sources[self.source].sequence_number(number, self.block)?;
        if self.source == 0 {
            self.targets.insert(target);
        }
        Some(target)
    }

    /// Records a block without the words of its call, jump or return.
    fn push_others(&mut self, words: &[Word]) {
        let is_macro = |word: &Word| word.letter == b'G' && word.number() == Some(65.0);
        let is_code = |word: &Word| word.letter == b'M' && [97.0, 98.0, 99.0, 198.0].contains(&word.value);
        // The arguments of a G65 stand behind it.
        let of_macro = words.iter().position(is_macro).unwrap_or(words.len());
        let of_call = |index: usize, word: &Word| match word.letter {
            0 | b'N' => false,
            _ if index >= of_macro => true,
            b'P' | b'L' => true,
            _ => is_code(word),
        };
        let rest: Vec<Word> = words.iter().enumerate().filter(|(k, word)| !of_call(*k, word)).map(|(_, word)| *word).collect();
        if !rest.is_empty() {
            self.push(Some(&rest), false);
        }
    }

    /// Whether the words call a subprogram.
    pub fn calls_by_code(&self, words: &[Word]) -> bool {
        self.how(words).is_some()
    }

    /// Body of a call by code, for the blocks that it may execute.
    pub fn callee(&mut self, words: &[Word]) -> Option<Body> {
        let how = self.how(words)?;
        self.body_of(words, how).ok().flatten().map(|(body, _)| body)
    }
}

/// Value of the last word with this letter.
pub(super) fn value_of(words: &[Word], letter: u8) -> Option<f64> {
    words.iter().rfind(|word| word.letter == letter).and_then(Word::number)
}

fn whole(number: f64) -> Option<u32> {
    (number.fract() == 0.0 && (0.0..=f64::from(u32::MAX)).contains(&number)).then_some(number as u32)
}

/// Values of local parameters from the words of a G65. I, J and K may stand several times, in groups (argument specification II).
fn arguments(words: &[Word]) -> Vec<(u32, Value)> {
    let mut values = Vec::new();
    let (mut group, mut last) = (0, None);
    let start = words.iter().position(|word| word.letter == b'G' && word.number() == Some(65.0)).unwrap_or(0);
    for word in &words[start..] {
        let Some(mut number) = ARGUMENTS.get(usize::from(word.letter.wrapping_sub(b'A'))).copied().filter(|number| *number > 0)
        else {
            continue;
        };
        if matches!(word.letter, b'I' | b'J' | b'K') {
            group += u32::from(last.is_some_and(|last| word.letter <= last));
            last = Some(word.letter);
            number += 3 * group;
        }
        values.push((number, word.number().map_or(Value::Unknown, Value::Number)));
    }
    values
}
