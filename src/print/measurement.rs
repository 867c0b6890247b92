//! What was measured of a run.

use motion::contour::CircularTest;
use pipeline::measure::{Fit, Measurement, Readback, Segment};
use pipeline::units::{ErrorUnit, um};
use serde_json::{Value, json};

use super::figures::{contour_json, orientation_json, tracking_figures_json};
use crate::output::{Printer, table};

/// A readback in words.
pub fn readback(found: &Readback) -> String {
    format!(
        "commanded path beside the planned one: {} µm RMS, {} µm MAX; {:.3} s planned, {:.3} s commanded, at most {:.1} ms apart",
        um(found.path.rms_mm),
        um(found.path.max_mm),
        found.intended_s,
        found.commanded_s,
        found.largest_delay_s * 1e3
    )
}

/// A readback as JSON.
pub fn readback_json(found: &Readback) -> Value {
    let [space, time] = found.is_faithful();
    json!({
        "readback_um": contour_json(&found.path),
        "planned_s": found.intended_s,
        "commanded_s": found.commanded_s,
        "largest_delay_ms": found.largest_delay_s * 1e3,
        "speed_difference": found.speed_difference,
        "path_is_kept": space,
        "time_is_kept": time,
    })
}

pub fn show_readback(printer: &Printer, found: &Readback) {
    printer.line(readback(found));
    printer.line(match found.is_faithful() {
        [true, true] => "the output format is faithful: the commanded path matches the program",
        [path_kept, false] if found.is_slow() => {
            if !path_kept {
                printer.line("path and time differ from the plan. A plan of other limits rounds corners elsewhere: look at the time first");
            }
            "the control takes longer than the plan. Where this is the original program, the plan's limits are not those of the control: \
             train with --programs, put them into the machine file, or compensate with --reference. Of a compensated one, write the points' time (--format g93)"
        }
        [_, false] => "the control is faster than the plan, or slower in places: its limits are not those of the plan. Train with --programs, or put them into the \
             machine file; of a compensated program, write the points' time (--format g93)",
        [false, true] => {
            "the control leaves the path where it rounds corners: tighten its tolerance (G64 P0.001 Q0 on LinuxCNC, $11 on Grbl, the high-accuracy mode of others)"
        }
    });
}

/// Relative difference between the times of plan and run that is reported: more than a feed override of a few steps, less than wrong limits make.
const OTHER_TIME: f64 = 0.1;

/// What is said of a run that takes another time than the plan.
pub fn other_time(planned_s: f64, run_s: f64) -> Option<String> {
    let differs = (run_s / planned_s - 1.0).abs() > OTHER_TIME;
    differs.then(|| {
        format!(
            "note: the run takes {run_s:.2} s, the plan {planned_s:.2} s: the limits or the feed override of the plan are not those of the control, and forecasts \
             of this plan are those of another motion. Train with --programs, put the control's own limits into the machine file, or compensate with --reference"
        )
    })
}

/// Segments and reversals that are printed; the JSON figures hold all.
const SHOWN: usize = 10;

/// Everything that was measured; `laid_over` where the run was laid over a path of its own.
pub fn show(printer: &Printer, measured: &Measurement, laid_over: bool) {
    if laid_over {
        let offset = measured.matched.offset;
        let time = match measured.matched.delay_s {
            Some(delay) => format!("delay {:.3} ms", delay * 1e3),
            None => "the run keeps a time of its own".to_owned(),
        };
        printer.line(format!("laid over the path: {time}, offset {:.4} {:.4} {:.4} mm", offset.x, offset.y, offset.z));
    }
    printer.line(tracking(measured));
    show_contour(printer, measured);
    printer.line(worst(measured));
    if !measured.reversals.is_empty() {
        printer.line(format!("{} reversals, the largest glitches:", measured.reversals_found));
        printer.line(reversals(measured));
    }
    if measured.segments.len() > 1 {
        printer.line(format!("{} segments, the worst by RMS:", measured.segments_found));
        printer.line(segments(measured));
    }
    if let Some(circle) = &measured.circle {
        show_circle(printer, circle);
    }
}

