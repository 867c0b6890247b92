//! `precomp demo`: the whole story on the built-in simulated machine.

use std::path::PathBuf;
use std::time::Instant;

use anyhow::Result;
use clap::Args;
use datasets::Log;
use machine::{Machine, MachineSpec, SimulatedMachine};
use models::Bundle;
use pipeline::compare::{CompareSettings, FEED_MM_S, Plant, compare, compare_programs};
use pipeline::excitation::{TRAVEL_MM, record};
use pipeline::model_based_ilc::{Settings, model_based_ilc};
use pipeline::statistics::figures_along;
use pipeline::training::{TrainSettings, Trained, train};
use pipeline::{Event, Input, OutputSettings, Part, ReadSettings, Setup};
use serde_json::{Value, json};

use super::compare::{LEAD, unseen};
use super::compensate::forecast;
use super::train::model_group;
use crate::args::{Common, MachineArgs};
use crate::files::Files;
use crate::kind::Kind;
use crate::numbers;
use crate::output::{Outputs, Printer};
use crate::print;
use crate::read;
use crate::report::{Forecasts, Group, Page, comparison, render};

/// The whole story on a simulated machine: excite, train, compensate unseen curves, compare with learning on the machine
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  precomp demo --out demo")]
pub struct Demo {
    #[command(flatten)]
    common: Common,
    #[command(flatten)]
    machine: MachineArgs,
    /// Folder for the model, the report and the figures
    #[arg(long, value_name = "DIR", default_value = "precomp-demo")]
    out: PathBuf,
    /// How the axes are predicted: staged, linear, lstm, lstm-paper, gru, gru-paper, narx, or a recipe file (.toml)
    #[arg(long, value_name = "NAME|TOML", default_value = "staged")]
    predictor: String,
    /// Seconds of excitation
    #[arg(long, default_value_t = 120.0, value_parser = numbers::excitation_s)]
    seconds: f64,
    /// Noise seeds over which figures are averaged
    #[arg(long, default_value_t = 1, value_parser = numbers::count)]
    seeds: u64,
}

/// Names of the files in the folder `--out`.
const MODEL: &str = "machine.model";
const REPORT: &str = "report.html";
/// The part of the story, and its name once it is compensated.
const PART: (&str, &str) = ("pocket.nc", include_str!("../../examples/pocket.nc"));
const COMPENSATED: &str = "pocket-compensated.nc";

/// The part, compensated and run.
struct Cut {
    group: Group,
    figures: Value,
    compensated: Vec<u8>,
}

impl Demo {
    pub fn files(&self) -> Files {
        Files::of(self.common.json.as_deref())
            .reads_machine(&*self.machine.machine)
            .reads_recipe(&*self.predictor)
            .writes("the model of --out", &*self.out.join(MODEL), Kind::Model)
            .writes("the report of --out", &*self.out.join(REPORT), Kind::Report)
            .writes("the part of --out", &*self.out.join(PART.0), Kind::Program)
            .writes("the compensated part of --out", &*self.out.join(COMPENSATED), Kind::Program)
    }

