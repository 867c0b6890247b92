//! Keys that are missing, unknown or of the wrong type: all of a file at once.
//!
//! A deserializer stops at the first fault. Here the fault is noted, a key that is unknown is taken out and a value that is missing or wrong gets a
//! stand-in, and the table is read again, until it is read whole or nothing fits.

use serde::de::DeserializeOwned;
use serde_path_to_error::{Path, Segment};
use toml::{Table, Value};

use super::faults::Gathered;
use super::places::Step;

/// Faults after which reading ends.
const MOST_FAULTS: usize = 100;

/// Similarity (Jaro and Winkler, 0 to 1) above which an unknown key is taken for a misspelt one.
const SIMILAR: f64 = 0.85;

/// Reads `table`, which stands `at` this path of the file, and notes every fault. `None` where there is one.
pub(super) fn read<T: DeserializeOwned>(table: Table, at: &[Step], faults: &mut Gathered<'_>) -> Option<T> {
    let mut trial = Value::Table(table);
    let mut stand_ins: Vec<(Vec<Step>, usize)> = Vec::new();
    let mut sound = true;
    for _ in 0..MOST_FAULTS {
        let error = match serde_path_to_error::deserialize(trial.clone()) {
            Ok(value) => return sound.then_some(value),
            Err(error) => error,
        };
        sound = false;
        let path = steps(error.path());
        let message = error.inner().message().to_owned();
        let fault = Fault::of(&message);
        if let (Some((_, tried)), Fault::Wrong { known }) = (stand_ins.iter_mut().find(|(replaced, _)| *replaced == path), &fault)
        {
            *tried += 1;
            let next = known.clone().map_or_else(|| stand_in(*tried), |known| Some(Value::String(known)));
            set(&mut trial, &path, next?)?;
            continue;
        }
        let whole = |path: &[Step]| -> Vec<Step> { at.iter().chain(path).cloned().collect() };
        match fault {
            Fault::Unknown { key, known } => {
                let path = if path.last() == Some(&Step::key(&key)) { path } else { below(path, &key) };
                faults.add(&whole(&path), |label| unknown(label, &key, &known));
                take_out(&mut trial, &path)?;
            }
            Fault::Missing { key } => {
                let path = below(path, &key);
                faults.add(&whole(&path), |label| format!("`{label}` is missing"));
                set(&mut trial, &path, stand_in(0)?)?;
                stand_ins.push((path, 0));
            }
            Fault::Wrong { known } => {
                faults.add(&whole(&path), |label| format!("`{label}`: {message}"));
                let first = known.map_or_else(|| stand_in(0), |known| Some(Value::String(known)));
                set(&mut trial, &path, first?)?;
                stand_ins.push((path, 0));
            }
        }
    }
    None
}

/// What a message of the deserializer says.
enum Fault {
    Unknown {
        key: String,
        known: Vec<String>,
    },
    Missing {
        key: String,
    },
    /// A value of the wrong type, or none of those `known`.
    Wrong {
        known: Option<String>,
    },
}

impl Fault {
    fn of(message: &str) -> Self {
        let mut quoted = message.split('`').skip(1).step_by(2).map(str::to_owned);
        if message.starts_with("unknown field") {
            Self::Unknown { key: quoted.next().unwrap_or_default(), known: quoted.collect() }
        } else if message.starts_with("missing field") {
            Self::Missing { key: quoted.next().unwrap_or_default() }
        } else {
            Self::Wrong { known: quoted.nth(1).filter(|_| message.starts_with("unknown variant")) }
        }
    }
}

fn unknown(label: &str, key: &str, known: &[String]) -> String {
    let nearest = known.iter().map(|name| (strsim::jaro_winkler(key, name), name)).max_by(|a, b| a.0.total_cmp(&b.0));
    match nearest {
        Some((likeness, name)) if likeness > SIMILAR => format!("`{label}` is no key; did you mean `{name}`?"),
        Some(_) => format!("`{label}` is no key; here may stand `{}`", known.join("`, `")),
        None => format!("`{label}` is no key, and none may stand here"),
    }
}

/// Stand-ins for a missing value, one after another until the type fits.
fn stand_in(number: usize) -> Option<Value> {
    let pair = || Value::Array(vec![Value::Float(1.0), Value::Float(2.0)]);
    Some(match number {
        0 => Value::Float(1.0),
        1 => Value::String("x".into()),
        2 => Value::Integer(1),
        3 => Value::Table(Table::new()),
        4 => Value::Array(Vec::new()),
        5 => pair(),
        6 => Value::Array(vec![Value::Float(1.0); 3]),
        7 => Value::Boolean(false),
        _ => return None,
    })
}

fn steps(path: &Path) -> Vec<Step> {
    let step = |segment: &Segment| match segment {
        Segment::Seq { index } => Some(Step::Index(*index)),
        Segment::Map { key } => Some(Step::key(key)),
        Segment::Enum { variant } => Some(Step::key(variant)),
        Segment::Unknown => None,
    };
    path.iter().filter_map(step).collect()
}

/// `path` to a key of the table there.
fn below(mut path: Vec<Step>, key: &str) -> Vec<Step> {
    path.push(Step::key(key));
    path
}

fn at<'a>(value: &'a mut Value, path: &[Step]) -> Option<&'a mut Value> {
    path.iter().try_fold(value, |value, step| match step {
        Step::Key(name) => value.as_table_mut()?.get_mut(name),
        Step::Index(index) => value.as_array_mut()?.get_mut(*index),
    })
}

/// Puts `new` at `path`, whose last step may be a key that is not there yet.
fn set(value: &mut Value, path: &[Step], new: Value) -> Option<()> {
    let (last, before) = path.split_last()?;
    match (at(value, before)?, last) {
        (Value::Table(table), Step::Key(name)) => {
            table.insert(name.clone(), new);
        }
        (Value::Array(list), Step::Index(index)) => *list.get_mut(*index)? = new,
        _ => return None,
    }
    Some(())
}

fn take_out(value: &mut Value, path: &[Step]) -> Option<Value> {
    let (Step::Key(name), before) = path.split_last()? else { return None };
    at(value, before)?.as_table_mut()?.remove(name)
}
