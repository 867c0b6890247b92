//! Sections on a diagnosis: verdicts, figures, what the logs do not show, and a picture for each finding that has one.

use diagnosis::linuxcnc::Joint;
use diagnosis::{Diagnosis, Estimate, Finding, Mark, Picture, Quantity, Series, Verdict, threshold};

use super::column::Column;
use super::polar::{Polar, PolarRun};
use super::section::{Chart, Content, Line, Quantity as Axis, Section, Style, Table, Verdict as Shown};
use crate::print::diagnosis::{digits, name};

/// All sections on a diagnosis.
#[must_use]
pub fn diagnosis(found: &Diagnosis) -> Vec<Section> {
    let mut sections = vec![verdicts(found)];
    sections.extend(figures(found));
    let pictured = found.findings.iter().filter(|finding| finding.estimate.is_some());
    sections.extend(pictured.filter_map(|finding| pictured_section(finding, found)));
    sections.extend(hidden(found));
    sections
}

fn verdicts(found: &Diagnosis) -> Section {
    let rated = |finding: &Finding| {
        let verdict = match finding.verdict {
            Verdict::Good => Shown::Good,
            Verdict::Fair => Shown::Fair,
            Verdict::Poor => Shown::Poor,
            Verdict::Figure | Verdict::NotObservable => return None,
        };
        let (value, interval) = finding.estimate.as_ref().map(|estimate| numbers(estimate, finding.unit))?;
        let effect = finding.effect_um.map_or_else(String::new, |effect| digits(effect.value.abs()));
        let named = format!("{}, {}", name(finding.quantity), finding.axis);
        Some((verdict, vec![named, value, interval, effect, finding.meaning.clone(), finding.remedy.clone()]))
    };
    let mut rows: Vec<(Shown, Vec<String>)> = found.findings.iter().filter_map(rated).collect();
    // The worst first; otherwise axis by axis.
    rows.sort_by_key(|(verdict, _)| match verdict {
        Shown::Poor => 0,
        Shown::Fair => 1,
        Shown::Good => 2,
    });
    let (verdicts, rows) = rows.into_iter().unzip();
    let header = ["quantity, axis", "value", "95 % interval", "effect µm", "what it is", "what to do"];
    let table = Table { texts: vec![0, 4, 5], verdicts, ..Table::new(&header, rows) };
    let circle = found.circle;
    let doubtful = match found.doubtful_axes.as_slice() {
        [] => String::new(),
        axes => format!(" The servo model does not follow axes {}: their findings are doubtful.", axes.join(", ")),
    };
    let note = format!(
        "From {:.1} s of commanded and actual positions, by a servo model of each axis. Effects are deviations on a circle of {} mm radius at {} mm/s, \
         or in the logs. Verdicts: {}.{doubtful}",
        found.seconds,
        digits(circle.radius_mm),
        digits(circle.feed_mm_s),
        threshold::SOURCE
    );
    Section::new("What the logs say about the machine", note, Content::Table(table))
}

/// A value with its unit, and its interval.
fn numbers(estimate: &Estimate, unit: &str) -> (String, String) {
    let unit = if unit == "share" { "" } else { unit };
    let value = format!("{} {unit}", digits(estimate.value));
    (value.trim_end().to_owned(), format!("{} … {}", digits(estimate.low), digits(estimate.high)))
}

/// Findings without a threshold.
fn figures(found: &Diagnosis) -> Option<Section> {
    let row = |finding: &Finding| {
        let (value, interval) = finding.estimate.as_ref().map(|estimate| numbers(estimate, finding.unit))?;
        Some(vec![format!("{}, {}", name(finding.quantity), finding.axis), value, interval, finding.meaning.clone()])
    };
    let unrated = found.findings.iter().filter(|finding| finding.verdict == Verdict::Figure);
    let rows: Vec<Vec<String>> = unrated.filter_map(row).collect();
    let table = Table { texts: vec![0, 3], ..Table::new(&["quantity, axis", "value", "95 % interval", "what it is"], rows) };
    let note = "What the drives are like, without a threshold: good or bad is only what comes of it.";
    (!table.rows.is_empty()).then(|| Section::new("Figures of the drives", note, Content::Table(table)))
}

