//! Which separator and decimal sign a text log uses, and where its header is.

use super::clock_text::clock_s;
use super::text::Line;

/// Notation of the fields of a text log.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Dialect {
    /// Between fields; `' '` stands for any run of blanks.
    pub separator: char,
    /// Whether `1,5` is one and a half.
    pub decimal_comma: bool,
    /// Fields in a row.
    pub width: usize,
}

/// Share of numbers among the fields between tabs above which blanks separate nothing.
const MOST: f64 = 0.5;
/// The minus sign of typography, which some tools write.
const MINUS: char = '\u{2212}';
/// Number of lines for the detection.
const SNIFFED: usize = 200;

/// Separators with point and with comma as decimal sign; between commas, numbers with a decimal comma stand in quotes.
const SEPARATORS: [(char, bool); 10] = [
    (',', false),
    (';', false),
    (';', true),
    ('\t', false),
    ('\t', true),
    ('|', false),
    ('|', true),
    (' ', false),
    (' ', true),
    (',', true),
];

impl Dialect {
    /// The dialect in which rows have the most numbers, as a share of all fields: a wrong one
    /// leaves fields such as `5;1`.
    pub fn sniff(lines: &[Line<'_>]) -> Self {
        let lines = &lines[..lines.len().min(SNIFFED)];
        let mut best = (Score::default(), Self::new(',', false, 1));
        for (separator, decimal_comma) in SEPARATORS {
            // Blanks beside tabs are those of digits in groups, or of names.
            if separator == ' ' && best.1.separator == '\t' && best.0.share > MOST {
                continue;
            }
            let mut dialect = Self::new(separator, decimal_comma, 1);
            let widths: Vec<usize> = lines.iter().map(|line| dialect.fields(line.text).len()).collect();
            dialect.width = most_common(&widths);
            let rows: Vec<Vec<&str>> = lines.iter().map(|line| dialect.fields(line.text)).collect();
            let rows: Vec<&Vec<&str>> = rows.iter().filter(|row| row.len() == dialect.width).collect();
            let score = Score::of(&dialect, &rows);
            // A separator at the end of every row adds no column; a column that is named and empty is one.
            if dialect.width > 1 && rows.iter().all(|row| row.last().is_some_and(|field| field.is_empty())) {
                dialect.width -= 1;
            }
            if score.is_above(&best.0, separator == best.1.separator) {
                best = (score, dialect);
            }
        }
        best.1
    }

    fn new(separator: char, decimal_comma: bool, width: usize) -> Self {
        Self { separator, decimal_comma, width }
    }

    /// Whether a line is a remark behind `;`, which separates nothing here.
    pub fn is_remark(&self, line: &str) -> bool {
        self.has_remark(line.as_bytes())
    }

    /// The same of the bytes of a line without blanks before.
    pub fn has_remark(&self, line: &[u8]) -> bool {
        self.separator != ';' && line.first() == Some(&b';')
    }

    /// The fields of a line; separators between double quotes do not count.
    pub fn fields<'a>(&self, line: &'a str) -> Vec<&'a str> {
        let mut fields = Vec::new();
        self.each_field(line, |field| fields.push(field));
        fields
    }

    /// Gives the fields of a line one by one, as [`Dialect::fields`] does.
    pub fn each_field<'a>(&self, line: &'a str, take: impl FnMut(&'a str)) {
        if self.separator == ' ' {
            return line.split_whitespace().for_each(take);
        }
        let plain = |field: &'a str| field.trim().trim_matches('"').trim();
        if !line.contains('"') {
            return line.split(self.separator).map(plain).for_each(take);
        }
        let mut quoted = false;
        let split = line.split(|character| {
            quoted ^= character == '"';
            character == self.separator && !quoted
        });
        split.map(plain).for_each(take);
    }

    /// The value of a field, if it is a number or a time of day, with or without a date, in s.
    pub fn number(&self, field: &str) -> Option<f64> {
        self.plain_number(field).or_else(|| self.grouped_number(field)).or_else(|| clock_s(field))
    }

    /// Whether a field is a number, its digits not in groups, or a time of day: serial numbers and addresses look like digits in groups.
    fn is_plain(&self, field: &str) -> bool {
        self.plain_number(field).is_some() || clock_s(field).is_some()
    }

    pub(super) fn plain_number(&self, field: &str) -> Option<f64> {
        let with_sign = field.strip_prefix(MINUS).map(|size| format!("-{size}"));
        let field = with_sign.as_deref().unwrap_or(field);
        if !self.decimal_comma {
            field.parse().ok()
        } else if field.contains('.') {
            None
        } else {
            field.replace(',', ".").parse().ok()
        }
    }

    /// The value of a number whose digits stand in groups of three: `43.164,300`, `43,164.300`, `43 164.3`, `43'164.3`. Points and commas between groups
    /// need a decimal sign or a second group, since one alone may be a decimal sign.
    fn grouped_number(&self, field: &str) -> Option<f64> {
        let (decimal, other) = if self.decimal_comma { (',', '.') } else { ('.', ',') };
        let (whole, fraction) = field.split_once(decimal).map_or((field, None), |(whole, fraction)| (whole, Some(fraction)));
        let (sign, whole) =
            whole.strip_prefix('-').map_or((1.0, whole.strip_prefix('+').unwrap_or(whole)), |whole| (-1.0, whole));
        let between = whole.chars().find(|character| !character.is_ascii_digit())?;
        let groups: Vec<&str> = whole.split(between).collect();
        let is_sign = between == other && (fraction.is_some() || groups.len() > 2);
        let are_digits = |text: &str| text.bytes().all(|byte| byte.is_ascii_digit());
        let [first, others @ ..] = groups.as_slice() else { return None };
        let are_groups = (1..=3).contains(&first.len())
            && are_digits(first)
            && others.iter().all(|group| group.len() == 3 && are_digits(group));
        if !are_groups
            || !(is_sign || [' ', '\u{a0}', '\u{202f}', '\'', '\u{2019}'].contains(&between))
            || !fraction.is_none_or(are_digits)
        {
            return None;
        }
        format!("{}.{}", groups.concat(), fraction.unwrap_or_default()).parse().ok().map(|value: f64| sign * value)
    }

    /// Whether a row of the right width, empty fields at its end aside, holds a number. A time of day alone may be a line of the head, and so may
    /// digits in groups.
    pub fn is_data(&self, line: &str) -> bool {
        let fields = self.fields(line);
        let fits = fields.len() >= self.width && fields.iter().skip(self.width).all(|field| field.is_empty());
        let grouped = || fields.iter().filter(|field| self.grouped_number(field).is_some()).count();
        fits && (fields.iter().any(|field| self.plain_number(field).is_some()) || grouped() > 1)
    }
}

