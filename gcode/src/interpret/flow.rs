//! Flow statements and their effect on the predictability of later blocks.

use crate::lexer::letters;
use crate::number::skip_blanks;

/// Effect of a flow statement.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Flow<'a> {
    /// Opens a subprogram's body, which runs only when called.
    Sub { label: &'a [u8] },
    /// Opens a body that runs any number of times, or never. The label closes it.
    Open { label: &'a [u8] },
    /// `do`: closed by `while` with the same label.
    OpenDo { label: &'a [u8] },
    /// `while`: opens a body, or closes a `do` of this label.
    While { label: &'a [u8] },
    /// Closes the body.
    Close { label: &'a [u8] },
    /// Calls a subprogram.
    Call,
    /// Jumps, perhaps conditionally.
    Jump,
    /// Conditional assignment to a parameter.
    Assign,
    /// Stays inside an open body.
    Inside,
}

/// Reads a flow statement, an O-word or a macro statement.
pub(super) fn classify(statement: &[u8]) -> Flow<'_> {
    match statement.first() {
        Some(b'o' | b'O') => o_word(statement),
        _ => macro_statement(statement),
    }
}

fn o_word(statement: &[u8]) -> Flow<'_> {
    let start = skip_blanks(statement, 1);
    let end = match statement.get(start) {
        Some(b'<') => statement.iter().position(|b| *b == b'>').map_or(statement.len(), |at| at + 1),
        Some(byte) if byte.is_ascii_digit() => {
            statement[start..].iter().position(|b| !b.is_ascii_digit()).map_or(statement.len(), |length| start + length)
        }
        // A computed label can only be called.
        _ => return Flow::Call,
    };
    let label = statement.get(start..end).unwrap_or_default();
    let keyword = letters(statement, skip_blanks(statement, end)).to_ascii_uppercase();
    match keyword.as_slice() {
        b"SUB" => Flow::Sub { label },
        b"IF" | b"REPEAT" => Flow::Open { label },
        b"DO" => Flow::OpenDo { label },
        b"WHILE" => Flow::While { label },
        b"ENDSUB" | b"ENDIF" | b"ENDWHILE" | b"ENDREPEAT" => Flow::Close { label },
        b"ELSE" | b"ELSEIF" | b"RETURN" | b"BREAK" | b"CONTINUE" => Flow::Inside,
        _ => Flow::Call,
    }
}

fn macro_statement(statement: &[u8]) -> Flow<'_> {
    let text = statement.to_ascii_uppercase();
    if text.starts_with(b"WHILE") || text.starts_with(b"DO") {
        let digits = statement.iter().rposition(|b| !b.is_ascii_digit()).map_or(0, |at| at + 1);
        return Flow::Open { label: statement.get(digits..).unwrap_or_default() };
    }
    if text.starts_with(b"ENDIF") || text.starts_with(b"GOTO") {
        return Flow::Jump;
    }
    if let Some(label) = text.strip_prefix(b"END") {
        let length = label.len();
        let label = &statement[statement.len() - length..];
        return Flow::Close { label: &label[skip_blanks(label, 0)..] };
    }
    let then = text.windows(4).position(|window| window == b"THEN");
    match then {
        Some(at) if text.get(skip_blanks(&text, at + 4)) == Some(&b'#') => Flow::Assign,
        _ => Flow::Jump,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn statements_are_distinguished() {
        let cases: [(&str, Flow); 13] = [
            ("o100 sub", Flow::Sub { label: b"100" }),
            ("O<probe> endsub", Flow::Close { label: b"<probe>" }),
            ("o<probe> call [1]", Flow::Call),
            ("o#1 call", Flow::Call),
            ("o5 do", Flow::OpenDo { label: b"5" }),
            ("o5 while [#1 LT 2]", Flow::While { label: b"5" }),
            ("o5 else", Flow::Inside),
            ("WHILE[#1LT3]DO1", Flow::Open { label: b"1" }),
            ("END 1", Flow::Close { label: b"1" }),
            ("GOTO 100", Flow::Jump),
            ("IF[#1EQ0]GOTO10", Flow::Jump),
            ("if [#1 eq 0] then #2=1", Flow::Assign),
            ("THEN", Flow::Jump),
        ];
        for (text, expected) in cases {
            assert_eq!(classify(text.as_bytes()), expected, "{text}");
        }
    }
}
