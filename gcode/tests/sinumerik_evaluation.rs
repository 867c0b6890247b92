//! Variables, branches, loops and subprograms of SINUMERIK programs.

use gcode::{Dialect, Fixed, GcodeError, MoveKind, Options, Shiftable, Toolpath, evaluate, expand, interpret, parse};

const START: &str = "G17 G54 G90 G71 G94\nG0 X0 Y0 Z0\nF600\n";

/// Subprogram files of all tests.
fn files(name: &str) -> Option<Vec<u8>> {
    let text = match name {
        "DRILL.SPF" => "G0 Z5\nG0 Z-1\nM17\n",
        "slot.spf" => {
            "PROC SLOT(REAL LENGTH, INT PASSES=2, VAR REAL DEPTH)\nDEF INT I\nFOR I=1 TO PASSES\nDEPTH=DEPTH-1\nG1 Z=DEPTH\nG1 X=LENGTH\nG1 X0\nENDFOR\nRET\n"
        }
        "L20.SPF" => "R10=R10+1\nG0 Y=R10\nRET\n",
        "_N_KEEP_SPF" => "PROC KEEP SAVE\nG91\nM17\n",
        "LOST.MPF" => "G0 X1\nGOTOF WEG\nM30\n",
        _ => return None,
    };
    Some(text.into())
}

fn read(text: &str) -> Result<Toolpath, GcodeError> {
    let mut program = Dialect::Sinumerik.read(parse(format!("{START}{text}")));
    let options = Options::from(Dialect::Sinumerik);
    evaluate(&mut program, &options, &files)?;
    interpret(&program, &options)
}

/// X, Y, Z of the ends of all moves behind the start.
fn ends(text: &str) -> Vec<[f64; 3]> {
    let path = read(text).unwrap_or_else(|error| panic!("{text}\n{error}"));
    path.moves.iter().skip(1).map(|step| step.end.nominal_mm().map(|value| (value * 1e6).round() / 1e6)).collect()
}

fn xs(text: &str) -> Vec<f64> {
    ends(text).into_iter().map(|[x, _, _]| x).collect()
}

fn refused(text: &str) -> String {
    read(text).expect_err(text).to_string()
}

#[test]
fn branches_and_loops_are_followed() {
    for (text, expected) in [
        ("R1=5\nIF R1>3\nG0 X1\nELSE\nG0 X2\nENDIF\nG0 X9", vec![1.0, 9.0]),
        ("R1=2\nIF R1>3\nG0 X1\nELSE\nG0 X2\nENDIF", vec![2.0]),
        ("R1=1\nIF R1==1\nIF R1==2\nG0 X1\nELSE\nG0 X2\nENDIF\nELSE\nG0 X3\nENDIF", vec![2.0]),
        ("DEF INT I\nFOR I=1 TO 3\nG0 X=I*10\nENDFOR\nG0 X=I", vec![10.0, 20.0, 30.0, 4.0]),
        ("DEF INT I\nFOR I=3 TO 1\nG0 X=I\nENDFOR", vec![]),
        ("R1=0\nWHILE R1<2\nR1=R1+1\nG0 X=R1\nENDWHILE", vec![1.0, 2.0]),
        ("R1=0\nREPEAT\nR1=R1+1\nG0 X=R1\nUNTIL R1>=2", vec![1.0, 2.0]),
        ("R1=0\nLOOP\nR1=R1+1\nIF R1>2 GOTOF OUT\nG0 X=R1\nENDLOOP\nOUT: G0 X9", vec![1.0, 2.0, 9.0]),
        ("R1=0\nN10 R1=R1+1\nN20 G0 X=R1\nN30 IF R1<3 GOTOB N10\nN40 G0 X9", vec![1.0, 2.0, 3.0, 9.0]),
        ("GOTOF ENDE\nG0 X1\nENDE:\nG0 X2", vec![2.0]),
        ("R1=2\nCASE R1 OF 1 GOTOF AA 2 GOTOF BB DEFAULT GOTOF CC\nAA: G0 X1\nBB: G0 X2\nCC: G0 X3", vec![2.0, 3.0]),
        ("r1=1\nif (r1==1) and (r1<5) gotof ziel\nG0 X1\nziel: G0 X2", vec![2.0]),
    ] {
        assert_eq!(xs(text), expected, "{text}");
    }
}

