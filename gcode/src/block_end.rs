//! Words behind `;`: a remark, or a block of their own on a control that ends a block there.
//!
//! Which of the two is the program's way. Where any text stands behind a `;` that no block has, remarks do, and all of them are remarks.

use crate::program::Program;
use crate::word::{Word, WordKind};

/// Words of macros. Any other word of several letters is text.
const KEYWORDS: [&[u8]; 36] = [
    b"IF", b"THEN", b"GOTO", b"WHILE", b"DO", b"END", b"EQ", b"NE", b"GT", b"LT", b"GE", b"LE", b"AND", b"OR", b"XOR", b"NOT",
    b"MOD", b"SIN", b"COS", b"TAN", b"ASIN", b"ACOS", b"ATAN", b"SQRT", b"SQR", b"ABS", b"ROUND", b"RND", b"FIX", b"FUP", b"BIN",
    b"BCD", b"LN", b"EXP", b"CALL", b"SETVN",
];

/// Whether remarks stand behind `;` in the program.
pub(crate) fn has_remarks(program: &Program) -> bool {
    program.words().iter().any(|word| word.kind == WordKind::Comment && is_text(program.text(word.span)))
}

/// Whether words of this block stand behind `;`, in a program without remarks there. A line that begins with `;` is a remark.
pub(crate) fn is_behind(program: &Program, word: &Word, is_first: bool) -> bool {
    let text = program.text(word.span);
    word.kind == WordKind::Comment
        && !is_first
        && text.first() == Some(&b';')
        && outside(text).any(|byte| byte.is_ascii_alphabetic() || byte == b'#')
}

/// Whether a comment behind `;` has a word that no block has.
fn is_text(comment: &[u8]) -> bool {
    if comment.first() != Some(&b';') {
        return false;
    }
    let bytes: Vec<u8> = outside(comment).map(|byte| byte.to_ascii_uppercase()).collect();
    let mut words = bytes.split(|byte| byte.is_ascii() && !byte.is_ascii_alphabetic());
    words.any(|word| word.len() > 1 && !KEYWORDS.contains(&word))
}

/// The bytes outside parentheses.
fn outside(text: &[u8]) -> impl Iterator<Item = u8> {
    let mut depth = 0_usize;
    text.iter().copied().filter(move |byte| {
        match byte {
            b'(' => depth += 1,
            b')' => {
                depth = depth.saturating_sub(1);
                return false;
            }
            _ => {}
        }
        depth == 0
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_is_what_no_block_has() {
        for text in ["; safe height", ";T1 drill", "; goto safe height", "; 3 mm", "; if worn X5", "; Größe", ";X5 (A) ok"] {
            assert!(is_text(text.as_bytes()), "{text}");
        }
        for block in
            ["", ";", "; X10. G91", ";M98 P5 (DRILL)", ";IF[#500EQ1]GOTO10", "; D6. R3", ";(REMARK)", "(REMARK)", "; 5", ";END1"]
        {
            assert!(!is_text(block.as_bytes()), "{block}");
        }
    }
}
