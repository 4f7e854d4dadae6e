//! The page of a chart.

use std::path::Path;
use std::process::Command;

use serde_json::Value;

use super::chart::text;

/// What a visitor does, as a script in a copy of the page, which writes down what it finds.
const VISIT: &str = r##"<script>
const found = { errors: window.errors };
const marks = () => [...document.querySelectorAll("#chart .mark")];
const fire = (element, name) => element.dispatchEvent(new Event(name, { bubbles: true }));
const text = (id) => document.getElementById(id).textContent;
found.marks = marks().length;
found.peers = document.querySelectorAll("#chart polygon.mark").length;
found.frontier = document.querySelector("#chart .frontier").getAttribute("d");
fire(marks()[0], "mouseenter");
found.hover = text("details");
found.picture = !document.getElementById("picture").hidden;
fire(marks()[0], "mouseleave");
found.left = text("details");
fire(document.querySelector("#chart polygon.mark"), "click");
found.kept = text("details");
const box = document.querySelector("#methods input[value=nerf]");
box.checked = false;
fire(box, "change");
found.filtered = marks().length;
const x = document.getElementById("x");
found.costs = [...x.options].map((option) => option.value);
x.value = "train_seconds";
fire(x, "change");
found.trained = marks().length;
found.rows = document.querySelectorAll("#table tbody tr").length;
found.foreign = document.querySelectorAll("b").length;
const result = document.createElement("pre");
result.id = "found";
result.textContent = JSON.stringify(found);
document.body.append(result);
</script></body>"##;
const WATCH: &str = "<head><script>window.errors = []; window.onerror = (message) => \
                     { window.errors.push(String(message)); };</script>";

/// Opens the page in a headless browser, if there is one.
pub(crate) fn page_works(page: &Path) {
    let html = std::fs::read_to_string(page).unwrap();
    assert!(!html.contains("</script><b>"), "a peer's text ends the script");
    let Some(browser) = browser() else {
        eprintln!("no chromium on this machine: the page was not opened");
        return;
    };
    let visited = page.with_file_name("visited.html");
    let html = html.replacen("<head>", WATCH, 1).replacen("</body>", VISIT, 1);
    std::fs::write(&visited, html).unwrap();
    let profile = tempfile::tempdir().unwrap();
    let output = Command::new(browser)
        .args(["--headless", "--no-sandbox", "--disable-gpu", "--dump-dom"])
        .arg(format!("--user-data-dir={}", text(profile.path())))
        .arg(format!("file://{}", text(&visited.canonicalize().unwrap())))
        .output()
        .unwrap();
    let dom = String::from_utf8(output.stdout).unwrap();
    let found =
        dom.split_once("<pre id=\"found\">").and_then(|(_, rest)| rest.split_once("</pre>"));
    let (found, _) = found.unwrap_or_else(|| {
        panic!("the script did not end: {}", String::from_utf8_lossy(&output.stderr))
    });
    let unescaped = found.replace("&lt;", "<").replace("&gt;", ">").replace("&amp;", "&");
    let found: Value = serde_json::from_str(&unescaped).unwrap();
    assert_eq!(found["errors"], serde_json::json!([]), "{found}");
    assert_eq!((&found["marks"], &found["peers"]), (&9.into(), &1.into()), "{found}");
    assert!(found["frontier"].as_str().unwrap().starts_with('M'), "{found}");
    let says = |key: &str, expected: &str| {
        assert!(found[key].as_str().unwrap().contains(expected), "{key}: {found}");
    };
    says("hover", "PSNR, dB");
    says("hover", "pocketnerf train builtin");
    assert_eq!(found["picture"], true, "{found}");
    says("left", "Point at a mark.");
    says("kept", "</script><b>a paper</b>");
    // Four of the grid and the peer; the peer has no time of training.
    assert_eq!((&found["filtered"], &found["trained"]), (&5.into(), &4.into()), "{found}");
    assert_eq!((&found["rows"], &found["foreign"]), (&5.into(), &0.into()), "{found}");
    assert!(found["costs"].as_array().unwrap().contains(&"ms_per_frame".into()), "{found}");
}

fn browser() -> Option<&'static str> {
    let works = |name: &&str| {
        Command::new(name).arg("--version").output().is_ok_and(|output| output.status.success())
    };
    ["chromium", "chromium-browser", "google-chrome"].into_iter().find(works)
}
