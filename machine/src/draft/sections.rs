//! Settings files of sections, keys and values.

use crate::MachineError;

/// Content of a file beside the settings, by the name that they give it.
pub(super) type Beside<'a> = &'a dyn Fn(&str) -> Option<String>;

/// A setting: section and key as written, value without comment, and the file and line, from 1, where it stands.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Setting {
    pub section: String,
    pub key: String,
    pub value: String,
    pub file: String,
    pub line: usize,
}

/// Way of writing settings.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Style {
    /// LinuxCNC's INI: blanks before a line mean nothing, `#INCLUDE name` takes in a file, and of several equal keys the first counts.
    Ini,
    /// Klipper's: an indented line continues the value above it, `[include name]` takes in a file, and of several equal keys the last counts.
    Klipper,
}

/// The settings of a file and of those that it includes.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Settings {
    all: Vec<Setting>,
    style: Style,
    /// What of it was not read, for the reader.
    pub notes: Vec<String>,
}

/// Depth up to which files include others.
const MOST_INCLUDES: usize = 8;

impl Settings {
    /// Reads a file. Keys end at `=` or `:`; comments begin with `#` or `;` at the head of a line, and behind a blank.
    pub fn read(file: &str, text: &str, style: Style, beside: Beside<'_>) -> Self {
        let mut settings = Self { all: Vec::new(), style, notes: Vec::new() };
        settings.add(&mut vec![file.to_owned()], text, &mut String::new(), beside);
        settings
    }

    /// Adds the last of `files`, each of which includes the next.
    fn add(&mut self, files: &mut Vec<String>, text: &str, section: &mut String, beside: Beside<'_>) {
        let file = files.last().cloned().unwrap_or_default();
        for (index, line) in text.lines().enumerate() {
            if self.style == Style::Klipper && line.starts_with([' ', '\t']) {
                continue;
            }
            if let Some(name) = self.style.included(line) {
                self.include(name, (files, index + 1), section, beside);
                continue;
            }
            let line = without_comment(line).trim();
            if let Some(name) = line.strip_prefix('[').and_then(|rest| rest.strip_suffix(']')) {
                name.trim().clone_into(section);
            } else if let Some((key, value)) = line.split_once(['=', ':']) {
                let [key, value] = [key, value].map(|text| text.trim().to_owned());
                self.all.push(Setting { section: section.clone(), key, value, file: file.clone(), line: index + 1 });
            }
        }
    }

    /// Takes in a file. In an INI file it goes on in the section that is open, and leaves its own one open.
    fn include(&mut self, name: &str, (files, line): (&mut Vec<String>, usize), section: &mut String, beside: Beside<'_>) {
        let file = files.last().cloned().unwrap_or_default();
        let is_open = files.iter().any(|open| open == name) || files.len() > MOST_INCLUDES;
        match beside(name).filter(|_| !is_open) {
            Some(text) => {
                files.push(name.to_owned());
                match self.style {
                    Style::Ini => self.add(files, &text, section, beside),
                    Style::Klipper => self.add(files, &text, &mut String::new(), beside),
                }
                files.pop();
            }
            None => {
                self.notes
                    .push(format!("{name}, which {file} includes in line {line}, is not read: what it states is missing here"));
            }
        }
    }

    /// The value of a key; keys and sections are the same in either case.
    pub fn find(&self, section: &str, key: &str) -> Option<&Setting> {
        let mut found = self.of(section).filter(|of| of.key.eq_ignore_ascii_case(key));
        match self.style {
            Style::Ini => found.next(),
            Style::Klipper => found.last(),
        }
    }

    /// The settings of a section.
    pub fn of(&self, section: &str) -> impl Iterator<Item = &Setting> {
        self.all.iter().filter(move |of| of.section.eq_ignore_ascii_case(section))
    }

    /// The sections that hold a setting, as written.
    pub fn sections(&self) -> impl Iterator<Item = &str> {
        self.all.iter().map(|of| of.section.as_str())
    }
}

impl Style {
    /// The file that a line takes in.
    fn included(self, line: &str) -> Option<&str> {
        let line = line.trim();
        let name = match self {
            Self::Ini => line.strip_prefix("#INCLUDE").filter(|name| name.starts_with([' ', '\t']))?,
            Self::Klipper => without_comment(line).trim().strip_prefix("[include ")?.strip_suffix(']')?,
        };
        Some(name.trim()).filter(|name| !name.is_empty())
    }
}

