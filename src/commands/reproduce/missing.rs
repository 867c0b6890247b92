//! Tables and figures of the papers that no code reproduces yet.

use super::found::{Entry, Printed, Section};

/// Paper, figure or row, and what is missing.
const MISSING: [(char, &str, &str); 8] = [
    ('A', "Figures 13 to 16: shape of the references", "A picture; the references of every run are not kept."),
    (
        'B',
        "Table I: bends of the flower as eight segments",
        "Five are found (figure 13 above); the distance of the paper's points is not printed.",
    ),
    (
        'C',
        "Figures 8 and 12: the paths as printed",
        "The paper prints no formula; ours are a saddle and a butterfly of the same kind.",
    ),
    (
        'D',
        "Figure 3: overshoot at a reversal and at a start",
        "A picture; `measure` and `diagnose` print reversal peaks of a circular test.",
    ),
    ('D', "Figures 13 to 15: curves over time", "Pictures; their RMS and MAX stand in tables II, IV and V."),
    (
        'D',
        "Table I: run time of the numerical optimisation",
        "The paper runs `fmincon`; ours is Newton's method on the curve, whose time stands in table I.",
    ),
    ('E', "Figure 3: the scan's sizes", "The paper prints no sizes."),
    ('E', "Figure 7: the corner in the experiment", "No testbed is at hand; figure 6 stands for both."),
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
    };
    MISSING.chunk_by(|a, b| a.0 == b.0).map(section).collect()
}
