//! Files of subprograms, which are read when they are called.

use std::collections::HashSet;

/// Content of a subprogram file by its name, such as `probe.ngc` or `O1234.nc`; `None` if there is no such file.
pub type Files<'a> = &'a dyn Fn(&str) -> Option<Vec<u8>>;

/// The subprogram files of an execution.
pub(super) struct Library<'a> {
    files: Files<'a>,
    missing: HashSet<String>,
}

impl<'a> Library<'a> {
    pub fn new(files: Files<'a>) -> Self {
        Self { files, missing: HashSet::new() }
    }

    /// Content of a file. A file that is missing is looked for once.
    pub fn read(&mut self, name: &str) -> Option<Vec<u8>> {
        if self.missing.contains(name) {
            return None;
        }
        let content = (self.files)(name);
        if content.is_none() {
            self.missing.insert(name.to_owned());
        }
        content
    }
}
