//! Pictures of the papers' figures, in SVG: panels of lines over two axes.

use std::fmt::Write;

/// A picture beside the page.
#[derive(Debug)]
pub(super) struct Picture {
    /// File name without its ending.
    pub file: &'static str,
    /// Figure of the paper, and what the lines are.
    pub caption: String,
    pub svg: String,
}

/// One drawing with its axes.
#[derive(Debug)]
pub(super) struct Panel {
    pub title: String,
    /// What the axes are, with their units.
    pub axes: (&'static str, &'static str),
    /// Whether a unit is as long on both axes, as in a path.
    pub is_path: bool,
    pub lines: Vec<Line>,
}

/// A line, in pieces where it is interrupted.
#[derive(Debug)]
pub(super) struct Line {
    pub name: &'static str,
    pub pieces: Vec<Vec<(f64, f64)>>,
}

/// Size of a panel's drawing and of the margins around it: left, top, right, bottom; px.
const PANEL: (f64, f64) = (264.0, 168.0);
/// A path needs as much height as width.
const PATH: (f64, f64) = (264.0, 264.0);
const MARGIN: [f64; 4] = [50.0, 24.0, 12.0, 36.0];
/// Height of the legend, px.
const LEGEND: f64 = 26.0;
/// Spans of a line over time of which the least and the largest value are drawn.
const SPANS: usize = 132;
/// Least distance of two drawn points of a path, px.
const APART: f64 = 1.5;
/// Colours in the order of the names, distinct for the colour-blind (Okabe and Ito 2008); the first one is the desired or measured line.
const COLOURS: [&str; 5] = ["#000000", "#d55e00", "#0072b2", "#009e73", "#cc79a7"];

impl Line {
    /// Values of every sample over time, s. Of each span only the least and the largest value stay.
    pub(super) fn over_time(name: &'static str, period_s: f64, values: &[f64]) -> Self {
        let length = values.len().div_ceil(SPANS).max(1);
        let mut points = Vec::with_capacity(2 * SPANS);
        for from in (0..values.len()).step_by(length) {
            let span = from..(from + length).min(values.len());
            let least = span.clone().min_by(|a, b| values[*a].total_cmp(&values[*b]));
            let largest = span.max_by(|a, b| values[*a].total_cmp(&values[*b]));
            let mut ends: Vec<usize> = least.into_iter().chain(largest).collect();
            ends.sort_unstable();
            ends.dedup();
            points.extend(ends.into_iter().map(|k| (k as f64 * period_s, values[k])));
        }
        Self { name, pieces: vec![points] }
    }
}

/// Panels in rows of `columns`, with one legend below.
pub(super) fn draw(columns: usize, panels: &[Panel]) -> String {
    let size = if panels.iter().any(|panel| panel.is_path) { PATH } else { PANEL };
    let [left, top, right, bottom] = MARGIN;
    let cell = (left + size.0 + right, top + size.1 + bottom);
    let rows = panels.len().div_ceil(columns);
    let (width, height) = (cell.0 * columns.min(panels.len()) as f64, cell.1 * rows as f64 + LEGEND);
    let mut names: Vec<&str> = Vec::new();
    for line in panels.iter().flat_map(|panel| &panel.lines) {
        if !names.contains(&line.name) {
            names.push(line.name);
        }
    }
    let width = width.max(left + names.iter().map(|name| entry_width(name)).sum::<f64>());
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width:.0} {height:.0}\" width=\"{width:.0}\" height=\"{height:.0}\" \
         font-family=\"system-ui, sans-serif\" font-size=\"11\">\n<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n"
    );
    for (index, panel) in panels.iter().enumerate() {
        let corner = ((index % columns) as f64 * cell.0 + left, (index / columns) as f64 * cell.1 + top);
        svg += &panel.drawn(corner, size, &names);
    }
    let mut x = left;
    for (index, name) in names.iter().enumerate() {
        let (y, colour) = (height - 0.5 * LEGEND, COLOURS[index % COLOURS.len()]);
        let _ = writeln!(
            svg,
            "<path d=\"M{x:.0} {y:.0}h18\" stroke=\"{colour}\" stroke-width=\"2\"/><text x=\"{:.0}\" y=\"{:.0}\">{name}</text>",
            x + 23.0,
            y + 4.0
        );
        x += entry_width(name);
    }
    svg + "</svg>\n"
}

