//! Programs with parameters, branches, loops and subprograms.

use crate::common::{Folder, without_mark};

/// Constants at the head, a decided branch, a subprogram without feed moves in a file of its own.
const CONSTANTS: &str = "G21 G90 G17 G64 P0.002\n#<depth>=-1 #<r>=10\nG0 X0 Y0 Z5\no<start> call [#<r>]\nG1 Z#<depth> F900\n\
G1 X[#<r>*2] F2400\nG3 X[#<r>*2] Y[2*#<r>] I0 J#<r>\no1 if [#<r> GT 5]\nG1 X0\no1 else\nG1 X-99\no1 endif\nG1 Y0\nG0 Z5\nM2\n";
const START: &str = "o<start> sub\nM3 S8000\nG0 X0 Y0\nG0 Z[#1/5]\no<start> endsub\n";
/// Feed moves in a loop in a subprogram.
const LOOP: &str = "G21 G90 G17 G64 P0.002\nG0 X0 Y0 Z5\no<pocket> sub\n#2=0\no2 while [#2 LT 3]\n#2=[#2+1]\nG1 X[#1*#2] Y0 F2400\n\
G3 X0 Y[#1*#2] I[-#1*#2] J0\no2 endwhile\no<pocket> endsub\nG1 Z-1 F600\no<pocket> call [8]\nG1 X0 Y0\nM2\n";
const WORDS: [&str; 6] = ["compensate", "part.ngc", "-m", "machine.model", "-o", "out.ngc"];

fn folder_with(program: &str) -> Folder {
    let folder = Folder::with_model();
    folder.write("part.ngc", program);
    folder.write("start.ngc", START);
    folder
}

#[test]
fn a_program_with_constants_and_decided_branches_is_compensated_in_place() {
    let folder = folder_with(CONSTANTS);
    let figures = folder.figures(&WORDS);
    assert_eq!(figures["left_alone"]["feed_length_share"], 0.0, "{figures}");
    let out = without_mark(&folder.read("out.ngc"));
    assert!(out.starts_with("G21 G90 G17 G64 P0.002\n#<depth>=-1 #<r>=10\nG0 X0 Y0 Z5\no<start> call [#<r>]\nG1X"), "{out}");
    assert!(out.contains("\no1 if [#<r> GT 5]\nG1X") && out.contains("\no1 else\nG1 X-99\no1 endif\nG1X"), "{out}");
    assert!(!out.contains("G1 X[") && out.ends_with("\nG0 Z5\nM2\n"), "{out}");
    assert_eq!(folder.read("start.ngc"), START);
}

#[test]
fn feed_moves_that_run_several_times_are_compensated_in_an_expanded_program() {
    let folder = folder_with(LOOP);
    let said = folder.fails(1, &WORDS);
    assert!(said.contains("a feed move runs several times\n --> part.ngc:7:1\n") && said.contains("give --expand"), "{said}");
    let figures = folder.figures(&[&WORDS[..], &["--expand"]].concat());
    assert_eq!(figures["left_alone"]["feed_length_share"], 0.0, "{figures}");
    let out = folder.read("out.ngc");
    for comment in ["(from sub pocket, line 7, run 1)", "(from sub pocket, line 7, run 3)", "(from line 13)"] {
        assert!(out.contains(comment), "{out}");
    }
    assert!(!out.contains('#') && !out.contains('['), "{out}");
}

#[test]
fn what_runs_in_another_file_is_simulated_where_it_is_found() {
    let folder = folder_with("G21 G90 G0 X0 Y0 Z0\nM98 P12\nG1 X0 Y0\nM30\n");
    let words = ["simulate", "part.ngc", "--dialect", "fanuc", "-o", "log.csv", "--expand"];
    assert!(folder.fails(1, &words).contains("an effect on path or frame that is not known"));
    folder.write("O0012.nc", "O12\nG1 X20 F1000\nY5\nM99\n");
    assert!(folder.prints(&words).contains("part.ngc (expanded) on the machine"));
}

#[test]
fn a_called_file_is_never_written_over() {
    let folder = folder_with("G21 G90 G94\nG0 X0. Y0. Z0.\nM98 P12\nG1 X0. Y0. F1000\nM30\n");
    let called = "O12\nG1 X20. F1000\nY5.\nM99\n";
    folder.write("O0012.nc", called);
    let words = ["compensate", "part.ngc", "-m", "machine.model", "--dialect", "fanuc", "--expand", "-o", "O0012.nc"];
    let error = folder.fails(2, &words);
    assert!(error.contains("O0012.nc would be written over"), "{error}");
    assert_eq!(folder.read("O0012.nc"), called);
}