    pub fn run(&self) -> Result<()> {
        let printer = self.common.printer();
        let started = Instant::now();
        let machine = read::machine(&self.machine.machine)?;
        let setup = Setup::new(&machine, None)?;
        let logs = record(&machine, self.seconds, TRAVEL_MM, self.common.seed)?;
        let samples: usize = logs.iter().map(Log::len).sum();
        printer.line(format!("1. excited the machine `{}`: {} runs, {samples} samples", machine.name, logs.len()));
        let (trained, trained_s) = self.train(&logs, &machine)?;
        printer.line(format!("2. trained in {trained_s:.1} s"));
        printer.line(print::training::held_out(&trained.bundle));
        let unseen = unseen(&setup);
        printer.line(format!("3. compensated {} curves that training never saw, and ran them", unseen.len()));
        let paths: Vec<Input> =
            unseen.iter().map(|name| Input::curve(name, FEED_MM_S, &setup)).collect::<pipeline::Result<_>>()?;
        let settings = CompareSettings { seeds: self.seeds, seed: self.common.seed, ..CompareSettings::default() };
        let (plant, shown) = (Plant::Simulated(&machine), self.common.shown());
        let progress = |event: Event<'_>| shown.event(event);
        let results = compare(&paths, plant, Some(&trained.bundle), &settings, &progress)?;
        printer.line(print::comparison::render(&results, &settings));
        printer.line("4. the same curves as G-code programs of short lines, whose time the control plans itself");
        let (programs, tuned) = compare_programs(paths, plant, Some(&trained.bundle), &settings, &results.tuned, &progress)?;
        printer.line(print::comparison::render_programs(&programs, &tuned, &settings));

        printer.line(format!("5. compensated the part {}, and ran it as it was and as it is now", PART.0));
        let cut = self.cut(&trained.bundle, &machine, &setup, &printer)?;

        let (model, report) = (self.out.join(MODEL), self.out.join(REPORT));
        let mut outputs = Outputs::default();
        outputs.add(&self.out.join(PART.0), PART.1);
        outputs.add(&self.out.join(COMPENSATED), cut.compensated);
        outputs.add(&model, trained.bundle.to_bytes()?);
        let mut groups = vec![model_group(&trained, &logs)];
        groups.push(cut.group);
        groups.extend(comparison(&results.paths)?);
        outputs.add(&report, render(&Page { title: "precomp demo".to_owned(), lead: LEAD.to_owned(), groups })?);
        let seconds = started.elapsed().as_secs_f64();
        printer.line(format!("model in {}, report in {}; {seconds:.0} s in all", model.display(), report.display()));
        let mut figures = print::comparison::json(&results, &settings);
        figures["programs"] = print::comparison::programs_json(&programs, &tuned, &settings);
        figures["part"] = cut.figures;
        figures["train"] = print::training::json(&trained, trained_s);
        figures["seconds"] = json!(seconds);
        outputs.write(self.common.json.as_deref(), &figures)
    }

    /// The part, compensated, with its forecasts and its runs on the machine.
    fn cut(&self, model: &Bundle, machine: &MachineSpec, setup: &Setup, printer: &Printer) -> Result<Cut> {
        let settings = ReadSettings { at_zero: true, ..ReadSettings::default() };
        let input = Input::from(Part::read(PART.0, PART.1, setup, &settings)?);
        let format = OutputSettings::new(setup, None, None, None);
        let (shown, forecasts) = (self.common.shown(), Forecasts::default());
        let progress = |event: Event<'_>| {
            forecasts.note(event);
            shown.event(event)
        };
        let outcome = model_based_ilc(&input, model, &Settings { written: format.program(), ..Settings::default() }, &progress)?;
        let output = outcome.write(&input, &format, &self.out.join(COMPENSATED))?;
        let read = |bytes: Vec<u8>| -> Result<Input> { Ok(Input::from(Part::read(PART.0, bytes, setup, &settings)?)) };
        let mut simulated = SimulatedMachine::new(machine, self.common.seed)?;
        let mut run = |program: &Input| -> Result<_> {
            let reference = program.command();
            Ok(figures_along(input.desired(), input.part(), reference, &simulated.run(reference)?)?)
        };
        let (before, after) = (run(&input)?, run(&read(output.content.clone())?)?);
        for (when, figures) in [("as it was", &before), ("compensated", &after)] {
            printer.line(format!("   {when}: {}", print::figures::text(figures)));
        }
        let mut group = forecast(&input, &outcome, model, &forecasts)?;
        let figures =
            json!({ "before": print::figures::contour_json(&before.tip), "after": print::figures::contour_json(&after.tip) });
        Ok(Cut { group: group.swap_remove(0), figures, compensated: output.content })
    }

    /// The model, and the time that training took, s.
    fn train(&self, logs: &[Log], machine: &MachineSpec) -> Result<(Trained, f64)> {
        let (started, shown) = (Instant::now(), self.common.shown());
        let settings = TrainSettings::of(read::recipe(&self.predictor)?, self.common.seed);
        let trained = train(logs, Some(machine), &settings, &|event| shown.event(event))?;
        Ok((trained, started.elapsed().as_secs_f64()))
    }
}
