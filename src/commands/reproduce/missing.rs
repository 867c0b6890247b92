//! Tables and figures of the papers that no code reproduces yet.

use super::found::{Entry, Printed, Section};

/// Paper, figure or row, and what is missing.
const MISSING: [(char, &str, &str); 3] = [
    (
        'C',
        "Figures 8 and 12: the paths as printed",
        "The paper prints no formula; ours are a saddle and a butterfly of the same kind.",
    ),
    (
        'D',
        "Table I: run time of the numerical optimisation",
        "The paper runs `fmincon`; ours is Newton's method on the curve, whose time stands in table I.",
    ),
    ('E', "Figure 3: the scan's sizes", "The paper prints no sizes."),
];

/// A section for every paper that has some.
pub(super) fn sections() -> Vec<Section> {
    let section = |rows: &[(char, &'static str, &'static str)]| Section {
        paper: rows[0].0,
        title: "Not reproduced".into(),
        note: String::new(),
        entries: rows
            .iter()
            .map(|(_, what, why)| Entry { what: (*what).into(), unit: "", printed: Printed::None, measured: None, why })
            .collect(),
        pictures: Vec::new(),
    };
    MISSING.chunk_by(|a, b| a.0 == b.0).map(section).collect()
}
