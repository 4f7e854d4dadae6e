//! Chromium without a window, told what to do over the DevTools protocol.

use std::net::TcpStream;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use serde_json::{Value, json};
use tempfile::TempDir;
use tungstenite::{Message, WebSocket};

/// After which something hangs: many times what a busy machine needs.
const PATIENCE: Duration = Duration::from_secs(60);

/// A page in a browser of its own, which ends with it.
pub(crate) struct Page {
    browser: Browser,
    socket: WebSocket<TcpStream>,
    session: Option<String>,
    last: u64,
    /// Errors of the console, exceptions, and requests to others.
    pub(crate) complaints: Vec<String>,
    home: String,
}

struct Browser {
    process: Child,
    profile: TempDir,
}

impl Drop for Browser {
    fn drop(&mut self) {
        // Its children end when it does.
        _ = self.process.kill();
        _ = self.process.wait();
    }
}

fn name() -> Option<&'static str> {
    let works = |name: &&str| {
        Command::new(name).arg("--version").output().is_ok_and(|output| output.status.success())
    };
    ["chromium", "chromium-browser", "google-chrome"].into_iter().find(works)
}

impl Page {
    /// An empty page of this size; `home` is the only server that it may ask.
    pub(crate) fn new(home: &str, size: [u32; 2]) -> Option<Self> {
        Self::open(home, size, &["--disable-gpu"])
    }

    /// The same with WebGPU, on a software GPU.
    pub(crate) fn with_gpu(home: &str, size: [u32; 2]) -> Option<Self> {
        Self::open(home, size, &["--enable-unsafe-webgpu", "--use-webgpu-adapter=swiftshader"])
    }

    /// The same with WebGL, by software.
    pub(crate) fn with_webgl(home: &str, size: [u32; 2]) -> Option<Self> {
        Self::open(home, size, &["--use-angle=swiftshader", "--enable-unsafe-swiftshader"])
    }

    fn open(home: &str, [width, height]: [u32; 2], how: &[&str]) -> Option<Self> {
        let Some(name) = name() else { return super::skip("no chromium on this machine") };
        let profile = tempfile::tempdir().unwrap();
        let process = Command::new(name)
            .args(["--headless=new", "--no-sandbox", "--remote-debugging-port=0"])
            .args(how)
            .args(["--no-first-run", "--disable-background-networking", "--disable-dev-shm-usage"])
            .arg(format!("--window-size={width},{height}"))
            .arg(format!("--user-data-dir={}", profile.path().display()))
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let mut browser = Browser { process, profile };
        let (port, path) = browser.endpoint();
        let stream = TcpStream::connect(("127.0.0.1", port)).unwrap();
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        let address = format!("ws://127.0.0.1:{port}{path}");
        let (socket, _) = tungstenite::client(address, stream).unwrap();
        let (home, complaints) = (home.to_owned(), Vec::new());
        let mut page = Self { browser, socket, session: None, last: 0, complaints, home };
        let target = page.call("Target.createTarget", json!({ "url": "about:blank" }));
        let target = json!({ "targetId": target["targetId"], "flatten": true });
        let session = page.call("Target.attachToTarget", target);
        page.session = Some(session["sessionId"].as_str().unwrap().to_owned());
        for domain in ["Page", "Runtime", "Log", "Network"] {
            page.call(&format!("{domain}.enable"), json!({}));
        }
        page.resize([width, height], 1.0, false);
        Some(page)
    }

    /// What the browser answers to a command of the protocol.
    #[track_caller]
    pub(crate) fn call(&mut self, method: &str, parameters: Value) -> Value {
        self.last += 1;
        let mut message = json!({ "id": self.last, "method": method, "params": parameters });
        if let Some(session) = &self.session {
            message["sessionId"] = session.as_str().into();
        }
        self.socket.send(Message::text(message.to_string())).unwrap();
        let begun = Instant::now();
        loop {
            assert!(begun.elapsed() < PATIENCE, "{method} is not answered");
            assert!(self.browser.process.try_wait().unwrap().is_none(), "the browser ended");
            let Message::Text(text) = self.socket.read().unwrap() else { continue };
            let mut answer: Value = serde_json::from_str(&text).unwrap();
            if answer["id"] == self.last {
                assert!(answer["error"].is_null(), "{method}: {}", answer["error"]);
                return answer["result"].take();
            }
            self.event(&answer);
        }
    }

