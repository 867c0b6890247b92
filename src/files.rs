//! Files that a command reads and writes, checked against one another before any work.

use std::path::{Path, PathBuf};

use anyhow::Result;

use crate::kind::Kind;
use crate::output::Usage;
use crate::read::CURVE;
use crate::same_file::{is_same, resolved};

/// What a command reads and writes, each with the option that names it.
#[derive(Debug, Default)]
pub struct Files {
    read: Vec<Named>,
    written: Vec<Named>,
    /// Folders in which files of their own names are made.
    folders: Vec<Named>,
}

/// A path with the option that names it, and what is written there.
#[derive(Debug)]
struct Named {
    option: String,
    path: PathBuf,
    kind: Option<Kind>,
}

impl Files {
    /// The output of `--json`; `-` is standard output.
    pub fn of(json: Option<&Path>) -> Self {
        Self::default().writes("--json", json.filter(|path| *path != Path::new("-")), Kind::Figures)
    }

    /// An input; a built-in curve is none.
    pub fn reads<'a>(mut self, option: &str, path: impl Into<Option<&'a Path>>) -> Self {
        let path = path.into().filter(|path| !path.to_string_lossy().starts_with(CURVE));
        self.read.extend(path.map(|path| Named::new(option, path)));
        self
    }

    /// Inputs of one option.
    pub fn reads_all<'a>(self, option: &str, paths: impl IntoIterator<Item = &'a PathBuf>) -> Self {
        paths.into_iter().fold(self, |files, path| files.reads(option, &**path))
    }

    /// Logs, and what may lie beside them to say what their columns are.
    pub fn reads_logs<'a>(mut self, option: &str, paths: impl IntoIterator<Item = &'a PathBuf>) -> Self {
        for path in paths {
            self.read.push(Named::new(option, path));
            self.read.push(Named::new(&format!("the column file of {option}"), &datasets::side_file(path)));
        }
        self
    }

    /// A TOML file, unless `name` is built in.
    pub fn reads_described<'a>(self, option: &str, name: impl Into<Option<&'a str>>, built_in: &[&str]) -> Self {
        let name = name.into().filter(|name| !built_in.contains(name));
        self.reads(option, name.map(Path::new))
    }

    /// The machine file behind `--machine`.
    pub fn reads_machine<'a>(self, machine: impl Into<Option<&'a str>>) -> Self {
        self.reads_described("--machine", machine, &machine::BUILTIN_MACHINES.map(|(name, _)| name))
    }

    /// The recipe behind `--predictor`.
    pub fn reads_recipe<'a>(self, recipe: impl Into<Option<&'a str>>) -> Self {
        self.reads_described("--predictor", recipe, &training::Recipe::names().collect::<Vec<_>>())
    }

    /// The profile behind `--controller`.
    pub fn reads_controller<'a>(self, controller: impl Into<Option<&'a str>>) -> Self {
        self.reads_described("--controller", controller, &machine::BUILTIN_CONTROLLERS.map(|(name, _)| name))
    }

    /// An output.
    pub fn writes<'a>(mut self, option: &str, path: impl Into<Option<&'a Path>>, kind: Kind) -> Self {
        self.written.extend(path.into().map(|path| Named { kind: Some(kind), ..Named::new(option, path) }));
        self
    }

    /// A folder in which files are made.
    pub fn writes_in<'a>(mut self, option: &str, folder: impl Into<Option<&'a Path>>) -> Self {
        self.folders.extend(folder.into().map(|folder| Named::new(option, folder)));
        self
    }

    /// Refuses outputs that are inputs or other outputs, whatever links or spellings lead to them, and those that cannot be written.
    ///
    /// # Errors
    /// [`Usage`], which names the options and the file.
    pub fn check(&self) -> Result<()> {
        let outputs = || self.written.iter().chain(&self.folders);
        for output in outputs().filter(|output| !output.is_special()) {
            if let Some(input) = self.read.iter().find(|input| input.is(output)) {
                let Named { option, path, .. } = output;
                let why = format!("{option} {} would write over what {} reads", path.display(), input.option);
                return Err(Usage(format!("{why}; name another file for {option}")).into());
            }
        }
        for (index, output) in outputs().enumerate().filter(|(_, output)| !output.is_special()) {
            for other in outputs().take(index) {
                if other.is(output) {
                    let (a, b, path) = (&other.option, &output.option, output.path.display());
                    return Err(Usage(format!("{a} and {b} both write {path}; name a file of its own for each")).into());
                }
            }
            if let Some(file) = self.written.iter().find(|file| output.is_below(file)) {
                let (file_path, path) = (file.path.display(), output.path.display());
                let why = format!("{} {file_path} is a file and cannot hold {} {path}", file.option, output.option);
                return Err(Usage(format!("{why}; name another file for one of them")).into());
            }
        }
        self.written.iter().try_for_each(Named::check_file)?;
        self.folders.iter().try_for_each(|folder| folder.check_folder(&folder.path))
    }
}

impl Named {
    fn new(option: &str, path: &Path) -> Self {
        Self { option: option.to_owned(), path: path.to_owned(), kind: None }
    }

    /// Whether this is a device or pipe, which may be written by several.
    fn is_special(&self) -> bool {
        self.path.metadata().is_ok_and(|there| !there.is_file() && !there.is_dir())
    }

