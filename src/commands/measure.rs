//! `precomp measure`: tracking and contour error of a recorded run.

use std::path::PathBuf;
use std::sync::Arc;

use anyhow::Result;
use clap::{Args, ValueEnum};
use datasets::Log;
use models::Bundle;
use motion::contour::{
    CircularTest, ContourEstimator, Exact, HermiteFootPoint, MovingWindow, OsculatingCircle, SplineSearch, Tangent,
};
use motion::{Cartesian, DesiredPath, Kinematics, Trajectory};
use serde_json::{Value, json};

use crate::cli::{Common, LogArgs, ProgramArgs};
use crate::evaluate;
use crate::files::Files;
use crate::input::{self, Frame, Input, Source};
use crate::measurement::{self, Fit, Measurement, Readback, Segment};
use crate::output::{Printer, Refusal, table, um, write_json};
use crate::units::ErrorUnit;

/// Tracking and contour error of a recorded run
///
/// With --desired the run is laid over that path by itself: a late start, a work offset and a time law of its own are found and taken off.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  precomp measure run.csv
  precomp measure run.csv --desired part.nc --machine mill.toml
  precomp measure run.csv --desired compensated.nc --machine mill.toml --readback
  precomp measure today.csv --model mill.model
  precomp measure circle.csv --desired curve:circle --feed 50 --machine mill.toml")]
pub struct Measure {
    /// The log: CSV, Parquet, halsampler, halscope, TwinCAT Scope, SINUMERIK Edge or trace
    log: PathBuf,
    #[command(flatten)]
    common: Common,
    /// Machine that made the log: a TOML file, or a built-in one; the model's when left out
    #[arg(long, value_name = "TOML")]
    machine: Option<String>,
    #[command(flatten)]
    program: ProgramArgs,
    /// The path that the part needs, where the log's command is a compensated one: program, reference or test curve (`curve:NAME`)
    #[arg(long, value_name = "INPUT")]
    desired: Option<PathBuf>,
    /// Judge the control instead of the machine: what it commanded against what the program --desired, the one that ran, was to make of it
    #[arg(long, requires = "desired")]
    readback: bool,
    /// Say whether this model still fits the machine: its prediction beside what the log shows
    #[arg(short, long, value_name = "MODEL")]
    model: Option<PathBuf>,
    /// How the contour error is found
    #[arg(long, value_enum, default_value_t = EstimatorName::Exact)]
    estimator: EstimatorName,
    #[command(flatten)]
    columns: LogArgs,
}

/// A contour-error estimator.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum EstimatorName {
    /// Newton's method on a spline of the path (default)
    Exact,
    /// Foot point on a Hermite spline (Paper A)
    HermiteFoot,
    /// Search on an interpolated spline (Paper D)
    SplineSearch,
    /// Adaptive window and chords (Paper C)
    MovingWindow,
    /// Osculating circle
    Circle,
    /// Tangent
    Tangent,
}

impl EstimatorName {
    fn estimator(self) -> Box<dyn ContourEstimator> {
        match self {
            Self::Exact => Box::new(Exact::default()),
            Self::HermiteFoot => Box::new(HermiteFootPoint::default()),
            Self::SplineSearch => Box::new(SplineSearch::default()),
            Self::MovingWindow => Box::new(MovingWindow::default()),
            Self::Circle => Box::new(OsculatingCircle::default()),
            Self::Tangent => Box::new(Tangent::default()),
        }
    }
}

impl Measure {
    pub fn files(&self) -> Files {
        Files::of(self.common.json.as_deref())
            .reads_logs("LOG", [&self.log])
            .reads("--desired", self.desired.as_deref())
            .reads("-m", self.model.as_deref())
            .reads_machine(self.machine.as_deref())
    }

