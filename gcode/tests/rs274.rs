//! The interpreter of LinuxCNC makes the same canonical calls of a program and of the same program written flat.
//!
//! `rs274` and the sample programs are read where LinuxCNC is installed; elsewhere the tests say that they are skipped.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

use gcode::{Dialect, expand, parse};

const INTERPRETER: &str = "/usr/bin/rs274";
const SAMPLES: &str = "/usr/share/linuxcnc/ncfiles";
/// Canonical calls have four decimals. Written values have nine, so the last digit may round otherwise.
const LAST_DIGIT: f64 = 1.1e-4;

static ALONE: Mutex<()> = Mutex::new(());

fn is_installed() -> bool {
    let found = Path::new(INTERPRETER).is_file();
    if !found {
        println!("skipped: {INTERPRETER} is not there");
    }
    found
}

/// Canonical calls of a program, one a line, without line numbers and messages; `None` if the interpreter refuses it.
fn calls(program: &Path) -> Option<Vec<String>> {
    let folder = program.parent()?;
    let name = program.file_name()?;
    // Each run has parameters of its own: none.
    let parameters = scratch("parameters").join("empty.var");
    std::fs::write(&parameters, "").ok()?;
    let mut command = Command::new("timeout");
    command.args(["5", INTERPRETER, "-g", "-v"]).arg(&parameters).arg(name).current_dir(folder);
    // Two interpreters at a time disturb each other.
    let alone = ALONE.lock().unwrap_or_else(PoisonError::into_inner);
    let out = command.output().ok()?;
    drop(alone);
    let _ = std::fs::remove_dir_all(parameters.parent()?);
    let text = String::from_utf8_lossy(&out.stdout).into_owned();
    let call = |line: &str| {
        let rest = line.trim_start().trim_start_matches(|c: char| c.is_ascii_digit()).trim_start();
        let call = rest.strip_prefix('N')?.trim_start_matches(|c: char| c.is_ascii_digit() || c == '.').trim();
        (!["COMMENT", "MESSAGE", "LOG"].iter().any(|silent| call.starts_with(silent))).then(|| call.to_owned())
    };
    let calls: Vec<String> = text.lines().filter_map(call).collect();
    calls.iter().any(|call| call.starts_with("PROGRAM_END") || call.starts_with("FINISH")).then_some(calls)
}

fn agree(a: &str, b: &str) -> bool {
    let numbers = |call: &str| -> Vec<f64> {
        call.split(|c: char| !(c.is_ascii_digit() || c == '.' || c == '-')).filter_map(|piece| piece.parse().ok()).collect()
    };
    let name = |call: &str| call.split('(').next().unwrap_or_default().to_owned();
    let (left, right) = (numbers(a), numbers(b));
    name(a) == name(b) && left.len() == right.len() && left.iter().zip(&right).all(|(a, b)| (a - b).abs() < LAST_DIGIT)
}

/// Writes a program flat beside nothing else, and compares. `None`: refused by either.
fn compare(original: &Path) -> Option<usize> {
    let bytes = std::fs::read(original).ok()?;
    let folder = original.parent()?;
    let expected = calls(original)?;
    let files = |name: &str| std::fs::read(folder.join(name)).ok();
    let flat = expand(&parse(bytes), &Dialect::LinuxCnc.into(), &files).ok()?;
    let path = scratch("flat").join("flat.ngc");
    std::fs::write(&path, &flat).ok()?;
    let found = calls(&path).unwrap_or_default();
    let _ = std::fs::remove_dir_all(path.parent()?);
    let first = expected.iter().zip(&found).position(|(a, b)| !agree(a, b));
    if let Some(at) = first {
        panic!("{}: {} is {}\n{}", original.display(), expected[at], found[at], String::from_utf8_lossy(&flat));
    }
    assert_eq!(expected.len(), found.len(), "{}", original.display());
    Some(expected.len())
}

