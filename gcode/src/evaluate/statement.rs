//! Flow statements: O-words of LinuxCNC, macro statements of Fanuc.

use super::expression::packed;

/// Keyword of an O-word.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Keyword {
    Sub,
    EndSub,
    Call,
    Return,
    If,
    ElseIf,
    Else,
    EndIf,
    While,
    EndWhile,
    Do,
    Repeat,
    EndRepeat,
    Break,
    Continue,
}

/// Spellings in upper case. A keyword stands before any that it begins with.
const KEYWORDS: [(&[u8], Keyword); 15] = [
    (b"SUB", Keyword::Sub),
    (b"ENDSUB", Keyword::EndSub),
    (b"CALL", Keyword::Call),
    (b"RETURN", Keyword::Return),
    (b"IF", Keyword::If),
    (b"ELSEIF", Keyword::ElseIf),
    (b"ELSE", Keyword::Else),
    (b"ENDIF", Keyword::EndIf),
    (b"WHILE", Keyword::While),
    (b"ENDWHILE", Keyword::EndWhile),
    (b"DO", Keyword::Do),
    (b"REPEAT", Keyword::Repeat),
    (b"ENDREPEAT", Keyword::EndRepeat),
    (b"BREAK", Keyword::Break),
    (b"CONTINUE", Keyword::Continue),
];

/// Label of an O-word, in upper case without blanks.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Label {
    /// `o100`, `o<name>`.
    Fixed(Vec<u8>),
    /// `o#1`, `o[#1+1]`: the text of the number.
    Computed(Vec<u8>),
}

/// What follows the condition of an IF.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Then {
    Goto(Vec<u8>),
    Assign(Vec<u8>),
}

/// A flow statement. Texts are in upper case without blanks.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Statement {
    OWord { label: Label, keyword: Keyword, arguments: Vec<u8> },
    If { condition: Vec<u8>, then: Then },
    While { condition: Vec<u8>, number: u32 },
    Do { number: u32 },
    End { number: u32 },
    Goto(Vec<u8>),
    NotUnderstood,
}

impl Statement {
    pub fn read(text: &[u8]) -> Self {
        let text = packed(text);
        let read = match text.first() {
            Some(b'O') => o_word(&text[1..]),
            _ => macro_statement(&text),
        };
        read.unwrap_or(Self::NotUnderstood)
    }

    /// Label and keyword, if it is an O-word with a fixed label.
    pub fn labelled(&self) -> Option<(&[u8], Keyword)> {
        match self {
            Self::OWord { label: Label::Fixed(label), keyword, .. } => Some((label, *keyword)),
            _ => None,
        }
    }
}

fn o_word(text: &[u8]) -> Option<Statement> {
    let (label, rest) = match text.first()? {
        b'<' => {
            let end = text.iter().position(|byte| *byte == b'>')?;
            (Label::Fixed(text[1..end].to_vec()), &text[end + 1..])
        }
        b'#' | b'[' => {
            let end = term_length(text)?;
            (Label::Computed(text[..end].to_vec()), &text[end..])
        }
        _ => {
            let end = digits(text);
            let significant = text[..end].iter().position(|digit| *digit != b'0').unwrap_or(end.saturating_sub(1));
            (Label::Fixed(text.get(significant..end)?.to_vec()), &text[end..])
        }
    };
    let (spelling, keyword) = KEYWORDS.iter().find(|(spelling, _)| rest.starts_with(spelling))?;
    Some(Statement::OWord { label, keyword: *keyword, arguments: rest[spelling.len()..].to_vec() })
}

fn digits(text: &[u8]) -> usize {
    text.iter().position(|byte| !byte.is_ascii_digit()).unwrap_or(text.len())
}

/// Length of the parameter or bracket at the start of `text`.
fn term_length(text: &[u8]) -> Option<usize> {
    let marks = text.iter().position(|byte| *byte != b'#')?;
    let rest = &text[marks..];
    let length = match rest.first()? {
        b'<' => rest.iter().position(|byte| *byte == b'>')? + 1,
        b'[' => bracket_length(rest)?,
        _ => digits(rest),
    };
    Some(marks + length)
}