    pub fn run(&self) -> Result<()> {
        let printer = Printer::new(self.common.json.as_deref());
        let log = input::log_to_measure(&self.log, &self.columns, &printer)?;
        let bundle = self.model.as_deref().map(input::model).transpose()?;
        let desired = self.desired(&log, bundle.as_ref(), &printer)?;
        let turned: Vec<&str> = log.axes().iter().filter(|axis| axis.slot() >= Some(3)).map(|axis| axis.name.as_str()).collect();
        if !turned.is_empty() && !desired.desired.kinematics().turns() {
            printer.line(format!(
                "note: axes {} are taken to turn neither tool nor workpiece; say how they do with --machine",
                turned.join(", ")
            ));
        }
        let (log, cut_s) = measurement::without_approach(&log, &desired.desired)?;
        if cut_s[0] + cut_s[1] > 0.0 {
            printer.line(format!("the way to the path and from it was left out: {:.3} s and {:.3} s", cut_s[0], cut_s[1]));
        }
        if self.readback {
            let (found, _) = measurement::readback(&log, &desired, self.estimator.estimator().as_mut())?;
            say_readback(&printer, &found);
            return write_json(self.common.json.as_deref(), &found.json());
        }
        let measured = measurement::measure(&log, &desired, self.estimator.estimator().as_mut())?;
        say(&printer, &log, &measured, self.desired.is_some())?;
        let mut figures = figures(&log, &measured)?;
        if let Some(bundle) = bundle {
            let fits = measurement::fits(&bundle, &log)?;
            say_fits(&printer, &fits);
            figures["model"] = json!(
                fits.iter()
                    .map(|fit| (
                        fit.axis.clone(),
                        json!({
                            fit.unit.key("rms"): fit.unit.value(fit.rms),
                            fit.unit.key("held_out_rms"): fit.unit.value(fit.expected),
                            "in_band_share": fit.in_band,
                            "outside_share": fit.outside,
                            "stale": fit.stale,
                        })
                    ))
                    .collect::<serde_json::Map<_, _>>()
            );
        }
        write_json(self.common.json.as_deref(), &figures)
    }

    /// The path to measure against: what --desired says, or the log's own command.
    fn desired(&self, log: &Log, bundle: Option<&Bundle>, printer: &Printer) -> Result<Input> {
        let machine = input::real_machine(self.machine.as_deref(), self.model.as_deref().zip(bundle))?;
        let frame = machine.as_ref().map(|(spec, _)| Frame::of(spec)).transpose()?;
        let as_logged = |trajectory: Trajectory| -> Result<DesiredPath> {
            let kinematics: Arc<dyn Kinematics> = match &frame {
                Some(frame) if frame.kinematics.axes() == trajectory.axes() => Arc::clone(&frame.kinematics),
                _ => Arc::new(Cartesian::new(trajectory.axes().to_vec())),
            };
            Ok(DesiredPath::new(trajectory, kinematics)?)
        };
        let Some(path) = &self.desired else {
            return Ok(Input { name: "command".into(), desired: as_logged(log.reference.clone())?, part: None });
        };
        let source = Source::open(path)?;
        let desired = match (source.into_reference(), machine.zip(frame.clone())) {
            (Ok(reference), _) => Input { name: path.display().to_string(), desired: as_logged(reference)?, part: None },
            (Err(source), Some(((_, which), frame))) => {
                printer.line(format!("{} is planned for the {which}", path.display()));
                // Planned at the log's own rate, so that samples pair up.
                source.on(&Frame { period_s: log.period_s(), ..frame }, &self.program)?
            }
            (Err(_), None) => return Err(input::machine_wanted(&format!("{} has to be planned for a machine", path.display()))),
        };
        desired.desired.trajectory().check_axes(log.axes()).map_err(|error| {
            Refusal(format!("path and log: {error}; give the machine that has the log's axes with --machine"))
        })?;
        Ok(desired)
    }
}

fn say_readback(printer: &Printer, found: &Readback) {
    printer.line(found.in_words());
    printer.line(match found.is_faithful() {
        [true, true] => "the carrier is faithful: the control commands what the program means",
        [true, false] => "the path is kept, its time is not: run slower, or write the points' time (--carrier g93)",
        [false, _] => "the control leaves the path: tighten its tolerance (G64 P0.001 Q0, or its high-accuracy mode)",
    });
}

/// Segments and reversals that are printed; the JSON figures hold all.
const SHOWN: usize = 10;

