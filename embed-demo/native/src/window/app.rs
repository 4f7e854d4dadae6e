//! The window's state: input in, pictures out.

use std::num::NonZeroU32;
use std::rc::Rc;
use std::sync::mpsc::Sender;
use std::time::Instant;

use softbuffer::{Context, Surface};
use winit::application::ApplicationHandler;
use winit::dpi::{LogicalSize, PhysicalPosition, PhysicalSize, Size};
use winit::event::{ElementState, MouseButton, MouseScrollDelta, WindowEvent};
use winit::event_loop::{ActiveEventLoop, ControlFlow, OwnedDisplayHandle};
use winit::window::{Window, WindowId};

use super::content::Content;
use super::input::{self, Command, Input, PathCommand};
use super::keyframes::Keyframes;
use super::{Settings, overlay};
use crate::Failure;
use crate::output::screenshot;
use crate::show::Next;

/// Qualities and frame rates that keys cycle through.
const QUALITIES: [f32; 5] = [0.0, 0.25, 0.5, 0.75, 1.0];
const RATES: [f64; 3] = [15.0, 30.0, 60.0];
/// Pixels of a smooth wheel that count as one step.
const WHEEL_PIXELS: f64 = 40.0;

/// Where pictures go.
type Screen = Surface<OwnedDisplayHandle, Rc<Window>>;

/// The window and what it shows.
pub(super) struct App<C> {
    pub(super) content: C,
    settings: Settings,
    context: Context<OwnedDisplayHandle>,
    window: Option<(Rc<Window>, Screen)>,
    cursor: PhysicalPosition<f64>,
    /// The button that drags.
    held: Option<MouseButton>,
    shift: bool,
    keyframes: Keyframes,
    /// The last message.
    note: String,
    at_rest: Vec<Sender<()>>,
    pub(super) failure: Option<Failure>,
}

/// The model's own size, reduced where it and a frame around it do not fit on the screen.
fn fitting(size: [u32; 2], events: &ActiveEventLoop) -> LogicalSize<f64> {
    const ROOM: f64 = 0.9;
    let [width, height] = size.map(f64::from);
    let monitor = events.primary_monitor().or_else(|| events.available_monitors().next());
    let part = monitor.map_or(1.0, |monitor| {
        let room: LogicalSize<f64> = monitor.size().to_logical(monitor.scale_factor());
        (ROOM * room.width / width).min(ROOM * room.height / height)
    });
    // 0 where the size of the screen is unknown.
    let part = if part > 0.0 { part.min(1.0) } else { 1.0 };
    LogicalSize::new((width * part).round(), (height * part).round())
}

impl<C: Content> App<C> {
    pub(super) fn new(
        content: C,
        settings: Settings,
        context: Context<OwnedDisplayHandle>,
    ) -> Self {
        Self {
            content,
            settings,
            context,
            window: None,
            cursor: PhysicalPosition::default(),
            held: None,
            shift: false,
            keyframes: Keyframes::default(),
            note: String::new(),
            at_rest: Vec::new(),
            failure: None,
        }
    }

    fn open(&mut self, events: &ActiveEventLoop) -> Result<(), Failure> {
        let size = match self.settings.size {
            Some([width, height]) => Size::Physical(PhysicalSize { width, height }),
            None => Size::Logical(fitting(self.content.view().size(), events)),
        };
        let title = self.title();
        let attributes = Window::default_attributes().with_title(title).with_inner_size(size);
        let window = Rc::new(events.create_window(attributes)?);
        let surface = Surface::new(&self.context, Rc::clone(&window))?;
        let PhysicalSize { width, height } = window.inner_size();
        self.window = Some((window, surface));
        self.content.resize([width, height]);
        Ok(())
    }

    fn title(&self) -> String {
        let (note, progress) = (self.note.clone(), self.content.progress());
        let parts = [note, progress, self.settings.name.clone(), "pocketnerf".to_owned()];
        let parts: Vec<String> = parts.into_iter().filter(|part| !part.is_empty()).collect();
        parts.join(" · ")
    }

