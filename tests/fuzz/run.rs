//! Mutated inputs in the command, under limits.

use std::path::Path;
use std::process::{Command, Output};
use std::sync::LazyLock;

use crate::seeds::{self, Kind};

/// Limits of a run: CPU time, s, which minutes of machining may take, and address space, KiB.
const SECONDS: u64 = 120;
const KIBIBYTES: u64 = 4 << 20;

/// A folder with a sound input of every kind.
static SOUND: LazyLock<tempfile::TempDir> = LazyLock::new(|| {
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes) in seeds::sound() {
        std::fs::write(folder.path().join(name), bytes).unwrap();
    }
    folder
});

/// What became of a run.
pub struct Outcome {
    words: String,
    output: Output,
}

impl Outcome {
    /// Why this is neither success nor a refusal with its reason.
    fn fault(&self, input: &[u8]) -> Option<String> {
        let (out, err) = (text(&self.output.stdout), text(&self.output.stderr));
        // A warning may quote the input.
        let quoted = text(input).to_ascii_lowercase();
        let is_none = |none: &str, word: &str| word.eq_ignore_ascii_case(none) && !quoted.contains(none);
        let of_number = |word: &str| ["inf", "nan", "infinity"].iter().any(|none| is_none(none, word));
        let fault = match self.output.status.code() {
            None => "was killed: it took too long",
            Some(0) if out.split(|c: char| !c.is_alphanumeric()).any(of_number) => "printed a number that is none",
            Some(0) => return None,
            Some(1 | 2) if err.contains("error: ") && !err.contains("panicked") => return None,
            Some(_) => "panicked or ran out of memory",
        };
        Some(format!("{} {fault}\n{err}{out}", self.words))
    }

    /// The same where success is a fault too.
    pub fn not_refused(&self, input: &[u8]) -> Option<String> {
        let done = || self.output.status.success().then(|| format!("{} was not refused", self.words));
        self.fault(input).or_else(done)
    }
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// Runs the commands that read such an input, and returns what went wrong.
pub fn run(kind: Kind, bytes: &[u8]) -> Option<String> {
    let faults: Vec<String> = outcomes(kind, bytes).iter().filter_map(|outcome| outcome.fault(bytes)).collect();
    let input = || text(bytes).chars().take(2000).collect::<String>();
    (!faults.is_empty()).then(|| format!("{}\nthe input:\n{}", faults.join("\n"), input()))
}

/// What became of the commands that read such an input.
pub fn outcomes(kind: Kind, bytes: &[u8]) -> Vec<Outcome> {
    let folder = tempfile::tempdir().unwrap();
    let name = kind.file_name();
    std::fs::write(folder.path().join(name), bytes).unwrap();
    let sound = |name: &str| SOUND.path().join(name).display().to_string();
    let (part, reference, log) = (sound("part.ngc"), sound("reference.csv"), sound("log.csv"));
    let (model, machine) = (sound("machine.model"), sound("mill.toml"));
    let commands = match kind {
        Kind::Program(_) => {
            vec![format!("predict {name} -m {model}"), format!("compensate {name} -m {model} --machine {machine} -o out.nc")]
        }
        Kind::Log(_) => {
            vec![format!("measure {name}"), format!("train {name} {log} --machine {machine} --predictor linear -o out.model")]
        }
        Kind::Reference(_) => {
            vec![format!("predict {name} -m {model} -o out.csv"), format!("compensate {name} -m {model} -o out.csv")]
        }
        Kind::Machine => vec![
            format!("simulate {reference} --machine {name} -o out.csv"),
            format!("compensate {part} -m {model} --machine {name} -o out.nc"),
        ],
        Kind::Controller => vec![format!("compensate {part} -m {model} --controller {name} -o out.nc")],
        Kind::Model => {
            vec![format!("predict {part} -m {name} --work-offset 0,0,0"), format!("compensate {reference} -m {name} -o out.csv")]
        }
    };
    commands.into_iter().map(|words| limited(words, folder.path())).collect()
}

fn limited(words: String, folder: &Path) -> Outcome {
    let script = format!("ulimit -v {KIBIBYTES} && ulimit -t {SECONDS} && exec \"$0\" \"$@\"");
    let mut command = Command::new("sh");
    command.args(["-c", &script, env!("CARGO_BIN_EXE_precomp")]).args(words.split(' ')).current_dir(folder);
    Outcome { output: command.output().unwrap(), words }
}