fn say(printer: &Printer, log: &Log, measured: &Measurement, laid_over: bool) -> Result<()> {
    if laid_over {
        let offset = measured.matched.offset;
        let time = match measured.matched.delay_s {
            Some(delay) => format!("delay {:.3} ms", delay * 1e3),
            None => "the run keeps a time of its own".to_owned(),
        };
        printer.line(format!("laid over the path: {time}, offset {:.4} {:.4} {:.4} mm", offset.x, offset.y, offset.z));
    }
    let common = measured.common_lag_s();
    let rows: Vec<Vec<String>> = log
        .axes()
        .iter()
        .zip(log.reference.tracking_error(&log.actual)?)
        .zip(&measured.lags_s)
        .map(|((axis, error), lag)| {
            let (rms, max) = evaluate::rms_max(&error);
            let ms = |value: Option<f64>| value.map_or("–".to_owned(), |value| format!("{:.3}", value * 1e3));
            let unit = ErrorUnit::from(axis);
            let (rms, max) = (unit.number(rms), unit.number(max));
            vec![unit.label(&axis.name), rms, max, ms(*lag), ms(lag.zip(common).map(|(lag, common)| lag - common))]
        })
        .collect();
    printer.line(table(&["axis", "tracking error RMS", "MAX", "lag ms", "against the mean ms"], &rows));
    let contour = &measured.contour;
    printer.line(format!(
        "contour error {} µm RMS, {} µm MAX, {} µm at 95 %",
        um(contour.rms_mm),
        um(contour.max_mm),
        um(contour.p95_mm)
    ));
    if let Some(o) = &measured.orientation {
        let urad = |rad: f64| format!("{:.2}", rad * 1e6);
        let (rms, max, p95) = (urad(o.rms_rad), urad(o.max_rad), urad(o.p95_rad));
        printer.line(format!("tool direction {rms} µrad RMS, {max} µrad MAX, {p95} µrad at 95 %"));
    }
    let line = |line: Option<usize>| line.map_or("–".to_owned(), |line| line.to_string());
    let rows: Vec<Vec<String>> = measured
        .worst
        .iter()
        .map(|place| {
            let at = format!("{:.3} {:.3} {:.3}", place.at.x, place.at.y, place.at.z);
            vec![um(place.error_mm), format!("{:.3}", place.time_s), line(place.line), at]
        })
        .collect();
    printer.line(table(&["worst µm", "t s", "line", "x y z mm"], &rows));
    if !measured.reversals.is_empty() {
        let mut largest: Vec<_> = measured.reversals.iter().collect();
        largest.sort_by(|a, b| b.glitch_mm.total_cmp(&a.glitch_mm));
        let rows: Vec<Vec<String>> = largest
            .iter()
            .take(SHOWN)
            .map(|one| {
                let way = if one.from_positive { "+ → −" } else { "− → +" };
                vec![one.axis.clone(), way.to_owned(), format!("{:.3}", one.time_s), format!("{:.3}", one.at), um(one.glitch_mm)]
            })
            .collect();
        printer.line(format!("{} reversals, the largest glitches:", measured.reversals.len()));
        printer.line(table(&["axis", "direction", "t s", "at mm", "glitch µm"], &rows));
    }
    if measured.segments.len() > 1 {
        let mut largest: Vec<&Segment> = measured.segments.iter().collect();
        largest.sort_by(|a, b| b.contour.rms_mm.total_cmp(&a.contour.rms_mm));
        let rows: Vec<Vec<String>> = largest
            .iter()
            .take(SHOWN)
            .map(|one| {
                vec![
                    line(one.line),
                    format!("{:.3}", one.from_s),
                    um(one.contour.rms_mm),
                    um(one.contour.max_mm),
                    one.samples.to_string(),
                ]
            })
            .collect();
        printer.line(format!("{} segments, the worst by RMS:", measured.segments.len()));
        printer.line(table(&["line", "from s", "RMS µm", "MAX µm", "samples"], &rows));
    }
    if let Some(circle) = &measured.circle {
        say_circle(printer, circle);
    }
    Ok(())
}

