//! Values of expressions. Those of LinuxCNC are what `rs274` 2.9 prints for them.

use proptest::prelude::*;

use super::expression::{assignment, brackets, term};
use super::parameters::{Name, Parameters};
use super::value::Value;
use crate::dialect::Dialect;

fn known(dialect: Dialect) -> Parameters {
    let mut parameters = Parameters::new(dialect);
    parameters.enter(&[]);
    for (number, value) in [(1, 5.0), (2, 7.0), (5, 2.0), (101, 1.5)] {
        parameters.set(Name::Number(number), Value::Number(value)).expect("a user parameter");
    }
    parameters.set(Name::Named(b"DEPTH".to_vec()), Value::Number(-3.0)).expect("a name");
    parameters
}

fn value(text: &str, dialect: Dialect) -> Value {
    term(text.as_bytes(), &known(dialect), dialect).unwrap_or_else(|fault| panic!("{text}: {}", fault.message))
}

fn check(dialect: Dialect, cases: &[(&str, f64)]) {
    for (text, expected) in cases {
        let Value::Number(found) = value(text, dialect) else { panic!("{text} is no number") };
        assert!((found - expected).abs() < 1e-9 * expected.abs().max(1.0), "{text}: {found}, not {expected}");
    }
}

#[test]
fn linux_cnc_evaluates_as_its_interpreter() {
    check(
        Dialect::LinuxCnc,
        &[
            ("[2**3**2]", 64.0),
            ("[-2**2]", 4.0),
            ("[-[2]**2]", 4.0),
            ("[2+3*4-1]", 13.0),
            ("[10 MOD 4**2]", 10.0),
            ("[-7 MOD 3]", 2.0),
            ("[7 MOD -3]", 1.0),
            ("[-7 MOD -3]", 2.0),
            ("[7.5 MOD 2]", 1.5),
            ("[5 - -3]", 8.0),
            ("[1 EQ 1.00009]", 1.0),
            ("[1 EQ 1.00011]", 0.0),
            ("[1 NE 1.00005]", 0.0),
            ("[1 LE 0.99995]", 0.0),
            ("[1 LT 1.00005]", 1.0),
            ("[3 GT 2 + 2]", 0.0),
            ("[1 OR 0 AND 0]", 0.0),
            ("[0 XOR 5]", 1.0),
            ("[1 + 2 EQ 3 AND 4 GT 3]", 1.0),
            ("ROUND[2.5]", 3.0),
            ("ROUND[-2.5]", -3.0),
            ("FIX[-2.5]", -3.0),
            ("FUP[-2.5]", -2.0),
            ("ATAN[1]/[-1]", 135.0),
            ("[ATAN[-1]/[1]]", -45.0),
            ("S I N [ 30 ]", 0.5),
            ("ACOS[0]", 90.0),
            ("LN[EXP[2]]", 2.0),
            ("[ABS[-4]**2]", 16.0),
            ("- #1", -5.0),
            ("##5", 7.0),
            ("#[1+1]", 7.0),
            ("#<De pth>", -3.0),
            ("EXISTS[#<depth>]", 1.0),
            ("EXISTS[#<width>]", 0.0),
            ("[.5+-2]", -1.5),
        ],
    );
}

#[test]
fn fanuc_evaluates_as_its_manual_says() {
    check(
        Dialect::Fanuc,
        &[
            ("[2+3*4]", 14.0),
            ("[12 AND 10]", 8.0),
            ("[12 OR 3 AND 2]", 14.0),
            ("[12 XOR 10]", 6.0),
            ("FIX[-2.5]", -2.0),
            ("FUP[-2.5]", -3.0),
            ("FUP[2.1]", 3.0),
            ("ATAN[1]/[-1]", 135.0),
            ("ATAN[1,1]", 45.0),
            ("ATAN[-1]", -45.0),
            ("POW[2,10]", 1024.0),
            ("BCD[92]", 146.0),
            ("BIN[146]", 92.0),
            ("[[#1 EQ 5] AND [#2 GT 6]]", 1.0),
            ("[#3 EQ #0]", 1.0),
            ("[#3 EQ 0]", 0.0),
            ("[#3 NE 0]", 1.0),
            ("[#3 GE 0]", 1.0),
            ("[#3 GT 0]", 0.0),
            ("[#3 * 5]", 0.0),
        ],
    );
    assert_eq!(value("#3", Dialect::Fanuc), Value::Null);
    assert_eq!(value("#0", Dialect::Fanuc), Value::Null);
}

#[test]
fn what_only_the_running_program_knows_is_unknown() {
    for text in ["#31", "#5061", "#5420", "[#5061*0]", "#<_x>", "EXISTS[#<_y>]", "#[#5061]", "SIN[#31]"] {
        assert_eq!(value(text, Dialect::LinuxCnc), Value::Unknown, "{text}");
    }
    for dialect in [Dialect::LinuxCnc, Dialect::Fanuc] {
        assert_eq!(term(b"#1", &Parameters::new(dialect), dialect), Ok(Value::Unknown));
    }
    for text in [
        "#100",
        "#500",
        "#5041",
        "#3001",
        "[#500 EQ #0]",
        "ADP[#1]",
        "ATAN[-1]/[1]",
        "ASIN[-1]",
        "[1 EQ 1 AND 2]",
        "[0.1+0.2 EQ 0.3]",
    ] {
        assert_eq!(value(text, Dialect::Fanuc), Value::Unknown, "{text}");
    }
}

