//! High-frequency recordings of SINUMERIK Edge (Capture4Analysis, Data Recorder): a header that lists signals, a payload of their values.

use std::path::Path;

use serde::Deserialize;
use serde_json::Value;

use super::LogFormat;
use crate::columns::edge_role;
use crate::cycles::{CYCLE, seconds};
use crate::{Check, DatasetError, Finding, Severity, Table};

/// JSON of SINUMERIK Edge: `DES_POS|n` is the commanded, `ENC_POS|n` or `ENC1_POS|n` the actual position of axis `n`, `ENC2_POS|n` that of
/// its encoder at the table; one row a position-control cycle.
#[derive(Debug, Clone, Copy)]
pub struct SinumerikJson;

#[derive(Deserialize)]
struct File {
    #[serde(rename = "Header")]
    header: Header,
    #[serde(rename = "Payload")]
    payload: Vec<Value>,
}

#[derive(Deserialize)]
struct Header {
    #[serde(rename = "SignalListHFData")]
    signals: Vec<Signal>,
    #[serde(flatten)]
    rest: Value,
}

#[derive(Deserialize)]
struct Signal {
    #[serde(rename = "Name", default)]
    name: String,
    #[serde(rename = "Address", default)]
    address: String,
    #[serde(rename = "Axis", default)]
    axis: String,
}

impl LogFormat for SinumerikJson {
    fn name(&self) -> &'static str {
        "SINUMERIK Edge JSON"
    }

    fn recognises(&self, head: &[u8]) -> bool {
        let head = String::from_utf8_lossy(head);
        head.trim_start_matches('\u{feff}').trim_start().starts_with('{') && head.contains("\"Header\"")
    }

    fn read(&self, path: &Path, bytes: Vec<u8>) -> Result<Table, DatasetError> {
        let bytes = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(&bytes);
        let file: File = serde_json::from_slice(bytes)
            .map_err(|error| DatasetError::format(path, format!("not a recording of high-frequency signals: {error}")))?;
        let signals = &file.header.signals;
        let mut columns: Vec<Vec<f64>> = vec![Vec::new(); signals.len()];
        for (index, row) in file.payload.iter().filter_map(|entry| entry.get("HFData")).flat_map(rows).enumerate() {
            let row = row.as_array().map_or(&[][..], Vec::as_slice);
            if row.len() != signals.len() {
                return Err(DatasetError::Ragged {
                    path: path.to_owned(),
                    line: index + 1,
                    found: row.len(),
                    expected: signals.len(),
                });
            }
            for (column, value) in columns.iter_mut().zip(row) {
                column.push(number(value));
            }
        }
        let mut names: Vec<String> = signals.iter().map(Signal::column).collect();
        let length = columns.first().map_or(0, Vec::len);
        if length == 0 {
            return Err(DatasetError::format(path, "the payload holds no `HFData`; record high-frequency signals"));
        }
        let period_s = cycle_ms(&file.header.rest).map(|ms| ms * 1e-3);
        let mut findings = Vec::new();
        if let (Some(counter), Some(period_s)) = (names.iter().position(|name| name == CYCLE), period_s) {
            // As time stamps, lost cycles are handled like those of any other log.
            columns[counter] = seconds(&columns[counter], period_s);
            names[counter] = "time [s]".to_owned();
        } else if period_s.is_none() {
            findings.push(Finding::new(Severity::Note, Check::Mended, "the header states no `CycleTimeMs`; give the period"));
        }
        Ok(Table { names, columns, lines: (1..=length).collect(), period_s, findings })
    }
}

impl Signal {
    /// Name of the signal's column: `x_ref_mm` for `DES_POS|1` of axis X; its own where the axis has no name.
    fn column(&self) -> String {
        let address = if self.address.is_empty() { &self.name } else { &self.address };
        let role = address.split_once('|').and_then(|(signal, _)| edge_role(signal));
        let Some((is_reference, is_table)) = role.filter(|_| !self.axis.is_empty()) else { return address.clone() };
        let side = match (is_reference, is_table) {
            (true, _) => "ref",
            (false, false) => "act",
            (false, true) => "enc2",
        };
        // Positions are in mm, those of rotary axes in degrees.
        let axis = self.axis.to_lowercase();
        let unit = if axis.starts_with(['a', 'b', 'c']) && !axis.starts_with("axis") { "deg" } else { "mm" };
        format!("{axis}_{side}_{unit}")
    }
}

/// The rows of an `HFData` entry: a list of rows, or one row by itself.
fn rows(data: &Value) -> Vec<&Value> {
    match data.as_array() {
        Some(list) if list.first().is_some_and(Value::is_array) => list.iter().collect(),
        Some(_) => vec![data],
        None => Vec::new(),
    }
}

fn number(value: &Value) -> f64 {
    value.as_f64().or_else(|| value.as_str()?.parse().ok()).or_else(|| value.as_bool().map(f64::from)).unwrap_or(f64::NAN)
}

/// `CycleTimeMs`, anywhere in the header.
fn cycle_ms(header: &Value) -> Option<f64> {
    match header {
        Value::Object(entries) => entries
            .iter()
            .find_map(|(key, value)| if key == "CycleTimeMs" { Some(number(value)) } else { cycle_ms(value) })
            .filter(|ms| ms.is_finite() && *ms > 0.0),
        Value::Array(entries) => entries.iter().find_map(cycle_ms),
        _ => None,
    }
}
