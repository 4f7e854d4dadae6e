//! Reads JSON files; what is wrong with one is said in one line with its place.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde::de::{DeserializeOwned, IgnoredAny};

/// Larger JSON files are refused unread, in bytes.
pub const MAX_JSON_BYTES: u64 = 256 << 20;

/// Why a JSON file or text was refused. Each message is one line.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum JsonError {
    /// The file cannot be opened or read.
    #[error("{}: cannot be read: {source}; check the path and its permissions", one_line(.file))]
    Unreadable {
        /// The file.
        file: PathBuf,
        /// The system's reason.
        source: std::io::Error,
    },
    /// The file is larger than [`MAX_JSON_BYTES`].
    #[error(
        "{}: {bytes} bytes, at most {MAX_JSON_BYTES} are read; is this really a JSON file of cameras?",
        one_line(.file)
    )]
    TooLarge {
        /// The file.
        file: PathBuf,
        /// Its size.
        bytes: u64,
    },
    /// The text is not JSON.
    #[error("{}:{line}:{column}: not valid JSON: {problem}; repair or re-export the file", one_line(.file))]
    Syntax {
        /// The file.
        file: PathBuf,
        /// Line, from 1.
        line: usize,
        /// Column, from 1.
        column: usize,
        /// What the parser found.
        problem: String,
    },
    /// A NaN, an infinity or a number too large stands in the text.
    #[error(
        "{}:{line}:{column}: a number is not finite; expected finite numbers only: remove that camera or re-export the file",
        one_line(.file)
    )]
    NonFinite {
        /// The file.
        file: PathBuf,
        /// Line, from 1.
        line: usize,
        /// Column, from 1.
        column: usize,
    },
    /// Valid JSON with other contents than expected.
    #[error("{}:{line}:{column}: {problem}; expected {expected}", one_line(.file))]
    Contents {
        /// The file.
        file: PathBuf,
        /// Line, from 1.
        line: usize,
        /// Column, from 1.
        column: usize,
        /// What was found.
        problem: String,
        /// What the file should hold.
        expected: &'static str,
    },
}

/// The names of a JSON object's keys.
pub(crate) type Keys = BTreeMap<String, IgnoredAny>;

/// A path as one line of text: control characters are escaped.
#[must_use]
pub fn one_line(path: &Path) -> String {
    escape(&path.display().to_string())
}

/// Text as one line: control characters are escaped.
#[must_use]
pub fn escape(text: &str) -> String {
    let mut line = String::with_capacity(text.len());
    for c in text.chars() {
        if c.is_control() {
            line.extend(c.escape_default());
        } else {
            line.push(c);
        }
    }
    line
}

/// The bytes of a JSON file, without a byte order mark.
pub(crate) fn read(file: &Path) -> Result<Vec<u8>, JsonError> {
    let unreadable = |source| JsonError::Unreadable { file: file.to_owned(), source };
    let bytes = std::fs::metadata(file).map_err(unreadable)?.len();
    if bytes > MAX_JSON_BYTES {
        return Err(JsonError::TooLarge { file: file.to_owned(), bytes });
    }
    let mut text = std::fs::read(file).map_err(unreadable)?;
    if text.starts_with(b"\xef\xbb\xbf") {
        text.drain(..3);
    }
    Ok(text)
}

/// Parses `text`, which came from `file`; `expected` completes "expected …".
pub(crate) fn parse<T: DeserializeOwned>(
    text: &[u8],
    file: &Path,
    expected: &'static str,
) -> Result<T, JsonError> {
    serde_json::from_slice(text).map_err(|error| {
        let file = file.to_owned();
        let (line, column) = (error.line(), error.column());
        let problem = escape(&without_place(&error));
        if error.is_data() {
            return JsonError::Contents { file, line, column, problem, expected };
        }
        if problem.contains("number out of range") || not_finite_at(text, line, column) {
            return JsonError::NonFinite { file, line, column };
        }
        JsonError::Syntax { file, line, column, problem }
    })
}

/// The parser's message; the place is said once, by us.
fn without_place(error: &serde_json::Error) -> String {
    let message = error.to_string();
    let place = format!(" at line {} column {}", error.line(), error.column());
    message.strip_suffix(&place).unwrap_or(&message).to_owned()
}

/// Whether Python's `NaN` or `Infinity` stands at this place.
fn not_finite_at(text: &[u8], line: usize, column: usize) -> bool {
    let Some(line) = text.split(|&b| b == b'\n').nth(line.saturating_sub(1)) else {
        return false;
    };
    // The parser's column is that of the first character it could not take,
    // or of the minus sign before it.
    let Some(rest) = line.get(column.saturating_sub(1)..) else {
        return false;
    };
    let rest = rest.strip_prefix(b"-").unwrap_or(rest);
    rest.starts_with(b"NaN") || rest.starts_with(b"Infinity")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn error(text: &str) -> JsonError {
        parse::<Vec<f64>>(text.as_bytes(), Path::new("a.json"), "a list of numbers").unwrap_err()
    }

    #[test]
    fn places_are_given() {
        let syntax = error("[1,\n 2,,]").to_string();
        assert!(syntax.starts_with("a.json:2:4: not valid JSON: "), "{syntax}");
        let contents = error("[1, \"x\"]").to_string();
        assert!(contents.starts_with("a.json:1:7: invalid type"), "{contents}");
        assert!(contents.ends_with("expected a list of numbers"), "{contents}");
    }

    #[test]
    fn numbers_that_are_not_finite() {
        for text in ["[1, NaN]", "[\n-Infinity]", "[Infinity ]", "[1e999]"] {
            assert!(matches!(error(text), JsonError::NonFinite { .. }), "{text}: {}", error(text));
        }
    }

    #[test]
    fn a_huge_file_is_refused_unread() {
        let file = tempfile::NamedTempFile::new().unwrap();
        file.as_file().set_len(MAX_JSON_BYTES + 1).unwrap();
        assert!(matches!(read(file.path()), Err(JsonError::TooLarge { .. })));
    }

    #[test]
    fn names_stay_on_one_line() {
        assert_eq!(one_line(Path::new("a\nb é.json")), "a\\nb é.json");
    }
}