#[test]
fn what_a_control_refuses_is_a_fault() {
    let linux_cnc = [
        ("[1/0]", "division by zero"),
        ("SQRT[-1]", "root of a negative"),
        ("LN[0]", "logarithm"),
        ("ASIN[2]", "beyond -1 to 1"),
        ("[-8**[1/3]]", "power that is not whole"),
        ("[5 MOD 0]", "not a number"),
        ("#<width>", "was not assigned"),
        ("#6000", "there is no parameter"),
        ("#[0.5]", "no number of a parameter"),
        ("[1 + 2", "`]` is missing"),
        ("[1]]", "no meaning"),
        ("POW[1]", "no function"),
        ("#<a", "`>` is missing"),
        ("[", "incomplete"),
    ];
    for (text, message) in linux_cnc {
        let fault = term(text.as_bytes(), &known(Dialect::LinuxCnc), Dialect::LinuxCnc).expect_err(text);
        assert!(fault.message.contains(message), "{text}: {}", fault.message);
    }
    let deep = format!("{}1{}", "[".repeat(100_000), "]".repeat(100_000));
    assert!(term(deep.as_bytes(), &known(Dialect::Fanuc), Dialect::Fanuc).is_err());
    assert!(assignment(b"#1=2*3", &known(Dialect::LinuxCnc), Dialect::LinuxCnc).is_err());
    assert!(term(b"[2**3]", &known(Dialect::Fanuc), Dialect::Fanuc).is_err());
}

#[test]
fn assignments_and_arguments_are_read() {
    let parameters = known(Dialect::LinuxCnc);
    let read = assignment(b"#[#1 + 1] = [#2*2]", &parameters, Dialect::LinuxCnc);
    assert_eq!(read, Ok((Some(Name::Number(6)), Value::Number(14.0))));
    let read = assignment(b"#<_A b> = -#1", &parameters, Dialect::LinuxCnc);
    assert_eq!(read, Ok((Some(Name::Named(b"_AB".to_vec())), Value::Number(-5.0))));
    let read = assignment(b"#9=#1*2+1", &known(Dialect::Fanuc), Dialect::Fanuc);
    assert_eq!(read, Ok((Some(Name::Number(9)), Value::Number(11.0))));
    assert_eq!(assignment(b"#[#500]=1", &known(Dialect::Fanuc), Dialect::Fanuc), Ok((None, Value::Number(1.0))));
    let arguments = brackets(b" [1] [#2+1] ", &parameters, Dialect::LinuxCnc);
    assert_eq!(arguments, Ok(vec![Value::Number(1.0), Value::Number(8.0)]));
    assert!(brackets(b"[1] 2", &parameters, Dialect::LinuxCnc).is_err());
}

fn dialects() -> impl Strategy<Value = Dialect> {
    prop_oneof![Just(Dialect::Fanuc), Just(Dialect::LinuxCnc)]
}

proptest! {
    /// Pieces of expressions in any order, and any bytes.
    #[test]
    fn evaluation_never_panics(
        pieces in prop::collection::vec(
            prop_oneof![
                Just("["), Just("]"), Just("#"), Just("<"), Just(">"), Just("a"), Just("_b"), Just("1"), Just("2.5"), Just("33"), Just("-"),
                Just("+"), Just("*"), Just("**"), Just("/"), Just("MOD"), Just("AND"), Just("EQ"), Just("LT"), Just("ATAN["), Just("SIN["),
                Just("EXISTS["), Just("POW["), Just("BCD["), Just(","), Just("="), Just(" "), Just("99999999999999999999"),
            ],
            0..24,
        ),
        dialect in dialects(),
    ) {
        let text = pieces.concat();
        let parameters = known(dialect);
        for result in [term(text.as_bytes(), &parameters, dialect).ok(), assignment(text.as_bytes(), &parameters, dialect).ok().map(|(_, v)| v)]
        {
            if let Some(Value::Number(value)) = result {
                prop_assert!(value.is_finite(), "{}", text);
            }
        }
        let _ = brackets(text.as_bytes(), &parameters, dialect);
    }

    #[test]
    fn sums_and_products_follow_their_precedence(a in -99_i32..99, b in -99_i32..99, c in 1_i32..99, dialect in dialects()) {
        let text = format!("[{a}+{b}*{c}-{b}/{c}]");
        let expected = f64::from(a) + f64::from(b) * f64::from(c) - f64::from(b) / f64::from(c);
        prop_assert_eq!(value(&text, dialect), Value::Number(expected));
    }
}
