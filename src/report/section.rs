//! What a page is made of: groups of sections of a few kinds.

use serde::Serialize;

use super::column::Column;
use super::path::PathView;
use super::polar::Polar;

/// A page.
#[derive(Debug, Serialize)]
pub struct Page {
    /// Heading.
    pub title: String,
    /// What it shows, in a sentence or two.
    pub lead: String,
    /// One for each path, machine or topic.
    pub groups: Vec<Group>,
}

/// Sections of one path, machine or topic.
#[derive(Debug, Serialize)]
pub struct Group {
    /// Heading.
    pub name: String,
    /// The sections, in order.
    pub sections: Vec<Section>,
}

/// A section.
#[derive(Debug, Serialize)]
pub struct Section {
    /// Heading.
    pub title: String,
    /// What it shows and how to read it.
    pub note: String,
    /// What is shown.
    #[serde(flatten)]
    pub content: Content,
}

/// What a section shows.
#[derive(Debug, Serialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub enum Content {
    /// A path with its runs: drawing, time series, worst places. Linked with one another.
    Path(Box<PathView>),
    /// A table.
    Table(Table),
    /// Lines over a common abscissa.
    Chart(Chart),
    /// Radial deviations of circles.
    Polar(Polar),
    /// Ranges beside the ranges that they should lie in.
    Ranges(Ranges),
}

impl Section {
    /// A section.
    #[must_use]
    pub fn new(title: &str, note: impl Into<String>, content: Content) -> Self {
        Self { title: title.to_owned(), note: note.into(), content }
    }
}

/// A table: texts to the left, the others to the right.
#[derive(Debug, Serialize)]
pub struct Table {
    /// Headings of the columns.
    pub header: Vec<String>,
    /// The rows.
    pub rows: Vec<Vec<String>>,
    /// Columns of text, by their index.
    pub texts: Vec<usize>,
    /// A verdict beside a row, by its index.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub verdicts: Vec<Verdict>,
}

impl Table {
    /// A table without verdicts, its first column of text.
    #[must_use]
    pub fn new(header: &[&str], rows: Vec<Vec<String>>) -> Self {
        Self { header: header.iter().map(|&text| text.to_owned()).collect(), rows, texts: vec![0], verdicts: Vec::new() }
    }
}

/// How a figure compares with its threshold.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// Within its threshold.
    Good,
    /// Near it.
    Fair,
    /// Beyond it.
    Poor,
}

/// Lines over a common abscissa.
#[derive(Debug, Serialize)]
pub struct Chart {
    /// The abscissa.
    pub x: Quantity,
    /// What the lines show.
    pub y: Quantity,
    /// The lines.
    pub lines: Vec<Line>,
    /// Whether the abscissa is logarithmic, and whether the ordinate is.
    pub log: [bool; 2],
}

/// A quantity on an axis.
#[derive(Debug, Serialize)]
pub struct Quantity {
    /// Name.
    pub name: String,
    /// Unit; empty without one.
    pub unit: String,
    /// Values of the abscissa; nothing for an ordinate.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub values: Option<Column>,
}

impl Quantity {
    /// An ordinate.
    #[must_use]
    pub fn of(name: &str, unit: &str) -> Self {
        Self { name: name.to_owned(), unit: unit.to_owned(), values: None }
    }

    /// An abscissa.
    #[must_use]
    pub fn at(name: &str, unit: &str, values: &[f64]) -> Self {
        Self { values: Some(Column::float(values)), ..Self::of(name, unit) }
    }
}

/// A line of a chart.
#[derive(Debug, Serialize)]
pub struct Line {
    /// Name.
    pub name: String,
    /// How it is drawn.
    pub style: Style,
    /// Which of the colours of runs it has.
    pub color: usize,
    /// One value for each of the abscissa.
    pub values: Column,
}

/// How a line is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Style {
    /// A plain line.
    Line,
    /// A thin, pale line: one of many.
    Pale,
    /// A dashed line: a level to compare with.
    Dashed,
    /// Points, joined by a line.
    Points,
    /// Points that are not joined.
    Dots,
    /// Steps, filled down to zero.
    Steps,
    /// The lower edge of a filled band; the next line is the upper one.
    Low,
    /// The upper edge of the band before.
    High,
}

/// Ranges beside the ranges that they should lie in.
#[derive(Debug, Serialize)]
pub struct Ranges {
    /// What is had, and what is asked for.
    pub names: [String; 2],
    /// One for each quantity.
    pub rows: Vec<RangeRow>,
}

/// One quantity of [`Ranges`].
#[derive(Debug, Serialize)]
pub struct RangeRow {
    /// Name.
    pub name: String,
    /// Unit.
    pub unit: String,
    /// What is had.
    pub has: [f64; 2],
    /// What is asked for.
    pub asks: [f64; 2],
}
