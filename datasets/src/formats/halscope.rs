//! LinuxCNC's `halscope`: a comment with the sampling period, the channels' names, rows of numbers; semicolons or tabs between them, decimals
//! as the system's locale has them.

use std::path::Path;

use super::{Csv, LogFormat, text};
use crate::columns::is_joint_pin;
use crate::side_file::period_s;
use crate::{Check, DatasetError, Finding, Severity, Table};

/// Output of `halscope` from LinuxCNC 2.9 on. Columns have the names of the pins, signals or
/// parameters of its channels.
#[derive(Debug, Clone, Copy)]
pub struct Halscope;

/// Beginning of the comment; the period follows.
const PERIOD: &str = "Sampling period is";

impl LogFormat for Halscope {
    fn name(&self) -> &'static str {
        "halscope"
    }

    fn recognises(&self, head: &[u8]) -> bool {
        let text = text::decode(head);
        text::lines(&text).1.iter().any(|comment| comment.text.starts_with(PERIOD))
    }

    fn read(&self, path: &Path, bytes: Vec<u8>) -> Result<Table, DatasetError> {
        let text = text::decode(&bytes);
        let (_, comments) = text::lines(&text);
        let stated = comments.iter().find_map(|comment| Some((comment.number, comment.text.strip_prefix(PERIOD)?.trim())));
        let (line, stated) = stated.unwrap_or_default();
        let period_s = period_s(&stated.replace(',', ".")).ok_or_else(|| {
            let message = format!("line {line}: `{stated}` is no sampling period; write it as `# {PERIOD} 1000000 ns`");
            DatasetError::format(path, message)
        })?;
        let mut table = Csv.read(path, bytes)?;
        table.period_s = Some(period_s);
        if table.names.iter().any(|name| is_joint_pin(name)) {
            let message = "joints 0 to 5 are taken for the axes x y z a b c, in mm and degrees; where the machine's are others, say so with a \
                           mapping like `z_ref=joint.1.motor-pos-cmd:in`";
            table.findings.push(Finding::new(Severity::Note, Check::Mended, message));
        }
        Ok(table)
    }
}
