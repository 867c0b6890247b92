//! Sound inputs of every kind, and inputs that failed once.

use std::fmt::Write;
use std::path::Path;
use std::process::Command;
use std::sync::LazyLock;

use crate::archive;

/// Kind of an input, with its file name where the name tells the format.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    Program(&'static str),
    Log(&'static str),
    Reference(&'static str),
    Machine,
    Controller,
    Model,
}

impl Kind {
    pub fn file_name(self) -> &'static str {
        match self {
            Self::Program(name) | Self::Log(name) | Self::Reference(name) => name,
            Self::Machine => "machine.toml",
            Self::Controller => "controller.toml",
            Self::Model => "fuzzed.model",
        }
    }
}

/// A sound input.
pub struct Seed {
    pub kind: Kind,
    pub bytes: Vec<u8>,
}

const RS274: &str = "%\nO0001 (PART)\nN10 G21 G90 G17 G40\nG54 G0 X0 Y0 Z5 S8000 M3\nG1 Z-1 F900\nG64 P0.01\nG1 X3.5 F600\nG3 X3.5 Y4 I0 J2\n\
G4 P0.2\nG2 X0 Y4 R2 F400\nG91\nG1 X-1 Y-1.5\nG90\nG0 Z5\nG81 X1 Y1 Z-2 R1 F100\nG80\nM30\n%\n";
const MACROS: &str = "O100 sub\nG1 X[#1*2] Y#2 F600\nO100 endsub\nG21 G90 G54\nG0 X0 Y0\n#3=1\nO101 while [#3 LT 3]\nG1 X#3 Y[SIN[30]*#3] F300\n\
#3=[#3+1]\nO101 endwhile\nO102 if [#3 GT 2]\nG1 X0\nO102 endif\nO100 call [1.5] [2]\nM2\n";
const SINUMERIK: &str = "DEF REAL WIDTH=2.5\nR1=3 R2=R1*2\nG17 G90 G71 G94\nG54 G0 X0 Y0 Z5\nG1 Z=-1 F500\nWHILE R1>0\nG1 X=R1*1.5 Y=WIDTH F=600\n\
R1=R1-1\nENDWHILE\nIF R2==6 GOTOF ENDE\nTRANS X10\nG2 X5 Y5 CR=20\nENDE: G1 X0 Y0\nM30\n";
const DIALOGUE: &str = "0 BEGIN PGM PART MM\n1 BLK FORM 0.1 Z X+0 Y+0 Z-20\n2 TOOL CALL 5 Z S8000\n3 L X+0 Y+0 Z+5 R0 FMAX M3\n4 L Z-1 F500\n\
5 L X+3,5 F600\n6 CC X+3,5 Y+2\n7 C X+3,5 Y+4 DR+\n8 L X+0 Y+0\n9 END PGM PART MM\n";
const MACHINE: &str = include_str!("corpus/mill.toml");
const CONTROLLER: &str =
    "decimals = 4\nformat = \"g93\"\npoint_spacing_ms = 8.0\npath_tolerance_mm = 0.002\ndecimal_point = \"unit\"\n";

const PERIOD_S: f64 = 0.002;
const SAMPLES: usize = 250;

/// Commanded and actual X and Z, mm.
fn sample(k: usize) -> [f64; 4] {
    let t = k as f64 * PERIOD_S;
    let (x, z) = (|t: f64| 5.0 * (6.0 * t).sin(), |t: f64| 3.0 * (9.0 * t).cos());
    [x(t), x(t - 0.0015), z(t), z(t - 0.0015)]
}

/// Rows of a log, each from its number and values.
fn rows(row: impl Fn(usize, [String; 4]) -> String) -> String {
    (0..SAMPLES).map(|k| row(k, sample(k).map(|value| format!("{value:.6}")))).collect()
}

