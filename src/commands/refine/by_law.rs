//! Refinement by a law that needs no model: one update from the best run.

use anyhow::Result;
use pipeline::refine::{Aligned, Ended, RefineLaw, RefineSettings, best_of, last_is_worse, refine_from_run};

use super::{LOW_PASS_HZ, LawArg, Refine, check_axes};

impl Refine {
    pub(super) fn learn_by_law(&self) -> Result<()> {
        let printer = self.common.printer();
        let logs = self.logs(&printer)?;
        let (input, format, setup) = self.input(logs.first().map(|log| log.period_s()), &printer)?;
        logs.iter().try_for_each(|log| check_axes(&input, log))?;
        let programs = self.programs(&input, &format)?;
        input.check_original()?;
        self.check_logs(&input, &setup, &logs, None)?;
        self.check_recordings(&logs, None, &printer)?;
        let runs = logs.iter().map(|log| Aligned::of(&input, log)).collect::<Result<Vec<_>, _>>()?;
        let measured: Vec<_> = runs.iter().map(|run| run.figures).collect();
        let best = best_of(&measured).unwrap_or_default();
        let pages = || {
            let shown: Vec<_> = runs.iter().map(|run| (run.command.clone(), run.actual.clone())).collect();
            self.pages(&input, &shown, &measured, None)
        };
        if let (true, Some(program)) = (last_is_worse(&measured), programs.get(best)) {
            let figures = self.show_runs(&printer, &measured, None);
            let (run, out) = (self.run_of(best), self.out.display());
            printer.line(format!(
                "the last run was worse than run {run}: learning has ended; {out} is the program of run {run}, the best one"
            ));
            return self.write_best((best, program), Ended::Worse, figures, &pages, &printer);
        }
        let run = runs.get(best).ok_or(pipeline::Error::NoRun("learning"))?;
        let refined = refine_from_run(&input, run, &self.law_settings())?;
        let figures = self.show_runs(&printer, &measured, Some(&run.matched.offset));
        let output = input.write(&refined.reference, &format, refined.max_shift, &self.out)?;
        self.write_program(output, figures, &pages, &printer)
    }

    fn law_settings(&self) -> RefineSettings {
        let settings = RefineSettings::of_run(self.last_run());
        let law = if self.law() == LawArg::Tracking { RefineLaw::Tracking } else { RefineLaw::Spatial };
        let (gain, low_pass_hz) = (self.gain.unwrap_or(settings.gain), self.low_pass.unwrap_or(LOW_PASS_HZ));
        RefineSettings { law, gain, low_pass_hz, max_shift: self.max_shift, ..settings }
    }
}