/// Tracking error and lag of every axis.
fn tracking(measured: &Measurement) -> String {
    let common = measured.common_lag_s();
    let ms = |value: Option<f64>| value.map_or("–".to_owned(), |value| format!("{:.3}", value * 1e3));
    let rows = measured.axes.iter().zip(&measured.tracking).zip(&measured.lags_s).map(|((axis, (rms, max)), lag)| {
        let unit = ErrorUnit::from(axis);
        let against_mean = lag.zip(common).map(|(lag, common)| lag - common);
        vec![unit.label(&axis.name), unit.number(*rms), unit.number(*max), ms(*lag), ms(against_mean)]
    });
    let header = ["axis", "tracking error RMS", "MAX", "lag ms", "against the mean ms"];
    table(&header, &rows.collect::<Vec<_>>())
}

fn show_contour(printer: &Printer, measured: &Measurement) {
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
}

/// A line of the program, where there is one.
fn shown_line(line: Option<usize>) -> String {
    line.map_or("–".to_owned(), |line| line.to_string())
}

fn worst(measured: &Measurement) -> String {
    let rows = measured.worst.iter().map(|place| {
        let at = format!("{:.3} {:.3} {:.3}", place.at.x, place.at.y, place.at.z);
        vec![um(place.error_mm), format!("{:.3}", place.time_s), shown_line(place.line), at]
    });
    table(&["worst µm", "t s", "line", "x y z mm"], &rows.collect::<Vec<_>>())
}

fn reversals(measured: &Measurement) -> String {
    let mut largest: Vec<_> = measured.reversals.iter().collect();
    largest.sort_by(|a, b| b.glitch_mm.total_cmp(&a.glitch_mm));
    let rows = largest.iter().take(SHOWN).map(|one| {
        let way = if one.from_positive { "+ → −" } else { "− → +" };
        vec![one.axis.clone(), way.to_owned(), format!("{:.3}", one.time_s), format!("{:.3}", one.at), um(one.glitch_mm)]
    });
    table(&["axis", "direction", "t s", "at mm", "glitch µm"], &rows.collect::<Vec<_>>())
}

fn segments(measured: &Measurement) -> String {
    let mut largest: Vec<&Segment> = measured.segments.iter().collect();
    largest.sort_by(|a, b| b.contour.rms_mm.total_cmp(&a.contour.rms_mm));
    let rows = largest.iter().take(SHOWN).map(|one| {
        let (rms, max) = (um(one.contour.rms_mm), um(one.contour.max_mm));
        vec![shown_line(one.line), format!("{:.3}", one.from_s), rms, max, one.samples.to_string()]
    });
    table(&["line", "from s", "RMS µm", "MAX µm", "samples"], &rows.collect::<Vec<_>>())
}

pub fn show_fits(printer: &Printer, fits: &[Fit]) {
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

fn show_circle(printer: &Printer, circle: &CircularTest) {
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
    let of_both = circle.bidirectional_mm.zip(circle.mean_bidirectional_mm).zip(circle.hysteresis_mm);
    if let Some(((both, mean), hysteresis)) = of_both {
        printer.line(format!(
            "bidirectional circular error G(b) {} µm, mean bidirectional radial error D {} µm, hysteresis H {} µm",
            um(both),
            um(mean),
            um(hysteresis)
        ));
    }
}

pub fn json(measured: &Measurement) -> Value {
    let ms = |value: Option<f64>| value.map(|value| value * 1e3);
    let lags: serde_json::Map<String, Value> =
        measured.axes.iter().zip(&measured.lags_s).map(|(axis, lag)| (axis.name.clone(), json!(ms(*lag)))).collect();
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
            "hysteresis_um": circle.hysteresis_mm.map(|value| value * 1e3),
        })
    });
    json!({
        "contour_um": contour_json(&measured.contour),
        "orientation_urad": orientation_json(measured.orientation.as_ref()),
        "tracking_um": tracking_figures_json(&measured.axes, &measured.tracking),
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
            "line": one.line, "from_s": one.from_s, "samples": one.samples, "contour_um": contour_json(&one.contour),
        })).collect::<Vec<_>>(),
        "reversals_found": measured.reversals_found,
        "segments_found": measured.segments_found,
        "circular_test": circle,
    })
}

/// How the axes of a model do, as JSON.
pub fn fits_json(fits: &[Fit]) -> Value {
    let axis = |fit: &Fit| {
        let figures = json!({
            fit.unit.key("rms"): fit.unit.value(fit.rms),
            fit.unit.key("held_out_rms"): fit.unit.value(fit.expected),
            "in_band_share": fit.in_band,
            "outside_share": fit.outside,
            "stale": fit.stale,
        });
        (fit.axis.clone(), figures)
    };
    Value::Object(fits.iter().map(axis).collect())
}
