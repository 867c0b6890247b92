//! SINUMERIK Operate's trace files: XML with a list of signals and one element a record.

use std::path::Path;

use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};

use super::LogFormat;
use crate::{Check, DatasetError, Finding, Severity, Table};

/// Values from here on mean missing: the bits of a NaN, printed as an integer.
const NO_VALUE: f64 = 9.2e18;

/// Trace XML: `dataSignal` elements name the signals, `rec` elements hold the time (s) and the values `f1`, `f2`, … in their order.
#[derive(Debug, Clone, Copy)]
pub struct SinumerikTrace;

impl LogFormat for SinumerikTrace {
    fn name(&self) -> &'static str {
        "SINUMERIK trace XML"
    }

    fn recognises(&self, head: &[u8]) -> bool {
        let head = String::from_utf8_lossy(head);
        head.trim_start_matches('\u{feff}').trim_start().starts_with('<')
            && (head.contains("<traceData") || head.contains("<dataFrame"))
    }

    fn read(&self, path: &Path, bytes: Vec<u8>) -> Result<Table, DatasetError> {
        let broken = |place: u64, message: String| DatasetError::format(path, format!("byte {place}: {message}"));
        let mut reader = Reader::from_reader(bytes.as_slice());
        let mut names = vec!["time [s]".to_owned()];
        let mut columns: Vec<Vec<f64>> = vec![Vec::new()];
        let (mut missing, mut depth) = (0, 0_usize);
        loop {
            let event = reader.read_event().map_err(|error| broken(reader.error_position(), error.to_string()))?;
            let element = match &event {
                Event::Start(element) => {
                    depth += 1;
                    element
                }
                Event::Empty(element) => element,
                Event::End(_) => {
                    depth = depth.saturating_sub(1);
                    continue;
                }
                Event::Eof if depth > 0 => {
                    return Err(broken(reader.buffer_position(), "the file ends within the trace; save it again".into()));
                }
                Event::Eof => break,
                _ => continue,
            };
            match element.local_name().as_ref() {
                b"dataSignal" => {
                    let described = attribute(element, "description").filter(|text| !text.is_empty());
                    let number = names.len();
                    names.push(described.or_else(|| attribute(element, "name")).unwrap_or_else(|| format!("f{number}")));
                    columns.push(Vec::new());
                }
                b"rec" => {
                    let place = reader.buffer_position();
                    let time = attribute(element, "time").ok_or_else(|| broken(place, "a record without `time`".into()))?;
                    columns[0].push(time.parse().unwrap_or(f64::NAN));
                    for (index, column) in columns.iter_mut().enumerate().skip(1) {
                        let value = attribute(element, &format!("f{index}")).and_then(|text| text.parse::<f64>().ok());
                        // A signal without a sample at this time keeps its value.
                        let value = value.filter(|value| value.abs() < NO_VALUE).unwrap_or_else(|| {
                            missing += 1;
                            column.last().copied().unwrap_or(f64::NAN)
                        });
                        column.push(value);
                    }
                }
                _ => {}
            }
        }
        let length = columns[0].len();
        if names.len() < 2 || length == 0 {
            return Err(DatasetError::format(path, "the trace holds no signal or no record"));
        }
        let mut findings = Vec::new();
        if missing > 0 {
            let message = format!("{missing} values are missing in records; each signal keeps the one before it");
            findings.push(Finding::new(Severity::Warn, Check::Mended, message));
        }
        Ok(Table { names, columns, lines: (1..=length).collect(), period_s: None, findings })
    }
}

fn attribute(element: &BytesStart<'_>, name: &str) -> Option<String> {
    let found = element.try_get_attribute(name).ok()??;
    Some(String::from_utf8_lossy(&found.value).into_owned())
}