fn without_comment(line: &str) -> &str {
    let mut before = ' ';
    let begins = |(at, character): (usize, char)| {
        let is_comment = matches!(character, '#' | ';') && before.is_whitespace();
        before = character;
        is_comment.then_some(at)
    };
    line.char_indices().find_map(begins).map_or(line, |at| &line[..at])
}

impl Setting {
    /// Its number.
    ///
    /// # Errors
    /// With the line where it is none.
    pub fn number(&self) -> Result<f64, MachineError> {
        self.value.parse().ok().filter(|number: &f64| number.is_finite()).ok_or_else(|| self.refused("a number is wanted"))
    }

    /// An error about its value.
    pub fn refused(&self, wanted: &str) -> MachineError {
        let Self { key, value, file, line, .. } = self;
        MachineError::BadDescription(format!("{file}:{line}: {key} is `{value}`; {wanted}"))
    }

    /// Where it stands, for the comment beside the value.
    pub fn place(&self, main: &str) -> String {
        let Self { section, key, file, line, .. } = self;
        if file == main { format!("[{section}] {key}, line {line}") } else { format!("[{section}] {key}, {file}, line {line}") }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn places(settings: &Settings) -> Vec<(&str, &str, &str, &str, usize)> {
        settings.all.iter().map(|of| (&*of.section, &*of.key, &*of.value, &*of.file, of.line)).collect()
    }

    #[test]
    fn settings_end_at_comments_and_keep_their_lines() {
        let text = "# a = 1\n[AXIS_X]\nMAX_VELOCITY = 30.5 # mm/s\n\n[stepper_x]\nposition_max: 235;\n  more: 1\n; b: 2\n";
        let found = Settings::read("printer.cfg", text, Style::Klipper, &|_| None);
        let file = "printer.cfg";
        let expected = [("AXIS_X", "MAX_VELOCITY", "30.5", file, 3), ("stepper_x", "position_max", "235;", file, 6)];
        assert_eq!(places(&found), expected);
        assert_eq!(found.find("axis_x", "max_velocity").map(|of| of.number().ok()), Some(Some(30.5)));
        let error = found.all[1].number().err().map(|error| error.to_string());
        assert!(error.is_some_and(|error| error.contains("printer.cfg:6: position_max is `235;`")));
        // In an INI file blanks before a line mean nothing.
        assert_eq!(Settings::read("m.ini", text, Style::Ini, &|_| None).all.len(), 3);
    }

    #[test]
    fn included_files_count_and_those_that_are_missing_are_told() {
        let beside = |name: &str| (name == "lim.inc").then(|| "[A]\nb = 2\nc = 3\n#INCLUDE lim.inc\n".to_owned());
        let ini = Settings::read("m.ini", "[A]\nb = 1\n#INCLUDE lim.inc\n#INCLUDE no.inc\n", Style::Ini, &beside);
        let value = |settings: &Settings, key: &str| settings.find("a", key).map(|of| (of.value.clone(), of.place("m.ini")));
        assert_eq!(value(&ini, "b"), Some(("1".into(), "[A] b, line 2".into())));
        assert_eq!(value(&ini, "c"), Some(("3".into(), "[A] c, lim.inc, line 3".into())));
        assert!(ini.notes.iter().any(|note| note.starts_with("no.inc, which m.ini includes in line 4")), "{:?}", ini.notes);
        // The section that is open goes on in the file.
        let limits = |name: &str| (name == "x.inc").then(|| "MAX = 5\n[Y]\n".to_owned());
        let ini = Settings::read("m.ini", "[X]\n#INCLUDE x.inc\nMIN = 1\n", Style::Ini, &limits);
        assert!(ini.find("X", "MAX").is_some() && ini.find("Y", "MIN").is_some() && ini.notes.is_empty());
        let klipper = Settings::read("m.cfg", "[A]\nb = 1\n[include lim.inc]\n[include *.cfg]\n", Style::Klipper, &beside);
        assert_eq!(value(&klipper, "b"), Some(("2".into(), "[A] b, lim.inc, line 2".into())));
        assert_eq!(klipper.notes.len(), 1);
    }
}
