//! Atomic writes: a file is complete or unchanged.

use std::fs::{File, Metadata};
use std::io::{Seek, Write};
use std::path::{Path, PathBuf};
use std::time::Duration;

use tempfile::NamedTempFile;

use crate::DatasetError;

/// Beginning of the names of temporary files.
const PREFIX: &str = ".precomp-";
/// Age from which on a temporary file is of a run that was killed.
const ABANDONED: Duration = Duration::from_secs(3600);

/// Writes a file through a temporary one in the same folder: written, synced, then renamed.
///
/// # Errors
/// When the folder cannot be written, or `fill` fails; `path` is then as it was before.
pub fn write_atomically(path: &Path, fill: impl FnOnce(&mut File) -> Result<(), DatasetError>) -> Result<(), DatasetError> {
    write_temporary(path, fill)?.commit()
}

/// Writes `files`, each a path with its content. All are written and synced beside their targets
/// before the first is renamed. Missing folders are made. A path to a device or pipe, such as
/// `/dev/null`, is written directly.
///
/// # Errors
/// When a file cannot be written; unless renaming itself failed, every path is then as it was before and no folder is left behind.
pub fn write_all(files: &[(PathBuf, Vec<u8>)]) -> Result<(), DatasetError> {
    write_all_and(files, &mut [])
}

/// As [`write_all`], and also `spools`: each a path with a file that holds its content and may be unnamed.
///
/// # Errors
/// As [`write_all`], and when a spool cannot be read.
pub fn write_all_and(files: &[(PathBuf, Vec<u8>)], spools: &mut [(PathBuf, File)]) -> Result<(), DatasetError> {
    let mut folders = NewFolders::default();
    let held = files.iter().map(|(path, content)| (path.as_path(), Content::Held(content)));
    let spooled = spools.iter_mut().map(|(path, file)| (path.as_path(), Content::Spooled(file)));
    let (special, plain): (Vec<_>, Vec<_>) = held.chain(spooled).partition(|(path, _)| is_special(path));
    let written = plain.into_iter().map(|(path, content)| {
        folders.make(folder_of(path))?;
        write_temporary(path, |file| content.write_to(file).map_err(|source| DatasetError::io(path, source)))
    });
    let written = written.collect::<Result<Vec<_>, _>>()?;
    for (path, content) in special {
        let written = File::options().write(true).open(path).and_then(|mut device| content.write_to(&mut device));
        written.map_err(|source| DatasetError::io(path, source))?;
    }
    written.into_iter().try_for_each(Temporary::commit)?;
    folders.made.clear();
    Ok(())
}

/// Content of a file to be written.
enum Content<'a> {
    Held(&'a [u8]),
    Spooled(&'a mut File),
}

impl Content<'_> {
    fn write_to(self, out: &mut File) -> std::io::Result<()> {
        match self {
            Self::Held(bytes) => out.write_all(bytes),
            Self::Spooled(spool) => {
                spool.rewind()?;
                std::io::copy(spool, out).map(drop)
            }
        }
    }
}

/// Checks that files can be made in the folder `at`, or in the nearest existing folder above it. Where the file system can, the
/// file of the trial never has a name, so that a run that is stopped leaves none.
///
/// # Errors
/// When they cannot be made; no file remains either way.
pub fn try_folder(at: &Path) -> std::io::Result<()> {
    let there = existing(at);
    if !there.metadata()?.is_dir() {
        return Err(std::io::Error::new(std::io::ErrorKind::NotADirectory, format!("{} is not a folder", there.display())));
    }
    tempfile::tempfile_in(there).map(drop)
}

/// A file without a name on the file system of `path`; for devices and pipes, where the system has its temporary files.
pub(crate) fn unnamed_beside(path: &Path) -> std::io::Result<File> {
    if is_special(path) { tempfile::tempfile() } else { tempfile::tempfile_in(existing(folder_of(path))) }
}

/// Whether names in the folder `at`, or in the nearest existing folder above it, are one name whatever their case: found by
/// a name that is there, without making a file.
pub fn ignores_case(at: &Path) -> bool {
    let there = existing(at).canonicalize();
    let same_in_other_case = |path: &Path| {
        let name = path.file_name()?.to_str()?;
        let other: String =
            name.chars().map(|c| if c.is_ascii_lowercase() { c.to_ascii_uppercase() } else { c.to_ascii_lowercase() }).collect();
        let own = path.canonicalize().ok()?;
        (other != name).then(|| path.with_file_name(other).canonicalize().is_ok_and(|other| other == own))
    };
    // What lies in the folder tells; where it is empty, its own name does.
    let answer = |folder: PathBuf| {
        let inside = std::fs::read_dir(&folder).into_iter().flatten().flatten();
        inside.map(|entry| entry.path()).chain([folder.clone()]).find_map(|path| same_in_other_case(&path))
    };
    there.ok().and_then(answer).unwrap_or(false)
}

/// The nearest folder above `at` that is there, or `at` itself.
fn existing(at: &Path) -> &Path {
    at.ancestors().map(named).find(|folder| folder.symlink_metadata().is_ok()).unwrap_or(Path::new("."))
}

/// The parent folder of a path.
fn folder_of(path: &Path) -> &Path {
    named(path.parent().unwrap_or(Path::new("")))
}

