//! The command, run as its user would.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::LazyLock;

use serde_json::Value;

/// First seed of the noise in the logs of training.
pub const TRAINING_SEED: usize = 50_001;

/// Lines, a helix, full and half circles, in a program as a user would write it.
pub const PART: &str = "%\r\nO0001 (BRACKET)\r\nN10 G21 G90 G17 G40 G49 G80\r\nN20 T1 M6\r\nN30 G0 G54 X-30. Y-20. S8000 M3\r\nN40 G0 Z5. (ABOVE)\r\n\
N50 G1 Z-1. F900 M8\r\nN60 G1 X30. F2400\r\nN70 G3 X30. Y20. I0. J20.\r\nN80 G1 X-30.\r\nN90 G3 X-30. Y-20. Z-3. J-20.\r\nN100 G2 I10. J10.\r\n\
N110 G0 Z5. M9\r\nN120 G81 X0. Y0. Z-5. R2. F100\r\nN130 G80\r\nN140 M30\r\n%\r\n";

/// A model and the excitation that it was trained on.
pub struct Trained {
    pub model: Vec<u8>,
    /// Name and content of the reference trajectories.
    pub excitation: Vec<(String, Vec<u8>)>,
}

/// 40 s of the machine `ballscrew`, predictor `staged`. Trained once: training takes longer than any test on the model.
pub static BALLSCREW: LazyLock<Trained> = LazyLock::new(|| {
    let folder = Folder::new();
    let model = std::fs::read(folder.train("40", "staged")).unwrap();
    let excitation = csv_files(&folder.path("excitation"));
    let content = |path: PathBuf| (path.file_name().unwrap().to_string_lossy().into_owned(), std::fs::read(&path).unwrap());
    Trained { model, excitation: excitation.into_iter().map(content).collect() }
});

/// A folder of its own for a test, removed when dropped.
pub struct Folder(pub tempfile::TempDir);

impl Folder {
    pub fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    /// With the model of [`BALLSCREW`] as `machine.model`.
    pub fn with_model() -> Self {
        let folder = Self::new();
        folder.write("machine.model", &BALLSCREW.model);
        folder
    }

    /// With the model of [`BALLSCREW`] as `machine.model` and [`PART`] as `part.nc`.
    pub fn with_model_and_part() -> Self {
        let folder = Self::with_model();
        folder.write("part.nc", PART);
        folder
    }

    pub fn write(&self, name: &str, content: impl AsRef<[u8]>) {
        std::fs::write(self.path(name), content).unwrap();
    }

    pub fn read(&self, name: &str) -> String {
        std::fs::read_to_string(self.path(name)).unwrap()
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// Runs `precomp` with these words in the folder.
    pub fn precomp(&self, words: &[&str]) -> Output {
        Command::new(env!("CARGO_BIN_EXE_precomp")).args(words).current_dir(self.0.path()).output().unwrap()
    }

    /// Runs it, expects success, and returns its JSON figures.
    pub fn figures(&self, words: &[&str]) -> Value {
        let mut all = words.to_vec();
        all.extend(["--json", "figures.json"]);
        let output = self.precomp(&all);
        assert!(output.status.success(), "{words:?}: {}{}", text(&output.stdout), text(&output.stderr));
        serde_json::from_slice(&std::fs::read(self.path("figures.json")).unwrap()).unwrap()
    }

    /// Runs it, expects success, and returns what it printed on standard output.
    pub fn prints(&self, words: &[&str]) -> String {
        let output = self.precomp(words);
        assert!(output.status.success(), "{words:?}: {}", text(&output.stderr));
        text(&output.stdout)
    }

    /// Runs it, expects this exit status, and returns what it said on standard error.
    pub fn fails(&self, status: i32, words: &[&str]) -> String {
        let output = self.precomp(words);
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(status), "{words:?}: {}{said}", text(&output.stdout));
        assert!(!said.contains("panicked"), "{said}");
        said
    }

    /// Excites and logs the built-in machine, and trains a model of it.
    pub fn train(&self, seconds: &str, predictor: &str) -> PathBuf {
        self.train_on("ballscrew", seconds, predictor)
    }

    /// The same on another built-in machine.
    pub fn train_on(&self, machine: &str, seconds: &str, predictor: &str) -> PathBuf {
        self.figures(&["excite", "--machine", machine, "-o", "excitation", "--seconds", seconds]);
        let mut logs = Vec::new();
        for path in csv_files(&self.path("excitation")) {
            let log = format!("log-{}", path.file_name().unwrap().to_string_lossy());
            // Runs that are judged have other noise: their seeds are small.
            let seed = (TRAINING_SEED + logs.len()).to_string();
            self.figures(&["simulate", &path.to_string_lossy(), "--machine", machine, "-o", &log, "--seed", &seed]);
            logs.push(log);
        }
        let mut words = vec!["train"];
        words.extend(logs.iter().map(String::as_str));
        words.extend(["--machine", machine, "--predictor", predictor, "-o", "machine.model"]);
        self.figures(&words);
        self.path("machine.model")
    }
}

/// The CSV files in a folder by name. File systems list them in any order, and the order gives the seeds of the noise.
pub fn csv_files(folder: &Path) -> Vec<PathBuf> {
    let mut files: Vec<PathBuf> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.retain(|path| path.extension().is_some_and(|ending| ending == "csv"));
    files.sort();
    files
}

pub fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// A file of the shared real data; `None`, said aloud, where a clone has none. Under CI it must be there.
pub fn shared(name: &str) -> Option<PathBuf> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data").join(name);
    if path.exists() {
        return Some(path);
    }
    assert_ne!(std::env::var("CI").as_deref(), Ok("true"), "{} is missing", path.display());
    println!("skipped: ../shared is not there");
    None
}

/// A compensated program without the comment at its head.
pub fn without_mark(program: &str) -> String {
    let of_mark = |line: &&str| line.contains("PRECOMP ") || line.contains("ORIGINAL SHA256") || line.contains(", CYCLE UP TO ");
    program.split_inclusive('\n').filter(|line| !of_mark(line)).collect()
}
