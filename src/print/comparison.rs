//! The comparison as text and JSON.

use compensation::laws::Gain;
use motion::{DesiredPath, Vec3};
use pipeline::compare::{
    BestIlc, CompareSettings, Comparison, Figures, Ilc, LawSettings, Method, PathComparison, Tuned, gap, mean, spread,
};
use pipeline::units::um;
use serde_json::{Map, Value, json};

use crate::output::table;

/// The table: a row a method, RMS and MAX in µm for every path and their mean; below it the settings of ILC, and what the rows say.
#[must_use]
pub fn render(comparison: &Comparison, settings: &CompareSettings) -> String {
    let results = &comparison.paths;
    let Some(first) = results.first() else { return String::new() };
    let mut text = rows(results, first, "tool tip, RMS / MAX, µm", &TIP);
    if first.desired.kinematics().has_rotary_axes() {
        text.push('\n');
        text.push_str(&rows(results, first, "tool direction, RMS / MAX, µrad", &TURN));
    }
    text.push('\n');
    text.push_str(&footer(results, &comparison.tuned, settings));
    if results.iter().any(|result| result.streams_part) {
        text.push_str(
            "\npart programs: here ILC shifts rapids and other moves too that a compensated program keeps, with their errors; \
             --programs compares all methods as G-code",
        );
    }
    text
}

/// The table of [`pipeline::compare::compare_programs`].
#[must_use]
pub fn render_programs(results: &[PathComparison], tuned: &Tuned, settings: &CompareSettings) -> String {
    let Some(first) = results.first() else { return String::new() };
    let mut text = rows(results, first, "as G-code, RMS / MAX, µm", &TIP);
    text.push('\n');
    text.push_str(&footer(results, tuned, settings));
    let cycle_s = |method: Method| -> Option<f64> {
        let all: Option<Vec<f64>> = results.iter().map(|result| Some(mean(&result.of(method)?.seconds))).collect();
        all.map(|all| mean(&all))
    };
    if let (Some(before), Some(after)) = (cycle_s(Method::Uncompensated), cycle_s(Method::FirstRun)) {
        let change = |after: f64| format!("{:+.1} %", 100.0 * (after / before - 1.0));
        let laws = tuned.laws.iter().filter_map(|(law, _)| Some((law.name(), cycle_s(Method::Ilc(*law))?)));
        let laws: Vec<String> = laws.map(|(law, after)| format!("{law} {}", change(after))).collect();
        text.push_str(&format!(
            "\ncycle time of the compensated programs: {}; ILC, which has no limit of it: {}",
            change(after),
            laws.join(", ")
        ));
    }
    text
}

/// What a table shows of a method's figures.
struct Shown {
    of: fn(&Figures) -> Option<(f64, f64)>,
    by_seed: fn(&Figures) -> (&[f64], &[f64]),
    text: fn(f64) -> String,
}

const TIP: Shown = Shown { of: |figures| Some(figures.mean()), by_seed: |figures| (&figures.rms, &figures.max), text: um };
const TURN: Shown = Shown {
    of: Figures::mean_turn,
    by_seed: |figures| (&figures.turn_rms, &figures.turn_max),
    text: |rad| format!("{:.2}", rad * 1e6),
};

fn rows(results: &[PathComparison], first: &PathComparison, title: &str, shown: &Shown) -> String {
    let mut header = vec![title.to_owned()];
    header.extend(results.iter().map(|result| result.name.clone()));
    header.push("mean ± spread".to_owned());
    let cell = |(rms, max): (f64, f64)| format!("{} / {}", (shown.text)(rms), (shown.text)(max));
    let rows: Vec<Vec<String>> = first
        .methods
        .iter()
        .map(|(method, _)| {
            let found: Vec<&Figures> = results.iter().filter_map(|result| result.of(*method)).collect();
            let cells = found.iter().filter_map(|figures| (shown.of)(figures)).map(cell);
            std::iter::once(method.name().to_owned()).chain(cells).chain([mean_cell(&found, shown)]).collect()
        })
        .collect();
    let header: Vec<&str> = header.iter().map(String::as_str).collect();
    table(&header, &rows)
}

