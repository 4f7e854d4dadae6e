//! Input, independent of the window system.

use std::sync::mpsc::Sender;

use winit::event::MouseButton;
use winit::keyboard::{Key, NamedKey};

use crate::paint::modes::Mode;

/// An input event.
#[derive(Clone, Debug)]
pub enum Input {
    /// A drag that turns the camera around the scene, pixels.
    Turn([f32; 2]),
    /// A drag that moves the scene along, pixels.
    Pull([f32; 2]),
    /// Steps towards the scene.
    Approach(f32),
    /// A key, by the letter or the name that [`key`] gives it, and whether shift was held.
    Key(String, bool),
    /// Another thread has painted a picture.
    Painted,
    /// Notify when the picture is complete.
    NotifyAtRest(Sender<()>),
    /// Close the window.
    Quit,
}

impl Input {
    /// Whether a path that is played ends with it: with all that a hand does, but the key that
    /// does so itself.
    pub(super) fn ends_path(&self) -> bool {
        match self {
            Self::Key(name, shift) => {
                command(name, *shift) != Some(Command::Path(PathCommand::Play))
            }
            Self::Painted | Self::NotifyAtRest(_) => false,
            _ => true,
        }
    }
}

/// The command of a key.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Command {
    /// Change what is shown.
    Mode(Mode),
    /// Change the quality.
    Quality(f32),
    /// Next quality.
    NextQuality,
    /// Next frame rate.
    NextRate,
    /// Back to the first view.
    Reset,
    /// Toggle the overlay.
    Overlay,
    /// Write a screenshot.
    Screenshot,
    /// Do something with keyframes.
    Path(PathCommand),
    /// Turn around the scene, radians.
    Turn([f32; 2]),
    /// Move sideways, as a fraction of the distance.
    Shift([f32; 2]),
    /// Steps towards the scene.
    Approach(f32),
    /// Close the window.
    Quit,
}

/// What keys do with keyframes, and with the path through them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PathCommand {
    /// Add what is shown.
    Add,
    /// Remove the last keyframe.
    Remove,
    /// Play the path, or end it.
    Play,
    /// Write the path.
    Save,
}

/// Help on mouse and keys.
pub const HELP: &str = "\
drag, arrows: turn · right or middle drag, shift+arrows: move · wheel, + -: zoom
1 colour · 2 depth · 3 normals · 4 occupancy · q [ ] quality · t frame rate · r reset view
k keyframe · Backspace remove the last one · p play the path, until any input · w save it
h overlay · s or F12 screenshot · Esc quit";

/// Radians of an arrow key.
const TURN: f32 = std::f32::consts::PI / 36.0;
/// Fraction of the distance that an arrow key moves by.
const SHIFT: f32 = 1.0 / 32.0;

/// The name of a key that has a command.
#[must_use]
pub fn key(key: &Key) -> Option<String> {
    let name = match key {
        Key::Character(text) => return Some(text.to_lowercase()),
        Key::Named(NamedKey::ArrowLeft) => "left",
        Key::Named(NamedKey::ArrowRight) => "right",
        Key::Named(NamedKey::ArrowUp) => "up",
        Key::Named(NamedKey::ArrowDown) => "down",
        Key::Named(NamedKey::Escape) => "escape",
        Key::Named(NamedKey::Backspace) => "backspace",
        Key::Named(NamedKey::F12) => "f12",
        _ => return None,
    };
    Some(name.to_owned())
}

/// The command of a key.
#[must_use]
pub fn command(name: &str, shift: bool) -> Option<Command> {
    let way = match name {
        "left" => [-1.0, 0.0],
        "right" => [1.0, 0.0],
        "up" => [0.0, 1.0],
        "down" => [0.0, -1.0],
        _ => [0.0; 2],
    };
    Some(match name {
        "1" => Command::Mode(Mode::Colour),
        "2" => Command::Mode(Mode::Depth),
        "3" => Command::Mode(Mode::Normals),
        "4" => Command::Mode(Mode::Occupancy),
        "q" => Command::NextQuality,
        "[" => Command::Quality(-0.05),
        "]" => Command::Quality(0.05),
        "t" => Command::NextRate,
        "r" => Command::Reset,
        "h" => Command::Overlay,
        "s" | "f12" => Command::Screenshot,
        "k" => Command::Path(PathCommand::Add),
        "backspace" => Command::Path(PathCommand::Remove),
        "p" => Command::Path(PathCommand::Play),
        "w" => Command::Path(PathCommand::Save),
        "+" | "=" => Command::Approach(1.0),
        "-" => Command::Approach(-1.0),
        "escape" => Command::Quit,
        "left" | "right" | "up" | "down" if shift => Command::Shift(way.map(|w| w * SHIFT)),
        "left" | "right" | "up" | "down" => Command::Turn(way.map(|w| w * TURN)),
        _ => return None,
    })
}

/// The input of a drag in pixels with this button.
#[must_use]
pub const fn drag(button: MouseButton, shift: bool, way: [f32; 2]) -> Option<Input> {
    match button {
        MouseButton::Left if !shift => Some(Input::Turn(way)),
        MouseButton::Left | MouseButton::Right | MouseButton::Middle => Some(Input::Pull(way)),
        _ => None,
    }
}

/// The factor of the distance after steps towards the scene.
#[must_use]
pub fn nearer(steps: f32) -> f32 {
    1.1f32.powf(-steps)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_do_what_the_help_says() {
        assert_eq!(command("3", false), Some(Command::Mode(Mode::Normals)));
        assert_eq!(command("right", false), Some(Command::Turn([TURN, 0.0])));
        assert_eq!(command("down", true), Some(Command::Shift([0.0, -SHIFT])));
        assert_eq!(command("s", false), command("f12", false));
        assert_eq!(command("x", false), None);
        assert_eq!(key(&Key::Named(NamedKey::Escape)).as_deref(), Some("escape"));
        let backspace = key(&Key::Named(NamedKey::Backspace)).unwrap();
        assert_eq!(command(&backspace, false), Some(Command::Path(PathCommand::Remove)));
        assert_eq!(key(&Key::Character("H".into())).as_deref(), Some("h"));
        assert_eq!(key(&Key::Named(NamedKey::Tab)), None);
    }

    #[test]
    fn drags() {
        let left = |shift| drag(MouseButton::Left, shift, [1.0, 2.0]);
        assert!(matches!(left(false), Some(Input::Turn([1.0, 2.0]))));
        assert!(matches!(left(true), Some(Input::Pull(_))));
        assert!(matches!(drag(MouseButton::Right, false, [0.0; 2]), Some(Input::Pull(_))));
        assert!(drag(MouseButton::Back, false, [0.0; 2]).is_none());
    }
}