    /// Shows a message in the window, and prints it.
    fn say(&mut self, note: String) {
        (self.settings.say)(&note);
        self.show(note);
    }

    /// Shows a message in the window.
    fn show(&mut self, note: String) {
        self.note = note;
        if let Some((window, _)) = &self.window {
            window.set_title(&self.title());
            window.request_redraw();
        }
    }

    /// Renders for as long as a frame, and shows the picture.
    fn draw(&mut self) -> Result<(), Failure> {
        let Some((window, surface)) = &mut self.window else { return Ok(()) };
        let content = &mut self.content;
        let painted = content.work()?;
        let begun = Instant::now();
        let picture = content.shown();
        let (width, height) = (picture.width, picture.height);
        let (Some(w), Some(h)) = (NonZeroU32::new(width), NonZeroU32::new(height)) else {
            return Ok(());
        };
        surface.resize(w, h)?;
        let mut buffer = surface.buffer_mut()?;
        buffer.copy_from_slice(&picture.pixels);
        if self.settings.overlay {
            let text = content.status(&self.settings.name, &self.note);
            let factor = window.scale_factor().round() as u32;
            overlay::draw(&mut buffer, [width, height], factor, &text);
        }
        window.pre_present_notify();
        buffer.present()?;
        if painted {
            content.presented(begun.elapsed());
        }
        Ok(())
    }

    fn handle(&mut self, input: Input, events: &ActiveEventLoop) -> Result<(), Failure> {
        if input.ends_path() {
            self.keyframes.stop();
        }
        let content = &mut self.content;
        let size = [content.shown().width, content.shown().height];
        match input {
            Input::Turn(way) => content.view().drag(way, size[1]),
            Input::Pull(way) => content.view().pull(way, size),
            Input::Approach(steps) => content.view().approach(input::nearer(steps)),
            Input::Key(name, shift) => {
                return match input::command(&name, shift) {
                    Some(command) => self.command(command, events),
                    None => Ok(()),
                };
            }
            Input::NotifyAtRest(sender) => {
                self.at_rest.push(sender);
                return Ok(());
            }
            Input::Painted => {
                let title = self.title();
                if let Some((window, _)) = &self.window {
                    window.set_title(&title);
                    window.request_redraw();
                }
                return Ok(());
            }
            Input::Quit => {
                events.exit();
                return Ok(());
            }
        }
        self.content.change();
        Ok(())
    }

    fn command(&mut self, command: Command, events: &ActiveEventLoop) -> Result<(), Failure> {
        let content = &mut self.content;
        match command {
            Command::Mode(mode) if !content.shows(mode) => {
                self.say("only a scene in a box has normals".to_owned());
                return Ok(());
            }
            Command::Mode(mode) => *content.mode() = mode,
            Command::Quality(more) => {
                let quality = content.quality();
                *quality = ((*quality + more) * 100.0).round().clamp(0.0, 100.0) / 100.0;
            }
            Command::NextQuality => {
                let quality = content.quality();
                *quality = QUALITIES.into_iter().find(|q| *q > *quality).unwrap_or(QUALITIES[0]);
            }
            Command::NextRate => {
                let fps = content.fps();
                *fps = RATES.into_iter().find(|rate| *rate > *fps).unwrap_or(RATES[0]);
            }
            Command::Reset => content.view().reset(),
            Command::Turn([right, up]) => content.view().turn(right, up),
            Command::Shift([right, up]) => content.view().shift(right, up),
            Command::Approach(steps) => content.view().approach(input::nearer(steps)),
            Command::Overlay => {
                self.settings.overlay = !self.settings.overlay;
                if let Some((window, _)) = &self.window {
                    window.request_redraw();
                }
                return Ok(());
            }
            Command::Screenshot => {
                let path = screenshot::free_name(&self.settings.screenshots, &self.settings.stem);
                // A full disk does not close the window.
                match screenshot::write(&path, &self.content.whole()?) {
                    Ok(()) => self.say(path.display().to_string()),
                    Err(reason) => self.say(reason),
                }
                return Ok(());
            }
            Command::Path(command) => {
                let size = [content.shown().width, content.shown().height];
                let file = &self.settings.camera_path;
                match self.keyframes.command(command, content.view(), size, file) {
                    said if command == PathCommand::Save => self.say(said),
                    said => self.show(said),
                }
                return Ok(());
            }
            Command::Quit => {
                events.exit();
                return Ok(());
            }
        }
        self.content.change();
        Ok(())
    }