/// The mean over paths and seeds, with the standard deviation over the seeds (the floor's over its runs) of the mean over the paths.
fn mean_cell(found: &[&Figures], shown: &Shown) -> String {
    let over_paths = |of: &dyn Fn(&Figures) -> Vec<f64>| -> Vec<f64> {
        let all: Vec<Vec<f64>> = found.iter().map(|figures| of(figures)).collect();
        let seeds = all.iter().map(Vec::len).min().unwrap_or_default();
        (0..seeds).map(|seed| mean(&all.iter().map(|values| values[seed]).collect::<Vec<_>>())).collect()
    };
    let cell = |values: Vec<f64>| {
        let text = (shown.text)(mean(&values));
        if values.len() > 1 { format!("{text} ± {}", (shown.text)(spread(&values))) } else { text }
    };
    let rms = cell(over_paths(&|figures| (shown.by_seed)(figures).0.to_vec()));
    format!("{rms} / {}", cell(over_paths(&|figures| (shown.by_seed)(figures).1.to_vec())))
}

fn footer(results: &[PathComparison], tuned: &Tuned, settings: &CompareSettings) -> String {
    let chosen = if tuned.searched { "tuned on this machine, on another curve and noise seed" } else { "as given" };
    let mut lines = vec![format!(
        "{} noise seed(s); ± over the seeds, of the floor over its runs. ILC: run {} on the machine, settings {chosen}:",
        settings.seeds, settings.ilc_runs
    )];
    lines.extend(tuned.laws.iter().map(|(law, settings)| format!("  {}: {}", law.name(), law_text(*settings, *law))));
    lines.push(
        "floor: run-to-run repeatability, the expected error of a perfect compensation; a single run may lie below it".to_owned(),
    );
    for result in results {
        if let Some(BestIlc { rms, max }) = result.best_ilc() {
            let worst =
                |method| result.of(method).and_then(Figures::worst_sample).map(|sample| where_on(&result.desired, sample));
            let places: Vec<String> = [Method::FirstRun, Method::BestIlc]
                .into_iter()
                .filter_map(|method| Some(format!("{} {}", method.name(), worst(method)?.text())))
                .collect();
            lines.push(format!(
                "{}: best ILC in RMS {}, in MAX {}; MAX of {}",
                result.name,
                rms.name(),
                max.name(),
                places.join(", ")
            ));
        }
    }
    let words = |gap: Option<f64>| gap.map_or("not defined".to_owned(), |gap| format!("{gap:.2}"));
    if results.iter().any(|result| result.of(Method::FirstRun).is_some()) {
        let (rms, max) = gap(results);
        lines.push(format!(
            "gap (first run − floor)/(best ILC − floor) of the means: {} in RMS, {} in MAX; below 1 the first run is better than every ILC",
            words(rms),
            words(max)
        ));
    }
    lines.join("\n")
}

/// The settings of every law as JSON.
fn tuned_json(tuned: &Tuned) -> Value {
    Value::Object(tuned.laws.iter().map(|(law, settings)| (law.name().to_owned(), law_json(*settings, *law))).collect())
}

/// The settings of a law in words.
fn law_text(settings: LawSettings, law: Ilc) -> String {
    match settings {
        LawSettings::NormOptimal { s, r } => format!("weights S {s}, R {r}"),
        LawSettings::Filtered { gain, low_pass_hz, window_s } => {
            let gain = match gain {
                Gain::Constant(gain) => format!("gain {gain}"),
                Gain::Decreasing => "gain 1/j in run j".to_owned(),
            };
            let window = if law.is_spatial() && window_s > 0.0 {
                format!(", {} ms at stops and turns", window_s * 1e3)
            } else {
                String::new()
            };
            format!("{gain}, low-pass {low_pass_hz} Hz{window}")
        }
    }
}

