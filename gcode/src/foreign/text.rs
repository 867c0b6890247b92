//! Recognition by the first lines and by the form of most lines.

use super::kind::Foreign;
use crate::program::Program;

/// Lines that are looked at.
const HEAD: usize = 200;

/// Recognises content by its lines, in upper case and without blanks around them.
pub(super) fn recognise(program: &Program) -> Option<Foreign> {
    let lines = program.blocks().iter().map(|block| program.text(block.span).trim_ascii().to_ascii_uppercase());
    let lines: Vec<Vec<u8>> = lines.filter(|line| !line.is_empty()).take(HEAD).collect();
    by_first_lines(&lines).or_else(|| by_any_line(&lines)).or_else(|| by_most_lines(&lines))
}

fn by_first_lines(lines: &[Vec<u8>]) -> Option<Foreign> {
    let line = |index: usize| lines.get(index).map_or(&[][..], Vec::as_slice);
    let first = line(0);
    if first.starts_with(b"%") && [&b" G70 *"[..], b" G71 *"].iter().any(|end| first.ends_with(end)) {
        return Some(Foreign::HeidenhainIso);
    }
    // A DXF file may begin with comments, which have the group code 999.
    let skipped = lines.chunks(2).take_while(|pair| pair[0] == b"999").count() * 2;
    if line(skipped) == b"0" && line(skipped + 1) == b"SECTION" {
        return Some(Foreign::Model("DXF"));
    }
    if first.starts_with(b"SOLID") && lines.iter().any(|line| line.starts_with(b"FACET NORMAL")) {
        return Some(Foreign::Model("STL"));
    }
    // The start section of IGES has an S in column 73 and a count behind it.
    if first.len() == 80 && first[72] == b'S' && first[73..].iter().all(|byte| byte.is_ascii_digit() || *byte == b' ') {
        return Some(Foreign::Model("IGES"));
    }
    let is_dstv_comment = |line: &&Vec<u8>| line.starts_with(b"**");
    if lines.iter().find(|line| !is_dstv_comment(line)).is_some_and(|line| line == b"ST")
        && lines.iter().any(|line| [&b"EN"[..], b"AK", b"IK", b"BO"].contains(&line.as_slice()))
    {
        return Some(Foreign::Dstv);
    }
    is_plotter(first, lines).then_some(Foreign::Plotter)
}

/// HP-GL: two letters, numbers and a semicolon, perhaps behind an escape sequence.
fn is_plotter(first: &[u8], lines: &[Vec<u8>]) -> bool {
    let opens = [&b"IN;"[..], b"DF;", b"PU;", b"PU", b"PD", b"PA", b"SP", b"\x1b."];
    let moves = |line: &Vec<u8>| line.split(|byte| *byte == b';').any(|command| is_pen_move(command.trim_ascii()));
    first.contains(&b';') && opens.iter().any(|open| first.starts_with(open)) && lines.iter().any(moves)
}

fn is_pen_move(command: &[u8]) -> bool {
    let rest = [b"PU", b"PD", b"PA"].iter().find_map(|name| command.strip_prefix(name.as_slice()));
    rest.is_some_and(|rest| rest.iter().all(|byte| byte.is_ascii_digit() || b" ,-.".contains(byte)))
}

fn by_any_line(lines: &[Vec<u8>]) -> Option<Foreign> {
    let starts = |words: &[&[u8]]| lines.iter().any(|line| words.iter().any(|word| line.starts_with(word)));
    if starts(&[b"GOTO/", b"GOTO /", b"FEDRAT/", b"LOADTL/", b"TLDATA/"]) {
        return Some(Foreign::CutterLocation);
    }
    let is_unit = |line: &Vec<u8>| line.starts_with(b"UNO") && (contains(line, b"UNIT") || contains(line, b"MAT"));
    lines.iter().any(is_unit).then_some(Foreign::Mazatrol)
}

