//! Whether paths lead to one file, and which files the input has called.

use std::collections::BTreeSet;
use std::path::{Component, Path, PathBuf};
use std::sync::{Mutex, PoisonError};

/// Subprograms that a program has called so far, and files that settings include: which ones is known only while they are read.
static CALLED: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

/// Notes that the input called this file.
pub fn note_called(path: &Path) {
    CALLED.lock().unwrap_or_else(PoisonError::into_inner).insert(path.to_owned());
}

/// The called file that `output` would write over.
pub fn called_at(output: &Path) -> Option<PathBuf> {
    let called = CALLED.lock().unwrap_or_else(PoisonError::into_inner);
    called.iter().find(|path| is_same(path, output)).cloned()
}

/// Whether both paths lead to one file, whatever links or spellings are on the way.
pub fn is_same(one: &Path, other: &Path) -> bool {
    match (inode(one), inode(other)) {
        (Some(a), Some(b)) => a == b,
        (None, None) => same_name(&resolved(one), &resolved(other)),
        _ => resolved(one) == resolved(other),
    }
}

/// What the file system calls the file itself, whatever links lead to it; `None` where there is no file, or it is not known.
#[cfg(unix)]
fn inode(path: &Path) -> Option<(u64, u64)> {
    use std::os::unix::fs::MetadataExt;
    path.metadata().ok().map(|there| (there.dev(), there.ino()))
}

#[cfg(not(unix))]
fn inode(path: &Path) -> Option<PathBuf> {
    path.canonicalize().ok()
}

/// The whole path with the links of those folders that exist followed.
pub fn resolved(path: &Path) -> PathBuf {
    let whole = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    let there = whole.ancestors().find_map(|folder| Some((folder, folder.canonicalize().ok()?)));
    let Some((folder, mut out)) = there else { return whole };
    for part in whole.strip_prefix(folder).into_iter().flat_map(Path::components) {
        match part {
            Component::ParentDir => {
                out.pop();
            }
            part => out.push(part),
        }
    }
    out
}

/// Whether two resolved paths, neither of which exists, will be one file: names may differ in case where the file system takes no notice.
fn same_name(a: &Path, b: &Path) -> bool {
    let folded = |path: &Path| path.to_string_lossy().to_lowercase();
    a == b || (folded(a) == folded(b) && datasets::ignores_case(a.parent().unwrap_or(a)))
}
