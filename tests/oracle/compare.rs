//! Comparison of the canonical calls of a program before and after compensation.

use crate::events::{Event, Point, distance};
use crate::follow::follow;

/// Printed digits of a canonical coordinate, program units.
const DIGIT: f64 = 1e-4;
/// G64 without a tolerance, which `rs274` also states around canned cycles.
const UNBOUNDED: &str = "CANON_CONTINUOUS, 0.000 mm";
const CONTINUOUS: &str = "CANON_CONTINUOUS";
/// Call of G5, G5.1 and G5.2.
const SPLINE: &str = "NURBS_FEED";
/// Length that a rounded corner loses, at most, for each unit of its tolerance: corners down to 5°.
const CUT: f64 = 25.0;
/// Distance of a chord of an arc from it, mm: chords of the oracle's arcs, and of written lines.
const CHORD_MM: f64 = 1.5e-3;

/// What a compensated program may change.
pub struct Allowed<'a> {
    /// Largest distance of a written point from the original path, mm.
    pub off_mm: f64,
    /// Least time between points within a move, s.
    pub spacing_s: f64,
    /// That part of `off_mm` which is the control's own rounding of corners. A sharp corner is cut by more of its length.
    pub corner_mm: f64,
    /// Whether the moves of the block with this N word may be shifted.
    pub shiftable: &'a dyn Fn(u32) -> bool,
    /// Whether rewritten feeds keep the feeds of the program.
    pub keeps_feeds: bool,
}

/// Compares two runs.
///
/// Calls other than feeds are the same, in the same order, between the same feeds. Feeds that may not be shifted are the same from the same
/// start, at the same feed and in the same path mode. The other feeds follow the original path.
///
/// Remarks have no effect and may move with the block that they stand in. Differences by design, which are no calls here: feed modes, feeds and path modes of compensated segments. They count where a feed is
/// unshifted. A path mode that the program does not state is not restored behind a segment, since it is not known: a segment rounds less.
pub fn compare(before: &[Event], after: &[Event], allowed: &Allowed) -> Result<(), String> {
    let (groups, others) = (split(before), split(after));
    for (index, (group, other)) in groups.iter().zip(&others).enumerate() {
        let fault = feeds_fault(group, other, allowed).or_else(|| match (group.end, other.end) {
            (Some(call), Some(same)) => call_fault(call, same, allowed),
            (None, None) => None,
            _ => Some("one of the programs has fewer calls".to_owned()),
        });
        if let Some(fault) = fault {
            let end = group.end.map_or("the end".to_owned(), shown);
            return Err(format!(
                "{fault}\n  in the feeds number {index}, before {end}, instead {}",
                other.end.map_or(String::new(), shown)
            ));
        }
    }
    if groups.len() == others.len() { Ok(()) } else { Err(format!("{} calls became {}", groups.len(), others.len())) }
}

/// Feeds between two other calls.
struct Group<'a> {
    feeds: &'a [Event],
    end: Option<&'a Event>,
    /// Whether a spline stands before them. Its call does not say where it ends.
    is_after_spline: bool,
}

impl Group<'_> {
    /// The feeds from this one on.
    fn from(&self, first: usize) -> Self {
        Self { feeds: &self.feeds[first..], is_after_spline: false, ..*self }
    }
}

fn split(events: &[Event]) -> Vec<Group<'_>> {
    let mut groups: Vec<Group> = Vec::new();
    let mut from = 0;
    let after_spline = |groups: &[Group]| groups.last().and_then(|last| last.end).is_some_and(|end| end.call.name == SPLINE);
    for (at, event) in events.iter().enumerate() {
        if event.path.is_empty() {
            let is_after_spline = after_spline(&groups);
            groups.push(Group { feeds: &events[from..at], end: Some(event), is_after_spline });
            from = at + 1;
        }
    }
    let is_after_spline = after_spline(&groups);
    groups.push(Group { feeds: &events[from..], end: None, is_after_spline });
    groups
}

fn shown(event: &Event) -> String {
    let line = event.call.line.map_or("N…".to_owned(), |line| format!("N{line}"));
    format!("{line} {}({}) from {:.4?} {:?}", event.call.name, event.call.text, event.start, event.modes)
}

/// Rounding of positions in two runs, mm.
fn rounding_mm(event: &Event) -> f64 {
    2.5 * DIGIT * event.unit_mm
}

/// Whether two calls have the same arguments, up to the last printed digit.
fn alike(a: &Event, b: &Event) -> bool {
    let numbers = a.call.numbers.iter().zip(&b.call.numbers).all(|(a, b)| (a - b).abs() < 1.5 * DIGIT);
    let words = |event: &Event| event.call.text.chars().filter(|c| !"-0123456789.".contains(*c)).collect::<String>();
    a.call.name == b.call.name && a.call.numbers.len() == b.call.numbers.len() && numbers && words(a) == words(b)
}