/// Width of a name in the legend with its stroke and the gap behind it, px.
fn entry_width(name: &str) -> f64 {
    43.0 + 6.5 * name.chars().count() as f64
}

impl Panel {
    fn drawn(&self, (x0, y0): (f64, f64), (width, height): (f64, f64), names: &[&str]) -> String {
        let points = || self.lines.iter().flat_map(|line| line.pieces.iter().flatten());
        let mut across = Range::of(points().map(|point| point.0));
        let mut up = Range::of(points().map(|point| point.1));
        if self.is_path {
            let scale = f64::max(across.extent() / width, up.extent() / height);
            across.widen(scale * width);
            up.widen(scale * height);
        } else {
            up.widen(1.08 * up.extent());
        }
        let at = |(x, y): (f64, f64)| (x0 + across.share(x) * width, y0 + (1.0 - up.share(y)) * height);
        let mut svg =
            format!("<text x=\"{:.0}\" y=\"{:.0}\" text-anchor=\"middle\">{}</text>\n", x0 + 0.5 * width, y0 - 8.0, self.title);
        for tick in across.ticks() {
            let (x, y) = (at((tick, 0.0)).0, y0 + height);
            let _ = writeln!(
                svg,
                "<path d=\"M{x:.1} {y0:.0}V{y:.0}\" stroke=\"#e4e4e4\"/><text x=\"{x:.1}\" y=\"{:.0}\" text-anchor=\"middle\">{}</text>",
                y + 14.0,
                label(tick)
            );
        }
        for tick in up.ticks() {
            let y = at((0.0, tick)).1;
            let _ = writeln!(
                svg,
                "<path d=\"M{x0:.0} {y:.1}h{width:.0}\" stroke=\"#e4e4e4\"/><text x=\"{:.0}\" y=\"{:.1}\" text-anchor=\"end\">{}</text>",
                x0 - 5.0,
                y + 4.0,
                label(tick)
            );
        }
        let (middle, foot) = (x0 + 0.5 * width, y0 + height + 28.0);
        let (side, centre) = (x0 - 38.0, y0 + 0.5 * height);
        let _ = writeln!(
            svg,
            "<text x=\"{middle:.0}\" y=\"{foot:.0}\" text-anchor=\"middle\">{}</text>\
             <text transform=\"translate({side:.0} {centre:.0})rotate(-90)\" text-anchor=\"middle\">{}</text>\n\
             <rect x=\"{x0:.0}\" y=\"{y0:.0}\" width=\"{width:.0}\" height=\"{height:.0}\" fill=\"none\" stroke=\"#888\"/>",
            self.axes.0, self.axes.1
        );
        for line in &self.lines {
            let index = names.iter().position(|name| *name == line.name).unwrap_or_default();
            for piece in &line.pieces {
                let points = spaced(piece.iter().map(|point| at(*point)), if self.is_path { APART } else { 0.0 });
                let _ = writeln!(
                    svg,
                    "<polyline fill=\"none\" stroke=\"{}\" stroke-width=\"1\" points=\"{}\"/>",
                    COLOURS[index % COLOURS.len()],
                    points.iter().map(|(x, y)| format!("{x:.1},{y:.1}")).collect::<Vec<_>>().join(" ")
                );
            }
        }
        svg
    }
}

/// Points at least this far apart; the last one stays.
fn spaced(points: impl Iterator<Item = (f64, f64)>, apart: f64) -> Vec<(f64, f64)> {
    let mut kept: Vec<(f64, f64)> = Vec::new();
    let mut skipped = None;
    for point in points {
        if kept.last().is_none_or(|last| (point.0 - last.0).hypot(point.1 - last.1) >= apart) {
            kept.push(point);
            skipped = None;
        } else {
            skipped = Some(point);
        }
    }
    kept.extend(skipped);
    kept
}

/// Values that an axis shows.
#[derive(Debug, Clone, Copy)]
struct Range {
    low: f64,
    high: f64,
}