/// The settings of a law as JSON.
fn law_json(settings: LawSettings, law: Ilc) -> Value {
    match settings {
        LawSettings::NormOptimal { s, r } => json!({ "weight_s": s, "weight_r": r }),
        LawSettings::Filtered { gain, low_pass_hz, window_s } => {
            let gain = match gain {
                Gain::Constant(gain) => json!(gain),
                Gain::Decreasing => json!("1/j"),
            };
            let window_ms = law.is_spatial().then_some(window_s * 1e3);
            json!({ "gain": gain, "low_pass_hz": low_pass_hz, "turn_window_ms": window_ms })
        }
    }
}

/// A place on a path, in time and space.
#[derive(Debug, Clone, PartialEq)]
struct Place {
    seconds: f64,
    position_mm: f64,
    near: String,
}

impl Place {
    fn text(&self) -> String {
        format!("at {:.2} s, {:.1} mm ({})", self.seconds, self.position_mm, self.near)
    }

    fn json(&self) -> Value {
        json!({ "t_s": self.seconds, "position_mm": self.position_mm, "near": self.near })
    }
}

/// Time after an event of the path within which an error is put down to it, s: as long as a servo settles. And before it, s.
const AFTER_S: f64 = 0.1;
const BEFORE_S: f64 = 0.02;
/// Turn of the direction within 20 ms that counts as a corner, rad.
const CORNER_RAD: f64 = 0.5;

/// Where a sample of the path lies, and the last start, stop, corner or reversal before it.
fn where_on(desired: &DesiredPath, sample: usize) -> Place {
    let (path, tips) = (desired.trajectory(), desired.tips());
    let sample = sample.min(tips.len().saturating_sub(1));
    let position_mm = tips[..=sample].windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum();
    let samples = |time_s: f64| (time_s / path.period_s()).round() as usize;
    let reach = samples(BEFORE_S).max(1);
    let (from, to) = (sample.saturating_sub(samples(AFTER_S)), (sample + reach).min(tips.len() - 1));
    let event = (from..=to).rev().find_map(|k| event_at(desired, &tips, k, reach));
    Place { seconds: sample as f64 * path.period_s(), position_mm, near: event.unwrap_or_else(|| "no event".to_owned()) }
}

/// What happens at a sample of the path, if anything.
fn event_at(desired: &DesiredPath, tips: &[Vec3], k: usize, reach: usize) -> Option<String> {
    if k == 0 || k + 1 >= tips.len() {
        return None;
    }
    let (before, after) = (tips[k] - tips[k - 1], tips[k + 1] - tips[k]);
    match (before.norm() > 0.0, after.norm() > 0.0) {
        (false, true) => return Some("start".to_owned()),
        (true, false) => return Some("stop".to_owned()),
        _ => {}
    }
    let path = desired.trajectory();
    let reversed = path.columns().iter().position(|column| (column[k] - column[k - 1]) * (column[k + 1] - column[k]) < 0.0);
    let half = (reach / 2).max(1);
    let (back, ahead) = (tips[k] - tips[k.saturating_sub(half)], tips[(k + half).min(tips.len() - 1)] - tips[k]);
    if back.norm() > 0.0 && ahead.norm() > 0.0 && back.angle(&ahead) > CORNER_RAD {
        return Some("corner".to_owned());
    }
    reversed.map(|axis| format!("reversal of {}", path.axes()[axis].name))
}

/// The figures as JSON, by path and method.
#[must_use]
pub fn json(comparison: &Comparison, settings: &CompareSettings) -> Value {
    let (rms, max) = gap(&comparison.paths);
    json!({
        "seeds": settings.seeds,
        "ilc": { "runs": settings.ilc_runs, "tuned": comparison.tuned.searched, "laws": tuned_json(&comparison.tuned) },
        "gap": { "rms": rms, "max": max },
        "paths": paths_json(&comparison.paths, settings),
    })
}

