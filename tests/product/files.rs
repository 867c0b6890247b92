//! No output is an input or another output, and a refused command leaves nothing behind.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use crate::common::{Folder, text};

/// Everything below a folder: its bytes, or nothing for a folder.
fn content(folder: &Path) -> BTreeMap<PathBuf, Option<Vec<u8>>> {
    let mut found = BTreeMap::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            found.extend(content(&path));
            found.insert(path, None);
        } else {
            let bytes = std::fs::read(&path).unwrap();
            found.insert(path, Some(bytes));
        }
    }
    found
}

/// Inputs of every kind, which no command comes to read: their content does not matter.
fn with_inputs() -> Folder {
    let folder = Folder::new();
    for name in ["part.nc", "run.csv", "run.csv.columns", "ref.csv", "mill.model", "mill.toml", "control.toml", "recipe.toml"] {
        std::fs::write(folder.path(name), name).unwrap();
    }
    std::fs::create_dir(folder.path("sub")).unwrap();
    folder
}

/// Commands with an output that is an input: the words, and the option and the input that the message names.
const OVERWRITING: [(&str, &str, &str); 36] = [
    ("simulate part.nc -o part.nc", "-o", "INPUT"),
    ("simulate part.nc -o run.csv --json part.nc", "--json", "INPUT"),
    ("simulate part.nc -o out.csv --against ref.csv --json ref.csv", "--json", "--against"),
    ("simulate part.nc --against ref.csv -o ref.csv", "-o", "--against"),
    ("simulate part.nc --machine mill.toml -o mill.toml", "-o", "--machine"),
    ("train run.csv -o run.csv", "-o", "LOG"),
    ("train run.csv -o run.csv.columns", "-o", "column file of LOG"),
    ("train ref.csv -o ref.csv.columns", "-o", "column file of LOG"),
    ("train ref.csv run.csv -o new.model --json run.csv", "--json", "LOG"),
    ("train run.csv --machine mill.toml -o mill.toml", "-o", "--machine"),
    ("train run.csv --predictor recipe.toml -o recipe.toml", "-o", "--predictor"),
    ("train run.csv --from mill.model -o mill.model", "-o", "--from"),
    ("train run.csv -o new.model --checkpoints run.csv", "--checkpoints", "LOG"),
    ("train run.csv -o new.model --report run.csv", "--report", "LOG"),
    ("predict part.nc -m mill.model --report part.nc", "--report", "INPUT"),
    ("predict part.nc -m mill.model -o mill.model", "-o", "-m"),
    ("predict part.nc -m mill.model -o part.nc", "-o", "INPUT"),
    ("predict part.nc -m mill.model --json mill.model", "--json", "-m"),
    ("compensate part.nc -m mill.model -o part.nc", "-o", "INPUT"),
    ("compensate part.nc -m mill.model -o mill.model", "-o", "-m"),
    ("compensate part.nc -m mill.model -o out.nc --json part.nc", "--json", "INPUT"),
    ("compensate part.nc -m mill.model -o out.nc --report part.nc", "--report", "INPUT"),
    ("compensate part.nc -m mill.model -o out.nc --machine mill.toml --report mill.toml", "--report", "--machine"),
    ("compensate part.nc -m mill.model --controller control.toml -o control.toml", "-o", "--controller"),
    ("compensate part.nc -m mill.model --reference run.csv -o run.csv", "-o", "--reference"),
    ("measure run.csv --json run.csv", "--json", "LOG"),
    ("measure run.csv --desired part.nc --machine mill.toml --json part.nc", "--json", "--desired"),
    ("measure run.csv -m mill.model --json mill.model", "--json", "-m"),
    ("measure run.csv -m mill.model --report mill.model", "--report", "-m"),
    ("refine part.nc --log run.csv -o out.nc --report run.csv", "--report", "--log"),
    ("refine part.nc --log run.csv -o run.csv", "-o", "--log"),
    ("refine part.nc --log run.csv -o out.nc --json part.nc", "--json", "INPUT"),
    ("refine part.nc --log run.csv --ran out.nc -o out.nc", "-o", "--ran"),
    ("compare part.nc ref.csv -m mill.model --report ref.csv", "--report", "INPUT"),
    ("demo --predictor recipe.toml --json recipe.toml", "--json", "--predictor"),
    ("reproduce table-1 --machine mill.toml --json mill.toml", "--json", "--machine"),
];

#[test]
fn no_output_is_an_input() {
    let folder = with_inputs();
    let before = content(folder.0.path());
    for (words, output, input) in OVERWRITING {
        let said = folder.fails(2, &words.split(' ').collect::<Vec<_>>());
        assert!(said.contains(output) && said.contains(input) && said.contains("name another file"), "{words}: {said}");
        assert_eq!(content(folder.0.path()), before, "{words}");
    }
}

#[test]
fn outputs_are_told_from_inputs_whatever_leads_to_them() {
    let folder = with_inputs();
    std::fs::hard_link(folder.path("part.nc"), folder.path("hard.nc")).unwrap();
    let mut others = vec!["./part.nc", "sub/../part.nc", "hard.nc"];
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink("part.nc", folder.path("soft.nc")).unwrap();
        std::os::unix::fs::symlink(".", folder.path("here")).unwrap();
        others.extend(["soft.nc", "here/part.nc"]);
    }
    let whole = folder.path("part.nc").to_string_lossy().into_owned();
    others.push(&whole);
    for other in others {
        let words = ["compensate", "part.nc", "-m", "mill.model", "-o", "out.nc", "--report", other];
        assert!(folder.fails(2, &words).contains("--report"), "{other}");
        let words = ["compensate", other, "-m", "mill.model", "-o", "part.nc"];
        assert!(folder.fails(2, &words).contains("-o part.nc"), "{other}");
        assert_eq!(std::fs::read(folder.path("part.nc")).unwrap(), b"part.nc", "{other}");
    }
}