#[test]
fn sections_are_repeated() {
    for (text, expected) in [
        ("LBL: G0 X=IC(1)\nG0 X=IC(10)\nREPEAT LBL P=2\nG0 X0", vec![1.0, 11.0, 12.0, 22.0, 23.0, 33.0, 0.0]),
        ("LBL: G0 X=IC(1)\nG0 X=IC(10)\nREPEATB LBL P3", vec![1.0, 11.0, 12.0, 13.0, 14.0]),
        ("AA: G0 X=IC(1)\nBB: G0 X=IC(2)\nG0 X=IC(4)\nREPEAT AA BB", vec![1.0, 3.0, 7.0, 8.0, 10.0]),
        ("AA: G0 X=IC(1)\nENDLABEL:\nG0 X=IC(4)\nREPEAT AA P=1", vec![1.0, 5.0, 6.0]),
    ] {
        assert_eq!(xs(text), expected, "{text}");
    }
}

#[test]
fn variables_have_types_and_levels() {
    for (text, expected) in [
        ("DEF REAL A=2.5, B\nG0 X=A Y=B", vec![2.5]),
        ("DEF INT A=2.6\nG0 X=A", vec![3.0]),
        ("DEF BOOL OK=TRUE\nIF OK\nG0 X1\nENDIF", vec![1.0]),
        ("DEF REAL LIST[3]\nLIST[1]=7\nG0 X=LIST[1]+LIST[2]", vec![7.0]),
        ("R[2+1]=8\nG0 X=R3", vec![8.0]),
        ("R1=3 R2=4\nG0 X=SQRT(POT(R1)+POT(R2))", vec![5.0]),
    ] {
        assert_eq!(xs(text), expected, "{text}");
    }
}

#[test]
fn subprograms_are_read_from_files_and_archives() {
    assert_eq!(ends("DRILL\nG0 X1"), [[0.0, 0.0, 5.0], [0.0, 0.0, -1.0], [1.0, 0.0, -1.0]]);
    assert_eq!(ends("CALL \"_N_DRILL_SPF\"").len(), 2);
    assert_eq!(ends("EXTCALL \"DRILL\"").len(), 2);
    assert_eq!(ends("DRILL P3").len(), 6);
    assert_eq!(ends("R10=5\nL20 P2\nG0 X=R10").last(), Some(&[7.0, 7.0, 0.0]));
    let archive = "HOLE(3)\nM30\n%_N_HOLE_SPF\nPROC HOLE(REAL D)\nG0 X=D\nM17\n";
    assert_eq!(xs(archive), [3.0]);
    let text = "DEF REAL T=-0.5\nSLOT(20,2,T)\nG0 Z=T";
    let mut program = Dialect::Sinumerik.read(parse(format!("{START}{text}")));
    let options = Options::from(Dialect::Sinumerik);
    evaluate(&mut program, &options, &files).expect("it is evaluated");
    let error = interpret(&program, &options).expect_err("feed moves in another file");
    assert!(error.to_string().contains("a feed move is in a subprogram of another file"), "{error}");
    let flat = expand(&program, &options, &files).expect("it is written");
    let flat = String::from_utf8(flat).expect("ASCII");
    let path = interpret(&Dialect::Sinumerik.read(parse(flat.as_str())), &options).expect(&flat);
    let lines: Vec<f64> =
        path.moves.iter().filter(|step| step.kind == MoveKind::Line).map(|step| step.end.nominal_mm()[2]).collect();
    assert_eq!(lines, [-1.5, -1.5, -1.5, -2.5, -2.5, -2.5], "{flat}");
    assert_eq!(path.moves.last().expect("a move").end.nominal_mm()[2], -2.5, "{flat}");
    assert!(flat.contains("; from slot.spf, line 5, run 2\n"), "{flat}");
}

