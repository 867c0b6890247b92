//! JSON: an object a row, an object of columns, or what table libraries write.

use std::collections::BTreeMap;
use std::path::Path;

use serde_json::{Map, Value};

use super::LogFormat;
use super::arrays::{Array, MOST_COLUMNS, MOST_NUMBERS, table};
use super::clock_text::clock_s;
use crate::{DatasetError, Table};

/// Rows as objects, one behind the other (JSON Lines) or in a list, or as lists of numbers; an object with a list, or with an object of numbered values, a
/// column; or names in `columns` and rows in `data`, as pandas writes them. Values within values are named by both: `x_cmd` for `{"x": {"cmd": 1.5}}`,
/// `cmd.1` for the first of `{"cmd": [1.5, 2.5]}`.
#[derive(Debug, Clone, Copy)]
pub struct Json;

impl LogFormat for Json {
    fn name(&self) -> &'static str {
        "JSON"
    }

    fn recognises(&self, head: &[u8]) -> bool {
        let head = String::from_utf8_lossy(head);
        let mut signs = head.trim_start_matches('\u{feff}').chars().filter(|sign| !sign.is_whitespace());
        // Some text logs begin with a section as `[Channels]`.
        matches!((signs.next(), signs.next()), (Some('{'), Some('"')) | (Some('['), Some('{' | '[')))
    }

    fn read(&self, path: &Path, bytes: Vec<u8>) -> Result<Table, DatasetError> {
        let bytes = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(&bytes);
        let refused = |why: String| DatasetError::format(path, why);
        let mut rows = Rows::default();
        let mut columns = Vec::new();
        for value in serde_json::Deserializer::from_slice(bytes).into_iter::<Value>() {
            match value.map_err(|error| refused(format!("the JSON is damaged: {error}; save it again")))? {
                Value::Array(list) => list.iter().try_for_each(|row| rows.add(row)).map_err(refused)?,
                Value::Object(object) if is_of_columns(&object) => columns.extend(arrays(&object).map_err(refused)?),
                row => rows.add(&row).map_err(refused)?,
            }
        }
        columns.extend(rows.arrays());
        table(path, columns)
    }
}

/// Columns by name, filled row by row.
#[derive(Default)]
struct Rows {
    columns: BTreeMap<String, Vec<f64>>,
    rows: usize,
}

impl Rows {
    /// Adds a row; columns without a value get NaN.
    ///
    /// # Errors
    /// When it has more columns, or more numbers, than a log.
    fn add(&mut self, row: &Value) -> Result<(), String> {
        each_value("", row, &mut |name, value| {
            let column = self.columns.entry(name).or_default();
            // Of a name that comes twice in a row the first value counts.
            if column.len() <= self.rows {
                column.resize(self.rows, f64::NAN);
                column.push(value);
            }
        });
        self.rows += 1;
        if self.columns.len() > MOST_COLUMNS || self.rows * self.columns.len() > MOST_NUMBERS {
            return Err(format!(
                "it holds more than {MOST_COLUMNS} columns or {MOST_NUMBERS} numbers; save what a log needs, in parts if need be"
            ));
        }
        Ok(())
    }

    fn arrays(self) -> impl Iterator<Item = Array> {
        let rows = self.rows;
        self.columns.into_iter().map(move |(name, mut column)| {
            column.resize(rows, f64::NAN);
            Array { name, columns: vec![column] }
        })
    }
}

/// Gives the numbers of a row with their names.
fn each_value(name: &str, value: &Value, take: &mut impl FnMut(String, f64)) {
    let within = |part: &str, sign: &str| if name.is_empty() { part.to_owned() } else { format!("{name}{sign}{part}") };
    match value {
        Value::Object(parts) => parts.iter().for_each(|(part, value)| each_value(&within(part, "_"), value, take)),
        Value::Array(parts) => {
            parts.iter().enumerate().for_each(|(index, value)| each_value(&within(&(index + 1).to_string(), "."), value, take));
        }
        single => take(name.to_owned(), number(single)),
    }
}

/// The number that a value is or spells; a time of day in s.
fn number(value: &Value) -> f64 {
    match value {
        Value::String(text) => text.trim().parse().ok().or_else(|| clock_s(text.trim())).unwrap_or(f64::NAN),
        Value::Bool(is) => f64::from(*is),
        other => other.as_f64().unwrap_or(f64::NAN),
    }
}

/// Longest list that may be one value of a row, such as the positions of all axes.
const LONGEST_VALUE: usize = 32;

/// Whether an object holds columns and not the values of one row.
fn is_of_columns(object: &Map<String, Value>) -> bool {
    object.values().any(|value| match value {
        Value::Array(list) => {
            list.len() > LONGEST_VALUE || list.first().is_some_and(|first| first.is_array() || first.is_object())
        }
        Value::Object(values) => values.len() > LONGEST_VALUE && by_number(values).is_some(),
        _ => false,
    })
}