#[test]
fn no_output_is_another_output() {
    let folder = with_inputs();
    let before = content(folder.0.path());
    for (words, a, b) in [
        ("simulate part.nc -o out.csv --json sub/../out.csv", "-o", "--json"),
        ("train run.csv -o new.model --json new.model", "-o", "--json"),
        ("train run.csv -o new --checkpoints new", "-o", "--checkpoints"),
        ("predict part.nc -m mill.model -o out.csv --json out.csv", "-o", "--json"),
        ("compensate part.nc -m mill.model -o out.nc --report out.nc", "-o", "--report"),
        ("compensate part.nc -m mill.model -o out.nc --report page --json page", "--report", "--json"),
        ("compensate part.nc -m mill.model -o out --report out/page.html", "-o", "--report"),
        ("refine part.nc --log run.csv -o out.nc --json ./out.nc", "-o", "--json"),
        ("compare part.nc --report page --json page", "--report", "--json"),
        ("demo --out new --json new/machine.model", "--out", "--json"),
        ("excite -o new --json new/03-sharp.nc", "-o", "--json"),
        ("excite -o new --json new", "-o", "--json"),
    ] {
        let said = folder.fails(2, &words.split(' ').collect::<Vec<_>>());
        assert!(said.contains(a) && said.contains(b), "{words}: {said}");
        assert_eq!(content(folder.0.path()), before, "{words}");
    }
}

#[test]
fn what_cannot_be_written_is_refused_before_any_work() {
    let folder = with_inputs();
    let before = content(folder.0.path());
    // Each of these would succeed but for the one output.
    for words in [
        "simulate curve:circle -o out.csv --json part.nc/figures.json",
        "simulate curve:circle -o out.csv --json sub",
        "simulate curve:circle -o part.nc/out.csv --json figures.json",
        "excite --seconds 10 -o part.nc",
        "excite --seconds 10 -o new/folder --json part.nc/figures.json",
        "demo --seconds 10 --out new --json sub",
        "compare curve:circle --report sub",
    ] {
        let said = folder.fails(2, &words.split(' ').collect::<Vec<_>>());
        assert!(said.contains("folder"), "{words}: {said}");
        assert_eq!(content(folder.0.path()), before, "{words}");
    }
}

#[test]
fn a_refused_command_leaves_nothing_behind() {
    let folder = Folder::new();
    std::fs::write(folder.path("other.csv"), "t,a\n0,0\n0.002,0\n0.004,0\n0.006,0\n").unwrap();
    let before = content(folder.0.path());
    for (status, words) in [
        (2, "simulate curve:circle --against curve:nothing -o new/run.csv --json new/figures.json"),
        (1, "simulate curve:circle --against other.csv -o new/run.csv"),
        (1, "excite --seconds 10000 -o new"),
        (1, "compare other.csv --report new/page.html --json new/figures.json"),
    ] {
        folder.fails(status, &words.split(' ').collect::<Vec<_>>());
        assert_eq!(content(folder.0.path()), before, "{words}");
    }
}

#[test]
fn missing_folders_are_made_and_devices_are_written() {
    let folder = Folder::new();
    let said = folder.precomp(&["simulate", "curve:circle", "-o", "new/a/run.csv", "--json", "new/b/figures.json"]);
    assert!(said.status.success() && folder.path("new/a/run.csv").is_file() && folder.path("new/b/figures.json").is_file());
    #[cfg(unix)]
    {
        use std::os::unix::fs::FileTypeExt;
        let said = folder.precomp(&["simulate", "curve:circle", "-o", "/dev/null", "--json", "/dev/null"]);
        assert!(said.status.success() && Path::new("/dev/null").metadata().unwrap().file_type().is_char_device());
    }
}

#[test]
fn folders_texts_and_standard_output_are_told_apart_from_logs_models_and_files() {
    let folder = Folder::with_model();
    folder.write("part.nc", "G21 G90\nG0 X0 Y0 Z0\nG1 X10 F600\nG1 Y10\nM2\n");
    folder.write("mill.toml", "name = \"mill\"\n");
    for (words, said) in [
        (&["measure", "."][..], "it is a folder; name the logs in it"),
        (&["measure", "mill.toml"], ".toml is a machine file or settings, and no log"),
        (&["train", "machine.model", "-o", "x.model"], ".model is a model, and no log"),
        (&["compensate", "part.nc", "-m", "machine.model", "-o", "-"], "files are not written to standard output"),
    ] {
        let error = folder.fails(2, words);
        assert!(error.contains(said), "{words:?}: {error}");
    }
    let checked = text(&folder.precomp(&["check", ".", "mill.toml"]).stdout);
    assert!(checked.contains("it is a folder") && checked.contains("and no log") && checked.contains("not fit"), "{checked}");
    let error = folder.fails(1, &["compensate", "part.nc", "-m", "mill.toml", "-o", "out.nc"]);
    assert!(error.contains("is a text and not a model"), "{error}");
    assert!(!folder.path("-").exists() && !folder.path("out.nc").exists());
}
