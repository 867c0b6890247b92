//! Places of keys and values in the text of a file.

use std::fmt::Write as _;
use std::ops::Range;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// A step from a table or list to what it holds.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Step {
    /// To the value of a key.
    Key(String),
    /// To an entry of a list, from 0.
    Index(usize),
}

impl Step {
    /// The key called `name`.
    pub(super) fn key(name: &str) -> Self {
        Self::Key(name.to_owned())
    }
}

/// A file as it was written.
pub(super) struct Places<'a> {
    text: &'a str,
    root: DeTable<'a>,
}

/// A place of a file and the key that stands there.
pub(super) struct Place {
    /// From 1.
    pub line: usize,
    /// From 1, characters.
    pub column: usize,
    /// The key with all its tables; an axis by its name.
    pub label: String,
}

impl<'a> Places<'a> {
    pub(super) const fn new(text: &'a str, root: DeTable<'a>) -> Self {
        Self { text, root }
    }

    /// The place of `path`, or of the innermost part of it that the file states. What an axis has from the drive that all axes
    /// share is found there.
    pub(super) fn of(&self, path: &[Step]) -> Place {
        let (whole, (own_depth, own)) = (path.len(), self.innermost(path));
        let shared = match path {
            [Step::Key(axes), Step::Index(_), rest @ ..] if axes == "axes" => self.shared(rest),
            _ => None,
        };
        match shared {
            // A value of its own stands before the shared one.
            Some((depth, span, path)) if own_depth < whole && depth + 2 >= own_depth => self.place(span.start, self.label(&path)),
            _ => self.place(own.start, self.label(path)),
        }
    }

    /// Whether the file has `key` at top level.
    pub(super) fn states(&self, key: &str) -> bool {
        self.root.iter().any(|(stated, _)| stated.get_ref() == key)
    }

    /// Line and column of a byte.
    pub(super) fn line_and_column(&self, byte: usize) -> (usize, usize) {
        let before = &self.text[..self.text.floor_char_boundary(byte)];
        let line_start = before.rfind('\n').map_or(0, |at| at + 1);
        (before.matches('\n').count() + 1, before[line_start..].chars().count() + 1)
    }

    /// Steps of a label such as `axes.x.drive.friction.patches[0].width_mm`.
    pub(super) fn steps(&self, label: &str) -> Vec<Step> {
        let mut steps = Vec::new();
        for part in label.split('.') {
            let mut pieces = part.split('[');
            let name = pieces.next().unwrap_or_default();
            match self.axis_called(name) {
                Some(index) if steps == [Step::key("axes")] => steps.push(Step::Index(index)),
                _ => steps.push(Step::key(name)),
            }
            steps.extend(pieces.filter_map(|index| index.trim_end_matches(']').parse().ok().map(Step::Index)));
        }
        steps
    }

    /// `path` below `[drive]` or `[rotary_drive]`, where the axis has `rest` from there.
    fn shared(&self, rest: &[Step]) -> Option<(usize, Range<usize>, Vec<Step>)> {
        let [Step::Key(drive), below @ ..] = rest else { return None };
        let names = if drive == "drive" { ["drive", "rotary_drive"] } else { return None };
        let found = names.into_iter().map(|name| {
            let path: Vec<Step> = [Step::key(name)].into_iter().chain(below.iter().cloned()).collect();
            let (depth, span) = self.innermost(&path);
            (depth, span, path)
        });
        found.filter(|(depth, ..)| *depth > 0).max_by_key(|(depth, ..)| *depth)
    }

    /// How many steps of `path` the file states, and the span of the last of them: of a key, or of an entry of a list.
    fn innermost(&self, path: &[Step]) -> (usize, Range<usize>) {
        let (mut depth, mut span) = (0, 0..0);
        let mut table = Some(&self.root);
        let mut list = None;
        for step in path {
            let value: &Spanned<DeValue> = match (step, table, list) {
                (Step::Key(name), Some(table), _) => {
                    let Some((key, value)) = table.iter().find(|(key, _)| key.get_ref() == name) else { break };
                    span = key.span();
                    value
                }
                (Step::Index(index), _, Some(entries)) => {
                    let entries: &toml::de::DeArray = entries;
                    let Some(value) = entries.get(*index) else { break };
                    span = value.span();
                    value
                }
                _ => break,
            };
            depth += 1;
            (table, list) = (value.get_ref().as_table(), value.get_ref().as_array());
        }
        (depth, span)
    }

    fn place(&self, byte: usize, label: String) -> Place {
        let (line, column) = self.line_and_column(byte);
        Place { line, column, label }
    }

    fn label(&self, path: &[Step]) -> String {
        let mut label = String::new();
        for (depth, step) in path.iter().enumerate() {
            match step {
                Step::Key(name) if label.is_empty() => label.push_str(name),
                Step::Key(name) => {
                    let _ = write!(label, ".{name}");
                }
                Step::Index(index) => {
                    let _ = match self.axis_name(*index).filter(|_| depth == 1 && label == "axes") {
                        Some(name) => write!(label, ".{name}"),
                        None => write!(label, "[{index}]"),
                    };
                }
            }
        }
        label
    }

    fn axis_names(&self) -> impl Iterator<Item = Option<&str>> {
        let axes = self.root.iter().find(|(key, _)| key.get_ref() == "axes").and_then(|(_, axes)| axes.get_ref().as_array());
        axes.into_iter()
            .flat_map(|axes| axes.iter())
            .map(|axis| axis.get_ref().get("name").and_then(|name| name.get_ref().as_str()))
    }

    /// The name of an axis, unless another has it too.
    fn axis_name(&self, index: usize) -> Option<&str> {
        let name = self.axis_names().nth(index).flatten()?;
        (self.axis_names().filter(|other| *other == Some(name)).count() == 1).then_some(name)
    }

    fn axis_called(&self, name: &str) -> Option<usize> {
        self.axis_names().position(|other| other == Some(name))
    }
}
