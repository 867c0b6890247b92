//! Refinement by a model of the machine: what repeats of the model's error is learned.

use anyhow::Result;
use pipeline::model_based_ilc::Settings;
use pipeline::refine::{Ended, Learning, ObservedRun, learn_from_runs};
use pipeline::units::um;
use pipeline::{Input, OutputSettings};
use serde_json::{Value, json};

use super::{Pages, Refine, check_axes};
use crate::commands::compensate::merged;
use crate::output::{Printer, Usage};
use crate::read;

impl Refine {
    pub(super) fn learn_by_model(&self) -> Result<()> {
        let printer = self.common.printer();
        let Some(model) = &self.model else {
            return Err(Usage("--law model-based needs a model: give it with -m, or choose --law spatial".into()).into());
        };
        let model = read::model(model)?;
        let logs = self.logs(&printer)?;
        let (input, format, setup) = self.input(None, &printer)?;
        logs.iter().try_for_each(|log| check_axes(&input, log))?;
        let programs = self.programs(&input, &format)?;
        let shown = self.common.shown();
        let settings = self.learning_settings(&format);
        self.check_logs(&input, &setup, &logs, Some(&model))?;
        self.check_recordings(&logs, Some(&model), &printer)?;
        let learning = learn_from_runs(&input, &logs, &model, &settings, &|event| shown.event(event))?;
        let measured: Vec<_> = learning.runs.iter().map(|run| run.figures).collect();
        let offset = learning.runs.last().map(|run| run.matched.offset);
        let figures = self.show_runs(&printer, &measured, offset.as_ref());
        let figures = merged(figures, json!({ "expected_um": expected_json(&learning) }));
        let pages = || {
            let in_path_time = |run: &ObservedRun| run.actual().map(|actual| (run.command.clone(), actual));
            let runs = learning.runs.iter().map(in_path_time).collect::<Result<Vec<_>, _>>()?;
            self.pages(&input, &runs, &measured, Some(&learning.outcome).filter(|_| learning.ended.is_none()))
        };
        match (learning.ended, programs.get(learning.best)) {
            (Some(ended), Some(program)) => {
                printer.line(self.why(&learning, ended));
                self.write_best((learning.best, program), ended, figures, &pages, &printer)
            }
            _ => self.write_next((&input, &format), &learning, figures, &pages, &printer),
        }
    }

    fn learning_settings(&self, format: &OutputSettings) -> Settings {
        let (max_shift, written, slow_stops) = (self.max_shift, format.program(), !self.keep_stops);
        Settings { max_shift, written, slow_stops, ..self.output.learning(None) }
    }

    fn write_next(
        &self,
        (input, format): (&Input, &OutputSettings),
        learning: &Learning,
        figures: Value,
        pages: Pages<'_>,
        printer: &Printer,
    ) -> Result<()> {
        let expected = &learning.expected;
        printer.line(format!(
            "expected of the program of run {}: {} µm RMS; of run {}'s, the best so far: {} µm",
            self.last_run() + 1,
            um(expected.next_mm),
            self.run_of(learning.best),
            um(expected.best_mm)
        ));
        let format = match learning.outcome.written {
            Some(points) => format.clone().with_points(points),
            None => format.clone(),
        };
        let output = input.write(&learning.outcome.reference, &format, learning.outcome.max_shift, &self.out)?;
        self.write_program(output, figures, pages, printer)
    }

    /// Why the program of the best run is written again.
    fn why(&self, learning: &Learning, ended: Ended) -> String {
        let (best, out) = (self.run_of(learning.best), self.out.display());
        let expected = &learning.expected;
        match ended {
            Ended::Worse => {
                format!(
                    "the last run was worse than run {best}: learning has ended; {out} is the program of run {best}, the best one"
                )
            }
            Ended::NoGain if learning.runs.len() == 1 => format!(
                "the model explains this run, and a single run does not show which errors repeat: {out} is its program once more"
            ),
            Ended::NoGain => format!(
                "no better program is expected from these runs ({} µm RMS, the best one {} µm): learning has ended; {out} is the \
                 program of run {best}, the best one",
                um(expected.next_mm),
                um(expected.best_mm)
            ),
        }
    }
}

fn expected_json(learning: &Learning) -> Value {
    let expected = &learning.expected;
    json!({
        "next_rms": expected.next_mm * 1e3,
        "best_rms": expected.best_mm * 1e3,
        "not_repeated_rms": expected.rest_mm * 1e3,
    })
}