/// A new folder.
fn scratch(name: &str) -> PathBuf {
    static NEXT: AtomicUsize = AtomicUsize::new(0);
    let number = NEXT.fetch_add(1, Ordering::Relaxed);
    let folder = std::env::temp_dir().join(format!("precomp-rs274-{}-{name}-{number}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder for temporary files");
    folder
}

#[test]
fn samples_of_linuxcnc_are_the_same_flat() {
    if !is_installed() || !Path::new(SAMPLES).is_dir() {
        return;
    }
    let (mut folders, mut same, mut flowing) = (vec![PathBuf::from(SAMPLES)], 0, 0);
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).expect("a folder") {
            let path = entry.expect("an entry").path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|ending| ending == "ngc") && compare(&path).is_some() {
                same += 1;
                let text = std::fs::read_to_string(&path).unwrap_or_default().to_lowercase();
                flowing += usize::from([" call", "while", "repeat", "if ["].iter().any(|flow| text.contains(flow)));
            }
        }
    }
    println!("{same} programs are the same flat, {flowing} of them with branches, loops or calls");
    assert!(same > 20 && flowing > 5);
}

/// Random numbers of a fixed seed (Knuth's MMIX generator).
struct Random(u64);

impl Random {
    fn below(&mut self, limit: u64) -> u64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) % limit
    }

    fn expression(&mut self, depth: u32) -> String {
        if depth == 0 {
            return match self.below(4) {
                0 => format!("#{}", 1 + self.below(6)),
                1 => format!("{}.{}", self.below(9), self.below(100)),
                2 => format!("-{}", 1 + self.below(9)),
                _ => "#<_scale>".to_owned(),
            };
        }
        let (a, b) = (self.expression(depth - 1), self.expression(depth - 1));
        match self.below(16) {
            0..=3 => format!("[{a} + {b}]"),
            4..=5 => format!("[{a} - {b} * 0.5]"),
            6 => format!("[{a} MOD 7]"),
            7 => format!("SIN[{a}*10]"),
            8 => format!("ATAN[{a}]/[ABS[{b}]+1]"),
            9 => format!("[{a} GT {b}]"),
            10 => format!("[[{a} LT 3] AND [{b} NE 2]]"),
            11 => format!("ROUND[{a}]"),
            12 => format!("[ABS[{a}] ** 0.5]"),
            13 => format!("FIX[{a}/3]"),
            14 => format!("SQRT[ABS[{b}]]"),
            _ => format!("[{a} EQ {b} OR {a} GE 1]"),
        }
    }

    fn body(&mut self, label: &mut u32, depth: u32) -> String {
        let mut text = String::new();
        for _ in 0..1 + self.below(3) {
            *label += 1;
            let (own, value) = (*label, self.expression(2));
            match if depth == 0 { self.below(3) } else { self.below(9) } {
                0 => text.push_str(&format!("G1 X{value} Y[#2/3] (c{own})\n")),
                1 => text.push_str(&format!("#{}={value} #<_scale>=[#3 MOD 5]\n", 1 + self.below(6))),
                2 => text.push_str(&format!("G0 Z#{} G1 A{value}\n", 1 + self.below(6)).replace(" G1", "")),
                3 => {
                    let (yes, no) = (self.body(label, depth - 1), self.body(label, depth - 1));
                    text.push_str(&format!(
                        "o{own} if [{value} GT 0.5]\n{yes}o{own} elseif [#1 LT 2]\n{no}o{own} else\nG1 Z1\no{own} endif\n"
                    ));
                }
                4 => {
                    let (count, inner) = (self.below(4), self.body(label, depth - 1));
                    text.push_str(&format!("o{own} repeat [{count}.3]\n{inner}o{own} endrepeat\n"));
                }
                5 => {
                    let (count, inner) = (1 + self.below(3), self.body(label, depth - 1));
                    let counter = format!("#<n{own}>");
                    text.push_str(&format!(
                        "{counter}=0\no{own} while [{counter} LT {count}]\n{counter}=[{counter}+1]\no9{own} if [#4 GT 30]\no{own} break\no9{own} endif\n\
                         {inner}o{own} endwhile\n"
                    ));
                }
                6 => {
                    let (count, inner) = (1 + self.below(3), self.body(label, depth - 1));
                    let counter = format!("#<n{own}>");
                    text.push_str(&format!(
                        "{counter}=0\no{own} do\n{counter}=[{counter}+1]\no8{own} if [{counter} EQ 2]\no{own} continue\no8{own} endif\n\
                         {inner}o{own} while [{counter} LT {count}]\n"
                    ));
                }
                _ => {
                    let second = self.expression(1);
                    text.push_str(&format!("o<part> call [{value}] [{second}]\nG1 Y#<_value> Z#<_value_returned>\n"));
                }
            }
        }
        text
    }

    fn program(&mut self) -> String {
        let mut text = "G21 G90 G94 F100\n#<_scale>=2\n".to_owned();
        (1..=6).for_each(|n| text.push_str(&format!("#{n}={}\n", self.below(9))));
        let mut label = 100;
        let inner = self.body(&mut label, 0);
        text.push_str(&format!(
            "o<part> sub\n{inner}o<deep> if [#1 GT 2]\no<part> return [#1*2]\no<deep> endif\no<last> if [#2 LT 0]\no<part> call [3] [1]\n\
             o<last> endif\no<part> endsub\n"
        ));
        text.push_str(&self.body(&mut label, 3));
        text + "M2\n"
    }
}

