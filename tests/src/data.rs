//! Where the data of tests lies.

use std::ffi::OsString;
use std::path::PathBuf;

/// The folder of real scenes and checkpoints, `POCKETNERF_DATA`. Without it the tests that
/// need one are left out, and say so.
///
/// # Panics
/// If it is not set although `POCKETNERF_REQUIRE_DATA` is.
#[must_use]
pub fn data() -> Option<PathBuf> {
    folder(|name| std::env::var_os(name))
}

fn folder(variable: impl Fn(&str) -> Option<OsString>) -> Option<PathBuf> {
    let folder = variable("POCKETNERF_DATA").map(PathBuf::from);
    if folder.is_none() {
        let required = variable("POCKETNERF_REQUIRE_DATA").is_some();
        assert!(!required, "POCKETNERF_DATA is not set, and POCKETNERF_REQUIRE_DATA is");
        println!("skipped: POCKETNERF_DATA is not set");
    }
    folder
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_may_be_missing() {
        assert_eq!(folder(|_| None), None);
        assert_eq!(folder(|name| Some(name.into())), Some("POCKETNERF_DATA".into()));
    }

    #[test]
    #[should_panic(expected = "POCKETNERF_DATA is not set")]
    fn unless_it_is_required() {
        let _ = folder(|name| (name == "POCKETNERF_REQUIRE_DATA").then(|| "1".into()));
    }
}