#[test]
fn what_only_the_control_knows_leaves_moves_alone() {
    use Shiftable::{No, Yes};
    let shiftable = |text: &str| {
        let path = read(text).unwrap_or_else(|error| panic!("{text}\n{error}"));
        path.moves.iter().skip(1).map(|step| step.shiftable).collect::<Vec<_>>()
    };
    let (run_time, unknown) = (No(Fixed::RunTime), No(Fixed::UnknownStart));
    assert_eq!(shiftable("G1 X=R1\nX2\nX3"), [run_time, unknown, Yes]);
    assert_eq!(shiftable("IF R1>1\nG1 X1\nENDIF\nG1 X2\nX3"), [run_time, unknown, Yes]);
    assert_eq!(shiftable("IF $A_IN[1]==1 GOTOF WEG\nG1 X1\nWEG: G1 X2\nX3"), [run_time, unknown, Yes]);
    // A jump to the end leaves no other path.
    assert_eq!(shiftable("IF $P_TOOLNO<>5 GOTOF FEHLER\nG1 X1\nM30\nFEHLER: MSG(\"Werkzeug\")\nM0\nM30"), [Yes]);
    assert_eq!(shiftable("IF $P_SIM\nRET\nENDIF\nG1 X1"), [Yes]);
    // A jump out of a branch may skip all that follows.
    assert_eq!(shiftable("IF R1>1\nGOTOF WEIT\nENDIF\nG1 X1\nWEIT: G1 X2\nX3"), [run_time, run_time, No(Fixed::NotUnderstood)]);
    assert_eq!(shiftable("R1=1\nWHILE $A_IN[1]\nR1=2\nENDWHILE\nG1 X=R1"), [run_time]);
    assert_eq!(shiftable("IF R1>1\nTRANS X5\nENDIF\nG0 X0 Y0 Z0\nG1 X2")[1], No(Fixed::NotUnderstood));
    // What is not found may change every frame.
    assert_eq!(shiftable("NOWHERE\nG0 X0 Y0 Z0\nG1 X2")[1], No(Fixed::NotUnderstood));
    assert_eq!(shiftable("KEEP\nG0 X0 Y0 Z0\nG1 X2")[1], No(Fixed::NotUnderstood));
    assert_eq!(shiftable("R1=5\nNOWHERE\nTRANS\nG1 X=R1"), [No(Fixed::NotUnderstood)]);
}

#[test]
fn faults_and_repeated_feed_moves_are_refused() {
    assert!(refused("R1=1/0").contains("a division by zero"));
    assert!(refused("GOTOF NIX").contains("there is no NIX to jump to"));
    assert!(refused("IF R1==1\nG0 X1").contains("the other end of this statement is missing"));
    assert!(refused("LOOP\nR1=1\nENDLOOP").contains("the program does not end"));
    assert!(refused("DEF INT I\nFOR I=1 TO 2\nG1 X=I\nENDFOR").contains("a feed move runs several times"));
    assert!(refused("/IF R1==1 GOTOF WEG\nWEG: G0 X1").contains("a switch may skip"));
    assert!(refused("LOST").contains("there is no WEG to jump to (line 2 of LOST.MPF)"));
}

#[test]
fn a_flat_program_has_values_instead_of_expressions() {
    let options = Options::from(Dialect::Sinumerik);
    let text =
        "R1=2\nDEF INT I\nFOR I=1 TO 2\nN5 G1 X=R1*I Y=IC(R1) F=R1*100 ; Bahn\nENDFOR\nR9=CYC\nT=\"MILL\" M6\nSPOS=R1\nM30\n";
    let flat = expand(&parse(text), &options, &files).expect("it is written");
    let expected = "G1 X=2. Y=IC(2.) F=200. ; Bahn\n; from line 4, run 2\nG1 X=4. Y=IC(2.) F=200. ; Bahn\n\
; from line 7\nT=\"MILL\" M6\nSPOS=2.\nM30\n";
    assert_eq!(String::from_utf8_lossy(&flat), expected);
    let smooth = "R1=1\nCYCLE832(0.01,_FINISH,1)\nG1 X=R1 F100\nM30\n";
    let flat = expand(&parse(smooth), &options, &files).expect("a constant of the control");
    assert_eq!(String::from_utf8_lossy(&flat), "CYCLE832(0.01,_FINISH,1)\nG1 X=1. F100\nM30\n");
    for (text, why) in [
        ("R1=1\nIF $A_IN[1]\nG0 X1\nENDIF", "the program decides this when it runs"),
        ("R1=1\nG0 X=R2", "known only when the program runs"),
        ("R1=1\nNOWHERE(R1)", "no statement or subprogram that is found"),
        ("R1=1\nCYCLE81(R1,0)", "the arguments of this name are variables"),
        ("R1=1\n$P_UIFR[1,X,TR]=R1", "may move the coordinate system"),
        ("R1=1\nG0 X1\n$A_OUT[1]=1", "acts on the control or outlives the program"),
        ("R1=1\n$AC_MARKER[0]=1", "acts on the control or outlives the program"),
    ] {
        let error = expand(&parse(text), &options, &files).expect_err(text).to_string();
        assert!(error.contains(why), "{text}: {error}");
    }
}
