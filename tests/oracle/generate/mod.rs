//! Programs drawn at random: what a stranger's program may hold, mostly valid on LinuxCNC.

mod blocks;
mod moves;

use crate::random::Random;

/// A program under construction, with the state that its next block depends on.
pub struct Writer {
    pub random: Random,
    text: String,
    /// Programmed coordinates, in the present units.
    pub at: [f64; 3],
    /// Whether they are known: not after a change of offsets.
    pub known: bool,
    pub inches: bool,
    pub incremental: bool,
    pub absolute_centres: bool,
    /// G17, G18, G19.
    pub plane: usize,
    pub inverse_time: bool,
    /// Modal motion code, where a block may leave it out.
    pub motion: &'static str,
    lower: bool,
    spaced: bool,
}

/// A random program.
pub fn program(seed: u64) -> String {
    let mut random = Random(seed.wrapping_mul(0x2545_f491_4f6c_dd1d));
    let (lower, spaced) = (random.chance(0.25), random.chance(0.7));
    let inches = random.chance(0.2);
    let mut writer = Writer {
        random,
        text: String::new(),
        at: [0.0; 3],
        known: false,
        inches,
        incremental: false,
        absolute_centres: false,
        plane: 17,
        inverse_time: false,
        motion: "",
        lower,
        spaced,
    };
    writer.head();
    let count = 5 + writer.random.below(40);
    for _ in 0..count {
        writer.block();
    }
    writer.tail();
    writer.text
}

impl Writer {
    fn head(&mut self) {
        if self.random.chance(0.2) {
            self.text.push_str("(a program)\n\n");
        }
        let units = if self.inches { "G20" } else { "G21" };
        let feed = 1500.0 / self.unit();
        let words = [units.to_owned(), "G90".to_owned(), "G94".to_owned(), self.word('F', feed)];
        self.line(&words);
        if self.random.chance(0.5) {
            self.path_mode();
        }
        if self.random.chance(0.9) {
            let code = self.random.pick(&["G0", "G1"]);
            self.state_position(code);
        }
    }

    fn tail(&mut self) {
        if self.random.chance(0.3) {
            self.raw("G80 G40 M5 M9");
        }
        let end = self.random.pick(&["M2", "M30", "M2 (end)", "G0 Z0\nM30"]);
        self.raw(end);
        if self.random.chance(0.1) {
            self.text.push_str("what follows is not read\n");
        }
    }

    /// One or more blocks of a random kind.
    fn block(&mut self) {
        match self.random.below(100) {
            0..30 => self.feed_line(),
            30..46 => self.arc(),
            46..52 => self.rapid(),
            52..90 => self.modes_and_words(),
            90..93 => self.cycles(),
            93..95 => self.contour(),
            95..97 => self.rotary(),
            _ => self.special(),
        }
    }

    /// Length of a program unit, mm.
    pub fn unit(&self) -> f64 {
        if self.inches { 25.4 } else { 1.0 }
    }

    /// A length in mm as a number of the program, rounded as it is written.
    pub fn rounded(&self, value: f64) -> f64 {
        (value * 1e5).round() / 1e5
    }

    /// A word: a number of up to five decimals, in one of its spellings.
    pub fn word(&mut self, letter: char, value: f64) -> String {
        let mut number = format!("{:.5}", self.rounded(value));
        if self.random.chance(0.8) {
            number = number.trim_end_matches('0').trim_end_matches(if self.random.chance(0.5) { '.' } else { ' ' }).to_owned();
        }
        if self.random.chance(0.05) {
            number = number.replace("0.", ".");
        }
        if self.random.chance(0.03) && !number.starts_with('-') {
            number.insert(0, '+');
        }
        if matches!(number.as_str(), "" | "." | "+" | "-" | "-." | "+.") {
            number = "0".to_owned();
        }
        let gap = if self.random.chance(0.02) { " " } else { "" };
        format!("{letter}{gap}{number}")
    }

    /// A block of these words, in order.
    pub fn line(&mut self, words: &[String]) {
        let mut text = String::new();
        for (index, word) in words.iter().enumerate() {
            if index > 0 && self.spaced {
                text.push(' ');
            }
            if self.random.chance(0.01) {
                text.push_str("(why)");
            }
            text.push_str(word);
        }
        if self.random.chance(0.03) {
            text.push_str(" ; remark");
        }
        self.raw(&text);
    }

    /// A block of these words, in any order.
    pub fn shuffled(&mut self, mut words: Vec<String>) {
        if self.random.chance(0.25) {
            for index in (1..words.len()).rev() {
                let other = self.random.below(index + 1);
                words.swap(index, other);
            }
        }
        self.line(&words);
    }

    pub fn raw(&mut self, text: &str) {
        let text = if self.lower { text.to_lowercase() } else { text.to_owned() };
        self.text.push_str(&text);
        self.text.push('\n');
    }
}
