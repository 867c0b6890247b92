//! Where the files of subprograms come from.

use std::fmt;
use std::sync::Arc;

/// Reads subprogram files by their names, such as `probe.ngc` or `O1234.nc`. The default knows none.
#[derive(Clone, Default)]
pub struct Subprograms(Option<Arc<ReadFile>>);

type ReadFile = dyn Fn(&str) -> Option<Vec<u8>> + Send + Sync;

impl Subprograms {
    /// Files that `read` returns by name; `None` where there is no such file.
    #[must_use]
    pub fn new(read: impl Fn(&str) -> Option<Vec<u8>> + Send + Sync + 'static) -> Self {
        Self(Some(Arc::new(read)))
    }

    /// Content of a file.
    #[must_use]
    pub fn read(&self, name: &str) -> Option<Vec<u8>> {
        self.0.as_ref().and_then(|read| read(name))
    }
}

impl fmt::Debug for Subprograms {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(if self.0.is_some() { "Subprograms(from files)" } else { "Subprograms(none)" })
    }
}

/// Two are equal if they read with the same function.
impl PartialEq for Subprograms {
    fn eq(&self, other: &Self) -> bool {
        match (&self.0, &other.0) {
            (Some(a), Some(b)) => Arc::ptr_eq(a, b),
            (a, b) => a.is_none() && b.is_none(),
        }
    }
}