/// Length of the bracket at the start of `text`.
fn bracket_length(text: &[u8]) -> Option<usize> {
    let mut depth = 0_usize;
    for (at, byte) in text.iter().enumerate() {
        match byte {
            b'[' => depth += 1,
            b']' => depth = depth.checked_sub(1)?,
            _ => {}
        }
        if depth == 0 {
            return (at > 0).then_some(at + 1);
        }
    }
    None
}

fn macro_statement(text: &[u8]) -> Option<Statement> {
    if let Some(rest) = text.strip_prefix(b"IF") {
        let (condition, rest) = rest.split_at(bracket_length(rest)?);
        let then = match (rest.strip_prefix(b"GOTO"), rest.strip_prefix(b"THEN")) {
            (Some(target), _) => Then::Goto(target.to_vec()),
            (None, Some(assignment)) if assignment.starts_with(b"#") => Then::Assign(assignment.to_vec()),
            _ => return None,
        };
        return Some(Statement::If { condition: condition.to_vec(), then });
    }
    if let Some(rest) = text.strip_prefix(b"WHILE") {
        let (condition, rest) = rest.split_at(bracket_length(rest)?);
        return Some(Statement::While { condition: condition.to_vec(), number: number(rest.strip_prefix(b"DO")?)? });
    }
    if let Some(target) = text.strip_prefix(b"GOTO") {
        return Some(Statement::Goto(target.to_vec()));
    }
    match (text.strip_prefix(b"DO"), text.strip_prefix(b"END")) {
        (Some(rest), _) => Some(Statement::Do { number: number(rest)? }),
        (None, Some(rest)) => Some(Statement::End { number: number(rest)? }),
        _ => None,
    }
}

fn number(text: &[u8]) -> Option<u32> {
    std::str::from_utf8(text).ok()?.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn o(label: &str, keyword: Keyword, arguments: &str) -> Statement {
        Statement::OWord { label: Label::Fixed(label.into()), keyword, arguments: arguments.into() }
    }

    #[test]
    fn statements_are_distinguished() {
        let goto = |text: &str| Then::Goto(text.into());
        let cases = [
            ("o100 sub", o("100", Keyword::Sub, "")),
            ("O0100 endsub [#1 + 2]", o("100", Keyword::EndSub, "[#1+2]")),
            ("o100 end sub", o("100", Keyword::EndSub, "")),
            ("o1 else  if [1]", o("1", Keyword::ElseIf, "[1]")),
            ("O<probe it> call [1] [2]", o("PROBEIT", Keyword::Call, "[1][2]")),
            ("o5 do", o("5", Keyword::Do, "")),
            ("o5 elseif [1]", o("5", Keyword::ElseIf, "[1]")),
            ("o5 else", o("5", Keyword::Else, "")),
            (
                "o#1 call [2]",
                Statement::OWord { label: Label::Computed("#1".into()), keyword: Keyword::Call, arguments: "[2]".into() },
            ),
            ("WHILE[#1LT3]DO1", Statement::While { condition: "[#1LT3]".into(), number: 1 }),
            ("END 1", Statement::End { number: 1 }),
            ("DO 2", Statement::Do { number: 2 }),
            ("GOTO 100", Statement::Goto("100".into())),
            ("IF[#1EQ0]GOTO#2", Statement::If { condition: "[#1EQ0]".into(), then: goto("#2") }),
            ("if [#1 eq 0] then #2=1", Statement::If { condition: "[#1EQ0]".into(), then: Then::Assign("#2=1".into()) }),
            ("THEN", Statement::NotUnderstood),
            ("IF #1 EQ 0 GOTO 3", Statement::NotUnderstood),
            ("o5 jump", Statement::NotUnderstood),
        ];
        for (text, expected) in cases {
            assert_eq!(Statement::read(text.as_bytes()), expected, "{text}");
        }
    }
}