/// The figures of programs as JSON, as [`json()`].
#[must_use]
pub fn programs_json(results: &[PathComparison], tuned: &Tuned, settings: &CompareSettings) -> Value {
    let (rms, max) = gap(results);
    json!({
        "ilc": { "runs": settings.ilc_runs, "tuned": tuned.searched, "laws": tuned_json(tuned) },
        "gap": { "rms": rms, "max": max },
        "paths": paths_json(results, settings),
    })
}

fn paths_json(results: &[PathComparison], settings: &CompareSettings) -> Vec<Value> {
    let path = |result: &PathComparison| {
        let methods =
            result.methods.iter().map(|(method, figures)| (method.name().to_owned(), entry(result, *method, figures, settings)));
        let methods: Map<String, Value> = methods.collect();
        let by_run: Vec<f64> = result.learning_of(Ilc::Spatial).iter().map(|rms| rms * 1e3).collect();
        let (rms, max) = result.gap();
        json!({
            "name": result.name, "methods": methods, "gap": { "rms": rms, "max": max }, "spatial_ilc_rms_by_run_um": by_run,
        })
    };
    results.iter().map(path).collect()
}

fn entry(result: &PathComparison, method: Method, figures: &Figures, settings: &CompareSettings) -> Value {
    let (rms, max) = figures.mean();
    let mut entry = json!({
        "rms_um": rms * 1e3,
        "max_um": max * 1e3,
        "rms_spread_um": spread(&figures.rms) * 1e3,
        "max_spread_um": spread(&figures.max) * 1e3,
    });
    if let Some((rms, max)) = figures.mean_turn() {
        entry["orientation_rms_urad"] = json!(rms * 1e6);
        entry["orientation_max_urad"] = json!(max * 1e6);
    }
    if !figures.seconds.is_empty() {
        entry["seconds"] = json!(mean(&figures.seconds));
    }
    if method != Method::Floor
        && let Some(sample) = figures.worst_sample()
    {
        entry["max_at"] = where_on(&result.desired, sample).json();
    }
    if matches!(method, Method::Ilc(_) | Method::BestIlc) {
        entry["runs"] = json!(settings.ilc_runs);
    }
    if method == Method::BestIlc
        && let Some(BestIlc { rms, max }) = result.best_ilc()
    {
        entry["rms_law"] = json!(rms.name());
        entry["max_law"] = json!(max.name());
    }
    entry
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use motion::{Axis, Cartesian, Trajectory};

    use super::*;

    #[test]
    fn a_place_is_named_by_the_event_before_it() {
        // 1 s at rest, 1 s along x, 1 s back, rest; every 2 ms.
        let mut x = vec![0.0; 500];
        x.extend((1..=500).map(|k| 0.02 * f64::from(k)));
        x.extend((0..500).rev().map(|k| 0.02 * f64::from(k)));
        x.extend(vec![0.0; 500]);
        let zeros = vec![0.0; x.len()];
        let path = Trajectory::new(0.002, Axis::xyz(), vec![x, zeros.clone(), zeros]).unwrap();
        let desired = DesiredPath::new(path, Arc::new(Cartesian::new(Axis::xyz()))).unwrap();
        let near = |sample| where_on(&desired, sample).near;
        assert_eq!((near(200).as_str(), near(510).as_str(), near(700).as_str()), ("no event", "start", "no event"));
        assert_eq!(near(1010), "corner");
        assert_eq!(near(1510), "stop");
        let place = where_on(&desired, 750);
        assert!((place.seconds - 1.5).abs() < 1e-12 && (place.position_mm - 5.02).abs() < 1e-9, "{place:?}");
        assert_eq!(where_on(&desired, 1_000_000).seconds, where_on(&desired, 1999).seconds);
    }
}
