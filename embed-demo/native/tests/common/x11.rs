//! A display of its own, and hands.

#![allow(dead_code, reason = "each test uses a part")]

use std::io::{BufRead, BufReader, Write};
use std::process::{Child, Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use x11rb::connection::Connection;
use x11rb::protocol::xproto::{
    ConfigureWindowAux, ConnectionExt, ImageFormat, InputFocus, MapState, Window,
};
use x11rb::protocol::xtest::ConnectionExt as _;
use x11rb::rust_connection::RustConnection;

/// After this a test has failed, however slow the machine.
const PATIENCE: Duration = Duration::from_secs(120);

/// A program that does not outlive its test.
pub(crate) struct Program(pub(crate) Child);

impl Drop for Program {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Asks until there is an answer.
pub(crate) fn wait_for<T>(what: &str, mut ask: impl FnMut() -> Option<T>) -> T {
    let begun = Instant::now();
    loop {
        if let Some(answer) = ask() {
            return answer;
        }
        assert!(begun.elapsed() < PATIENCE, "waited in vain for {what}");
        sleep(Duration::from_millis(20));
    }
}

pub(crate) struct Display {
    /// `:N`.
    pub(crate) name: String,
    connection: RustConnection,
    root: Window,
    _server: Program,
}

impl Display {
    /// A display under a number that is free. `None`, and a word about it, without Xvfb;
    /// that is a failure where POCKETNERF_REQUIRE_TOOLS is set.
    pub(crate) fn open() -> Option<Self> {
        let mut command = Command::new("Xvfb");
        command.args(["-displayfd", "1", "-screen", "0", "640x480x24", "-nolisten", "tcp"]);
        // With the last who looks at it, should the test be killed.
        command.arg("-terminate");
        let server = command.stdout(Stdio::piped()).stderr(Stdio::null()).spawn();
        let mut server = match server {
            Ok(server) => Program(server),
            Err(e) => {
                assert!(std::env::var_os("POCKETNERF_REQUIRE_TOOLS").is_none(), "Xvfb: {e}");
                // Past the test harness, which keeps what tests that pass have printed.
                let _ = writeln!(std::io::stderr(), "SKIPPED: Xvfb: {e}; apt-get install xvfb");
                return None;
            }
        };
        let mut number = String::new();
        // Ends with a number, or when the server does.
        BufReader::new(server.0.stdout.take().unwrap()).read_line(&mut number).unwrap();
        assert!(!number.trim().is_empty(), "Xvfb found no display number");
        let name = format!(":{}", number.trim());
        let (connection, screen) = wait_for("the display", || x11rb::connect(Some(&name)).ok());
        let root = connection.setup().roots[screen].root;
        Some(Self { name, connection, root, _server: server })
    }

    /// The window of this size, when it is there; it gets the keyboard.
    pub(crate) fn window(&self, size: [u16; 2]) -> Window {
        let window = wait_for("the window", || {
            let tree = self.connection.query_tree(self.root).ok()?.reply().ok()?;
            tree.children.into_iter().find(|window| {
                let attributes = self.connection.get_window_attributes(*window).unwrap().reply();
                attributes.is_ok_and(|a| a.map_state == MapState::VIEWABLE)
                    && self.size(*window) == Some(size)
            })
        });
        self.connection.set_input_focus(InputFocus::PARENT, window, x11rb::CURRENT_TIME).unwrap();
        self.connection.flush().unwrap();
        window
    }

    fn size(&self, window: Window) -> Option<[u16; 2]> {
        let geometry = self.connection.get_geometry(window).ok()?.reply().ok()?;
        Some([geometry.width, geometry.height])
    }

    /// RGB bytes of what a window shows.
    pub(crate) fn seen(&self, window: Window) -> Vec<u8> {
        let [width, height] = self.size(window).unwrap();
        let image =
            self.connection.get_image(ImageFormat::Z_PIXMAP, window, 0, 0, width, height, u32::MAX);
        let data = image.unwrap().reply().unwrap().data;
        data.as_chunks::<4>().0.iter().flat_map(|[b, g, r, _]| [*r, *g, *b]).collect()
    }

    pub(crate) fn resize(&self, window: Window, [width, height]: [u32; 2]) {
        let size = ConfigureWindowAux::new().width(width).height(height);
        self.connection.configure_window(window, &size).unwrap();
        self.connection.flush().unwrap();
    }

    fn fake(&self, kind: u8, detail: u8, [x, y]: [i16; 2]) {
        self.connection.xtest_fake_input(kind, detail, 0, self.root, x, y, 0).unwrap();
        self.connection.flush().unwrap();
    }

    /// Presses a key, by its keysym, and lets it go.
    pub(crate) fn key(&self, keysym: u32) {
        let setup = self.connection.setup();
        let (first, last) = (setup.min_keycode, setup.max_keycode);
        let mapping = self.connection.get_keyboard_mapping(first, last - first + 1).unwrap();
        let mapping = mapping.reply().unwrap();
        let mut keys = mapping.keysyms.chunks(mapping.keysyms_per_keycode.into());
        let key = first + keys.position(|syms| syms[0] == keysym).unwrap() as u8;
        self.fake(2, key, [0; 2]);
        self.fake(3, key, [0; 2]);
    }

    pub(crate) fn point(&self, place: [i16; 2]) {
        self.fake(6, 0, place);
    }

    pub(crate) fn press(&self, button: u8) {
        self.fake(4, button, [0; 2]);
    }

    pub(crate) fn release(&self, button: u8) {
        self.fake(5, button, [0; 2]);
    }
}