/// The columns of an object of columns.
///
/// # Errors
/// As of [`Rows::add`].
fn arrays(object: &Map<String, Value>) -> Result<Vec<Array>, String> {
    let mut arrays = Vec::new();
    for (name, value) in object {
        match value {
            Value::Array(list) if list.first().is_some_and(|first| first.is_array() || first.is_object()) => {
                let names = object.get("columns").and_then(Value::as_array);
                let mut rows = Rows::default();
                list.iter().try_for_each(|row| rows.add(row))?;
                arrays.extend(rows.arrays().map(|array| match names.and_then(|names| named(names, &array.name)) {
                    Some(name) => Array { name, ..array },
                    None if list[0].is_array() => Array { name: format!("{name}.{}", array.name), ..array },
                    None => array,
                }));
            }
            Value::Array(list) => arrays.push(Array { name: name.clone(), columns: vec![list.iter().map(number).collect()] }),
            Value::Object(values) => {
                let column = by_number(values).map(|values| values.into_iter().map(number).collect());
                arrays.extend(column.map(|column| Array { name: name.clone(), columns: vec![column] }));
            }
            _ => {}
        }
    }
    Ok(arrays)
}

/// The name that a list gives to column `number`, counted from 1.
fn named(names: &[Value], number: &str) -> Option<String> {
    let index: usize = number.parse().ok()?;
    names.get(index.checked_sub(1)?)?.as_str().map(str::to_owned)
}

/// The values of an object whose names are numbers, in their order.
fn by_number(values: &Map<String, Value>) -> Option<Vec<&Value>> {
    let mut numbered: Vec<(u64, &Value)> =
        values.iter().map(|(name, value)| Some((name.parse().ok()?, value))).collect::<Option<_>>()?;
    numbered.sort_by_key(|(number, _)| *number);
    Some(numbered.into_iter().map(|(_, value)| value).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Table {
        assert!(Json.recognises(text.as_bytes()), "{text}");
        Json.read(Path::new("log.json"), text.as_bytes().to_vec()).unwrap()
    }

    #[test]
    fn rows_are_objects_one_a_line_or_in_a_list() {
        for text in [
            "{\"t\": 0.0, \"x\": {\"cmd\": 1.5, \"act\": \"1.25\"}, \"on\": true}\n{\"t\": 0.5, \"x\": {\"act\": 2.25}}\n",
            "[{\"t\": 0.0, \"x\": {\"cmd\": 1.5, \"act\": 1.25}, \"on\": true}, {\"t\": 0.5, \"x\": {\"act\": 2.25, \"cmd\": null}}]",
        ] {
            let table = read(text);
            assert_eq!(table.names, ["on", "t", "x_act", "x_cmd"]);
            assert_eq!([&table.columns[1], &table.columns[2]], [&[0.0, 0.5], &[1.25, 2.25]]);
            assert!(table.columns[3][0] == 1.5 && table.columns[3][1].is_nan() && table.len() == 2);
        }
        let table = read("{\"t\": 0, \"cmd\": [1, 2]}{\"t\": 1, \"cmd\": [3, 4]}");
        assert_eq!(table.names, ["cmd.1", "cmd.2", "t"]);
        assert_eq!(table.columns, [[1.0, 3.0], [2.0, 4.0], [0.0, 1.0]]);
    }

    #[test]
    fn columns_are_lists_or_numbered_values() {
        let many: Vec<String> = (0..40).map(|k| k.to_string()).collect();
        let table = read(&format!("{{\"t\": [{0}], \"x_cmd\": [{0}], \"unit\": \"mm\"}}", many.join(",")));
        assert_eq!((table.names.as_slice(), table.len()), (["t".to_owned(), "x_cmd".to_owned()].as_slice(), 40));
        let numbered: Vec<String> = (0..40).map(|k| format!("\"{k}\": {k}")).collect();
        let table = read(&format!("{{\"x_cmd\": {{{}}}}}", numbered.join(",")));
        assert!(table.columns[0].iter().enumerate().all(|(k, value)| *value == k as f64), "{:?}", table.columns[0]);
        let split = read("{\"columns\": [\"t\", \"x_cmd\"], \"index\": [0, 1], \"data\": [[0, 5], [1, 6]]}");
        let x = split.names.iter().position(|name| name == "x_cmd").unwrap();
        assert_eq!(split.columns[x], [5.0, 6.0]);
        let within = read("{\"schema\": 1, \"data\": [{\"t\": 0, \"x\": 5}, {\"t\": 1, \"x\": 6}]}");
        assert_eq!((within.names, within.columns), (vec!["t".into(), "x".into()], vec![vec![0.0, 1.0], vec![5.0, 6.0]]));
    }

    #[test]
    fn damage_is_told_with_its_line() {
        let error = Json.read(Path::new("log.json"), b"{\"t\": 0}\n{\"t\": 1\n".to_vec()).unwrap_err().to_string();
        assert!(error.contains("log.json") && error.contains("line 3"), "{error}");
        let names: Vec<String> = (0..5000).map(|k| format!("{{\"a{k}\": 1}}")).collect();
        for text in [names.concat(), format!("[{}]", names.join(",")), format!("{{\"data\": [{}]}}", names.join(","))] {
            let error = Json.read(Path::new("log.json"), text.into_bytes()).unwrap_err().to_string();
            assert!(error.contains("more than 4096 columns"), "{error}");
        }
        assert!(!Json.recognises(b"[Channels]\nt,x\n") && !Json.recognises(b"{note}\n0,1\n"));
    }
}