#[test]
fn generated_programs_are_the_same_flat() {
    if !is_installed() {
        return;
    }
    let (mut random, mut same) = (Random(7), 0);
    let place = scratch("generated");
    for number in 0..150 {
        let path = place.join(format!("generated{number}.ngc"));
        std::fs::write(&path, random.program()).expect("a temporary file");
        same += usize::from(compare(&path).is_some());
    }
    let _ = std::fs::remove_dir_all(&place);
    println!("{same} of 150 generated programs run and are the same flat");
    assert!(same > 100, "{same}");
}

/// What one program shows that the others do not.
const WRITTEN: [(&str, &str); 8] = [
    (
        "recursion",
        "F100\no<r> sub\n#2=[#1-1]\nG1 Y#1\no1 if [#1 GT 0]\no<r> call [#2]\no1 endif\nG1 Z#2\no<r> endsub\no<r> call [3]\nM2\n",
    ),
    (
        "computed",
        "F100\no101 sub\nG1 X#1\no101 endsub\no102 sub\nG1 X-#1\no102 endsub\n#1=0\no1 repeat [2]\n#1=[#1+1]\no[100+#1] call [5]\no1 endrepeat\nM2\n",
    ),
    ("later", "F100\no<l> call [2]\nM2\no<l> sub\nG1 X#1 Y#3 Z[#1*#2]\no<l> endsub\n"),
    (
        "locals",
        "F100\n#1=1 #2=2 #<a>=3\no<s> sub\n#<a>=9\nG1 X#1 Y#2 Z#<a>\n#1=7\no<s> endsub\no<s> call [5]\nG1 X#1 Y#2 Z#<a>\nM2\n",
    ),
    ("swap", "F100\n#1=1 #2=2\n#1=#2 #2=#1 G1 X#1 Y#2\nG1 X#1 Y#2\n#3=1 #3=[#3+1]\nM2\n"),
    ("codes", "#1=1 #2=90\nG[#1] G[#2] X1 F[50*2] S[1000/3] M[2+1]\nG[80+1] X3 Z-1 R1 L[1+1]\nG80 G[60+1.1]\nM2\n"),
    ("arcs", "F100 G0 X10 Y0\n#1=10\no1 repeat [4]\nG3 X[-#1] Y0 I[-#1] J0\nG3 X#1 Y0 I#1 J0\n#1=[#1]\no1 endrepeat\nM2\n"),
    ("fanuc", "G21 F100\nM98 P7 L2\nG1 Y5\nM2\nO7\nG91 G1 X1\nG90\nM99\n"),
];

#[test]
fn written_programs_are_the_same_flat() {
    if !is_installed() {
        return;
    }
    let place = scratch("written");
    for (name, text) in WRITTEN {
        let path = place.join(format!("{name}.ngc"));
        std::fs::write(&path, text).expect("a temporary file");
        assert!(compare(&path).is_some_and(|calls| calls > 10), "{name} was not compared");
    }
    let _ = std::fs::remove_dir_all(&place);
}
