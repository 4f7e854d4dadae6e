//! A browser, and a server for it to ask.

pub(crate) mod chromium;
pub(crate) mod server;

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

/// Whether missing tools are failures: set where everything is to be tested.
const REQUIRE: &str = "POCKETNERF_REQUIRE_TOOLS";

/// Says what is missing, if that may be.
pub(crate) fn skip<T>(what: &str) -> Option<T> {
    assert!(std::env::var_os(REQUIRE).is_none(), "{what}, and {REQUIRE} is set");
    eprintln!("{what}: the page was not opened");
    None
}

/// The folder that `build` makes, made once for all tests.
pub(crate) fn dist() -> Option<PathBuf> {
    static DIST: OnceLock<Option<PathBuf>> = OnceLock::new();
    DIST.get_or_init(build).clone()
}

fn build() -> Option<PathBuf> {
    let web = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut ask = Command::new("rustc");
    ask.args(["--print", "target-libdir", "--target", "wasm32-unknown-unknown"]);
    let folder = ask.output().map(|output| String::from_utf8(output.stdout).unwrap());
    if !folder.is_ok_and(|folder| Path::new(folder.trim()).is_dir()) {
        return skip("rustc cannot compile for wasm32-unknown-unknown here");
    }
    let built = Command::new(web.join("build")).arg("--quiet").output().unwrap();
    assert!(built.status.success(), "{}", String::from_utf8_lossy(&built.stderr));
    Some(web.join("dist"))
}
