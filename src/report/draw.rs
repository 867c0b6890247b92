//! Pictures as SVG coordinates.

use std::fmt::Write;

use motion::Vec3;
use serde::Serialize;

/// Colours of the runs.
pub const COLORS: [&str; 5] = ["#b3452c", "#1f6f8b", "#6a7f2b", "#7a4f9a", "#a67c1c"];
/// Points drawn of a path or a line: enough for a screen, few enough for a page.
const MOST_POINTS: usize = 900;
/// Steps of the colour scale.
const SHADES: usize = 8;
const WIDTH: f64 = 420.0;
const HEIGHT: f64 = 360.0;
const MARGIN: f64 = 16.0;

/// The path, seen from above, displaced by its error, magnified, and coloured by it.
#[derive(Debug, Serialize)]
pub struct PathDrawing {
    name: String,
    magnification: String,
    /// The desired path as an SVG polyline.
    desired: String,
    /// Polylines of one colour each.
    strokes: Vec<Stroke>,
    scale: Vec<Shade>,
}

#[derive(Debug, Serialize)]
struct Stroke {
    points: String,
    color: String,
}

#[derive(Debug, Serialize)]
struct Shade {
    color: String,
    up_to_um: String,
}

impl PathDrawing {
    /// Draws `desired` tips and a run's feet and error vectors (mm); `worst_mm` is the error at the end of the colour scale.
    pub fn new(name: &str, desired: &[Vec3], run: &[(Vec3, Vec3)], worst_mm: f64) -> Self {
        let view = View::of(desired);
        let span = view.span_mm;
        // The largest error is drawn as a twentieth of the picture.
        let magnification = if worst_mm > 0.0 { round_down(span / 20.0 / worst_mm) } else { 1.0 };
        let step = run.len().div_ceil(MOST_POINTS).max(1);
        let places: Vec<(usize, (f64, f64))> = run
            .iter()
            .step_by(step)
            .map(|(foot, error)| {
                let shade = (error.norm() / worst_mm.max(1e-12) * SHADES as f64) as usize;
                (shade.min(SHADES - 1), view.place(foot + error * magnification))
            })
            .collect();
        let mut strokes: Vec<Stroke> = Vec::new();
        let mut current: Option<usize> = None;
        for pair in places.windows(2) {
            let (shade, _) = pair[1];
            if current != Some(shade) {
                strokes.push(Stroke { points: point(pair[0].1), color: color(shade) });
                current = Some(shade);
            }
            if let Some(stroke) = strokes.last_mut() {
                stroke.points.push_str(&point(pair[1].1));
            }
        }
        let step = desired.len().div_ceil(MOST_POINTS).max(1);
        Self {
            name: name.to_owned(),
            magnification: format!("{magnification:.0}"),
            desired: desired.iter().step_by(step).chain(desired.last()).map(|tip| point(view.place(*tip))).collect(),
            strokes,
            scale: (0..SHADES)
                .map(|shade| Shade {
                    color: color(shade),
                    up_to_um: format!("{:.2}", worst_mm * 1e3 * (shade + 1) as f64 / SHADES as f64),
                })
                .collect(),
        }
    }
}

/// A parallel view that shows all of a path: from above, or for a path that is flat in XY from the side it extends to.
struct View {
    axes: (usize, usize),
    center: (f64, f64),
    scale: f64,
    span_mm: f64,
}

impl View {
    fn of(points: &[Vec3]) -> Self {
        let range = |axis: usize| {
            points.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), p| (low.min(p[axis]), high.max(p[axis])))
        };
        let extent = |axis: usize| {
            let (low, high) = range(axis);
            high - low
        };
        let axes = if extent(1) > 1e-6 || extent(2) < 1e-6 { (0, 1) } else { (0, 2) };
        let middle = |axis: usize| {
            let (low, high) = range(axis);
            0.5 * (low + high)
        };
        let (wide, high) = (extent(axes.0).max(1e-6), extent(axes.1).max(1e-6));
        let scale = ((WIDTH - 2.0 * MARGIN) / wide).min((HEIGHT - 2.0 * MARGIN) / high);
        Self { axes, center: (middle(axes.0), middle(axes.1)), scale, span_mm: wide.max(high) }
    }

    fn place(&self, tip: Vec3) -> (f64, f64) {
        (
            WIDTH / 2.0 + (tip[self.axes.0] - self.center.0) * self.scale,
            HEIGHT / 2.0 - (tip[self.axes.1] - self.center.1) * self.scale,
        )
    }
}