/// The empty path is the working folder.
fn named(folder: &Path) -> &Path {
    if folder.as_os_str().is_empty() { Path::new(".") } else { folder }
}

/// Whether `path` exists and can be written but not renamed over.
fn is_special(path: &Path) -> bool {
    path.metadata().is_ok_and(|there| !there.is_file() && !there.is_dir())
}

/// A temporary file beside its target.
struct Temporary {
    temporary: NamedTempFile,
    path: PathBuf,
}

fn write_temporary(path: &Path, fill: impl FnOnce(&mut File) -> Result<(), DatasetError>) -> Result<Temporary, DatasetError> {
    let failed = |source| DatasetError::io(path, source);
    let mut builder = tempfile::Builder::new();
    builder.prefix(PREFIX);
    #[cfg(unix)]
    {
        // As an ordinary file: the user's umask sets the read permissions.
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    let mut temporary = builder.tempfile_in(folder_of(path)).map_err(failed)?;
    remove_abandoned(&temporary, folder_of(path));
    fill(temporary.as_file_mut())?;
    temporary.as_file().sync_all().map_err(failed)?;
    Ok(Temporary { temporary, path: path.to_owned() })
}

/// Removes temporary files beside `new` that a killed run left behind. Those of runs that go on are younger: a file is written in
/// seconds.
fn remove_abandoned(new: &NamedTempFile, folder: &Path) {
    let changed = |path: &Path| path.symlink_metadata().ok().filter(Metadata::is_file)?.modified().ok();
    let Some(now) = changed(new.path()) else { return };
    for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
        let is_ours = entry.file_name().to_string_lossy().starts_with(PREFIX);
        let age = || now.duration_since(changed(&entry.path())?).ok();
        if is_ours && age().is_some_and(|age| age > ABANDONED) {
            // Whatever cannot be removed does no harm.
            let _ = std::fs::remove_file(entry.path());
        }
    }
}

impl Temporary {
    fn commit(self) -> Result<(), DatasetError> {
        let failed = |source| DatasetError::io(&self.path, source);
        self.temporary.persist(&self.path).map_err(|error| failed(error.error))?;
        #[cfg(unix)]
        File::open(folder_of(&self.path)).and_then(|folder| folder.sync_all()).map_err(failed)?;
        Ok(())
    }
}

/// New folders; those that are still empty are removed on drop.
#[derive(Default)]
struct NewFolders {
    made: Vec<PathBuf>,
}

impl NewFolders {
    fn make(&mut self, folder: &Path) -> Result<(), DatasetError> {
        let missing = folder.ancestors().map(named).take_while(|folder| !folder.exists());
        // The outermost first, so that they are removed from the innermost outwards.
        let missing: Vec<PathBuf> = missing.map(Path::to_owned).collect();
        self.made.extend(missing.into_iter().rev());
        std::fs::create_dir_all(folder).map_err(|source| DatasetError::io(folder, source))
    }
}

impl Drop for NewFolders {
    fn drop(&mut self) {
        for folder in self.made.iter().rev() {
            // A folder that is in use by now stays.
            let _ = std::fs::remove_dir(folder);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn either_all_files_are_written_or_none() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        std::fs::create_dir(at("taken")).unwrap();
        std::fs::write(at("taken/inside"), b"").unwrap();
        std::fs::write(at("file"), b"old").unwrap();
        // A file cannot be a folder.
        let failed = write_all(&[(at("new/a/one"), b"1".to_vec()), (at("file"), b"2".to_vec()), (at("file/two"), b"3".to_vec())]);
        assert!(failed.is_err());
        assert!(!at("new").exists() && std::fs::read(at("file")).unwrap() == b"old");
        write_all(&[(at("new/a/one"), b"1".to_vec()), (at("file"), b"2".to_vec())]).unwrap();
        assert_eq!((std::fs::read(at("new/a/one")).unwrap(), std::fs::read(at("file")).unwrap()), (b"1".to_vec(), b"2".to_vec()));
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 3);
    }

    #[test]
    fn files_of_killed_runs_are_removed_and_those_of_others_stay() {
        let folder = tempfile::tempdir().unwrap();
        let names = [".precomp-killed", ".precomp-running", "part.nc"];
        let old = File::open(folder.path()).unwrap().metadata().unwrap().modified().unwrap() - 2 * ABANDONED;
        for name in names {
            let file = File::create(folder.path().join(name)).unwrap();
            if name != ".precomp-running" {
                file.set_modified(old).unwrap();
            }
        }
        write_all(&[(folder.path().join("out"), b"new".to_vec())]).unwrap();
        assert_eq!(names.map(|name| folder.path().join(name).exists()), [false, true, true]);
    }

    #[test]
    fn a_folder_is_tried_without_a_trace() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("file"), b"").unwrap();
        assert!(try_folder(&folder.path().join("not/yet/there")).is_ok());
        assert!(try_folder(&folder.path().join("file/below")).is_err());
        // As the file system of this machine answers for a file of its own.
        std::fs::write(folder.path().join("Name"), b"").unwrap();
        assert_eq!(ignores_case(&folder.path().join("not/yet/there")), folder.path().join("nAME").exists());
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 2);
    }
}
