//! Canonical calls of LinuxCNC's stand-alone interpreter, `rs274`.

use std::io::Read;
use std::path::Path;
use std::process::{Command, Stdio};

/// Work offsets, G28 and G30 positions of the oracle's machine: numbers of LinuxCNC parameters with their values, mm.
const PARAMETERS: &[(u32, f64)] = &[
    (5161, 1.5),
    (5162, -2.5),
    (5163, 60.0),
    (5181, -3.0),
    (5183, 55.0),
    (5220, 1.0),
    (5221, 12.5),
    (5222, -7.25),
    (5223, 3.0),
    (5241, 100.0),
    (5243, -5.0),
    (5262, 40.125),
    (5381, 8.0),
];
/// Bounds of a run: a program may run without end (LinuxCNC's own tests hold some). Its longest sample takes a second and prints 6 MB.
const MOST_SECONDS: &str = "20";
const MOST_BYTES: u64 = 200_000_000;
const TOOLS: &str = "T1 P1 D6 Z12.5\nT2 P2 D3 Z7\nT3 P3 D0.1 Z20\n";

/// A canonical call.
#[derive(Debug, Clone, PartialEq)]
pub struct Call {
    /// The N word of the block that made the call.
    pub line: Option<u32>,
    pub name: String,
    /// Arguments as printed.
    pub text: String,
    /// Those of them that are numbers.
    pub numbers: Vec<f64>,
}

/// Whether the interpreter is installed.
pub fn is_installed() -> bool {
    Path::new("/usr/bin/rs274").exists()
}

/// Canonical calls of a program; the message of the interpreter where it refuses the program. `block_delete`: the position of the switch.
pub fn run(program: &[u8], block_delete: bool) -> Result<Vec<Call>, String> {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let parameters: String = (5161..=5390)
        .map(|number| {
            let value = PARAMETERS.iter().find(|(known, _)| *known == number).map_or(0.0, |(_, value)| *value);
            format!("{number}\t{value}\n")
        })
        .collect();
    std::fs::write(path("a.ngc"), program).unwrap();
    std::fs::write(path("a.tbl"), TOOLS).unwrap();
    // The interpreter writes the parameters back.
    std::fs::write(path("a.var"), parameters).unwrap();
    let mut command = Command::new("timeout");
    command.args([MOST_SECONDS, "/usr/bin/rs274", "-t", "a.tbl", "-v", "a.var", "-g"]);
    command.args(block_delete.then_some("-b")).args(["a.ngc"]);
    command.stdout(Stdio::piped()).stderr(std::fs::File::create(path("stderr")).unwrap());
    // The tool table is mapped into a file below HOME, which runs at the same time must not share.
    let mut child = command.current_dir(folder.path()).env("HOME", folder.path()).spawn().unwrap();
    let mut printed = Vec::new();
    // Reading ends at the bound; the interpreter then fails at its closed output.
    child.stdout.take().unwrap().take(MOST_BYTES).read_to_end(&mut printed).unwrap();
    let status = child.wait().unwrap();
    let said = String::from_utf8_lossy(&std::fs::read(path("stderr")).unwrap()).trim().replace('\n', " | ");
    let calls = String::from_utf8_lossy(&printed);
    if status.success() { Ok(calls.lines().filter_map(call).collect()) } else { Err(said) }
}

/// `  12 N40    STRAIGHT_FEED(1.0000, …)`.
fn call(line: &str) -> Option<Call> {
    let (head, rest) = line.split_at_checked(line.find(" N")?)?;
    head.trim().parse::<u32>().ok()?;
    // No space follows a number of more than five digits.
    let rest = rest.trim_start();
    let (number, call) = rest.split_at_checked(1 + rest.get(1..)?.find(|c: char| !(c.is_ascii_digit() || c == '.'))?)?;
    let (name, text) = call.trim().split_once('(')?;
    let text = text.strip_suffix(')')?.to_owned();
    let numbers = text.split([',', ' ']).filter_map(|part| part.trim().parse().ok()).collect();
    Some(Call { line: number[1..].parse().ok(), name: name.to_owned(), text, numbers })
}
