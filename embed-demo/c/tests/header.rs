//! The committed header is the one that cbindgen makes of the crate.
//!
//! `POCKETNERF_BLESS=1` writes it.

use std::path::Path;

#[test]
fn header_is_that_of_the_crate() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let config = cbindgen::Config::from_file(root.join("cbindgen.toml")).unwrap();
    let library = root.join("src/lib.rs");
    let builder = cbindgen::Builder::new().with_config(config).with_src(library);
    let mut made = Vec::new();
    builder.generate().unwrap().write(&mut made);
    let made = String::from_utf8(made).unwrap();
    let path = root.join("include/pocketnerf.h");
    if std::env::var_os("POCKETNERF_BLESS").is_some_and(|value| value == "1") {
        std::fs::write(&path, &made).unwrap();
    }
    let committed = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(
        made == committed,
        "{} is not what the sources say; POCKETNERF_BLESS=1 cargo test -p pocketnerf-c --test header writes it",
        path.display()
    );
}
