//! Files that are no milling programs: every command says what they are and what to give instead.

use crate::common::{Folder, text};

const PART: &str = "G21 G90\nG0 X0 Y0 Z0\nG1 X10 F600\nG1 Y10\nM2\n";

#[test]
fn every_command_says_what_a_file_is_instead_of_a_program() {
    let folder = Folder::with_model();
    folder.write("part.nc", PART);
    folder.figures(&["simulate", "part.nc", "-o", "run.csv"]);
    for (name, content, said) in [
        ("empty.nc", "", "empty"),
        ("print.gcode", "M104 S200\nG28\nG1 X10 Y10 E1.5 F1500\n", "3D printer"),
        ("pen.plt", "IN;SP1;PU0,0;PD100,0;\n", "HP-GL"),
        ("turn.nc", "G50 S2000\nG96 S200\nG0 X50 Z2\nG1 Z-30 F.2\n", "lathe"),
        ("part.dxf", "0\nSECTION\n2\nHEADER\n", "DXF"),
        ("part.cls", "PARTNO A\nGOTO/ 1, 2, 3\n", "APT"),
        ("mill.ini", "[EMC]\nVERSION = 1.1\n[TRAJ]\nAXES = 3\n", "INI"),
        ("part.bin", "G1 X1\0\u{1}\0\u{2}Y", "binary"),
    ] {
        folder.write(name, content);
        for words in [
            &["simulate", name, "-o", "x.csv"][..],
            &["predict", name, "-m", "machine.model", "-o", "x.csv"],
            &["compensate", name, "-m", "machine.model", "-o", "x.nc"],
            &["measure", "run.csv", "--desired", name, "-m", "machine.model"],
            &["refine", name, "--log", "run.csv", "-m", "machine.model", "-o", "x.nc"],
            &["compare", name, "-m", "machine.model"],
        ] {
            let error = folder.fails(1, words);
            assert!(error.starts_with(&format!("error: {name}: the ")) && error.contains(said), "{words:?}: {error}");
            assert!(error.contains("; ") && error.matches("error:").count() == 1, "{words:?}: {error}");
        }
    }
    assert!(!folder.path("x.csv").exists() && !folder.path("x.nc").exists());
}

#[test]
fn a_program_with_a_byte_order_mark_is_compensated_and_keeps_it() {
    let folder = Folder::with_model();
    folder.write("part.nc", format!("\u{feff}{PART}"));
    let figures = folder.figures(&["compensate", "part.nc", "-m", "machine.model", "-o", "out.nc"]);
    assert_eq!(figures["changed"], true);
    assert_eq!(figures["left_alone"]["feed_length_share"], 0.0, "{figures}");
    let out = folder.read("out.nc");
    assert!(out.starts_with("\u{feff}(PRECOMP ") && out.matches('\u{feff}').count() == 1, "{out}");
}

#[test]
fn text_in_utf_16_is_named() {
    let folder = Folder::new();
    let bytes: Vec<u8> = format!("\u{feff}{PART}").encode_utf16().flat_map(u16::to_le_bytes).collect();
    folder.write("part.nc", bytes);
    let error = text(&folder.precomp(&["simulate", "part.nc", "-o", "x.csv"]).stderr);
    assert!(error.contains("UTF-16; save it as UTF-8"), "{error}");
}

#[test]
fn samples_that_are_no_reference_are_named() {
    let folder = Folder::with_model();
    folder.write("run.jsonl", "{\"t\": 0, \"x_cmd\": 1}\n{\"t\": 0.002, \"x_cmd\": 2}\n");
    let said = folder.fails(2, &["compensate", "run.jsonl", "-m", "machine.model", "-o", "out.nc"]);
    assert!(said.contains("run.jsonl holds samples, and no part program") && said.contains("CSV or Parquet"), "{said}");
}
