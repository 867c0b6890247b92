//! The page of all tables and figures, in Markdown.

use std::path::{Path, PathBuf};

use super::found::{Entry, Printed, Section};
use super::picture::Picture;

/// Title of each paper's chapter.
const PAPERS: [(char, &str); 5] = [
    ('A', "Paper A: spatial ILC, two axes"),
    ('B', "Paper B: corners and feeds"),
    ('C', "Paper C: five axes"),
    ('D', "Paper D: LSTM pre-compensation"),
    ('E', "Paper E: norm-optimal and cross-coupled ILC"),
];

/// The page: `command` made it, in `seconds`, without the tables `left_out`. Its pictures lie in `folder` beside it.
pub(super) fn page(sections: &[Section], command: &str, seconds: f64, left_out: &[String], folder: &str) -> String {
    let mut text = format!(
        "# The papers' results, printed and measured\n\n\
         Written by `{command}` in {}. The simulated machine stands in for the papers' machines: orders and ratios are to be\n\
         compared, not micrometres. *Difference* is measured minus printed, and its share of the printed value. The numbers under *why* lead to the\n\
         sentences below each table. `tests/product/reproduce.rs` runs the code again and compares.\n",
        duration(seconds)
    );
    if !left_out.is_empty() {
        text += &format!("\nNot on this page: `reproduce {}`.\n", left_out.join(" "));
    }
    for (paper, title) in PAPERS {
        let mut sections = sections.iter().filter(|section| section.paper == paper).peekable();
        if sections.peek().is_some() {
            text += &format!("\n## {title}\n");
        }
        sections.for_each(|section| text += &shown(section, folder));
    }
    text
}

/// Folder of the pictures of a page.
pub(super) fn figures(page: &Path) -> PathBuf {
    let stem = page.file_stem().unwrap_or_default().to_string_lossy();
    page.with_file_name(format!("{stem}-figures"))
}

fn shown(section: &Section, folder: &str) -> String {
    let mut text = format!("\n### {}\n\n", section.title);
    if !section.note.is_empty() {
        text += &format!("{}\n\n", section.note);
    }
    text += "| | unit | printed | measured | difference | why |\n|---|---|---:|---:|---:|---|\n";
    let mut reasons: Vec<&str> = Vec::new();
    for entry in &section.entries {
        let why = if entry.why.is_empty() {
            String::new()
        } else {
            let known = reasons.iter().position(|reason| *reason == entry.why);
            let index = known.unwrap_or_else(|| {
                reasons.push(entry.why);
                reasons.len() - 1
            });
            (index + 1).to_string()
        };
        let printed = match &entry.printed {
            Printed::Value(value) => number(*value),
            Printed::Words(words) => words.clone(),
            Printed::None => "–".to_owned(),
        };
        let measured = entry.measured.map_or("not reproduced".to_owned(), number);
        text += &format!("| {} | {} | {printed} | {measured} | {} | {why} |\n", entry.what, entry.unit, difference(entry));
    }
    if !reasons.is_empty() {
        text.push('\n');
    }
    for (index, reason) in reasons.iter().enumerate() {
        text += &format!("{}. {reason}\n", index + 1);
    }
    for Picture { file, caption, .. } in &section.pictures {
        text += &format!("\n![{caption}]({folder}/{file}.svg)\n\n*{caption}*\n");
    }
    text
}

/// Measured minus printed, and its share; empty where one of them is missing.
fn difference(entry: &Entry) -> String {
    match (&entry.printed, entry.measured) {
        (Printed::Value(printed), Some(measured)) if *printed != 0.0 => {
            let (off, share) = (measured - printed, 100.0 * (measured / printed - 1.0));
            format!("{}{} ({share:+.0} %)", if off > 0.0 { "+" } else { "" }, number(off)).replace('-', "−")
        }
        _ => String::new(),
    }
}

/// Four digits, without trailing zeros behind the point.
fn number(value: f64) -> String {
    let digits = if value == 0.0 { 0 } else { (3 - value.abs().log10().floor() as i64).clamp(0, 5) as usize };
    let text = format!("{value:.digits$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

/// As in "3 min 20 s".
pub(super) fn duration(seconds: f64) -> String {
    let whole = seconds.round() as u64;
    if whole < 60 { format!("{seconds:.0} s") } else { format!("{} min {} s", whole / 60, whole % 60) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_stand_beside_their_difference_and_reasons_are_named_once() {
        let entry =
            |what: &str, printed, measured| Entry { what: what.into(), unit: "µm", printed, measured, why: "Another machine." };
        let section = Section {
            paper: 'D',
            title: "Table I".into(),
            note: String::new(),
            entries: vec![
                entry("a", Printed::Value(4.0), Some(3.0)),
                entry("b", Printed::Words("diverges".into()), Some(12345.6)),
                entry("c", Printed::None, None),
            ],
            pictures: vec![Picture { file: "d-figure-1", caption: "Figure 1: a.".into(), svg: String::new() }],
        };
        let text = page(&[section], "precomp reproduce", 200.4, &["table-1".into()], "page-figures");
        for line in [
            "in 3 min 20 s.",
            "Not on this page: `reproduce table-1`.",
            "| a | µm | 4 | 3 | −1 (−25 %) | 1 |",
            "| b | µm | diverges | 12346 |  | 1 |",
            "| c | µm | – | not reproduced |  | 1 |",
            "1. Another machine.",
            "![Figure 1: a.](page-figures/d-figure-1.svg)",
        ] {
            assert!(text.contains(line), "{line}: {text}");
        }
        assert_eq!(text.matches("Another machine").count(), 1);
        assert!(!text.contains("Paper A"));
    }

    #[test]
    fn numbers_have_four_digits() {
        assert_eq!(
            [0.0, 0.000_123_46, 7.240, 25.784, 604.0, 1e5].map(number),
            ["0", "0.00012", "7.24", "25.78", "604", "100000"]
        );
    }
}
