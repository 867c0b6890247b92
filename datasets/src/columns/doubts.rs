//! Columns whose names say one thing and whose values or neighbours another.

use super::meaning::{Meaning, Role};
use super::names::role_of;
use super::unit::Unit;
use crate::Table;

/// Letters that name axes, and speeds or voltages as well.
const NO_AXES: [&str; 3] = ["u", "v", "w"];
/// What else is named as positions are, commanded and actual: positions of an axis without a name, currents, angles.
const ELSE: [&str; 9] = ["pos", "position", "p", "s", "i", "q", "theta", "phi", "angle"];

/// Pairs of columns that are named as axes, and may be speeds or voltages.
pub(super) struct Doubtful<'a> {
    table: &'a Table,
    meanings: &'a [Option<Meaning>],
    /// Columns of something that is no axis, beside which those pairs are doubtful.
    others: Vec<usize>,
    left_out: Vec<[usize; 2]>,
}

impl<'a> Doubtful<'a> {
    pub fn of(table: &'a Table, meanings: &'a [Option<Meaning>]) -> Self {
        Self { table, meanings, others: others(table, meanings), left_out: Vec::new() }
    }

    /// Whether the columns of an axis without a unit, command and actual position, are left out.
    pub fn leaves_out(&mut self, axis: &str, sides: [usize; 2]) -> bool {
        let is_doubtful = NO_AXES.contains(&axis) && (!self.others.is_empty() || is_speed(self.table, self.meanings, sides[0]));
        if is_doubtful {
            self.left_out.push(sides);
        }
        is_doubtful
    }

    /// Which columns are left out, and why.
    pub fn why(&self) -> Option<String> {
        let named = |columns: &[usize], between: &str| {
            columns.iter().map(|column| format!("`{}`", self.table.names[*column])).collect::<Vec<_>>().join(between)
        };
        let pairs: Vec<String> = self.left_out.iter().map(|pair| named(pair, " and ")).collect();
        let why = if self.others.is_empty() {
            "their values are the speed of another axis".to_owned()
        } else {
            format!("beside {}", named(&self.others, ", "))
        };
        (!pairs.is_empty()).then(|| format!("{} may be speeds or voltages ({why})", pairs.join(", ")))
    }
}

/// Columns whose names say that they are commanded or actual values of something that is no axis: `pos_cmd`, `i_act`, `Soll`.
fn others(table: &Table, meanings: &[Option<Meaning>]) -> Vec<usize> {
    let is_other = |name: &str| {
        let words = name.split(|sign: char| !sign.is_alphanumeric()).filter(|word| !word.is_empty());
        let words: Vec<String> = words.map(str::to_lowercase).collect();
        let (sides, rest): (Vec<&String>, Vec<&String>) = words.iter().partition(|word| role_of(word).is_some());
        !sides.is_empty() && rest.iter().all(|word| ELSE.contains(&word.as_str()) || Unit::named(word).is_some())
    };
    (0..table.names.len()).filter(|column| meanings[*column].is_none() && is_other(&table.names[*column])).collect()
}

/// Share of the variance of a column that the steps of another explain, from which on it is that one's speed.
const SPEED_SHARE: f64 = 0.98;

/// Whether the first values of a column are the speed of another axis, but for a factor.
fn is_speed(table: &Table, meanings: &[Option<Meaning>], column: usize) -> bool {
    let head = |column: usize| table.columns.get(column).map_or(&[][..], |values| &values[..values.len().min(SPEED_ROWS)]);
    let speeds = head(column);
    let is_command = |(_, meaning): &(usize, &Option<Meaning>)| {
        meaning.as_ref().is_some_and(|meaning| meaning.role == Role::Reference && !NO_AXES.contains(&meaning.axis.as_str()))
    };
    meanings.iter().enumerate().filter(is_command).any(|(other, _)| {
        let (mut both, mut own, mut of_other) = (0.0, 0.0, 0.0);
        for (step, speed) in head(other).windows(2).zip(speeds.windows(2)) {
            let (step, speed) = (step[1] - step[0], f64::midpoint(speed[0], speed[1]));
            both += step * speed;
            own += speed * speed;
            of_other += step * step;
        }
        both * both > SPEED_SHARE * own * of_other && own > 0.0
    })
}

/// Rows at the beginning of a log that show what its columns are.
const SPEED_ROWS: usize = 20_000;

/// Turns of an axis beyond which its angles may be degrees.
const MANY_TURNS: f64 = 1.0;

/// What to say of angles that count as radians by their names, and are many turns then.
pub(super) fn many_turns(axis: &str, angles: &[f64]) -> Option<String> {
    let (low, high) = angles.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), at| (low.min(*at), high.max(*at)));
    (high - low > MANY_TURNS * std::f64::consts::TAU).then(|| {
        let degrees = (high - low).to_degrees();
        format!("the angles of {axis} count as rad, {degrees:.0}° of travel; where they are degrees, map `{axis}:deg`")
    })
}

/// Whether the name of a column of time may be another's: with a number, as of temperatures `T1`, a unit alone, or `Ts`, a sampling time.
pub(super) fn is_perhaps_time(name: &str) -> bool {
    name.ends_with(|sign: char| sign.is_ascii_digit()) || name.eq_ignore_ascii_case("ts") || Unit::named(name).is_some()
}

/// Number of values that show it.
const RISING_ROWS: usize = 1000;

/// Whether the first of some values rise, as time stamps do.
pub(super) fn rises(values: &[f64]) -> bool {
    let steps = values[..values.len().min(RISING_ROWS)].windows(2).filter(|pair| !(pair[0].is_nan() || pair[1].is_nan()));
    let (mut rising, mut all) = (0, 0);
    for pair in steps {
        (rising, all) = (rising + usize::from(pair[1] > pair[0]), all + 1);
    }
    all > 0 && 10 * rising > 9 * all
}

/// Whether a name has the look of another encoding read as Latin-1: letters beyond ASCII follow each other, as in no western word.
pub(super) fn is_garbled(name: &str) -> bool {
    let is_high = |sign: &&char| ('\u{80}'..='\u{ff}').contains(*sign);
    let signs: Vec<char> = name.chars().collect();
    // By chance two bytes of another encoding are one letter of UTF-8.
    signs.windows(3).any(|signs| !signs.iter().any(char::is_ascii) && signs.iter().filter(is_high).count() > 1)
}
