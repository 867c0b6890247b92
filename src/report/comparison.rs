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
        let runs = result.runs.iter().map(|run| Run::of(run.name, &track, Some(&run.reference), &run.actual));
        let runs = runs.collect::<Result<Vec<_>>>()?;
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

/// Every ILC run by run, beside the first run and the floor.
fn learning_on_machine(result: &PathComparison) -> Option<Section> {
    let runs = result.learning.iter().map(|(_, rms)| rms.len()).max().filter(|runs| *runs > 1)?;
    let numbers: Vec<f64> = (1..=runs).map(|number| number as f64).collect();
    let line = |name: &str, style, color, values: &[f64]| {
        let um: Vec<f64> = values.iter().map(|rms| rms * 1e3).collect();
        Line { name: name.to_owned(), style, color, values: Column::float(&um) }
    };
    let levels = [(Method::FirstRun, "first run, by the model"), (Method::Floor, "floor")];
    let level = |(color, (method, name)): (usize, &(Method, &str))| {
        let (rms, _) = result.of(*method)?.mean();
        Some(line(name, Style::Dashed, color, &vec![rms; runs]))
    };
    let laws = result.learning.iter().enumerate();
    let laws = laws.map(|(color, (law, rms))| line(law.name(), Style::Points, color + levels.len(), rms));
    let chart = Chart {
        x: Quantity::at("run on the machine", "", &numbers),
        y: Quantity::of("contour error RMS", "µm"),
        lines: levels.iter().enumerate().filter_map(level).chain(laws).collect(),
        log: [false, true],
    };
    let note = "Learning on the machine takes a run for each step; the first of them is uncompensated. The model's first run is its only one.";
    Some(Section::new("Learning on the machine", note, Content::Chart(chart)))
}
