//! Options that change feeds, and what they come to.

use anyhow::Result;
use clap::Args;
use models::Bundle;
use pipeline::feed_adjustment::{Adjusted, FeedLimits, Goal, adjust, trade_off};
use pipeline::model_based_ilc::Settings;
use pipeline::{Part, Progress};
use serde_json::{Value, json};

use crate::args::parse_length;
use crate::numbers;
use crate::output::{Printer, Usage};
use crate::print::feeds as print;

/// Choices of feeds that `--pareto` prints.
const TRADE_OFFS: usize = 10;

/// Options that change feeds.
#[derive(Debug, Clone, Args)]
pub struct FeedArgs {
    /// Slow moves down whose predicted contour error stays above this after compensation: 2um, 0.002mm
    #[arg(long, value_name = "LENGTH", value_parser = parse_length)]
    tolerance: Option<f64>,
    /// With --tolerance: speed other moves up until the cycle takes no longer than before
    #[arg(long, requires = "tolerance")]
    keep_time: bool,
    /// With --tolerance: the feeds of the shortest cycle whose predicted contour error stays within it
    #[arg(long, requires = "tolerance", conflicts_with_all = ["keep_time", "max_time"])]
    fastest: bool,
    /// The feeds of the least predicted MAX, in a cycle that takes at most this much longer than programmed: +1%, 0%, -20%. Plans some twenty
    /// programs
    #[arg(long, value_name = "PERCENT", value_parser = numbers::change, conflicts_with = "tolerance", allow_hyphen_values = true)]
    max_time: Option<f64>,
    /// Print cycle time against predicted contour error for ten choices of feeds
    #[arg(long)]
    pareto: bool,
    /// Feeds may exceed the programmed ones by this, percent. When left out: not at all, with --keep-time by 100
    #[arg(long, value_name = "PERCENT", value_parser = numbers::percent)]
    may_exceed_feed: Option<f64>,
    /// Largest feed of all, mm/min, or inches a minute as 80in
    #[arg(long, value_name = "FEED", value_parser = numbers::feed_mm_min)]
    max_feed: Option<f64>,
    /// Change only feeds in these lines of the program: 120-480,900-950
    #[arg(long, value_name = "A-B", value_parser = numbers::lines, value_delimiter = ',')]
    lines: Vec<(usize, usize)>,
    /// Change only feeds of these tools: 3,12
    #[arg(long, value_name = "T", value_delimiter = ',')]
    tools: Vec<u32>,
}

/// A part with its feeds, and their compensation where they were adjusted.
pub enum Chosen {
    /// The part with the feeds of its program.
    Same(Box<Part>),
    /// Other feeds, with their compensation.
    Adjusted(Box<Adjusted>),
}

impl FeedArgs {
    /// Whether any feed may change, or is asked about.
    pub fn is_used(&self) -> bool {
        self.pareto || self.goal().is_some()
    }

    /// Refuses limits of feeds where no feed is to change.
    ///
    /// # Errors
    /// [`Usage`].
    pub fn check(&self) -> Result<()> {
        let has_limits =
            self.may_exceed_feed.is_some() || self.max_feed.is_some() || !self.lines.is_empty() || !self.tools.is_empty();
        if has_limits && !self.is_used() {
            let why = "--may-exceed-feed, --max-feed, --lines and --tools limit what --tolerance, --max-time and --pareto change; give one of those";
            return Err(Usage(why.into()).into());
        }
        Ok(())
    }

    fn goal(&self) -> Option<Goal> {
        match (self.tolerance, self.max_time) {
            (Some(tolerance_mm), _) if self.fastest => Some(Goal::Fastest { tolerance_mm }),
            (Some(tolerance_mm), _) => Some(Goal::Slower { tolerance_mm, keep_time: self.keep_time }),
            (None, Some(change)) => Some(Goal::WithinTime { change }),
            (None, None) => None,
        }
    }

    fn limits(&self) -> FeedLimits {
        FeedLimits {
            highest_factor: self.may_exceed_feed.map(|percent| 1.0 + 0.01 * percent),
            max_feed_mm_s: self.max_feed.map_or(f64::INFINITY, |feed| feed / 60.0),
            lines: self.lines.clone(),
            tools: self.tools.clone(),
        }
    }

    /// Chooses the feeds of a part. Returns them with their compensation, where any were to change, or the part as it was, and the figures.
    ///
    /// # Errors
    /// As [`adjust`].
    pub fn choose(
        &self,
        mut part: Part,
        model: &Bundle,
        settings: &Settings,
        printer: &Printer,
        progress: Progress<'_>,
    ) -> Result<(Chosen, Value)> {
        let limits = self.limits();
        let mut pareto = Value::Null;
        if self.pareto {
            let (same, programmed, points) = trade_off(part, model, settings, TRADE_OFFS, &limits, progress)?;
            print::show_trade_off(printer, &programmed, &points);
            pareto = print::trade_off_json(&programmed, &points);
            part = same;
        }
        let Some(goal) = self.goal() else {
            return Ok((Chosen::Same(Box::new(part)), json!({ "pareto": pareto })));
        };
        let adjusted = adjust(part, model, settings, goal, &limits, progress)?;
        print::show(printer, &adjusted, goal);
        let figures = print::json(&adjusted, goal, &pareto);
        Ok((Chosen::Adjusted(Box::new(adjusted)), figures))
    }
}