    /// Whether both are one file.
    fn is(&self, other: &Self) -> bool {
        is_same(&self.path, &other.path)
    }

    /// Whether this path leads through `file` as if it were a folder.
    fn is_below(&self, file: &Self) -> bool {
        let (path, file) = (resolved(&self.path), resolved(&file.path));
        path != file && path.starts_with(&file)
    }

    fn check_file(&self) -> Result<()> {
        let Self { option, path, kind } = self;
        if let Some((kind, other)) = kind.filter(|_| path.is_file()).and_then(|kind| Some((kind, kind.is_not(path)?))) {
            let (path, kind, other) = (path.display(), kind.what(), other.what());
            return Err(Usage(format!(
                "{option} {path} is there, by its name {other}, and what is written is {kind}; name another file"
            ))
            .into());
        }
        if *kind == Some(Kind::Table) && Kind::is_only_read(path) {
            let why = format!("{option} {}: logs and references are written as CSV and Parquet", path.display());
            return Err(Usage(format!("{why}; name a file that ends in .csv or .parquet")).into());
        }
        if path.as_os_str() == "-" {
            return Err(Usage(format!(
                "{option} -: files are not written to standard output; name a file, or ./- for one of this name"
            ))
            .into());
        }
        match path.metadata() {
            Ok(there) if there.is_dir() => {
                return Err(Usage(format!("{option} {} is a folder; name a file", path.display())).into());
            }
            Ok(there) if there.permissions().readonly() => {
                let why = format!("{option} {} is there and may not be written", path.display());
                return Err(Usage(format!("{why}; name another file or make it writable")).into());
            }
            _ if path.file_name().is_none() => {
                return Err(Usage(format!("{option} `{}` is no file name", path.display())).into());
            }
            _ if self.is_special() => return Ok(()),
            _ => {}
        }
        self.check_folder(path.parent().unwrap_or(Path::new("")))
    }

    fn check_folder(&self, folder: &Path) -> Result<()> {
        datasets::try_folder(folder).map_err(|error| {
            let (option, path) = (&self.option, self.path.display());
            Usage(format!("{option} {path} cannot be written: {error}; name another place")).into()
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refused(files: &Files) -> String {
        files.check().unwrap_err().to_string()
    }

    #[test]
    fn outputs_are_told_from_inputs_by_identity() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        std::fs::write(at("in"), b"").unwrap();
        std::fs::hard_link(at("in"), at("hard")).unwrap();
        std::fs::create_dir(at("sub")).unwrap();
        for name in ["in", "./in", "sub/../in", "hard"] {
            let error = refused(&Files::of(Some(&at(name))).reads("LOG", &*at("in")));
            assert!(error.contains("--json") && error.contains("LOG"), "{error}");
        }
        // What is not there yet is known by its resolved path.
        let error = refused(&Files::of(Some(&at("new/out"))).writes("-o", &*at("sub/../new/./out"), Kind::Table));
        assert!(error.contains("--json and -o both write"), "{error}");
        assert!(
            Files::of(Some(&at("new/out"))).writes("-o", &*at("new/other"), Kind::Table).reads("LOG", &*at("in")).check().is_ok()
        );
        assert!(!at("new").exists());
    }

    #[test]
    fn nothing_is_written_to_a_name_of_another_kind() {
        let folder = tempfile::tempdir().unwrap();
        let writes = |name: &str, kind: Kind| Files::default().writes("-o", &*folder.path().join(name), kind);
        for (name, kind) in
            [("part.nc", Kind::Table), ("part.NC", Kind::Model), ("log.csv", Kind::Report), ("m.toml", Kind::Path)]
        {
            assert!(writes(name, kind).check().is_ok(), "{name} is not there");
            std::fs::write(folder.path().join(name), b"kept").unwrap();
            let error = refused(&writes(name, kind));
            assert!(error.contains(kind.what()) && error.contains("name another file"), "{error}");
        }
        for (name, kind) in [("run.csv", Kind::Path), ("part.nc", Kind::Path), ("run.out", Kind::Table), ("model", Kind::Model)] {
            std::fs::write(folder.path().join(name), b"").unwrap();
            assert!(writes(name, kind).check().is_ok(), "{name}");
        }
    }

    #[test]
    fn what_cannot_be_written_is_said_before() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        std::fs::write(at("file"), b"").unwrap();
        assert!(refused(&Files::of(Some(folder.path()))).contains("is a folder"));
        assert!(refused(&Files::of(Some(&at("file/below")))).contains("not a folder"));
        assert!(refused(&Files::of(Some(&at("new"))).writes("-o", &*at("new/below"), Kind::Table)).contains("cannot hold"));
        // A format that is read alone.
        assert!(refused(&Files::of(None).writes("-o", &*at("run.NPZ"), Kind::Table)).contains("written as CSV and Parquet"));
        let mut only = at("file").metadata().unwrap().permissions();
        only.set_readonly(true);
        std::fs::set_permissions(at("file"), only).unwrap();
        assert!(refused(&Files::of(Some(&at("file")))).contains("may not be written"));
        #[cfg(unix)]
        assert!(Files::of(Some(Path::new("/dev/null"))).writes("-o", Path::new("/dev/null"), Kind::Table).check().is_ok());
    }
}
