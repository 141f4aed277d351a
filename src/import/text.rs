//! Words and numbers in files of text that need not be UTF-8.

/// Lines with their numbers, from 1. A line ends with `\n`, `\r\n` or `\r`.
pub(super) struct Lines<'a> {
    rest: Option<&'a [u8]>,
    number: u64,
}

/// The lines of `text`.
pub(super) fn lines(text: &[u8]) -> Lines<'_> {
    Lines { rest: Some(text), number: 0 }
}

impl<'a> Iterator for Lines<'a> {
    type Item = (u64, &'a [u8]);

    fn next(&mut self) -> Option<(u64, &'a [u8])> {
        let text = self.rest.filter(|rest| !rest.is_empty())?;
        self.number += 1;
        let end = text.iter().position(|b| matches!(b, b'\n' | b'\r')).unwrap_or(text.len());
        let (line, mut rest) = text.split_at(end);
        rest = rest.strip_prefix(b"\r\n").or(rest.get(1..)).unwrap_or_default();
        self.rest = Some(rest);
        Some((self.number, line))
    }
}

/// The words of a line: what lies between white space.
pub(super) fn words(line: &[u8]) -> impl Iterator<Item = &[u8]> + Clone {
    line.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty())
}

/// The first word of a line, and the rest without white space around it.
pub(super) fn first_word(line: &[u8]) -> Option<(&[u8], &[u8])> {
    let line = line.trim_ascii();
    if line.is_empty() {
        return None;
    }
    let end = line.iter().position(u8::is_ascii_whitespace).unwrap_or(line.len());
    Some((&line[..end], line[end..].trim_ascii()))
}

/// A number as C and its kin write it. `nan`, `inf` and what old Windows writes for them (`-1.#IND`) are numbers that are not
/// finite.
pub(super) fn number(word: &[u8]) -> Option<f64> {
    let text = std::str::from_utf8(word).ok()?;
    text.parse().ok().or_else(|| {
        let digits = text.trim_start_matches(['-', '+']);
        digits.split_once(".#").filter(|(whole, _)| *whole == "1").map(|_| f64::NAN)
    })
}

/// A whole number.
pub(super) fn integer(word: &[u8]) -> Option<i64> {
    std::str::from_utf8(word).ok()?.parse().ok()
}

/// Text to show: what is not UTF-8 is taken for Latin-1, control characters become spaces.
pub(super) fn name(bytes: &[u8]) -> String {
    let text = match std::str::from_utf8(bytes) {
        Ok(text) => text.to_owned(),
        Err(_) => bytes.iter().map(|&b| char::from(b)).collect(),
    };
    text.chars().map(|c| if c.is_control() { ' ' } else { c }).take(LONGEST_NAME).collect::<String>().trim().to_owned()
}

/// Longer names are cut.
const LONGEST_NAME: usize = 1000;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_end_in_three_ways_and_are_counted() {
        let all: Vec<(u64, &[u8])> = lines(b"a\nb\r\n\rc").collect();
        assert_eq!(all, [(1, &b"a"[..]), (2, b"b"), (3, b""), (4, b"c")]);
        assert_eq!(lines(b"").count(), 0);
    }

    #[test]
    fn words_numbers_and_names() {
        assert_eq!(words(b"  v 1\t2 ").collect::<Vec<_>>(), [&b"v"[..], b"1", b"2"]);
        assert_eq!(first_word(b" o  two words "), Some((&b"o"[..], &b"two words"[..])));
        assert_eq!(first_word(b"  "), None);
        assert_eq!(number(b"-1.5e3"), Some(-1500.0));
        assert!(number(b"-1.#IND").is_some_and(f64::is_nan) && number(b"1.#INF").is_some() && number(b"1,5").is_none());
        assert_eq!(integer(b"-3"), Some(-3));
        assert_eq!(name(b"caf\xE9\x07 "), "café");
    }
}