/// Lines over time, each reduced to the largest value of every stretch, so that no peak is lost.
#[derive(Debug, Serialize)]
pub struct Chart {
    lines: Vec<ChartLine>,
    top_um: String,
    half_um: String,
    end_s: String,
}

#[derive(Debug, Serialize)]
struct ChartLine {
    name: String,
    points: String,
    color: &'static str,
}

/// Size of a chart's plot area.
const CHART: (f64, f64) = (860.0, 200.0);

impl Chart {
    /// Draws magnitudes (µm) over time.
    pub fn new(lines: &[(String, Vec<f64>)], period_s: f64) -> Self {
        let top = lines.iter().flat_map(|(_, values)| values).fold(1e-9_f64, |top, v| top.max(*v));
        let samples = lines.iter().map(|(_, values)| values.len()).max().unwrap_or(1).max(2);
        let step = samples.div_ceil(MOST_POINTS);
        let drawn = lines.iter().enumerate().map(|(i, (name, values))| ChartLine {
            name: name.clone(),
            points: values
                .chunks(step)
                .enumerate()
                .map(|(chunk, values)| {
                    let value = values.iter().fold(0.0_f64, |top, v| top.max(*v));
                    point(((chunk * step) as f64 / (samples - 1) as f64 * CHART.0, CHART.1 * (1.0 - value / top)))
                })
                .collect(),
            color: COLORS[i % COLORS.len()],
        });
        Self {
            lines: drawn.collect(),
            top_um: format!("{top:.2}"),
            half_um: format!("{:.2}", top / 2.0),
            end_s: format!("{:.2}", (samples - 1) as f64 * period_s),
        }
    }
}

fn point((x, y): (f64, f64)) -> String {
    let mut text = String::new();
    // Writing to a string cannot fail.
    let _ = write!(text, "{x:.1},{y:.1} ");
    text
}

/// From blue-grey over yellow to red.
fn color(shade: usize) -> String {
    let t = shade as f64 / (SHADES - 1) as f64;
    let mix = |a: f64, b: f64, t: f64| (a + (b - a) * t).round() as u8;
    let (from, to, t) = if t < 0.5 {
        ([70.0, 130.0, 180.0], [220.0, 190.0, 60.0], 2.0 * t)
    } else {
        ([220.0, 190.0, 60.0], [190.0, 40.0, 30.0], 2.0 * t - 1.0)
    };
    let [r, g, b] = [0, 1, 2].map(|i| mix(from[i], to[i], t));
    format!("#{r:02x}{g:02x}{b:02x}")
}

/// The largest of 1, 2, 5 times a power of ten that does not exceed `value`.
fn round_down(value: f64) -> f64 {
    let power = 10.0_f64.powf(value.max(1e-9).log10().floor());
    [5.0, 2.0, 1.0]
        .into_iter()
        .map(|digit| digit * power)
        .find(|rounded| *rounded <= value * (1.0 + 1e-12))
        .unwrap_or(power)
        .max(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn magnifications_are_round_and_never_shrink() {
        assert_eq!(round_down(734.0), 500.0);
        assert_eq!(round_down(2000.0), 2000.0);
        assert_eq!(round_down(0.3), 1.0);
    }

    #[test]
    fn no_peak_is_lost_in_a_chart() {
        let mut values = vec![0.1; 100_000];
        values[54_321] = 7.0;
        let chart = Chart::new(&[("run".into(), values)], 0.002);
        assert_eq!(chart.top_um, "7.00");
        assert!(chart.lines[0].points.split(' ').any(|p| p.ends_with(",0.0")));
    }
}
