//! Content that is no milling program is recognised, and every milling program is taken for one.

use std::path::{Path, PathBuf};

use gcode::{Foreign, parse, recognise};

const TURRET: Foreign = Foreign::Lathe("no Y; tools with offsets, without M6");

fn kind(content: impl Into<Vec<u8>>) -> Option<Foreign> {
    recognise(&parse(content))
}

fn utf16(text: &str, mark: bool, bytes: fn(u16) -> [u8; 2]) -> Vec<u8> {
    let mark = mark.then_some('\u{feff}');
    mark.into_iter().chain(text.chars()).flat_map(|c| bytes(c as u16)).collect()
}

#[test]
fn every_kind_is_recognised_in_a_small_file() {
    let stl = [&[7_u8; 80][..], &1_u32.to_le_bytes(), &[3; 50]].concat();
    let iges = format!("{:<72}S      1\n{:<72}G      1\n", "A model", "1H,,1H;,4HSLOT");
    let cases: Vec<(&[u8], Foreign)> = vec![
        (b"", Foreign::Empty),
        (b"\xef\xbb\xbf\r\n \n", Foreign::Empty),
        (b"\0\0\x1a", Foreign::Empty),
        (b"G1 X1\0\x07\x01\0Y2", Foreign::Binary),
        (b"\x01\x02MAZATROL\0\0\x03", Foreign::Mazatrol),
        (b"%PDF-1.7\n", Foreign::Document),
        (b"\x89PNG\r\n\x1a\n", Foreign::Document),
        (b"<?xml version=\"1.0\"?>\n<a/>", Foreign::Markup),
        (b"  0\nSECTION\n  2\nHEADER\n", Foreign::Model("DXF")),
        (b"999\nby a CAD\n0\nSECTION\n", Foreign::Model("DXF")),
        (b"AC1032\0\0", Foreign::Model("DWG")),
        (b"ISO-10303-21;\nHEADER;\n", Foreign::Model("STEP")),
        (b"solid part\n facet normal 0 0 1\n  outer loop\n", Foreign::Model("STL")),
        (&stl, Foreign::Model("STL")),
        (iges.as_bytes(), Foreign::Model("IGES")),
        (b"** beam\nST\n  1\n  HEA200\nBO\n  v 10.0 20.0 5.0\nEN\n", Foreign::Dstv),
        (b"%PLATE G71 *\nN10 G30 G17 X+0 Y+0 Z-20*\n", Foreign::HeidenhainIso),
        (b"N10 G0 X0\n(CALL 5)\nM30\n(SUB 5)\nN20 G1 X1 F100\n(RET)\n", Foreign::Fagor),
        (b"N10 G0 X0\nM30\n(SUB 5)\nN20 G1 X1 F100\n( RET )\n", Foreign::Fagor),
        (b"N10 G0 X0\nN20 (RPT N10,N15) N3\n", Foreign::Fagor),
        (b"N10 G0 X0\nN20 (IF P1 GT 5 GOTO N10)\n", Foreign::Fagor),
        (b"N10 G0 X0\n(pcall 5, P0=2)\n", Foreign::Fagor),
        (b"(UAO,1)\nG0 X0 Y0\n(UTO,1,X200.,Y100.)\nG1 X1 F100\n", Foreign::Parenthesised),
        (b"G0 X0\n(rot, -45)\nG1 X1 F100\n", Foreign::Parenthesised),
        (b"N10 G0 X0\n(DFS,P1)\nG1 X1 F100\n(ENS)\nN50 (CLS,P1)\n", Foreign::Parenthesised),
        (b"G0 X0\n(UAO,2)\nG1 X1 F100\n", Foreign::Parenthesised),
        (b"UNo. MAT INITIAL-Z ATC MODE\n0 S45C 50. 0\nUNo. UNIT ADD\n", Foreign::Mazatrol),
        (b"PARTNO PLATE\nLOADTL/1\nGOTO/ 1.0, 2.0, 3.0\n", Foreign::CutterLocation),
        (b"$$ by a CAM system\nFEDRAT/200,MMPM\nGOTO / 0,0,0\n", Foreign::CutterLocation),
        (b"IN;SP1;PU0,0;PD100,0,100,100;PU;\n", Foreign::Plotter),
        (b"IN;\nSP1;\nPU 10 10;\nPD 20 20;\n", Foreign::Plotter),
        (b"M104 S200\nG28\nG1 X10 Y10 E1.5 F1500\n", Foreign::Printer),
        (b"M82\nM109 S200\nG92 E0\nG0 X1\nG1 X10 E.4\n", Foreign::Printer),
        (b"%\nO1\nG50 S2000\nG96 S200\nG0 X50. Z2.\nG1 Z-30. F.2\n", Foreign::Lathe("no Y; G96")),
        (b"G50 S2000\nG97 S800\nG0 X50. Z2.\nG1 Z-30. F.2\n", Foreign::Lathe("no Y; G50 S")),
        (
            b"G0 X50 Z2\nG71 U2 R1\nG71 P10 Q20 U.4 W.1 F.2\nN10 G0 X20\nN20 G1 Z-30\n",
            Foreign::Lathe("no Y; G70 to G73 with P and Q"),
        ),
        (b"G7 G18\nG1 X20 Z-3 F100\n", Foreign::Lathe("no Y; G7")),
        (b"T0101\nG0 X50. Z2.\nG1 W-30. F.2\n", Foreign::Lathe("no Y; tools with offsets, U and W")),
        (b"M6 T1012\nG0 X50. Z2.\nG1 W-30. F.2\n", Foreign::Lathe("no Y; tools with offsets, U and W")),
        (b"T3\nG0 X50. Z2.\nG1 Z-30. F200.\nG28 U0. W0.\nM30\n", Foreign::Lathe("no Y; G28 with U or W")),
        (b"T0101.1\nG0 X50. Z2.\nG1 Z-30. F200.\n", TURRET),
        // Without any G: the modal turning cycle G90 would be read as moves, an arc as one in XY.
        (b"T0101\nG97 S2000 M3\nG98\nG0 X52. Z2.\nG90 X48. Z-30. F200.\nX46.\nM30\n", TURRET),
        (b"T101\nG97 S1500 M3\nG54\nG98\nG0 X18. Z2.\nG1 X20. Z-20. F300.\nG2 X30. Z-25. R6.\nM30\n", TURRET),
        (b"T0312\nG0 X10. Z2.\nG1 Z-1. F100\n", TURRET),
        (b"T010101\nG0 X10. Z2.\nG1 Z-1. F100\n", TURRET),
        (
            b"G28 U0. W0.\nG98 G17\nT0505\nG97 S3000 M3\nG0 X80. Y0. C0.\nG1 X20. F1000.\nG3 X40. Y20. R60.\nZ2.\nM30\n",
            Foreign::Lathe("tools with offsets, and U, W or G96"),
        ),
        (b"$0=10\n$1=25\n$100=250.000\n", Foreign::Settings),
        (b"%\nN01320A1P99000A2P99000\nN01321A1P-99000A2P0\nN01322A1P0\n%\n", Foreign::Settings),
        (b"N10000 $MN_AXCONF_MACHAX_NAME_TAB[0]=\"X1\"\nN1 $MC_A=1\n$MA_B=2\n", Foreign::Settings),
        (b"5161\t0.000000\n5162\t0.000000\n5163\t-1.5\n", Foreign::Settings),
        (b"[EMC]\nVERSION = 1.1\n[TRAJ]\nAXES = 3\n", Foreign::Ini),
        (b"loadrt motmod\nnet x-pos <= joint.0.pos\nsetp pid.x.Pgain 10\n", Foreign::Hal),
        (b"; tools\nT1 P1 D6.35 Z+2.5 ;drill\nT2 P2 D3 Z0\n", Foreign::ToolTable),
    ];
    for (content, expected) in cases {
        assert_eq!(kind(content), Some(expected), "{}", String::from_utf8_lossy(content));
    }
    for bytes in [u16::to_le_bytes, u16::to_be_bytes] {
        for mark in [true, false] {
            assert_eq!(kind(utf16("G21 G90\nG1 X1 F100\nM30\n", mark, bytes)), Some(Foreign::Utf16));
        }
    }
}

