//! Sections on the runs of a path beside the path itself: figures, distribution, spectrum, reversals.

use pipeline::analysis::{ReversalCurves, distribution, reversal_curves, spectrum};
use pipeline::statistics::COUNTED;
use pipeline::units::um;

use super::circle::polar;
use super::column::Column;
use super::path::PathView;
use super::run::Run;
use super::section::{Chart, Content, Line, Quantity, Section, Style, Table};
use super::track::Track;

/// All sections on the runs of a path.
#[must_use]
pub fn sections(track: &Track<'_>, runs: &[Run]) -> Vec<Section> {
    let mut sections = vec![figures(track, runs), path(track, runs)];
    sections.extend(polar(track, runs));
    sections.extend(spread(track, runs));
    sections.extend(frequencies(track, runs));
    sections.extend(reversals(track, runs));
    sections
}

fn figures(track: &Track<'_>, runs: &[Run]) -> Section {
    let mut header = vec!["run", "RMS µm", "95 % µm", "MAX µm"];
    if track.turns() {
        header.extend(["tool direction RMS µrad", "MAX µrad"]);
    }
    let row = |run: &Run| {
        let of_turn = run.turn.iter().flat_map(|turn| [turn.rms_rad, turn.max_rad]).map(|rad| format!("{:.2}", rad * 1e6));
        let contour = [run.figures.rms_mm, run.figures.p95_mm, run.figures.max_mm].map(um);
        std::iter::once(run.name.clone()).chain(contour).chain(of_turn).collect()
    };
    let counted = if track.has_lines() { format!(", {COUNTED}") } else { String::new() };
    let note = format!("Contour error: distance of the tool tip from the desired path, whatever the time{counted}.");
    Section::new("Figures", note, Content::Table(Table::new(&header, runs.iter().map(row).collect())))
}

fn path(track: &Track<'_>, runs: &[Run]) -> Section {
    let note = "Point at the path, at a curve over time or at a row of the table: the others show the same place. The deviation is drawn \
                larger than it is, by the factor beside its slider.";
    Section::new("Where the error is", note, Content::Path(Box::new(PathView::new(track, runs))))
}

fn spread(track: &Track<'_>, runs: &[Run]) -> Option<Section> {
    let contour: Vec<Vec<f64>> = runs.iter().map(|run| run.contour_um(track)).collect();
    let found = distribution(&contour.iter().map(Vec::as_slice).collect::<Vec<_>>())?;
    let line = |(color, (run, shares)): (usize, (&Run, &Vec<f64>))| {
        let percent: Vec<f64> = shares.iter().map(|share| 100.0 * share).collect();
        Line { name: run.name.clone(), style: Style::Steps, color, values: Column::scaled(&percent) }
    };
    let chart = Chart {
        x: Quantity::at("contour error up to", "µm", &found.upper),
        y: Quantity::of("share of the samples", "%"),
        lines: runs.iter().zip(&found.shares).enumerate().map(line).collect(),
        log: [true, false],
    };
    let note = "How often an error of this size occurs: twelve bins a decade.";
    Some(Section::new("Distribution of the error", note, Content::Chart(chart)))
}

fn frequencies(track: &Track<'_>, runs: &[Run]) -> Option<Section> {
    let spectra = runs.iter().map(|run| spectrum(&run.vectors(), &track.counts(), track.period_s));
    let spectra = spectra.collect::<Option<Vec<_>>>()?;
    let hz = spectra.first()?.hz.clone();
    let line = |(color, (run, found)): (usize, (&Run, &pipeline::analysis::Spectrum))| {
        let density: Vec<f64> = found.density.iter().map(|density| density * 1e3).collect();
        Line { name: run.name.clone(), style: Style::Line, color, values: Column::float(&density) }
    };
    let chart = Chart {
        x: Quantity::at("frequency", "Hz", &hz),
        y: Quantity::of("contour error", "µm/√Hz"),
        lines: runs.iter().zip(&spectra).enumerate().map(line).collect(),
        log: [true, true],
    };
    let note = "At which frequencies the error lies: amplitude spectral density of the error vector (Welch's method, Hann windows). Peaks are \
                resonances, ripple of a motor or screw, or the period of a repeated shape.";
    Some(Section::new("Spectrum of the error", note, Content::Chart(chart)))
}

/// A chart for every axis and run that reverses.
fn reversals(track: &Track<'_>, runs: &[Run]) -> Vec<Section> {
    // In a time of its own a run's samples are not those of the path.
    if track.places.iter().enumerate().any(|(k, place)| k != *place) {
        return Vec::new();
    }
    let of_run = |(color, run): (usize, &Run)| {
        let curves = reversal_curves(track.desired, &run.vectors(), &track.counts());
        curves.into_iter().map(|axis| (axis.axis.clone(), color, run.name.clone(), axis)).collect::<Vec<_>>()
    };
    let found: Vec<(String, usize, String, ReversalCurves)> = runs.iter().enumerate().flat_map(of_run).collect();
    let mut axes: Vec<&String> = found.iter().map(|(axis, ..)| axis).collect();
    axes.dedup();
    axes.sort();
    axes.dedup();
    let chart = |axis: &String| {
        let of_axis: Vec<&(String, usize, String, ReversalCurves)> = found.iter().filter(|(name, ..)| name == axis).collect();
        let first = &of_axis.first()?.3;
        let ms: Vec<f64> = first.time_s.iter().map(|time_s| time_s * 1e3).collect();
        let values = |of: &[f64]| Column::scaled(&of.iter().map(|value| value * 1e3).collect::<Vec<f64>>());
        let mut lines = Vec::new();
        for (_, color, run, curves) in &of_axis {
            lines.extend(curves.curves.iter().map(|curve| Line {
                name: format!("{run}, sample {}", curve.sample),
                style: Style::Pale,
                color: *color,
                values: values(&curve.error_mm),
            }));
        }
        lines.extend(of_axis.iter().map(|(_, color, run, curves)| Line {
            name: format!("{run}, median"),
            style: Style::Line,
            color: *color,
            values: values(&curves.median_mm),
        }));
        let chart = Chart {
            x: Quantity::at("time from the reversal", "ms", &ms),
            y: Quantity::of(&format!("contour error along {axis}"), "µm"),
            lines,
            log: [false, false],
        };
        let (count, shown) = (first.reversals, first.curves.len());
        let of = if shown < count { format!("the {shown} largest of {count} reversals") } else { format!("{count} reversals") };
        let note = format!(
            "Contour error along axis {axis} at {of}, laid over one another; positive in the direction of the motion after the reversal. \
             A dip after zero is a quadrant glitch: friction holds the axis back while its motor builds up torque."
        );
        Some(Section::new(&format!("Reversals of axis {axis}"), note, Content::Chart(chart)))
    };
    axes.into_iter().filter_map(chart).collect()
}