fn logs() -> [(&'static str, String); 8] {
    let signals = ["DES_POS|1", "ENC_POS|1", "DES_POS|3", "ENC_POS|3"];
    let mut edge =
        String::from("{\"Header\":{\"CycleTimeMs\":2,\"SignalListHFData\":[{\"Name\":\"CYCLE\",\"Address\":\"CYCLE\"}");
    for (index, signal) in signals.iter().enumerate() {
        let axis = if index < 2 { "X" } else { "Z" };
        write!(edge, ",{{\"Name\":\"{signal}\",\"Axis\":\"{axis}\",\"Address\":\"{signal}\"}}").unwrap();
    }
    edge += "]},\n\"Payload\":[{\"HFTimestamp\":\"2026-01-01T00:00:00Z\"}";
    edge += &rows(|k, [a, b, c, d]| format!(",\n{{\"HFData\":[[{},{a},{b},{c},{d}]]}}", 7000 + k));
    let mut trace = String::from("<?xml version=\"1.0\"?>\n<root><traceData><dataFrame>\n");
    for name in ["X set position", "X actual position", "Z set position", "Z actual position"] {
        writeln!(trace, "<dataSignal name=\"/Nck/{name}\" description=\"{name}\"/>").unwrap();
    }
    let time = |k: usize| k as f64 * PERIOD_S;
    trace += &rows(|k, [a, b, c, d]| format!("<rec time=\"{:.6}\" f1=\"{a}\" f2=\"{b}\" f3=\"{c}\" f4=\"{d}\"/>\n", time(k)));
    let scope = "Name\tScope\r\nFile\trun.svdx\r\n\r\nName\tX SetPos\tX ActPos\tZ SetPos\tZ ActPos\r\nUnit\tmm\tmm\tmm\tmm\r\n\
                 SampleTime[ms]\t2\t2\t2\t2\r\n\r\n";
    let labview = "LabVIEW Measurement\t\n***End_of_Header***\t\nSamples\t5\t\nDelta_X\t0.002\t\n***End_of_Header***\t\nX_Value\tx_cmd\tx_act\tz_cmd\tz_act\tComment\n";
    let pins = "joint.0.motor-pos-cmd;joint.0.motor-pos-fb;joint.2.motor-pos-cmd;joint.2.motor-pos-fb";
    [
        ("log.csv", format!("t,x_ref,x_act,z_ref,z_act\n{}", rows(|k, v| format!("{:.6},{}\n", time(k), v.join(","))))),
        ("run.txt", rows(|_, v| format!("{} 1 \n", v.join(" ")))),
        ("halscope.csv", format!("# Sampling period is 2000000 ns\n{pins}\n{}", rows(|_, v| v.join(";") + "\n"))),
        ("scope.csv", format!("{scope}{}EOF\r\n", rows(|k, v| format!("{}\t{}\r\n", 2 * k, v.join("\t"))))),
        (
            "run.jsonl",
            rows(|k, [a, b, c, d]| format!("{{\"t\":{:.6},\"x\":{{\"cmd\":{a},\"act\":{b}}},\"z\":[{c},{d}]}}\n", time(k))),
        ),
        ("run.lvm", format!("{labview}{}", rows(|k, v| format!("{:.6}\t{}\t\n", time(k), v.join("\t"))))),
        ("capture.json", edge + "],\n\"Footer\":{}}"),
        ("trace.xml", trace + "</dataFrame></traceData></root>\n"),
    ]
}

/// A file of `np.save`: records of four positions.
fn array() -> Vec<u8> {
    let fields = ["x_cmd", "x_act", "z_cmd", "z_act"].map(|name| format!("('{name}', '<f8')")).join(", ");
    let header = format!("{{'descr': [{fields}], 'fortran_order': False, 'shape': ({SAMPLES},), }}\n");
    let length = u16::try_from(header.len()).unwrap().to_le_bytes();
    let data: Vec<u8> = (0..SAMPLES).flat_map(sample).flat_map(f64::to_le_bytes).collect();
    [b"\x93NUMPY\x01\0", &length[..], header.as_bytes(), &data].concat()
}

fn reference() -> String {
    let row = |k: usize| {
        let [x, _, z, _] = sample(k);
        format!("{:.6},{x:.6},{:.6},{z:.6}\n", k as f64 * PERIOD_S, 0.5 * x)
    };
    format!("t,x,y,z\n{}", (0..SAMPLES).map(row).collect::<String>())
}

/// A short log and a model of the built-in machine, made by the command.
static MADE: LazyLock<[Vec<u8>; 3]> = LazyLock::new(|| {
    let folder = tempfile::tempdir().unwrap();
    precomp(folder.path(), "excite -o excitation --seconds 10");
    let mut paths: Vec<_> =
        std::fs::read_dir(folder.path().join("excitation")).unwrap().map(|entry| entry.unwrap().path()).collect();
    paths.retain(|path| path.extension().is_some_and(|ending| ending == "csv"));
    paths.sort();
    let mut logs = Vec::new();
    for (index, path) in paths.iter().enumerate() {
        precomp(folder.path(), &format!("simulate {} -o log{index}.csv --seed {index}", path.display()));
        logs.push(format!("log{index}.csv"));
    }
    precomp(folder.path(), &format!("train {} --machine ballscrew --predictor linear -o machine.model", logs.join(" ")));
    std::fs::write(folder.path().join("part.ngc"), RS274).unwrap();
    precomp(folder.path(), "simulate part.ngc -o log.parquet");
    ["machine.model", "log0.csv", "log.parquet"].map(|name| std::fs::read(folder.path().join(name)).unwrap())
});

fn precomp(folder: &Path, words: &str) {
    let output = Command::new(env!("CARGO_BIN_EXE_precomp")).args(words.split(' ')).current_dir(folder).output().unwrap();
    assert!(output.status.success(), "{words}: {}", String::from_utf8_lossy(&output.stderr));
}

/// Files that the commands need beside the input.
pub fn sound() -> Vec<(&'static str, Vec<u8>)> {
    let [model, log, _] = &*MADE;
    vec![
        ("part.ngc", RS274.into()),
        ("reference.csv", reference().into()),
        ("log.csv", log.clone()),
        ("machine.model", model.clone()),
        ("mill.toml", MACHINE.into()),
    ]
}

/// Seeds of every kind.
pub fn all() -> Vec<Seed> {
    let seed = |kind, bytes: &[u8]| Seed { kind, bytes: bytes.to_vec() };
    let [model, _, parquet] = &*MADE;
    let mut seeds: Vec<Seed> = [("part.ngc", RS274), ("macros.ngc", MACROS), ("part.mpf", SINUMERIK), ("part.h", DIALOGUE)]
        .map(|(name, text)| seed(Kind::Program(name), text.as_bytes()))
        .into();
    seeds.extend(logs().map(|(name, text)| seed(Kind::Log(name), text.as_bytes())));
    seeds.push(seed(Kind::Log("log.parquet"), parquet));
    seeds.push(seed(Kind::Log("log.npy"), &array()));
    seeds.push(seed(Kind::Reference("reference.csv"), reference().as_bytes()));
    seeds.push(seed(Kind::Machine, MACHINE.as_bytes()));
    seeds.push(seed(Kind::Machine, include_bytes!("../../machine/machines/xyzac.toml")));
    seeds.push(seed(Kind::Controller, CONTROLLER.as_bytes()));
    // Models have the most numbers.
    seeds.extend((0..3).map(|_| seed(Kind::Model, model)));
    seeds
}

/// Inputs that took gigabytes or minutes, or panicked, before they were refused: changes of a sound input.
pub fn failed_once() -> Vec<(String, Kind, Vec<u8>)> {
    let changed = |kind, text: &str, from: &str, to: &str| {
        assert!(text.contains(from), "{from}");
        (format!("{from} → {to}"), kind, text.replacen(from, to, 1).into_bytes())
    };
    let program = |from, to| changed(Kind::Program("part.ngc"), RS274, from, to);
    let machine = |from, to| changed(Kind::Machine, MACHINE, from, to);
    let mut inputs = vec![
        program("F600", "F0.0001"),
        program("G4 P0.2", "G4 P1000000000"),
        program("X3.5 F600", "X999999999 F600"),
        machine("jerk_mm_s3 = 20000.0", "jerk_mm_s3 = 0.01"),
        machine("acceleration_mm_s2 = 800.0", "acceleration_mm_s2 = 1e7"),
        machine("point_spacing_ms = 8.0", "point_spacing_ms = 1e-300"),
        changed(Kind::Controller, CONTROLLER, "point_spacing_ms = 8.0", "point_spacing_ms = 1e-300"),
        changed(Kind::Reference("reference.csv"), &reference(), "0.020000,", "0.020000,9"),
    ];
    let (manifest, weights) = archive::parts(&MADE[0]);
    let manifest = String::from_utf8(manifest).unwrap();
    for (key, value) in [
        ("first_lag", "-9223372036854775808"),
        ("first_lag", "9007199254740993"),
        ("first_lag", "-100000000"),
        ("period_s", "1e-300"),
        ("upper", "1e308"),
        ("raw_rms", "1e300"),
    ] {
        let at = manifest.find(&format!("\"{key}\": ")).expect(key) + key.len() + 4;
        let end = at + manifest[at..].find([',', '\n']).unwrap();
        let text = [&manifest[..at], value, &manifest[end..]].concat();
        inputs.push((format!("{key} = {value}"), Kind::Model, archive::model(text.as_bytes(), &weights)));
    }
    inputs
}