#[test]
fn a_message_names_the_kind_and_the_remedy() {
    let text = Foreign::Model("STEP").to_string();
    assert_eq!(text, "the file is a STEP model; generate toolpaths in a CAM system and give the part program that it writes");
    assert!(Foreign::Lathe("G96").to_string().contains("(G96)"));
}

#[test]
fn milling_programs_with_a_word_of_another_kind_are_milling_programs() {
    for text in [
        "\u{feff}G21 G90\nG1 X1 F100\nM30\n",
        "\0\0\0%\nO1\nG1 X1 F100\nM30\n%\0\0\x1a",
        "G71\nG1 X1 Z1 F100\n",
        "G96 S100\nG1 X1 Y2 Z1 F100\n",
        "G18 G8\nG96 S100\nG1 X1 Z1 F100\n",
        "(MAZATROL FUSION 640)\nG1 X1 F100\n",
        "(BEGIN PGM A MM)\nG1 X1 F100\n",
        "(SUB 1)\n(P1=10)\n(CALL 555-1234)\n(IF P1 IS LARGE)\nG1 X1 F100\n",
        "M109 P1\nG1 X1 Y1 F100\n",
        "T1 M6\nG1 X1 F100\n",
        "T0101 M6\nG1 X1 Z1 F100\n",
        "T0000\nG1 X1 Z1 F100\n",
        "T0101\nM98 P9001\nG43 H1 G0 X0 Z2\nG1 Z-3 F200\nX52\nM30\n",
        "T0404\nM98 P9006\nG43 H4 G0 X0 Y0 Z2\nW-10.\nG1 X5 F100\n",
        "T0404\nG0 X0 Y0 Z2\nG73 X5. Z-10. R2. Q2. P500 F100\n",
        "T1234\nG1 X1 Z1 F100\n",
        "T102\nG1 X1 Z1 F100\n",
        "T0101\nG1 X1 Y1 Z1 F100\n",
        "[#1 = 2]\nG1 X1 F100\n",
        "N1 GOTO 10\nG1 X1\nN10 M30\n",
        "0 BEGIN PGM A MM\n1 L X+1 F100\n2 END PGM A MM\n",
        "PU\nG1 X1\n",
        "#1=5\n#2=6\n#3=7\nG1 X1 F100\n",
        "G10 L2 P1 X5 Y6 Z7\nG1 X1 F100\n",
    ] {
        assert_eq!(kind(text), None, "{text}");
    }
}

/// Files of a folder and the folders in it that end as programs do.
fn programs(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
        let path = entry.path();
        if path.is_dir() && !path.is_symlink() {
            programs(&path, found);
        } else if path.extension().is_some_and(|ending| ["ngc", "nc", "gcode"].iter().any(|known| ending == *known)) {
            found.push(path);
        }
    }
}

#[test]
fn no_published_program_is_taken_for_something_else() {
    let mut found = Vec::new();
    for folder in [concat!(env!("CARGO_MANIFEST_DIR"), "/../../shared/data/gcode"), "/usr/share/linuxcnc", "/usr/share/axis"] {
        programs(Path::new(folder), &mut found);
    }
    for path in &found {
        let name = path.to_string_lossy().to_lowercase();
        let is_lathe = ["lathe", "turn", "thread", "g76", "fac", "bor"].iter().any(|word| name.contains(word));
        match kind(std::fs::read(path).unwrap()) {
            None => {}
            Some(Foreign::Lathe(_)) if is_lathe => {}
            Some(other) => panic!("{name}: {other}"),
        }
    }
    println!("{} published programs", found.len());
}
