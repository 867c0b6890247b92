//! Files that are never half-written.

use std::fs::File;
use std::path::Path;

use crate::DatasetError;

/// Writes a file through a temporary one in the same folder: written, synced, then renamed.
///
/// # Errors
/// When the folder cannot be written, or `fill` fails; `path` is then as it was before.
pub fn write_atomically(path: &Path, fill: impl FnOnce(&mut File) -> Result<(), DatasetError>) -> Result<(), DatasetError> {
    let folder = match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    let failed = |source| DatasetError::io(path, source);
    let mut builder = tempfile::Builder::new();
    builder.prefix(".precomp-");
    #[cfg(unix)]
    {
        // As an ordinary file: the user's umask decides who may read it.
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    let mut temporary = builder.tempfile_in(folder).map_err(failed)?;
    fill(temporary.as_file_mut())?;
    temporary.as_file().sync_all().map_err(failed)?;
    temporary.persist(path).map_err(|error| failed(error.error))?;
    #[cfg(unix)]
    File::open(folder).and_then(|folder| folder.sync_all()).map_err(failed)?;
    Ok(())
}