/// How well a dialect fits rows: the sum over the rows of their numbers, squared, by their fields.
#[derive(Default)]
struct Score {
    /// Of numbers whose digits are in no groups.
    plain: f64,
    /// The same where numbers in groups count half.
    all: f64,
    /// Share of the fields that are numbers.
    share: f64,
}

impl Score {
    fn of(dialect: &Dialect, rows: &[&Vec<&str>]) -> Self {
        let (mut score, mut numbers, mut fields) = (Self::default(), 0.0, 0.0);
        for row in rows {
            fields += row.len() as f64;
            let plain = row.iter().filter(|field| dialect.is_plain(field)).count() as f64;
            let grouped = row.iter().filter(|field| dialect.grouped_number(field).is_some()).count() as f64;
            score.plain += plain.powi(2) / row.len() as f64;
            score.all += (plain + 0.5 * grouped).powi(2) / row.len() as f64;
            numbers += plain + grouped;
        }
        score.share = if fields > 0.0 { numbers / fields } else { 0.0 };
        score
    }

    /// Of two decimal signs beside one separator plain numbers decide, since a serial number may look like digits in groups of either.
    fn is_above(&self, other: &Self, same_separator: bool) -> bool {
        if same_separator && (self.plain > 0.0 || other.plain > 0.0) { self.plain > other.plain } else { self.all > other.all }
    }
}

fn most_common(widths: &[usize]) -> usize {
    let count = |width: usize| widths.iter().filter(|&&other| other == width).count();
    widths.iter().copied().max_by_key(|&width| (count(width), width)).unwrap_or(1)
}

#[cfg(test)]
mod tests {
    use super::super::text::lines;
    use super::*;

    fn sniff(text: &str) -> Dialect {
        Dialect::sniff(&lines(text).0)
    }