fn say_fits(printer: &Printer, fits: &[Fit]) {
    let rows: Vec<Vec<String>> = fits
        .iter()
        .map(|fit| {
            let verdict = match fit.stale {
                true => "stale: train again, or adapt it with train --from",
                false if fit.outside >= 1.0 => "not judged: the run lies outside what the model was trained on",
                false => "fits",
            };
            vec![
                fit.unit.label(&fit.axis),
                fit.unit.number(fit.rms),
                fit.unit.number(fit.expected),
                format!("{:.1} %", fit.in_band * 100.0),
                format!("{:.1} %", fit.outside * 100.0),
                verdict.to_owned(),
            ]
        })
        .collect();
    printer.line(table(&["model, axis", "error RMS", "held-out RMS", "within its 95 % band", "outside its range", ""], &rows));
}

fn say_circle(printer: &Printer, circle: &CircularTest) {
    printer.line(format!("circular test (ISO 230-4), least-squares radius {:.4} mm", circle.radius_mm));
    let rows: Vec<Vec<String>> = [("counterclockwise", circle.counterclockwise), ("clockwise", circle.clockwise)]
        .into_iter()
        .filter_map(|(name, figures)| {
            let f = figures?;
            let shown = [f.circular_deviation_mm, f.radial_max_mm, f.radial_min_mm, f.radial_mean_mm];
            Some(std::iter::once(name.to_owned()).chain(shown.map(um)).collect())
        })
        .collect();
    printer.line(table(&["direction", "G µm", "F max µm", "F min µm", "mean radial µm"], &rows));
    if let (Some(both), Some(mean)) = (circle.bidirectional_mm, circle.mean_bidirectional_mm) {
        printer.line(format!(
            "bidirectional circular error G(b) {} µm, mean bidirectional radial error D {} µm",
            um(both),
            um(mean)
        ));
    }
}

fn figures(log: &Log, measured: &Measurement) -> Result<Value> {
    let ms = |value: Option<f64>| value.map(|value| value * 1e3);
    let lags: serde_json::Map<String, Value> =
        log.axes().iter().zip(&measured.lags_s).map(|(axis, lag)| (axis.name.clone(), json!(ms(*lag)))).collect();
    let direction = |figures: Option<motion::contour::DirectionFigures>| {
        figures.map(|f| {
            json!({
                "circular_um": f.circular_deviation_mm * 1e3,
                "radial_max_um": f.radial_max_mm * 1e3,
                "radial_min_um": f.radial_min_mm * 1e3,
                "radial_mean_um": f.radial_mean_mm * 1e3,
            })
        })
    };
    let circle = measured.circle.as_ref().map(|circle| {
        json!({
            "radius_mm": circle.radius_mm,
            "counterclockwise": direction(circle.counterclockwise),
            "clockwise": direction(circle.clockwise),
            "bidirectional_um": circle.bidirectional_mm.map(|value| value * 1e3),
            "mean_bidirectional_um": circle.mean_bidirectional_mm.map(|value| value * 1e3),
        })
    });
    Ok(json!({
        "contour_um": evaluate::contour_json(&measured.contour),
        "orientation_urad": evaluate::orientation_json(measured.orientation.as_ref()),
        "tracking_um": evaluate::tracking_json(&log.reference, &log.actual)?,
        "delay_ms": ms(measured.matched.delay_s),
        "offset_mm": measured.matched.offset.as_slice(),
        "lag_ms": lags,
        "common_lag_ms": ms(measured.common_lag_s()),
        "worst": measured.worst.iter().map(|place| json!({
            "um": place.error_mm * 1e3, "t_s": place.time_s, "line": place.line, "at_mm": place.at.as_slice(),
        })).collect::<Vec<_>>(),
        "reversals": measured.reversals.iter().map(|one| json!({
            "axis": one.axis, "t_s": one.time_s, "at_mm": one.at, "from_positive": one.from_positive, "glitch_um": one.glitch_mm * 1e3,
        })).collect::<Vec<_>>(),
        "segments": measured.segments.iter().map(|one| json!({
            "line": one.line, "from_s": one.from_s, "samples": one.samples, "contour_um": evaluate::contour_json(&one.contour),
        })).collect::<Vec<_>>(),
        "circular_test": circle,
    }))
}
