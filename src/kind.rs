//! What files hold, as their names say.

use std::path::Path;

/// What a file holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    Program,
    /// Log, reference or another table of samples.
    Table,
    /// A program or a reference, of the kind of the input.
    Path,
    Model,
    /// Machine file or settings.
    Toml,
    /// Settings of a control.
    Settings,
    Report,
    Figures,
}

impl Kind {
    /// What a file of this name holds by its ending; `None` where that does not say.
    #[must_use]
    pub fn of(path: &Path) -> Option<Self> {
        let ending = path.extension()?.to_string_lossy().to_lowercase();
        Some(match ending.as_str() {
            "nc" | "ngc" | "gcode" | "mpf" => Self::Program,
            "csv" | "parquet" => Self::Table,
            "model" => Self::Model,
            "toml" => Self::Toml,
            "html" => Self::Report,
            _ => return None,
        })
    }

    /// What such a file is.
    #[must_use]
    pub fn what(self) -> &'static str {
        match self {
            Self::Program => "a part program",
            Self::Table => "a log or a reference",
            Self::Path => "a part program or a reference",
            Self::Model => "a model",
            Self::Toml => "a machine file or settings",
            Self::Settings => "settings of a control",
            Self::Report => "a report",
            Self::Figures => "figures",
        }
    }

    /// Whether a file of this name is a table in a format that is not written.
    #[must_use]
    pub fn is_only_read(path: &Path) -> bool {
        let only_read = [
            "json", "jsonl", "ndjson", "npz", "npy", "mat", "lvm", "svb", "arrow", "feather", "ipc", "h5", "hdf5", "xlsx", "tdms",
        ];
        path.extension().is_some_and(|ending| only_read.iter().any(|known| ending.eq_ignore_ascii_case(known)))
    }

    /// What a file of this name holds that is not of this kind.
    #[must_use]
    pub fn is_not(self, path: &Path) -> Option<Self> {
        let other = Self::of(path)?;
        let fits = self == other || (self == Self::Path && matches!(other, Self::Program | Self::Table));
        (!fits).then_some(other)
    }
}
