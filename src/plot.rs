//! The contour error in the terminal: along the path, and how often an error of a size occurs.

use clap::Args;
use console::{Style, Term};
use pipeline::units::um;
use textplots::{Chart, LabelBuilder, LabelFormat, Plot, Shape};

use crate::output::Printer;
use crate::report::{Run, Track};

/// Whether the errors are drawn in the terminal.
#[derive(Debug, Clone, Args)]
pub struct PlotArgs {
    /// Draw the contour error along the path and its histogram in the terminal
    #[arg(long)]
    pub plot: bool,
}

/// Width where there is no terminal and COLUMNS is not set, and the narrowest one that is drawn for.
const USUAL_COLUMNS: usize = 80;
const LEAST_COLUMNS: usize = 40;
/// Characters beside a drawing for the label of its ordinate, and beside the bars of a histogram.
const LABEL: usize = 12;
const BESIDE_BARS: usize = 28;
/// Height of a drawing, characters; a Braille character is two dots wide and four high.
const ROWS: u32 = 10;
const DOTS: (u32, u32) = (2, 4);
/// Bars of a histogram.
const BARS: usize = 8;

impl PlotArgs {
    /// Draws runs of a path, all to one scale, as wide as the terminal. Colours as `NO_COLOR` and `CLICOLOR` say.
    pub fn show(&self, printer: &Printer, track: &Track<'_>, runs: &[Run]) {
        if self.plot {
            drawings(track, runs, columns()).iter().for_each(|drawing| printer.line(drawing));
        }
    }
}

/// Columns of the terminal, or those that COLUMNS states.
fn columns() -> usize {
    let of_terminal = Term::stdout().size_checked().map(|(_, columns)| usize::from(columns));
    let stated = || std::env::var("COLUMNS").ok().and_then(|columns| columns.parse().ok());
    of_terminal.or_else(stated).unwrap_or(USUAL_COLUMNS).max(LEAST_COLUMNS)
}

/// The drawings of every run.
fn drawings(track: &Track<'_>, runs: &[Run], columns: usize) -> Vec<String> {
    let way_mm = way_mm(track);
    let errors: Vec<Vec<f64>> = runs.iter().map(|run| run.contour_um(track)).collect();
    let top_um = errors.iter().flatten().copied().filter(|um| um.is_finite()).fold(0.0, f64::max);
    if top_um <= 0.0 {
        return Vec::new();
    }
    let styles = [Style::new().yellow(), Style::new().cyan()];
    let of_run = |(index, (run, errors)): (usize, (&Run, &Vec<f64>))| {
        let style = &styles[index % styles.len()];
        let title =
            |what: &str| format!("{what}, {}: {} µm RMS, {} µm MAX", run.name, um(run.figures.rms_mm), um(run.figures.max_mm));
        let along = style.apply_to(along(&way_mm, errors, top_um, columns)).to_string();
        let bars = style.apply_to(histogram(errors, top_um, columns)).to_string();
        [title("contour error along the path"), along, "share of the samples by contour error".to_owned(), bars]
    };
    runs.iter().zip(&errors).enumerate().flat_map(of_run).collect()
}

/// Length of the path up to every sample, mm.
fn way_mm(track: &Track<'_>) -> Vec<f64> {
    let tips = track.tips();
    let steps = tips.windows(2).map(|pair| (pair[1] - pair[0]).norm());
    std::iter::once(0.0)
        .chain(steps.scan(0.0, |sum, step| {
            *sum += step;
            Some(*sum)
        }))
        .collect()
}

