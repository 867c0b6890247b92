//! Paper A, figures 13 to 16: how learning moves the reference, and with it the path of the machine. Deviations are magnified.

use anyhow::Result;
use motion::Vec3;
use pipeline::control::ProgramRun;
use pipeline::part::Part;
use pipeline::statistics::{contour_errors_along, counts};

use super::picture::{Line, Panel, Picture, draw};

/// Half the width of the enlarged bend, mm.
const ENLARGED_MM: f64 = 2.0;
/// Largest deviation in the drawing of the whole path and in that of a bend, as a share of its width.
const LARGEST: [f64; 2] = [0.05, 0.12];

const DESIRED: &str = "desired";
const REFERENCE: &str = "reference";
const BEFORE: &str = "actual, run before";
const ACTUAL: &str = "actual";

/// A path beside the desired one: foot point of every sample, and the way from there to the sample; mm.
type Beside = Vec<(Vec3, Vec3)>;

/// The path as a whole after the first update, and the bend where the first run errs most after the first and the last update.
pub(super) fn picture(file: &'static str, figures: &str, part: &Part, runs: &[ProgramRun]) -> Result<Picture> {
    let [first, second, ..] = runs else { anyhow::bail!("one run has no update") };
    let last = &runs[runs.len() - 1];
    let before_last = &runs[runs.len() - 2];
    let worst = beside(part, first, false)?.into_iter().max_by(|a, b| a.1.norm().total_cmp(&b.1.norm()));
    let Some((bend, _)) = worst else { anyhow::bail!("a run without samples has no bend") };
    let panels = [
        panel("first update", part, (first, second), None)?,
        panel("bend, first update", part, (first, second), Some(bend))?,
        panel(&format!("bend, update {}", runs.len() - 1), part, (before_last, last), Some(bend))?,
    ];
    Ok(Picture {
        file,
        caption: format!(
            "Figures {figures}: {}, the reference that an update makes of the run before, and the run with it; deviations magnified as stated",
            part.name
        ),
        svg: draw(3, &panels),
    })
}

/// One update: the run `before` it and the run `after` it, in a window around `centre` where there is one.
fn panel(title: &str, part: &Part, (before, after): (&ProgramRun, &ProgramRun), centre: Option<Vec3>) -> Result<Panel> {
    let is_in = |foot: &Vec3| centre.is_none_or(|centre| (foot - centre).amax() <= ENLARGED_MM);
    let paths =
        [(BEFORE, beside(part, before, false)?), (REFERENCE, beside(part, after, true)?), (ACTUAL, beside(part, after, false)?)];
    let shown = || paths.iter().flat_map(|(_, path)| path).filter(|(foot, _)| is_in(foot));
    let largest = shown().map(|(_, way)| way.norm()).fold(f64::MIN_POSITIVE, f64::max);
    let (low, high) = shown().fold((Vec3::repeat(f64::INFINITY), Vec3::repeat(f64::NEG_INFINITY)), |(low, high), (foot, _)| {
        (low.inf(foot), high.sup(foot))
    });
    let magnified = round(LARGEST[usize::from(centre.is_some())] * (high - low).amax() / largest);
    let line = |name, path: &Beside, factor: f64| {
        let pieces = path.chunk_by(|a, b| is_in(&a.0) == is_in(&b.0)).filter(|piece| is_in(&piece[0].0));
        let at = |(foot, way): &(Vec3, Vec3)| (foot.x + factor * way.x, foot.y + factor * way.y);
        Line { name, pieces: pieces.map(|piece| piece.iter().map(at).collect()).collect() }
    };
    let desired = line(DESIRED, &paths[1].1, 0.0);
    let lines = std::iter::once(desired).chain(paths.iter().map(|(name, path)| line(*name, path, magnified))).collect();
    Ok(Panel { title: format!("{title}, × {magnified}"), axes: ("x, mm", "y, mm"), is_path: true, lines })
}

/// Command or actual positions of a run beside the desired path, over its feed moves.
fn beside(part: &Part, run: &ProgramRun, is_command: bool) -> Result<Beside> {
    let desired = &part.plan.desired;
    let path = if is_command { &run.run.command } else { &run.run.actual };
    let (errors, positions) = contour_errors_along(desired, &run.run.command, path)?;
    let feeds = positions.iter().map(|position| counts(Some(part), position.round() as usize));
    Ok(errors.iter().zip(feeds).filter(|(_, feeds)| *feeds).map(|(error, _)| (error.foot, error.vector)).collect())
}

/// The largest of 1, 2, 5, 10, … that is not above a positive value.
fn round(value: f64) -> f64 {
    let power = 10.0_f64.powf(value.log10().floor());
    [5.0, 2.0, 1.0].into_iter().map(|digit| digit * power).find(|round| *round <= value).unwrap_or(power)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn magnifications_are_round() {
        assert_eq!([1.0, 1.9, 37.0, 99.0, 4321.0].map(round), [1.0, 1.0, 20.0, 50.0, 2000.0]);
    }
}