fn by_most_lines(lines: &[Vec<u8>]) -> Option<Foreign> {
    let content: Vec<&[u8]> = lines
        .iter()
        .map(Vec::as_slice)
        .filter(|line| !line.starts_with(b";") && !line.starts_with(b"#") && *line != b"%")
        .collect();
    let share = |is: fn(&[u8]) -> bool| content.iter().filter(|line| is(line)).count() * 10 >= content.len() * 7;
    if content.is_empty() {
        return None;
    }
    let headings = content.iter().filter(|line| is_heading(line)).count();
    if headings > 0 && share(|line| is_heading(line) || is_entry(line)) {
        return Some(Foreign::Ini);
    }
    if share(is_hal) {
        return Some(Foreign::Hal);
    }
    if content.iter().all(|line| is_tool(line)) {
        return Some(Foreign::ToolTable);
    }
    (content.len() > 2 && (share(is_setting) || share(is_numbers))).then_some(Foreign::Settings)
}

/// `[TRAJ]`
fn is_heading(line: &[u8]) -> bool {
    line.starts_with(b"[") && line.ends_with(b"]") && line[1..].first().is_some_and(u8::is_ascii_alphabetic)
}

/// `MAX_VELOCITY = 30`
fn is_entry(line: &[u8]) -> bool {
    let name = line.split(|byte| *byte == b'=').next().unwrap_or_default().trim_ascii();
    let plain = name.iter().all(|byte| byte.is_ascii_alphanumeric() || b"_.-".contains(byte));
    name.len() < line.len() && name.len() > 1 && plain
}

fn is_hal(line: &[u8]) -> bool {
    let first = line.split(|byte| byte.is_ascii_whitespace()).next().unwrap_or_default();
    [&b"LOADRT"[..], b"LOADUSR", b"ADDF", b"NET", b"SETP", b"SETS", b"LINKPP", b"UNLINKP"].contains(&first)
}

/// `T1 P1 D6.35 Z+2.5 ;DRILL`
fn is_tool(line: &[u8]) -> bool {
    let text = line.split(|byte| *byte == b';').next().unwrap_or_default();
    let mut words = text.split(|byte| byte.is_ascii_whitespace()).filter(|word| !word.is_empty());
    let is = |word: Option<&[u8]>, letter: u8| {
        word.is_some_and(|word| word.len() > 1 && word[0] == letter && word[1..].iter().all(u8::is_ascii_digit))
    };
    is(words.next(), b'T') && is(words.next(), b'P')
}

/// `$100=250.000` of Grbl, `N10000 $MN_AXCONF=1` of SINUMERIK, `N01320Q1A1P99.` of Fanuc.
fn is_setting(line: &[u8]) -> bool {
    let value = line.strip_prefix(b"$").and_then(|rest| rest.split(|byte| *byte == b'=').next());
    let grbl = value.is_some_and(|number| number.len() + 1 < line.len() && number.iter().all(u8::is_ascii_digit));
    let rest = line.strip_prefix(b"N").map(skip_number).unwrap_or(line);
    let siemens = [&b"$M"[..], b"$SC_", b"$TC_"].iter().any(|name| rest.starts_with(name));
    let fanuc = rest.len() < line.len() && [&b"Q0"[..], b"Q1", b"A1P", b"L1P", b"L0P"].iter().any(|name| rest.starts_with(name));
    grbl || siemens || fanuc
}

/// `5161 0.000000`: a LinuxCNC parameter file.
fn is_numbers(line: &[u8]) -> bool {
    let mut words = line.split(|byte| byte.is_ascii_whitespace()).filter(|word| !word.is_empty());
    let number = |word: &[u8]| word.iter().all(|byte| byte.is_ascii_digit() || b"+-.".contains(byte));
    let key = words.next().is_some_and(|word| word.iter().all(u8::is_ascii_digit));
    key && words.next().is_some_and(number) && words.next().is_none()
}

/// The line behind its leading digits and blanks.
fn skip_number(line: &[u8]) -> &[u8] {
    let digits = line.iter().position(|byte| !byte.is_ascii_digit()).unwrap_or(line.len());
    line[digits..].trim_ascii_start()
}

fn contains(line: &[u8], text: &[u8]) -> bool {
    line.windows(text.len()).any(|window| window == text)
}