    fn event(&mut self, event: &Value) {
        let about = &event["params"];
        let is_bad = match event["method"].as_str() {
            Some("Runtime.exceptionThrown") => true,
            Some("Runtime.consoleAPICalled") => about["type"] == "error",
            Some("Log.entryAdded") => about["entry"]["level"] == "error",
            Some("Network.requestWillBeSent") => {
                let url = about["request"]["url"].as_str().unwrap_or_default();
                ![&self.home, "data:", "blob:", "about:"].iter().any(|own| url.starts_with(*own))
            }
            _ => false,
        };
        if is_bad {
            self.complaints.push(about.to_string());
        }
    }

    /// The value of an expression of the page's, awaited.
    #[track_caller]
    pub(crate) fn value(&mut self, expression: &str) -> Value {
        let parameters =
            json!({ "expression": expression, "awaitPromise": true, "returnByValue": true });
        let mut answer = self.call("Runtime.evaluate", parameters);
        assert!(answer["exceptionDetails"].is_null(), "{}", answer["exceptionDetails"]);
        answer["result"]["value"].take()
    }

    /// Waits until an expression is true.
    #[track_caller]
    pub(crate) fn until(&mut self, expression: &str) {
        let begun = Instant::now();
        while self.value(expression) != true {
            if begun.elapsed() > PATIENCE {
                let page = self.value("document.body.innerText");
                panic!("{expression}: never; {page}; {:?}", self.complaints);
            }
            std::thread::sleep(Duration::from_millis(20));
        }
    }

    pub(crate) fn go(&mut self, url: &str) {
        self.call("Page.navigate", json!({ "url": url }));
        self.until(&format!(
            "location.href.startsWith('{url}') && document.readyState === 'complete'"
        ));
    }

    /// A screen of this size, so many pixels for each of CSS's.
    pub(crate) fn resize(&mut self, [width, height]: [u32; 2], scale: f64, is_mobile: bool) {
        let metrics = json!({ "width": width, "height": height, "deviceScaleFactor": scale,
            "mobile": is_mobile });
        self.call("Emulation.setDeviceMetricsOverride", metrics);
        self.call("Emulation.setTouchEmulationEnabled", json!({ "enabled": is_mobile }));
    }

    pub(crate) fn mouse(&mut self, kind: &str, [x, y]: [f64; 2], more: Value) {
        let mut event = json!({ "type": kind, "x": x, "y": y });
        event.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
        self.call("Input.dispatchMouseEvent", event);
    }

    pub(crate) fn touch(&mut self, kind: &str, points: &[[f64; 2]]) {
        let points: Vec<_> = points.iter().map(|[x, y]| json!({ "x": x, "y": y })).collect();
        self.call("Input.dispatchTouchEvent", json!({ "type": kind, "touchPoints": points }));
    }

    /// What is on the screen, as an image file.
    pub(crate) fn screenshot(&mut self, format: &str) -> Vec<u8> {
        use base64::Engine;
        let shot = self.call("Page.captureScreenshot", json!({ "format": format, "quality": 82 }));
        base64::prelude::BASE64_STANDARD.decode(shot["data"].as_str().unwrap()).unwrap()
    }
}

impl Browser {
    /// Where it listens; it writes that to its profile.
    fn endpoint(&mut self) -> (u16, String) {
        let begun = Instant::now();
        loop {
            let said = std::fs::read_to_string(self.profile.path().join("DevToolsActivePort"));
            if let Some((port, path)) = said.as_deref().ok().and_then(|said| said.split_once('\n'))
            {
                return (port.parse().unwrap(), path.to_owned());
            }
            assert!(self.process.try_wait().unwrap().is_none(), "the browser ended");
            assert!(begun.elapsed() < PATIENCE, "the browser never listens");
            std::thread::sleep(Duration::from_millis(20));
        }
    }
}
