//! Input from a file, with its times: so that a window can be driven by a test or a
//! benchmark.

use std::sync::mpsc::channel;
use std::thread;
use std::time::Duration;

use winit::event::MouseButton;

use crate::input::{Input, command, drag};

/// Between two events of a drag.
const EVENT: Duration = Duration::from_millis(8);

/// What is said about scripts.
pub const HELP: &str = "\
File of input, one thing a line: `wait MS`; `drag left|middle|right DX DY MS`, pixels and how
long; `wheel STEPS`; `key NAME`, e.g. `key h`, `key left`, `key shift+up`, `key escape`; `rest`,
until the picture is whole; empty lines and # are skipped. Then the window closes, and what
pictures took is printed as one line of JSON: moving pictures (frames), how many a second (fps),
median, 95th percentile and maximum of the milliseconds between two, median scale, and the
milliseconds from the last change to the whole picture (rest_ms)";

/// A line of a script.
#[derive(Clone, Debug, PartialEq)]
pub enum Line {
    /// Nothing for a while.
    Wait(Duration),
    /// A drag over so many pixels in so long.
    Drag(MouseButton, [f32; 2], Duration),
    /// Nearer by so many steps.
    Wheel(f32),
    /// A key, and whether shift is held.
    Key(String, bool),
    /// Nothing until the picture is whole.
    Rest,
}

/// Reads a script.
///
/// # Errors
/// The number of the line, what was found and what was expected.
pub fn parse(text: &str) -> Result<Vec<Line>, String> {
    let lines = text.lines().enumerate().map(|(i, line)| (i + 1, line.trim()));
    let lines = lines.filter(|(_, line)| !line.is_empty() && !line.starts_with('#'));
    let read = |(number, line): (usize, &str)| {
        let expected = "expected wait, drag, wheel, key or rest as --help has them";
        read(line).ok_or_else(|| format!("line {number}: \"{}\", {expected}", line.escape_debug()))
    };
    lines.map(read).collect()
}

fn read(line: &str) -> Option<Line> {
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

/// Plays a script, then quits: `send` takes the input to the window, and says whether
/// there still is one.
pub fn play(lines: &[Line], send: impl Fn(Input) -> bool) {
    for line in lines {
        let is_there = match line {
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
                let (tell, told) = channel();
                send(Input::TellAtRest(tell)) && told.recv().is_ok()
            }
        };
        if !is_there {
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
