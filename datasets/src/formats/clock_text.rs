//! Times of day and dates as text.

/// Seconds of `HH:MM:SS`, with a fraction after a point or comma, behind a date or none, in s: since the start of 1970 where there is a date, else
/// since midnight. Dates are `2026-11-27`, `20261127`, `27.11.2026`, `27-Nov-2026` and `11/27/2026`; `T` or a blank follows. `1 days` may stand before. `Z`, a time zone such as `+02:00`, and AM or PM may
/// stand behind. `MM:SS` has to have a fraction, and no date. A fraction of three or six digits may follow a colon or semicolon: `HH:MM:SS:mmm`. Seconds may be stated
/// as such: `0.002 sec`.
pub(super) fn clock_s(text: &str) -> Option<f64> {
    if let Some((seconds, "s" | "sec" | "seconds")) = text.split_once(' ') {
        return seconds.parse().ok();
    }
    if let Some((days, rest)) = text.split_once(" days ").or_else(|| text.split_once(" day ")) {
        let of_day_s = if rest.contains(' ') { None } else { clock_s(rest) };
        return Some(86_400.0 * digits(days)? as f64 + of_day_s?);
    }
    let text = text.strip_suffix(['Z', 'z']).unwrap_or(text);
    if !text.contains(':') || !text.is_ascii() {
        return None;
    }
    let (date, time) = match text.find(['T', ' ']) {
        Some(at) if !text[..at].contains(':') => (Some(&text[..at]), text[at + 1..].trim_start()),
        _ => (None, text),
    };
    let (time, zone_s) = match time.find(['+', '-']) {
        Some(at) => (time[..at].trim_end(), zone_s(&time[at..])?),
        None => (time, 0.0),
    };
    let (time, half_day) = match time.len().checked_sub(2).map(|at| time.split_at_checked(at)) {
        Some(Some((time, half))) if half.eq_ignore_ascii_case("am") => (time.trim_end(), Some(0.0)),
        Some(Some((time, half))) if half.eq_ignore_ascii_case("pm") => (time.trim_end(), Some(12.0)),
        _ => (time, None),
    };
    let mut parts: Vec<&str> = time.split([':', ';']).collect();
    let fraction = match parts.last() {
        Some(last) if parts.len() == 4 && matches!(last.len(), 3 | 6) && last.bytes().all(|byte| byte.is_ascii_digit()) => {
            let fraction = format!("0.{last}").parse().ok()?;
            parts.pop();
            fraction
        }
        _ => 0.0,
    };
    let has_hours = parts.len() == 3;
    if parts.len() == 2 && date.is_none() && half_day.is_none() && parts[1].contains(['.', ',']) {
        parts.insert(0, "0");
    }
    let &[hours, minutes, seconds] = parts.as_slice() else { return None };
    let (hours, minutes) = (digits(hours)?, digits(minutes)?);
    let seconds = seconds.replace(',', ".").parse::<f64>().ok()? + fraction;
    if has_hours && minutes >= 60 || !(0.0..61.0).contains(&seconds) {
        return None;
    }
    let hours = half_day.map_or(hours as f64, |from| (hours % 12) as f64 + from);
    let of_day_s = 3600.0 * hours + 60.0 * minutes as f64 + seconds - zone_s;
    match date {
        Some(date) => Some(86_400.0 * days_of(date)? as f64 + of_day_s),
        None if has_hours => Some(of_day_s.rem_euclid(86_400.0)),
        None => Some(of_day_s),
    }
}

/// Seconds of a time zone: `+HH:MM`, `+HHMM` or `+HH`.
fn zone_s(text: &str) -> Option<f64> {
    let (sign, zone) = if let Some(zone) = text.strip_prefix('+') { (1.0, zone) } else { (-1.0, text.strip_prefix('-')?) };
    let zone = zone.replace(':', "");
    let (hours, minutes) = match zone.len() {
        2 => (digits(&zone)?, 0),
        4 => (digits(&zone[..2])?, digits(&zone[2..])?),
        _ => return None,
    };
    (hours <= 14 && minutes < 60).then_some(sign * (3600 * hours + 60 * minutes) as f64)
}

fn digits(text: &str) -> Option<i64> {
    let text = text.trim();
    (text.len() <= 4 && text.bytes().all(|byte| byte.is_ascii_digit())).then(|| text.parse().ok())?
}

