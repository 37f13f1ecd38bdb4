//! What can go wrong, by cause. Every message is one line that says what, where and what to do.

use std::io;
use std::path::{Path, PathBuf};

/// Result of every fallible function of this crate.
pub type Result<T> = std::result::Result<T, Error>;

/// A failure that the user can act upon. Our own bugs are `assert!`s instead.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A file could not be read or written.
    #[error("cannot {action} {}: {cause}", path.display())]
    Io {
        /// What was attempted, as a verb: "read", "write", "rename".
        action: &'static str,
        /// The file.
        path: PathBuf,
        /// What the system said. Part of the message, so not a `source` that would be printed again.
        cause: io::Error,
    },
    /// The bytes or the text do not follow the format.
    #[error("{place}: {problem}")]
    Format {
        /// Where: file kind and lump, index, line number or world coordinates.
        place: String,
        /// What is wrong there and what to do about it.
        problem: String,
    },
    /// The input is well formed but larger than a format or this program can hold.
    #[error("{what} is {value}, the limit is {limit}: {advice}")]
    Limit {
        /// The quantity.
        what: String,
        /// Its value here.
        value: u64,
        /// The largest value accepted.
        limit: u64,
        /// What to do about it.
        advice: &'static str,
    },
    /// A valid file of a kind that is not handled.
    #[error("unsupported: {0}")]
    Unsupported(String),
    /// A setting (option or worldspawn key) has an unusable value.
    #[error("setting {name}: {problem}")]
    Setting {
        /// Option or key as the user writes it.
        name: String,
        /// What is wrong and which values are accepted.
        problem: String,
    },
}

impl Error {
    /// A format error at `place`.
    pub fn format(place: impl Into<String>, problem: impl Into<String>) -> Self {
        Self::Format { place: place.into(), problem: problem.into() }
    }

    /// A setting error for the option or key `name`.
    pub fn setting(name: impl Into<String>, problem: impl Into<String>) -> Self {
        Self::Setting { name: name.into(), problem: problem.into() }
    }

    /// For `map_err` on file operations: `action` is a verb such as "read".
    pub fn io(action: &'static str, path: &Path) -> impl FnOnce(io::Error) -> Self {
        let path = path.to_path_buf();
        move |cause| Self::Io { action, path, cause }
    }
}

/// The known word that is most like `word`, for "did you mean": the first of those that are alike.
///
/// # Panics
/// If no word is known.
pub(crate) fn nearest<'a>(word: &str, known: impl IntoIterator<Item = &'a str>) -> &'a str {
    let distance = |k: &&str| strsim::damerau_levenshtein(word, k);
    known.into_iter().min_by_key(distance).expect("some word is known")
}
