//! Whether a written path follows the original one from its start to its end.

use crate::events::{Point, distance};

/// Distance from a point to a segment, and the length along the segment to the nearest point.
fn project(point: &Point, a: &Point, b: &Point) -> (f64, f64) {
    let chord: Point = std::array::from_fn(|k| b[k] - a[k]);
    let squared: f64 = chord.iter().map(|c| c * c).sum();
    let along: f64 = (0..6).map(|k| (point[k] - a[k]) * chord[k]).sum();
    let share = if squared > 0.0 { (along / squared).clamp(0.0, 1.0) } else { 0.0 };
    let nearest: Point = std::array::from_fn(|k| a[k] + chord[k] * share);
    (distance(point, &nearest), share * squared.sqrt())
}

/// Follows `original` with the points of `written` and the centres between them. Each lies within `off_mm` of the original path, not before
/// the point before it, and no further along than the written path has come; both but for `slack`, mm. Returns the first fault.
pub fn follow(original: &[Point], written: &[Point], off_mm: f64, slack: f64) -> Option<String> {
    if original.is_empty() || written.is_empty() {
        return (original.is_empty() != written.is_empty()).then(|| "feeds are missing or added".to_owned());
    }
    let mut lengths = vec![0.0];
    for pair in original.windows(2) {
        lengths.push(lengths.last().unwrap_or(&0.0) + distance(&pair[0], &pair[1]));
    }
    let total = lengths.last().copied().unwrap_or(0.0);
    let centre = |a: &Point, b: &Point| std::array::from_fn(|k| 0.5 * (a[k] + b[k]));
    let mut points = vec![written[0]];
    points.extend(written.windows(2).flat_map(|pair| [centre(&pair[0], &pair[1]), pair[1]]));
    // Where two parts of the path are close to each other a point may belong to either: all places are kept.
    let (mut reached, mut before) = (vec![0.0_f64], points[0]);
    for point in &points {
        let step = distance(point, &before) * 1.01;
        let (low, high) = (reached[0] - slack, reached[reached.len() - 1] + step + slack);
        let from = lengths.partition_point(|length| *length < low).saturating_sub(1);
        let candidates = (from..original.len().saturating_sub(1)).take_while(|k| lengths[*k] <= high);
        let projected = candidates.map(|k| {
            let (off, along) = project(point, &original[k], &original[k + 1]);
            (off, lengths[k] + along)
        });
        let follows = |at: f64| reached.iter().any(|before| (before - slack..=before + step + slack).contains(&at));
        let mut next: Vec<f64> = projected.filter(|(off, at)| *off <= off_mm && follows(*at)).map(|(_, at)| at).collect();
        next.sort_by(f64::total_cmp);
        next.dedup();
        if next.is_empty() {
            let at = reached[reached.len() - 1];
            return Some(format!(
                "the point {point:.4?} lies beyond {off_mm:.4} mm of the original path at {at:.3} of {total:.3} mm"
            ));
        }
        (reached, before) = (next, *point);
    }
    let gap = total - reached[reached.len() - 1];
    (gap > slack).then(|| format!("the written path ends {gap:.4} mm before the original one"))
}
