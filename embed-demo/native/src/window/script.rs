//! Input with its times from a file, for tests and benchmarks of the window.

use std::path::Path;
use std::sync::mpsc::channel;
use std::thread;
use std::time::Duration;

use winit::event::MouseButton;

use super::input::{Input, command, drag};

/// Time between two events of a drag.
const EVENT: Duration = Duration::from_millis(8);

/// Help on scripts, short and long.
pub const HELP: (&str, &str) = (
    "Play input from a file, then close and print timings",
    "\
Play input from a file, then close and print timings

One command a line: `wait MS`; `drag left|middle|right DX DY MS`, a distance in pixels and its
duration; `wheel STEPS`; `key NAME`, such as `key h`, `key left`, `key shift+up` or `key escape`;
`rest`, which waits until the picture is complete. Empty lines and lines that start with # are
skipped. The timings are one line of JSON: the number of moving pictures (frames), pictures per
second (fps), median, 95th percentile and maximum of the milliseconds between two, the median
scale, and the milliseconds from the last change to the complete picture (rest_ms).",
);

/// A line of a script.
#[derive(Clone, Debug, PartialEq)]
pub enum Line {
    /// Wait.
    Wait(Duration),
    /// A drag by pixels, and its duration.
    Drag(MouseButton, [f32; 2], Duration),
    /// Steps of the wheel, towards the scene.
    Wheel(f32),
    /// A key, and whether shift is held.
    Key(String, bool),
    /// Wait until the picture is complete.
    Rest,
}

/// Reads a script's file.
///
/// # Errors
/// One line: why it cannot be read, or what [`parse`] says.
pub fn read(path: &Path) -> Result<Vec<Line>, String> {
    let text = std::fs::read_to_string(path)
        .map_err(|e| format!("{}: cannot be read: {e}; give a text file", path.display()))?;
    parse(&text).map_err(|e| format!("{}: {e}", path.display()))
}

/// Reads a script.
///
/// # Errors
/// The number of the line, what was found and what was expected.
pub fn parse(text: &str) -> Result<Vec<Line>, String> {
    let lines = text.lines().enumerate().map(|(i, line)| (i + 1, line.trim()));
    let lines = lines.filter(|(_, line)| !line.is_empty() && !line.starts_with('#'));
    let read = |(number, line): (usize, &str)| {
        let expected = "expected wait, drag, wheel, key or rest as in --help";
        read_line(line)
            .ok_or_else(|| format!("line {number}: \"{}\", {expected}", line.escape_debug()))
    };
    lines.map(read).collect()
}

fn read_line(line: &str) -> Option<Line> {
    let words: Vec<&str> = line.split_whitespace().collect();
    let number = |word: &str| word.parse().ok().filter(|v: &f32| v.abs() < 1e6);
    let time = |word: &str| word.parse().ok().filter(|ms| *ms < 600_000).map(Duration::from_millis);
    Some(match words[..] {
        ["wait", ms] => Line::Wait(time(ms)?),
        ["drag", button, x, y, ms] => {
            let button = match button {
                "left" => MouseButton::Left,
                "middle" => MouseButton::Middle,
                "right" => MouseButton::Right,
                _ => return None,
            };
            Line::Drag(button, [number(x)?, number(y)?], time(ms)?)
        }
        ["wheel", steps] => Line::Wheel(number(steps)?),
        ["key", name] => {
            let (shift, name) = match name.strip_prefix("shift+") {
                Some(name) => (true, name),
                None => (false, name),
            };
            command(name, shift)?;
            Line::Key(name.to_owned(), shift)
        }
        ["rest"] => Line::Rest,
        _ => return None,
    })
}

/// Plays a script, then quits: `send` passes input to the window, and returns whether the
/// window is still open.
pub fn play(lines: &[Line], send: impl Fn(Input) -> bool) {
    for line in lines {
        let is_open = match line {
            Line::Wait(time) => {
                thread::sleep(*time);
                true
            }
            Line::Drag(button, way, time) => {
                let events = (time.as_millis() / EVENT.as_millis()).max(1) as u32;
                let part = way.map(|v| v / events as f32);
                (0..events).all(|_| {
                    let sent = drag(*button, false, part).is_none_or(&send);
                    thread::sleep(*time / events);
                    sent
                })
            }
            Line::Wheel(steps) => send(Input::Approach(*steps)),
            Line::Key(name, shift) => send(Input::Key(name.clone(), *shift)),
            Line::Rest => {
                let (sender, at_rest) = channel();
                send(Input::NotifyAtRest(sender)) && at_rest.recv().is_ok()
            }
        };
        if !is_open {
            return;
        }
    }
    send(Input::Quit);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reads_what_help_says() {
        let text = "# a comment\n\nwait 5\ndrag right 10 -2.5 16\nwheel -1\nkey shift+up\nrest\n";
        let ms = Duration::from_millis;
        let expected = [
            Line::Wait(ms(5)),
            Line::Drag(MouseButton::Right, [10.0, -2.5], ms(16)),
            Line::Wheel(-1.0),
            Line::Key("up".to_owned(), true),
            Line::Rest,
        ];
        assert_eq!(parse(text).unwrap(), expected);
    }

    #[test]
    fn says_what_it_cannot_read() {
        for line in ["wait", "wait -1", "drag up 1 1 1", "wheel x", "wheel nan", "key foo", "go"] {
            let error = parse(&format!("rest\n{line}")).unwrap_err();
            assert!(error.starts_with(&format!("line 2: \"{line}\", expected")), "{error}");
        }
    }

    #[test]
    fn a_drag_is_many_small_ones() {
        let sent = std::cell::RefCell::new(Vec::new());
        let lines = [Line::Drag(MouseButton::Left, [32.0, 16.0], Duration::from_millis(16))];
        play(&lines, |input| {
            sent.borrow_mut().push(input);
            true
        });
        let sent = sent.into_inner();
        assert_eq!(sent.len(), 3);
        assert!(matches!(sent[0], Input::Turn([16.0, 8.0])) && matches!(sent[2], Input::Quit));
    }
}
