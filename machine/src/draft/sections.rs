//! Settings files of sections, keys and values.

use crate::MachineError;

/// A setting: section and key as written, value without comment, line from 1.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Setting<'a> {
    pub section: &'a str,
    pub key: &'a str,
    pub value: &'a str,
    pub line: usize,
}

/// The settings of a file, in order. Keys end at `=` or `:`; comments begin with `#` or `;` at the head of a line, and behind a blank.
pub(super) fn settings(text: &str) -> Vec<Setting<'_>> {
    let mut section = "";
    let mut out = Vec::new();
    for (index, line) in text.lines().enumerate() {
        // An indented line continues the value above it.
        if line.starts_with([' ', '\t']) {
            continue;
        }
        let line = without_comment(line).trim();
        if let Some(name) = line.strip_prefix('[').and_then(|rest| rest.strip_suffix(']')) {
            section = name.trim();
        } else if let Some((key, value)) = line.split_once(['=', ':']) {
            out.push(Setting { section, key: key.trim(), value: value.trim(), line: index + 1 });
        }
    }
    out
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

/// The value of a key; keys and sections are the same in either case. Of several the last one counts.
pub(super) fn find<'a, 'b>(settings: &'b [Setting<'a>], section: &str, key: &str) -> Option<&'b Setting<'a>> {
    settings.iter().rev().find(|of| of.section.eq_ignore_ascii_case(section) && of.key.eq_ignore_ascii_case(key))
}

impl Setting<'_> {
    /// Its number.
    ///
    /// # Errors
    /// With the line where it is none.
    pub fn number(&self, file: &str) -> Result<f64, MachineError> {
        self.value.parse().ok().filter(|number: &f64| number.is_finite()).ok_or_else(|| {
            let Self { key, value, line, .. } = self;
            MachineError::BadDescription(format!("{file}:{line}: {key} is `{value}`; a number is wanted"))
        })
    }

    /// Where it stands, for the comment beside the value.
    pub fn place(&self) -> String {
        format!("[{}] {}, line {}", self.section, self.key, self.line)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn settings_end_at_comments_and_keep_their_lines() {
        let text = "# a = 1\n[AXIS_X]\nMAX_VELOCITY = 30.5 # mm/s\n\n[stepper_x]\nposition_max: 235;\n  more: 1\n; b: 2\n";
        let found = settings(text);
        let expected = [("AXIS_X", "MAX_VELOCITY", "30.5", 3), ("stepper_x", "position_max", "235;", 6)];
        assert_eq!(found.iter().map(|of| (of.section, of.key, of.value, of.line)).collect::<Vec<_>>(), expected);
        assert_eq!(find(&found, "axis_x", "max_velocity").map(|of| of.number("f").ok()), Some(Some(30.5)));
        let error = found[1].number("printer.cfg").err().map(|error| error.to_string());
        assert!(error.is_some_and(|error| error.contains("printer.cfg:6: position_max is `235;`")));
    }
}