impl Range {
    fn of(values: impl Iterator<Item = f64>) -> Self {
        let (low, high) = values
            .filter(|value| value.is_finite())
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)));
        if high > low {
            Self { low, high }
        } else {
            let middle = if low.is_finite() { low } else { 0.0 };
            Self { low: middle - 0.5, high: middle + 0.5 }
        }
    }

    fn extent(self) -> f64 {
        self.high - self.low
    }

    /// Widens the range to this extent about its middle.
    fn widen(&mut self, extent: f64) {
        let more = 0.5 * (extent - self.extent());
        (self.low, self.high) = (self.low - more, self.high + more);
    }

    fn share(self, value: f64) -> f64 {
        (value - self.low) / self.extent()
    }

    /// Round numbers in the range, three to seven of them.
    fn ticks(self) -> Vec<f64> {
        let rough = self.extent() / 4.0;
        let power = 10.0_f64.powf(rough.log10().floor());
        let step = [1.0, 2.0, 5.0, 10.0].into_iter().map(|digit| digit * power).find(|step| *step >= rough).unwrap_or(power);
        let first = (self.low / step).ceil() as i64;
        (first..).map(|k| k as f64 * step).take_while(|tick| *tick <= self.high + 1e-9 * step).collect()
    }
}

/// A tick's number, without the rest that binary fractions leave.
fn label(tick: f64) -> String {
    format!("{}", (tick * 1e6).round() / 1e6 + 0.0).replace('-', "−")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn panel(is_path: bool, lines: Vec<Line>) -> Panel {
        Panel { title: "a".into(), axes: ("x, mm", "y, mm"), is_path, lines }
    }

    /// Coordinates of the polylines of a picture.
    fn polylines(svg: &str) -> Vec<Vec<(f64, f64)>> {
        let of = |text: &str| -> Vec<(f64, f64)> {
            let pairs = text.split('"').next().unwrap().split(' ').filter_map(|pair| pair.split_once(','));
            pairs.map(|(x, y)| (x.parse().unwrap(), y.parse().unwrap())).collect()
        };
        svg.split("points=\"").skip(1).map(of).collect()
    }

    #[test]
    fn a_peak_of_one_sample_stays_among_many() {
        let mut values = vec![0.0; 20_000];
        values[7777] = 3.0;
        let line = Line::over_time("error", 0.002, &values);
        assert!(line.pieces[0].len() <= 2 * SPANS + 2);
        assert!(line.pieces[0].contains(&(7777.0 * 0.002, 3.0)));
        let svg = draw(1, &[panel(false, vec![line])]);
        let drawn = &polylines(&svg)[0];
        let top = drawn.iter().map(|point| point.1).fold(f64::INFINITY, f64::min);
        assert!(top > MARGIN[1] && top < MARGIN[1] + 0.1 * PANEL.1, "{top}");
        assert!(svg.len() < 6000, "{}", svg.len());
    }

    #[test]
    fn a_path_keeps_its_proportions_inside_its_panel() {
        let corners = vec![(0.0, 0.0), (40.0, 0.0), (40.0, 10.0), (0.0, 10.0)];
        let svg = draw(1, &[panel(true, vec![Line { name: "desired", pieces: vec![corners] }])]);
        let drawn = &polylines(&svg)[0];
        let (width, height) = (drawn[1].0 - drawn[0].0, drawn[1].1 - drawn[2].1);
        assert!((width / height - 4.0).abs() < 0.02, "{drawn:?}");
        assert!(drawn.iter().all(|(x, y)| *x >= MARGIN[0] && *y >= MARGIN[1] && *y <= MARGIN[1] + PATH.1));
    }

    #[test]
    fn lines_of_one_name_have_one_colour_and_one_entry_in_the_legend() {
        let line = |name| Line { name, pieces: vec![vec![(0.0, 0.0), (1.0, 1.0)]] };
        let svg = draw(2, &[panel(false, vec![line("measured"), line("predicted")]), panel(false, vec![line("predicted")])]);
        assert_eq!(svg.matches(">predicted</text>").count(), 1);
        assert_eq!(svg.matches(COLOURS[1]).count(), 3);
    }

    #[test]
    fn ticks_are_round_and_few() {
        for (low, high) in [(0.0, 1.0), (-3.7, 11.2), (0.001, 0.0042), (-120.0, 5.0)] {
            let ticks = Range { low, high }.ticks();
            assert!((2..=7).contains(&ticks.len()) && ticks.iter().all(|tick| (low..=high + 1e-9).contains(tick)), "{ticks:?}");
        }
        assert_eq!([0.1 + 0.2, -0.5, -1e-12].map(label), ["0.3", "−0.5", "0"]);
    }
}
