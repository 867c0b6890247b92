//! `precomp reproduce`: the papers' tables, printed beside what this build measures.

mod estimators;
mod feed;
mod five_axis;
mod pre_compensation;
mod prediction;
mod raster;
mod spatial;

use anyhow::Result;
use clap::{Args, ValueEnum};
use serde_json::json;

use crate::args::{Common, MachineArgs};
use crate::files::Files;
use crate::numbers;
use crate::output::write_json;

/// Print the papers' tables beside what this build measures
///
/// The simulated machine stands in for the papers' machines: orders and ratios are to be compared, not micrometres.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  precomp reproduce table-1
  precomp reproduce table-2 table-3 --paper --seeds 3      # Paper D's networks as printed: hours")]
pub struct Reproduce {
    /// Tables; all when none is given
    #[arg(value_enum)]
    tables: Vec<TableName>,
    #[command(flatten)]
    common: Common,
    #[command(flatten)]
    machine: MachineArgs,
    /// Networks as the paper prints them (3 × 128 units, up to 1000 epochs) instead of small ones (64 units)
    #[arg(long)]
    paper: bool,
    /// Seeds of data, training and noise over which figures are averaged
    #[arg(long, default_value_t = 1, value_parser = numbers::count)]
    seeds: u64,
    /// Seconds of excitation that models are trained on
    #[arg(long, default_value_t = 120.0, value_parser = numbers::excitation_s)]
    seconds: f64,
}

/// A table of a paper.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum TableName {
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
    /// Paper A: spatial ILC with four gains; tracking-error ILC with the feed planned anew
    Spatial,
    /// Paper B, table I: slower corners, found by the curve-to-chord ratio
    Feed,
    /// Paper E, figures 4 to 6: norm-optimal ILC of a raster scan, single axes to contour
    Raster,
    /// Paper C, tables I to III: five axes, spatial and tracking-error ILC, and the compensated first run
    FiveAxis,
}

impl Reproduce {
    pub fn files(&self) -> Files {
        Files::of(self.common.json.as_deref()).reads_machine(&*self.machine.machine)
    }

    pub fn run(&self) -> Result<()> {
        let printer = self.common.printer();
        let tables = if self.tables.is_empty() { TableName::value_variants().to_vec() } else { self.tables.clone() };
        let mut figures = Vec::new();
        for name in tables {
            figures.extend(match name {
                TableName::Table1 => self.table_1(&printer)?,
                TableName::Table2 => self.table_2(&printer)?,
                TableName::Table3 => self.table_3(&printer)?,
                TableName::Table4 => self.table_4(&printer)?,
                TableName::Table5 => self.table_5(&printer)?,
                TableName::Spatial => self.spatial(&printer)?,
                TableName::Feed => self.feed(&printer)?,
                TableName::Raster => self.raster(&printer)?,
                TableName::FiveAxis => self.five_axis(&printer)?,
            });
        }
        write_json(self.common.json.as_deref(), &json!({ "tables": figures }))
    }
}