    #[test]
    fn separators_and_decimal_commas_are_distinguished() {
        assert_eq!(sniff("t,x\n0,1\n1,2\n"), Dialect::new(',', false, 2));
        assert_eq!(sniff("t;x\n0.5;1\n1;2\n"), Dialect::new(';', false, 2));
        assert_eq!(sniff("t;x\n0,5;1,25\n1,0;2,5\n"), Dialect::new(';', true, 2));
        assert_eq!(sniff("t\tx\n0,5\t1,25\n1,0\t2,5\n"), Dialect::new('\t', true, 2));
        assert_eq!(sniff("t  x\n0.5  1.25\n1.0 2.5\n"), Dialect::new(' ', false, 2));
        assert_eq!(sniff("t|x\n0.5|1.25\n1.0|2.5\n"), Dialect::new('|', false, 2));
        assert_eq!(sniff("t|x\n0,5|1,25\n1,0|2,5\n"), Dialect::new('|', true, 2));
        assert_eq!(sniff("t,x\n\"0,5\",\"1,25\"\n\"1,0\",\"2,5\"\n"), Dialect::new(',', true, 2));
        assert_eq!(sniff("t,x\n2026-11-27T18:50:03.002,1.25\n2026-11-27T18:50:03.004,2.5\n"), Dialect::new(',', false, 2));
    }

    #[test]
    fn digits_in_groups_are_numbers() {
        let of = |decimal_comma: bool, field: &str| Dialect::new(';', decimal_comma, 1).number(field);
        assert_eq!(of(true, "43.164,300"), Some(43_164.3));
        assert_eq!(of(true, "-1.043.164"), Some(-1_043_164.0));
        assert_eq!(of(false, "43,164.300"), Some(43_164.3));
        assert_eq!([of(false, "\u{2212}1.5"), of(true, "\u{2212}1,5")], [Some(-1.5); 2]);
        assert_eq!([of(true, "43 164,3"), of(false, "43'164.3"), of(true, "43\u{a0}164,3")], [Some(43_164.3); 3]);
        for (decimal_comma, field) in [
            (true, "43.164"),
            (false, "43,164"),
            (true, "4.16,3"),
            (true, "4.1645,3"),
            (false, "1,000,"),
            (false, "a 123"),
            (true, "1.000,5,1"),
        ] {
            assert_eq!(of(decimal_comma, field), None, "{field}");
        }
        let head = "IP;192.168.100.200;\nt;x;y\n0,5;1,25;7\n1,0;1.002,5;8\n";
        let (text, dialect) = (lines(head).0, sniff(head));
        assert_eq!(text.iter().filter(|line| dialect.is_data(line.text)).map(|line| line.number).collect::<Vec<_>>(), [3, 4]);
        assert!(!sniff("t;x;fw\n0;1;1.200.300\n1;2;1.200.300\n").decimal_comma);
        // Groups appear only where values are large.
        assert_eq!(sniff("t;x\n0,5;1,25\n1,0;1.002,5\n"), Dialect::new(';', true, 2));
        assert_eq!(sniff("t,x\n0.5,1.25\n1.0,\"1,002.5\"\n"), Dialect::new(',', false, 2));
        assert_eq!(sniff("t\tx\ty\tz\n0,5\t7,5\t3,5\t1 250,5\n1,0\t7,5\t3,5\t1 002,5\n"), Dialect::new('\t', true, 4));
    }

    #[test]
    fn a_separator_at_the_end_adds_no_column_unless_it_is_named() {
        assert_eq!(sniff("t,x,\n0,1,\n1,2,\n").width, 2);
        assert_eq!(sniff("t,x\n0,1,\n1,2,\n").width, 2);
        assert_eq!(sniff("t,x,y\n0,1,\n1,2,\n").width, 3);
    }

    #[test]
    fn a_time_in_the_head_is_no_data() {
        let text = "recorded,2026-11-27 12:00:00\ntime,x\n12:00:00.002,1.25\n12:00:00.004,2.5\n";
        let (lines, dialect) = (lines(text).0, sniff(text));
        let data: Vec<usize> = lines.iter().filter(|line| dialect.is_data(line.text)).map(|line| line.number).collect();
        assert_eq!(data, [3, 4]);
    }

    #[test]
    fn a_separator_between_quotes_is_none() {
        let dialect = Dialect::new(',', false, 2);
        assert_eq!(dialect.fields("\"a,b\", 2"), vec!["a,b", "2"]);
    }
}