/// What the logs do not show, and what would.
fn hidden(found: &Diagnosis) -> Option<Section> {
    let row = |finding: &Finding| {
        vec![format!("{}, {}", name(finding.quantity), finding.axis), finding.meaning.clone(), finding.remedy.clone()]
    };
    let rows: Vec<Vec<String>> = found.findings.iter().filter(|finding| finding.estimate.is_none()).map(row).collect();
    let table = Table { texts: vec![0, 1, 2], ..Table::new(&["quantity, axis", "why", "what would show it"], rows) };
    (!table.rows.is_empty()).then(|| Section::new("Not observable in these logs", "", Content::Table(table)))
}

/// The picture of a finding: that of a mismatch as the circle that it deforms, the others as charts.
fn pictured_section(finding: &Finding, found: &Diagnosis) -> Option<Section> {
    let picture = finding.picture.as_ref()?;
    let (value, interval) = finding.estimate.as_ref().map(|estimate| numbers(estimate, finding.unit))?;
    let rating = match finding.verdict {
        Verdict::Good => ": good",
        Verdict::Fair => ": fair",
        Verdict::Poor => ": poor",
        Verdict::Figure | Verdict::NotObservable => "",
    };
    let named = name(finding.quantity);
    let note = format!("{named} of {}: {value} (95 %: {interval}){rating}. {}.", finding.axis, capital(&finding.meaning));
    let title = format!("{}: {}", capital(named), picture.title);
    let content = match finding.quantity {
        Quantity::ServoMismatch => Content::Polar(ellipse(finding, picture, found)?),
        _ => Content::Chart(chart(picture, finding.quantity)),
    };
    Some(Section::new(&title, note, content))
}

fn capital(text: &str) -> String {
    let mut characters = text.chars();
    characters.next().map_or_else(String::new, |first| first.to_uppercase().chain(characters).collect())
}

/// The test circle as a mismatch deforms it, in both senses of travel.
fn ellipse(finding: &Finding, picture: &Picture, found: &Diagnosis) -> Option<Polar> {
    let series = picture.series.first()?;
    let (one, other) = finding.axis.split_once('-')?;
    let angles: Vec<f64> = series.x.iter().map(|degrees| degrees.to_radians()).collect();
    // Clockwise the lags point the other way.
    let radial: Vec<f64> = series.y.iter().copied().chain(series.y.iter().map(|um| -um)).collect();
    let left: Vec<bool> = (0..radial.len()).map(|k| k < angles.len()).collect();
    let run = PolarRun {
        name: "by the mismatch alone".to_owned(),
        angle_rad: Column::float(&[&angles[..], &angles[..]].concat()),
        radial_um: Column::float(&radial),
        counterclockwise: Column::flags(&left),
    };
    let (difference, interval) = finding.estimate.as_ref().map(|estimate| numbers(estimate, finding.unit))?;
    let effect = finding.effect_um?;
    let row = vec![
        finding.axis.clone(),
        difference,
        interval,
        digits(effect.value),
        format!("{} … {}", digits(effect.low), digits(effect.high)),
    ];
    Some(Polar {
        radius_mm: found.circle.radius_mm,
        plane: [one, other].map(str::to_uppercase),
        runs: vec![run],
        header: vec!["axes", "difference of the lags", "95 % interval", "deviation at 45° µm", "95 % interval µm"],
        rows: vec![row],
    })
}

/// A picture as a chart: all series over the abscissae of all of them.
fn chart(picture: &Picture, quantity: Quantity) -> Chart {
    let mut xs: Vec<f64> = picture.series.iter().flat_map(|series| series.x.iter().copied()).collect();
    xs.sort_by(f64::total_cmp);
    xs.dedup();
    let bands = picture.series.iter().any(|series| series.mark == Mark::Lower);
    let line = |(index, series): (usize, &Series)| {
        let (style, values) = match series.mark {
            Mark::Points => (Style::Dots, at_own_places(series, &xs)),
            Mark::Line => (Style::Line, between_places(series, &xs)),
            Mark::Lower => (Style::Low, between_places(series, &xs)),
            Mark::Upper => (Style::High, between_places(series, &xs)),
        };
        // A band has the colour of its line.
        let color = if bands { 0 } else { index };
        Line { name: series.name.clone(), style, color, values: Column::float(&values) }
    };
    let log = match quantity {
        Quantity::Ripple => [true, false],
        Quantity::Resonance => [false, true],
        _ => [false, false],
    };
    Chart {
        lines: picture.series.iter().enumerate().map(line).collect(),
        x: Axis::at(&picture.x.name, &picture.x.unit, &xs),
        y: Axis::of(&picture.y.name, &picture.y.unit),
        log,
    }
}

