//! Lines and numbers of the text scene format, with the line number for every complaint.

use crate::{Error, Result};

/// The text of a scene file. A byte order mark is skipped.
///
/// # Errors
/// [`Error::Format`] with the line of the first byte that is not UTF-8.
pub fn decode<'a>(bytes: &'a [u8], name: &str) -> Result<&'a str> {
    let text = std::str::from_utf8(bytes).map_err(|e| {
        let line = 1 + bytes[..e.valid_up_to()].iter().filter(|&&b| b == b'\n').count();
        Error::format(place(name, line), "not text: a scene is a file of plain numbers")
    })?;
    Ok(text.strip_prefix('\u{feff}').unwrap_or(text))
}

/// How a line of the file `name` is called in messages.
pub(super) fn place(name: &str, line: usize) -> String {
    format!("{name}: line {line}")
}

/// A line that holds something other than blanks and a comment.
#[derive(Clone, Copy)]
pub(super) struct Line<'a> {
    /// Counted from 1 in the file, blank lines included.
    pub number: usize,
    content: &'a str,
}

/// The lines of `text` that hold something, in order.
pub(super) fn lines(text: &str) -> impl Iterator<Item = Line<'_>> {
    text.lines().enumerate().filter_map(|(i, line)| {
        let content = line.split('#').next().unwrap_or("").trim();
        (!content.is_empty()).then_some(Line { number: i + 1, content })
    })
}

impl<'a> Line<'a> {
    /// Exactly `N` finite numbers; `what` names them in the complaint.
    pub fn floats<const N: usize>(&self, what: &str) -> std::result::Result<[f64; N], String> {
        self.parse_all(what, |token| {
            let value: f64 =
                token.parse().map_err(|_| format!("\"{}\" is not a number", excerpt(token)))?;
            if value.is_finite() {
                Ok(value)
            } else {
                Err(format!("\"{}\" is not a finite number", excerpt(token)))
            }
        })
    }

    /// Exactly `N` counting numbers; `what` names them in the complaint.
    pub fn counts<const N: usize>(&self, what: &str) -> std::result::Result<[u32; N], String> {
        self.parse_all(what, |token| {
            token.parse().map_err(|_| {
                format!("\"{}\" is not a whole number from 0 to {}", excerpt(token), u32::MAX)
            })
        })
    }

    /// The line up to its word number `count`, and the words from there if the first of them is none that
    /// could be a number.
    pub fn words_after(&self, count: usize) -> (Self, &'a str) {
        let word = self.content.split_whitespace().nth(count);
        let Some(word) = word.filter(|w| w.starts_with(|c: char| c.is_ascii_alphabetic())) else {
            return (*self, "");
        };
        let number = word.parse::<f64>().is_ok();
        // Both are parts of one string.
        let at = word.as_ptr() as usize - self.content.as_ptr() as usize;
        if number {
            (*self, "")
        } else {
            (Self { content: &self.content[..at], ..*self }, &self.content[at..])
        }
    }

    fn parse_all<T: Copy + Default, const N: usize>(
        &self,
        what: &str,
        parse: impl Fn(&str) -> std::result::Result<T, String>,
    ) -> std::result::Result<[T; N], String> {
        let found = self.content.split_whitespace().count();
        let mut values = [T::default(); N];
        for (value, token) in values.iter_mut().zip(self.content.split_whitespace()) {
            *value = parse(token)?;
        }
        if found != N {
            return Err(format!("{found} numbers where {N} are expected ({what})"));
        }
        Ok(values)
    }
}

/// The start of a word, fit for a one-line message.
pub(super) fn excerpt(token: &str) -> String {
    let mut shown: String = token.chars().take(24).collect::<String>().escape_debug().collect();
    if token.chars().nth(24).is_some() {
        shown.push_str("...");
    }
    shown
}
