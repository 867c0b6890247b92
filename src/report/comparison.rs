//! The comparison of methods: a group for each path.

use anyhow::Result;
use pipeline::compare::{Figures, Method, PathComparison};
use pipeline::units::um;

use super::column::Column;
use super::figures::sections;
use super::run::Run;
use super::section::{Chart, Content, Group, Line, Quantity, Section, Style, Table};
use super::track::Track;

/// A group for each path, with the methods' figures, learning on the machine, and the runs that were kept.
///
/// # Errors
/// When a run does not match its path.
pub fn comparison(results: &[PathComparison]) -> Result<Vec<Group>> {
    let group = |result: &PathComparison| -> Result<Group> {
        let track = Track::of_path(&result.desired);
        let runs = result.runs.iter().map(|(name, actual)| Run::of(name, &track, None, actual)).collect::<Result<Vec<_>>>()?;
        let mut all = vec![methods(result)];
        all.extend(learning_on_machine(result));
        all.extend(sections(&track, &runs));
        Ok(Group { name: result.name.clone(), sections: all })
    };
    results.iter().map(group).collect()
}

fn methods(result: &PathComparison) -> Section {
    let turns = result.desired.kinematics().has_rotary_axes();
    let mut header = vec!["method", "RMS µm", "MAX µm"];
    if turns {
        header.extend(["tool direction RMS µrad", "MAX µrad"]);
    }
    let row = |(method, figures): &(Method, Figures)| {
        let (rms, max) = figures.mean();
        let turn = figures.mean_turn().filter(|_| turns);
        let turn = turn.map_or(Vec::new(), |(rms, max)| [rms, max].map(|rad| format!("{:.2}", rad * 1e6)).to_vec());
        [method.name().to_owned(), um(rms), um(max)].into_iter().chain(turn).collect()
    };
    let note = "Contour error of every method on this path, mean over the noise seeds. Floor: run-to-run repeatability, the expected error of \
                a perfect compensation.";
    Section::new("Methods", note, Content::Table(Table::new(&header, result.methods.iter().map(row).collect())))
}

/// Spatial ILC run by run, beside the first run and the floor.
fn learning_on_machine(result: &PathComparison) -> Option<Section> {
    let runs = result.ilc_rms.len();
    if runs < 2 {
        return None;
    }
    let numbers: Vec<f64> = (1..=runs).map(|number| number as f64).collect();
    let level = |(color, (method, name)): (usize, (Method, &str))| {
        let (rms, _) = result.of(method)?.mean();
        let values = Column::float(&vec![rms * 1e3; runs]);
        Some(Line { name: name.to_owned(), style: Style::Dashed, color: color + 1, values })
    };
    let rms: Vec<f64> = result.ilc_rms.iter().map(|rms| rms * 1e3).collect();
    let learned = Line { name: "spatial ILC".to_owned(), style: Style::Points, color: 0, values: Column::float(&rms) };
    let levels = [(Method::FirstRun, "first run, by the model"), (Method::Floor, "floor")];
    let chart = Chart {
        x: Quantity::at("run on the machine", "", &numbers),
        y: Quantity::of("contour error RMS", "µm"),
        lines: std::iter::once(learned).chain(levels.into_iter().enumerate().filter_map(level)).collect(),
        log: [false, true],
    };
    let note = "Learning on the machine takes a run for each step; the first of them is uncompensated. The model's first run is its only one.";
    Some(Section::new("Learning on the machine", note, Content::Chart(chart)))
}