fn call_fault(before: &Event, after: &Event, allowed: &Allowed) -> Option<String> {
    if !alike(before, after) || before.call.line != after.call.line {
        return Some("another call".to_owned());
    }
    let moves = before.call.numbers.len() >= 6 && before.call.name.starts_with("STRAIGHT");
    let off = distance(&before.start, &after.start);
    if moves && off > rounding_mm(before) {
        return Some(format!("a move that does not feed starts {off:.4} mm off its start"));
    }
    (off > allowed.off_mm + rounding_mm(before)).then(|| format!("a call is made {off:.4} mm from its position"))
}

/// Whether `after` is the feed `before`, unshifted.
fn is_same(before: &Event, after: &Event) -> bool {
    alike(before, after) && distance(&before.start, &after.start) <= rounding_mm(before)
}

/// Compares the feeds between two calls. The first one after a spline comes from a point that no call states: its end alone is compared.
fn feeds_fault(before: &Group, after: &Group, allowed: &Allowed) -> Option<String> {
    let Some(first) = before.feeds.first().filter(|_| before.is_after_spline) else { return group_fault(before, after, allowed) };
    let off_mm = allowed.off_mm + rounding_mm(first);
    let ends_there = |feed: &Event| first.path.last().zip(feed.path.last()).is_some_and(|(a, b)| distance(a, b) <= off_mm);
    let Some(last) = after.feeds.iter().position(ends_there) else {
        return Some(format!("no feed after the spline ends like {}", shown(first)));
    };
    // The last lines of a written segment are shorter than its shift.
    let more = after.feeds[last..].iter().take_while(|feed| ends_there(feed)).count();
    group_fault(&before.from(1), &after.from(last + more), allowed)
}

fn group_fault(before: &Group, after: &Group, allowed: &Allowed) -> Option<String> {
    let fixed = |event: &&Event| event.call.line.is_some_and(|line| !(allowed.shiftable)(line));
    let mut written = after.feeds.iter();
    for feed in before.feeds.iter().filter(fixed) {
        let Some(same) = written.find(|other| is_same(feed, other)) else {
            return Some(format!("a feed that must not change is not in the output: {}", shown(feed)));
        };
        if let Some(fault) = mode_fault(feed, same) {
            return Some(fault);
        }
    }
    let points = |group: &Group| -> Vec<Point> { group.feeds.iter().flat_map(|feed| feed.path.iter().copied()).collect() };
    let chords_mm = before.feeds.iter().map(|feed| sagitta_mm(feed, allowed.spacing_s)).fold(0.0, f64::max);
    let off_mm = allowed.off_mm + CHORD_MM + chords_mm + before.feeds.iter().map(rounding_mm).fold(0.0, f64::max);
    let corners: Vec<Point> = before.feeds.iter().filter_map(|feed| feed.path.last().copied()).collect();
    let ends: Vec<Point> = after.feeds.iter().filter_map(|feed| feed.path.last().copied()).collect();
    follow(&points(before), &points(after), off_mm, 4.0 * off_mm + CUT * allowed.corner_mm)
        .or_else(|| missing_corner(&corners, &ends, off_mm))
        .or_else(|| if allowed.keeps_feeds { time_fault(before, after) } else { None })
}

/// Largest distance of the written chords of an arc from it, mm. Controls that starve on dense points get them at a least spacing in time.
fn sagitta_mm(feed: &Event, spacing_s: f64) -> f64 {
    let length = length_mm(feed);
    let steps = (length / (feed.modes.rate / 60.0 * spacing_s)).floor().max(1.0);
    if feed.radius_mm > 0.0 { (length / steps).powi(2) / (8.0 * feed.radius_mm) } else { 0.0 }
}

fn length_mm(feed: &Event) -> f64 {
    feed.path.windows(2).map(|pair| distance(&pair[0], &pair[1])).sum()
}

/// Every end of an original feed is the end of a written one, in the same order.
fn missing_corner(corners: &[Point], ends: &[Point], off_mm: f64) -> Option<String> {
    let mut from = 0;
    let mut is_missing = |corner: &&Point| match ends[from..].iter().position(|end| distance(corner, end) <= off_mm) {
        Some(at) => {
            from += at;
            false
        }
        None => true,
    };
    let missing = corners.iter().find(|corner| is_missing(corner))?;
    Some(format!("no written line ends at {missing:.4?}"))
}

fn mode_fault(before: &Event, after: &Event) -> Option<String> {
    let (a, b) = (&before.modes, &after.modes);
    let rates = (a.rate - b.rate).abs() <= 1e-3 * a.rate.abs() + 1e-2 && a.feed == b.feed;
    let paths = a.path.is_empty() || a.path == b.path || a.path == UNBOUNDED && b.path.starts_with(CONTINUOUS);
    (!(rates && paths)).then(|| format!("an unshifted feed runs in other modes: {} became {b:?}", shown(before)))
}

/// Program time of the feeds, min: with the same feeds it changes by the shifts alone.
fn time_fault(before: &Group, after: &Group) -> Option<String> {
    let minutes = |group: &Group| -> f64 { group.feeds.iter().map(|feed| length_mm(feed) / feed.modes.rate.max(1e-6)).sum() };
    let (a, b) = (minutes(before), minutes(after));
    ((a - b).abs() > 0.03 * a + 1e-4).then(|| format!("feeds of {a:.5} min became {b:.5} min"))
}