/// The largest error in each column of dots, as a filled area; nothing where no sample counts.
fn along(way_mm: &[f64], errors_um: &[f64], top_um: f64, columns: usize) -> String {
    let end_mm = way_mm.last().copied().unwrap_or(0.0).max(f64::MIN_POSITIVE);
    let dots = (columns - LABEL) as u32 * DOTS.0;
    let mut largest = vec![None::<f64>; dots as usize];
    for (way, error) in way_mm.iter().zip(errors_um).filter(|(_, error)| error.is_finite()) {
        let column = ((way / end_mm * f64::from(dots)) as usize).min(largest.len() - 1);
        largest[column] = Some(largest[column].map_or(*error, |known| known.max(*error)));
    }
    let place = |column: usize| ((column as f64 + 0.5) / f64::from(dots) * end_mm) as f32;
    let columns = largest.iter().enumerate().filter_map(|(column, um)| um.map(|um| (place(column), um as f32)));
    let points: Vec<(f32, f32)> = columns.flat_map(|(x, um)| [(x, 0.0), (x, um), (x, 0.0)]).collect();
    let shape = Shape::Lines(&points);
    let mut chart = Chart::new_with_y_range(dots, ROWS * DOTS.1, 0.0, end_mm as f32, 0.0, top_um as f32);
    let chart = chart
        .lineplot(&shape)
        .x_label_format(LabelFormat::Custom(Box::new(|mm| format!("{mm:.1} mm"))))
        .y_label_format(LabelFormat::Custom(Box::new(|um| format!("{um:.2} µm"))));
    chart.axis();
    chart.figures();
    chart.to_string().trim_end().to_owned()
}

/// Share of the samples in equal bins up to the largest error of all runs.
fn histogram(errors_um: &[f64], top_um: f64, columns: usize) -> String {
    let mut counts = [0_usize; BARS];
    let finite: Vec<f64> = errors_um.iter().copied().filter(|um| um.is_finite()).collect();
    for um in &finite {
        counts[((um / top_um * BARS as f64) as usize).min(BARS - 1)] += 1;
    }
    let most = counts.iter().copied().max().unwrap_or(0).max(1);
    let row = |(bin, count): (usize, &usize)| {
        let edge = |bin: usize| top_um * bin as f64 / BARS as f64;
        let range = format!("{:.2} to {:.2} µm", edge(bin), edge(bin + 1));
        let share = 100.0 * *count as f64 / finite.len().max(1) as f64;
        format!("{range:>18} {} {share:.1} %", bar(*count as f64 / most as f64, columns - BESIDE_BARS))
    };
    counts.iter().enumerate().map(row).collect::<Vec<_>>().join("\n")
}

/// A bar of a share of `columns`, to an eighth of a character.
fn bar(share: f64, columns: usize) -> String {
    const EIGHTHS: [&str; 8] = ["", "▏", "▎", "▍", "▌", "▋", "▊", "▉"];
    let eighths = (share * 8.0 * columns as f64).round() as usize;
    format!("{}{}", "█".repeat(eighths / 8), EIGHTHS[eighths % 8])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn width(text: &str) -> usize {
        text.lines().map(|line| line.chars().count()).max().unwrap_or(0)
    }

    #[test]
    fn drawings_fit_the_terminal_and_keep_peaks() {
        let way: Vec<f64> = (0..5000).map(|k| 0.1 * f64::from(k)).collect();
        // One sample in five thousand stands out; a fifth does not count.
        let errors: Vec<f64> = (0..5000)
            .map(|k| {
                if k == 3333 {
                    4.0
                } else if (1000..2000).contains(&k) {
                    f64::NAN
                } else {
                    0.5
                }
            })
            .collect();
        for columns in [LEAST_COLUMNS, 80, 200] {
            let drawn = along(&way, &errors, 4.0, columns);
            assert!(width(&drawn) <= columns, "{columns}: {}", width(&drawn));
            let rows: Vec<&str> = drawn.lines().collect();
            let dotted = |row: &str| row.chars().filter(|c| ('\u{2801}'..='\u{28ff}').contains(c)).count();
            // The peak alone reaches the upper rows, beside the axis.
            assert_eq!(rows.len(), ROWS as usize + 2);
            assert_eq!(dotted(rows[2]), 2, "{drawn}");
            assert!(drawn.contains("4.00 µm") && drawn.contains("499.9 mm"), "{drawn}");
            // In the middle of what does not count: three tenths of the way.
            let middle = (columns - LABEL) * 3 / 10;
            let gap = rows[ROWS as usize - 1].chars().skip(middle).take(2).all(|c| c == '\u{2800}');
            assert!(gap, "{drawn}");
            let bars = histogram(&errors, 4.0, columns);
            assert!(width(&bars) <= columns && bars.lines().count() == BARS, "{bars}");
            assert!(bars.lines().nth(1).unwrap().ends_with(" 100.0 %") && bars.contains('█'), "{bars}");
        }
    }
}