/// The month that begins with these letters.
fn month_of(text: &str) -> Option<i64> {
    const MONTHS: [&str; 12] = ["jan", "feb", "mar", "apr", "may", "jun", "jul", "aug", "sep", "oct", "nov", "dec"];
    let month = MONTHS.iter().position(|month| text.eq_ignore_ascii_case(month))?;
    i64::try_from(month + 1).ok()
}

/// Days from the start of 1970 to a date.
fn days_of(date: &str) -> Option<i64> {
    let in_one = |date: &str| Some(vec![digits(&date[..4])?, digits(&date[4..6])?, digits(&date[6..])?]);
    let separator = ['-', '.', '/'].into_iter().find(|separator| date.contains(*separator));
    let parts: Vec<i64> = match separator {
        Some(separator) => date.split(separator).map(|part| digits(part).or_else(|| month_of(part))).collect::<Option<_>>()?,
        None if date.len() == 8 && date.is_ascii() => in_one(date)?,
        None => return None,
    };
    let &[first, second, third] = parts.as_slice() else { return None };
    let (year, month, day) = match separator.unwrap_or('-') {
        _ if first > 31 => (first, second, third),
        '/' => (third, first, second),
        _ => (third, second, first),
    };
    if !(1..=12).contains(&month) || !(1..=31).contains(&day) {
        return None;
    }
    // Years begin in March, so that the leap day is the last of its year.
    let (year, month) = if month > 2 { (year, month - 3) } else { (year - 1, month + 9) };
    let of_year = (153 * month + 2) / 5 + day - 1;
    Some(365 * year + year.div_euclid(4) - year.div_euclid(100) + year.div_euclid(400) + of_year - 719_468)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_and_dates_are_seconds() {
        assert_eq!(clock_s("00:00:01.5"), Some(1.5));
        assert_eq!(clock_s("12:30:05,250"), Some(45_005.25));
        assert_eq!(clock_s("1970-01-02T00:00:00Z"), Some(86_400.0));
        assert_eq!(clock_s("2026-11-27 18:50:03.002"), Some(1_795_805_403.002));
        assert_eq!(clock_s("27.11.2026 18:50:03"), clock_s("11/27/2026 6:50:03 PM"));
        assert_eq!(clock_s("2024-02-29T00:00:00").map(|s| s + 86_400.0), clock_s("2024-03-01T00:00:00"));
        assert_eq!(clock_s("2026-11-27 18:50:03.5+02:00"), clock_s("2026-11-27T16:50:03.5Z"));
        assert_eq!(clock_s("2026-11-27 18:50:03-0130"), clock_s("2026-11-27 20:20:03"));
        assert_eq!([clock_s("01:02.250"), clock_s("60:00.000")], [Some(62.25), Some(3600.0)]);
        assert_eq!(clock_s("00:00:01+02:00"), Some(79_201.0));
        assert_eq!([clock_s("00:00:01:250"), clock_s("00:01:01:250000")], [Some(1.25), Some(61.25)]);
        assert_eq!(clock_s("6:50:03 PM +02:00"), clock_s("16:50:03"));
        assert_eq!(
            [clock_s("27-Nov-2026 18:50:03.002"), clock_s("20261127 18:50:03.002")],
            [clock_s("2026-11-27 18:50:03.002"); 2]
        );
        assert_eq!(
            [clock_s("0.25 sec"), clock_s("1.5 s"), clock_s("0 days 00:00:01.250000")],
            [Some(0.25), Some(1.5), Some(1.25)]
        );
        assert_eq!([clock_s("10:00:00;250"), clock_s("2 days 00:00:01")], [Some(36_000.25), Some(172_801.0)]);
        for text in [
            "12:00:00 +99",
            "12:00:00+1:2:3",
            "01:02",
            "2026-11-27 01:02.5",
            "",
            ":",
            "1:2",
            "12:61:00",
            "a:b:c",
            "2026-13-01 00:00:00",
            "1:2:3:4",
            "00:00:01:25",
            "00:00:1.5:250:100",
            "x_ref:mm",
            "12 mm",
            "sec",
            "a days 00:00:01",
            "99-Foo-2026 10:00:00",
            "2026112 10:00:00",
            "\u{b5}:1:2",
            "12:00:00 +1",
            "::",
            "T:1:2",
        ] {
            assert_eq!(clock_s(text), None, "{text}");
        }
    }
}
