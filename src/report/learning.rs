//! The learning curve: the forecast over the updates of the iteration.

use std::sync::{Mutex, PoisonError};

use pipeline::Event;
use pipeline::statistics::Figures;

use super::column::Column;
use super::section::{Chart, Content, Line, Quantity, Section, Style};

/// The forecasts that a job reported, series by series.
#[derive(Default)]
pub struct Forecasts(Mutex<Vec<Vec<f64>>>);

impl Forecasts {
    /// Notes the event where it is a forecast.
    pub fn note(&self, event: Event<'_>) {
        if let Event::Forecast { number, cost_mm, .. } = event {
            let mut series = self.0.lock().unwrap_or_else(PoisonError::into_inner);
            if number <= 1 || series.is_empty() {
                series.push(Vec::new());
            }
            if let Some(last) = series.last_mut() {
                last.push(cost_mm);
            }
        }
    }
}

/// The section on the forecasts of an iteration; `None` where there are fewer than two.
#[must_use]
pub fn learning_curve(forecasts: &Forecasts) -> Option<Section> {
    let series = forecasts.0.lock().unwrap_or_else(PoisonError::into_inner);
    let longest = series.iter().map(Vec::len).max().filter(|longest| *longest > 1)?;
    let numbers: Vec<f64> = (1..=longest).map(|number| number as f64).collect();
    let line = |(index, costs): (usize, &Vec<f64>)| {
        let name = if index == 0 { "on the reference".to_owned() } else { format!("on the replanned program, {index}") };
        let missing = std::iter::repeat_n(f64::NAN, longest - costs.len());
        let um: Vec<f64> = costs.iter().map(|cost| cost * 1e3).chain(missing).collect();
        Line { name, style: Style::Points, color: index, values: Column::float(&um) }
    };
    let chart = Chart {
        x: Quantity::at("forecast", "", &numbers),
        y: Quantity::of("cost", "µm"),
        lines: series.iter().enumerate().map(line).collect(),
        log: [false, true],
    };
    let note = "Every forecast that the iteration made, by its cost: RMS of the predicted contour error over the moves that may be changed, \
                with rotary axes the tool's direction at a lever of 20 mm included. Several cut-offs are tried first, so the cost may rise \
                in between. On the program, whose time the control plans anew, there is a series for each spacing of points that is tried. \
                The best forecast is taken.";
    Some(Section::new("Learning curve", note, Content::Chart(chart)))
}

/// The figures of the runs of a part, in order, from run `first` on; `None` where there is but one.
#[must_use]
pub fn over_runs(first: usize, figures: &[Figures]) -> Option<Section> {
    if figures.len() < 2 {
        return None;
    }
    let numbers: Vec<f64> = (first..first + figures.len()).map(|number| number as f64).collect();
    let line = |color: usize, name: &str, of: &dyn Fn(&Figures) -> f64| {
        let values: Vec<f64> = figures.iter().map(|run| of(run) * 1e3).collect();
        Line { name: name.to_owned(), style: Style::Points, color, values: Column::float(&values) }
    };
    let lines = vec![
        line(0, "RMS", &|run| run.tip.rms_mm),
        line(1, "95 %", &|run| run.tip.p95_mm),
        line(2, "MAX", &|run| run.tip.max_mm),
    ];
    let chart =
        Chart { x: Quantity::at("run", "", &numbers), y: Quantity::of("contour error", "µm"), lines, log: [false, true] };
    Some(Section::new("Run by run", "Measured contour error of every run so far.", Content::Chart(chart)))
}