/// Values at the abscissae of the series itself; of several at one place the last.
fn at_own_places(series: &Series, xs: &[f64]) -> Vec<f64> {
    let mut values = vec![f64::NAN; xs.len()];
    for (x, y) in series.x.iter().zip(&series.y) {
        values[xs.partition_point(|known| known.total_cmp(x).is_lt()).min(xs.len() - 1)] = *y;
    }
    values
}

/// Linear between the points of a series, none beyond its ends.
fn between_places(series: &Series, xs: &[f64]) -> Vec<f64> {
    let mut points: Vec<(f64, f64)> = series.x.iter().copied().zip(series.y.iter().copied()).collect();
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    let value = |x: &f64| {
        let next = points.partition_point(|point| point.0 < *x);
        match (next.checked_sub(1).and_then(|before| points.get(before)), points.get(next)) {
            (_, Some(here)) if here.0 == *x => here.1,
            (Some(a), Some(b)) => a.1 + (b.1 - a.1) * (x - a.0) / (b.0 - a.0),
            _ => f64::NAN,
        }
    };
    xs.iter().map(value).collect()
}

/// A section that says why there is none.
#[must_use]
pub fn nothing(title: &str, why: String) -> Section {
    Section::new(title, why, Content::Table(Table::new(&[], Vec::new())))
}

/// Settings of LinuxCNC that follow, with the forecast of each.
#[must_use]
pub fn suggestion(joints: &[Joint]) -> Section {
    let rows = joints.iter().flat_map(|joint| {
        let now = vec![format!("JOINT_{} ({})", joint.joint, joint.axis), "as logged".to_owned(), digits(joint.logged_um)];
        let setting = |setting: &diagnosis::linuxcnc::Setting| {
            vec![String::new(), format!("{} = {:.6}", setting.key, setting.value), digits(setting.forecast_um)]
        };
        std::iter::once(now).chain(joint.settings.iter().map(setting)).collect::<Vec<_>>()
    });
    let table = Table { texts: vec![0, 1], ..Table::new(&["joint", "setting", "following error RMS µm"], rows.collect()) };
    let notes: Vec<String> =
        joints.iter().filter_map(|joint| joint.note.as_ref().map(|note| format!("{}: {note}.", joint.axis))).collect();
    let note = format!(
        "For review: nothing was sent. Each forecast is with the settings above it, by the servo model on the logs. {}",
        notes.join(" ")
    );
    Section::new("Suggested settings of LinuxCNC", note.trim_end(), Content::Table(table))
}

#[cfg(test)]
mod tests {
    use super::*;
    use diagnosis::Label;

    #[test]
    fn series_of_a_picture_share_one_abscissa() {
        let dots = Series::new("logged", Mark::Points, [(2.0, 5.0), (-1.0, 3.0), (0.5, 4.0)]);
        let line = Series::new("lag", Mark::Line, [(1.0, 10.0), (-1.0, -10.0)]);
        let xs = [-1.0, 0.5, 1.0, 2.0];
        let is = |found: Vec<f64>, wanted: [f64; 4]| {
            assert!(
                found.iter().zip(wanted).all(|(a, b)| (a.is_nan() && b.is_nan()) || (a - b).abs() < 1e-12),
                "{found:?} {wanted:?}"
            );
        };
        is(at_own_places(&dots, &xs), [3.0, 4.0, f64::NAN, 5.0]);
        is(between_places(&line, &xs), [-10.0, 5.0, 10.0, f64::NAN]);
        let label = || Label::new("speed", "mm/s");
        let picture = Picture { title: String::new(), x: label(), y: label(), series: vec![dots, line] };
        let made = serde_json::to_value(chart(&picture, Quantity::FollowingLag)).unwrap();
        assert_eq!((&made["lines"][0]["style"], &made["lines"][1]["style"]), (&"dots".into(), &"line".into()));
        assert!(
            made["lines"].as_array().unwrap().iter().all(|line| line["values"]["length"] == 4)
                && made["x"]["values"]["length"] == 4
        );
    }
}