    fn event(&mut self, event: WindowEvent, events: &ActiveEventLoop) -> Result<(), Failure> {
        match event {
            WindowEvent::CloseRequested => events.exit(),
            WindowEvent::Resized(PhysicalSize { width, height }) => {
                self.content.resize([width, height]);
            }
            WindowEvent::RedrawRequested => self.draw()?,
            WindowEvent::ModifiersChanged(modifiers) => self.shift = modifiers.state().shift_key(),
            WindowEvent::MouseInput { state, button, .. } => {
                self.held = (state == ElementState::Pressed).then_some(button);
                self.keyframes.stop();
            }
            WindowEvent::CursorMoved { position, .. } => {
                let way = [position.x - self.cursor.x, position.y - self.cursor.y];
                self.cursor = position;
                let dragged = self.held.and_then(|button| {
                    input::drag(button, self.shift, way.map(|pixels| pixels as f32))
                });
                if let Some(input) = dragged {
                    self.handle(input, events)?;
                }
            }
            WindowEvent::MouseWheel { delta, .. } => {
                let steps = match delta {
                    MouseScrollDelta::LineDelta(_, y) => y,
                    MouseScrollDelta::PixelDelta(way) => (way.y / WHEEL_PIXELS) as f32,
                };
                self.handle(Input::Approach(steps), events)?;
            }
            WindowEvent::KeyboardInput { event, is_synthetic: false, .. } => {
                if let (ElementState::Pressed, Some(name)) =
                    (event.state, input::key(&event.logical_key))
                {
                    self.handle(Input::Key(name, self.shift), events)?;
                }
            }
            _ => {}
        }
        Ok(())
    }

    /// Keeps the first error, and ends.
    fn check(&mut self, result: Result<(), Failure>, events: &ActiveEventLoop) {
        if let Err(failure) = result {
            self.failure.get_or_insert(failure);
            events.exit();
        }
    }
}

impl<C: Content> ApplicationHandler<Input> for App<C> {
    fn resumed(&mut self, events: &ActiveEventLoop) {
        if self.window.is_none() {
            let opened = self.open(events);
            self.check(opened, events);
        }
    }

    fn window_event(&mut self, events: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        let handled = self.event(event, events);
        self.check(handled, events);
    }

    fn user_event(&mut self, events: &ActiveEventLoop, input: Input) {
        let handled = self.handle(input, events);
        self.check(handled, events);
    }

    fn about_to_wait(&mut self, events: &ActiveEventLoop) {
        let Some((window, _)) = &self.window else { return };
        if let Some(pose) = self.keyframes.due(Instant::now()) {
            self.content.view().go_to(pose);
            self.content.change();
        }
        let (next, of_path) = (self.content.next(), self.keyframes.next());
        let at = match next {
            Next::At(time) => Some(time),
            Next::Now | Next::Rest => None,
        };
        let at = at.into_iter().chain(of_path).min();
        events.set_control_flow(at.map_or(ControlFlow::Wait, ControlFlow::WaitUntil));
        match next {
            // Pending events come before this.
            Next::Now => window.request_redraw(),
            Next::At(_) => {}
            Next::Rest if of_path.is_some() => {}
            // The receiver may be gone.
            Next::Rest => self.at_rest.drain(..).for_each(|sender| _ = sender.send(())),
        }
    }
}
