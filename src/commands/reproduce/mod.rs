//! `precomp reproduce`: the papers' tables, printed beside what this build measures.

mod circle;
mod corner;
mod errors_over_time;
mod estimators;
mod feed;
mod five_axis;
mod found;
mod missing;
mod overshoot;
mod page;
mod paper_d;
mod picture;
mod pre_compensation;
mod prediction;
mod raster;
mod s_piece;
mod shapes;
mod spatial;
mod testbed;
mod trained;

use std::path::PathBuf;
use std::time::Instant;

use anyhow::Result;
use clap::{Args, ValueEnum};
use serde_json::json;

use self::found::Found;
use self::trained::Trained;
use crate::args::{Common, MachineArgs};
use crate::files::Files;
use crate::kind::Kind;
use crate::numbers;
use crate::output::{Outputs, Printer};

/// Print the papers' tables beside what this build measures
///
/// The simulated machine stands in for the papers' machines: orders and ratios are to be compared, not micrometres.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  precomp reproduce table-1
  precomp reproduce table-2 table-3 --quick --seeds 3
  precomp reproduce --all --page papers.md                 # every table and figure as one page")]
pub struct Reproduce {
    /// Tables; all when none is given
    #[arg(value_enum)]
    tables: Vec<TableName>,
    #[command(flatten)]
    common: Common,
    #[command(flatten)]
    machine: MachineArgs,
    /// All tables and figures
    #[arg(long, conflicts_with = "tables")]
    all: bool,
    /// Write the printed values beside the measured ones as a page in Markdown, and its pictures in the folder FILE-figures
    #[arg(long, alias = "report", value_name = "FILE.md")]
    page: Option<PathBuf>,
    /// Small networks (64 units) instead of Paper D's (3 × 128 units, up to 1000 epochs)
    #[arg(long)]
    quick: bool,
    /// The papers' networks, which are the default now
    #[arg(long, hide = true, conflicts_with = "quick")]
    paper: bool,
    /// Seeds of data, training and noise over which figures are averaged
    #[arg(long, default_value_t = 1, value_parser = numbers::count)]
    seeds: u64,
    /// Seconds of excitation that models are trained on; by default 120, for Paper D's tables about its 30,106 samples
    #[arg(long, value_parser = numbers::excitation_s)]
    seconds: Option<f64>,
    #[arg(skip)]
    trained: Trained,
}

/// A table of a paper.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum TableName {
    /// Paper A, figure 3: its contour-error estimator on a circle of 1.5 mm
    Circle,
    /// Paper A: spatial ILC with four gains; tracking-error ILC with the feed planned anew
    Spatial,
    /// Paper B, table I: slower corners, found by the curve-to-chord ratio
    Feed,
    /// Paper C, tables I to III and the S-shaped test piece: five axes, spatial and tracking-error ILC, and the compensated first run
    FiveAxis,
    /// Paper D, figure 3: tracking error of a circular test at a reversal and at a start
    Overshoot,
    /// Paper D, table I: contour-error estimators on the flower
    #[value(name = "table-1")]
    Table1,
    /// Paper D, table II: features of the LSTM, X axis of the butterfly
    #[value(name = "table-2")]
    Table2,
    /// Paper D, table III: NARX, GRU and LSTM, X axis of the butterfly
    #[value(name = "table-3")]
    Table3,
    /// Paper D, table IV: predicted tracking and contour error of four curves
    #[value(name = "table-4")]
    Table4,
    /// Paper D, tables V and VI: contour error before and after pre-compensation, and of converged ILC
    #[value(name = "table-5")]
    Table5,
    /// Paper E, figures 4 to 8, on its testbed: norm-optimal ILC of a raster scan, deadbeat, S against R
    Testbed,
    /// Paper E, figures 4, 5, 7 and 8, on the simulated drives, which stand in for its experiment
    Raster,
}

/// Seconds of excitation for models that no paper prescribes.
const SECONDS: f64 = 120.0;

impl Reproduce {
    pub fn files(&self) -> Files {
        let figures = self.page.as_deref().map(page::figures);
        Files::of(self.common.json.as_deref())
            .reads_machine(&*self.machine.machine)
            .writes("--page", self.page.as_deref(), Kind::Report)
            .writes_in("--page", figures.as_deref())
    }

    pub fn run(&self) -> Result<()> {
        let started = Instant::now();
        let printer = self.common.printer();
        let tables = if self.tables.is_empty() { TableName::value_variants().to_vec() } else { self.tables.clone() };
        let mut found = Found::default();
        for name in tables {
            let begun = Instant::now();
            found.extend(self.table(name, &printer)?);
            printer.line(format!("took {}\n", page::duration(begun.elapsed().as_secs_f64())));
        }
        found.add_missing(missing::sections());
        let seconds = started.elapsed().as_secs_f64();
        let mut outputs = Outputs::default();
        if let Some(path) = &self.page {
            let folder = page::figures(path);
            let name = folder.file_name().unwrap_or_default().to_string_lossy();
            outputs.add(path, page::page(&found.sections, &self.command(), seconds, &self.left_out(), &name));
            for picture in found.sections.iter().flat_map(|section| &section.pictures) {
                outputs.add(&folder.join(format!("{}.svg", picture.file)), picture.svg.as_str());
            }
            printer.line(format!("page in {}", path.display()));
        }
        printer.line(format!("all took {}", page::duration(seconds)));
        outputs.write(self.common.json.as_deref(), &json!({ "tables": found.tables, "seconds": seconds }))
    }

    fn table(&self, name: TableName, printer: &Printer) -> Result<Found> {
        match name {
            TableName::Circle => self.circle(printer),
            TableName::Spatial => self.spatial(printer),
            TableName::Feed => self.feed(printer),
            TableName::FiveAxis => self.five_axis(printer),
            TableName::Overshoot => self.overshoot(printer),
            TableName::Table1 => self.table_1(printer),
            TableName::Table2 => self.table_2(printer),
            TableName::Table3 => self.table_3(printer),
            TableName::Table4 => self.table_4(printer),
            TableName::Table5 => self.table_5(printer),
            TableName::Testbed => self.testbed(printer),
            TableName::Raster => self.raster(printer),
        }
    }

    /// The command that makes the same page, but for paths.
    fn command(&self) -> String {
        let names = self.tables.iter().filter_map(ValueEnum::to_possible_value);
        let mut words = vec!["precomp reproduce".to_owned()];
        words.extend(names.map(|name| name.get_name().to_owned()));
        words.extend(
            [(self.all, "--all"), (self.quick, "--quick")].iter().filter(|(set, _)| *set).map(|(_, word)| (*word).into()),
        );
        words.extend((self.seeds != 1).then(|| format!("--seeds {}", self.seeds)));
        words.extend((self.common.seed != 1).then(|| format!("--seed {}", self.common.seed)));
        words.extend(self.seconds.map(|seconds| format!("--seconds {seconds}")));
        words.extend((self.machine.machine != "ballscrew").then(|| format!("--machine {}", self.machine.machine)));
        words.push("--page FILE.md".into());
        words.join(" ")
    }

    /// Names of the tables that are not asked for.
    fn left_out(&self) -> Vec<String> {
        let all = TableName::value_variants().iter().filter(|name| !self.tables.is_empty() && !self.tables.contains(name));
        all.filter_map(ValueEnum::to_possible_value).map(|name| name.get_name().to_owned()).collect()
    }

    /// Seconds of excitation for the models of Papers B and C.
    fn seconds(&self) -> f64 {
        self.seconds.unwrap_or(SECONDS)
    }
}
