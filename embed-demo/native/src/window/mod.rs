//! The window: events in, pictures out.

pub mod input;
pub mod overlay;
pub mod script;
mod status;

use std::num::NonZeroU32;
use std::path::PathBuf;
use std::rc::Rc;

use softbuffer::{Context, Surface};
use winit::application::ApplicationHandler;
use winit::dpi::{LogicalSize, PhysicalPosition, PhysicalSize, Size};
use winit::event::{ElementState, MouseButton, MouseScrollDelta, WindowEvent};
use winit::event_loop::{ActiveEventLoop, ControlFlow, EventLoop, OwnedDisplayHandle};
use winit::window::{Window, WindowId};

use crate::Failure;
use crate::output::screenshot;
use crate::show::{Next, Show};

use input::{Command, Input};
use script::Line;
use status::status;

/// Qualities and frame rates that keys cycle through.
const QUALITIES: [f32; 5] = [0.0, 0.25, 0.5, 0.75, 1.0];
const RATES: [f64; 3] = [15.0, 30.0, 60.0];
/// Pixels of a smooth wheel that count as one step.
const WHEEL_PIXELS: f64 = 40.0;

/// The window at its start.
#[derive(Clone, Debug)]
pub struct Settings {
    /// The model's name in the title.
    pub name: String,
    /// Width and height, pixels of the screen; the model's own if `None`.
    pub size: Option<[u32; 2]>,
    /// Whether figures are shown.
    pub overlay: bool,
    /// Folder of screenshots.
    pub screenshots: PathBuf,
    /// Start of the names of screenshots.
    pub stem: String,
    /// Input to play.
    pub script: Option<Vec<Line>>,
}

/// Where pictures go.
type Screen = Surface<OwnedDisplayHandle, Rc<Window>>;

/// The window and what it shows.
struct App<'m> {
    show: Show<'m>,
    settings: Settings,
    context: Context<OwnedDisplayHandle>,
    window: Option<(Rc<Window>, Screen)>,
    cursor: PhysicalPosition<f64>,
    /// The button that drags.
    held: Option<MouseButton>,
    shift: bool,
    /// The last message.
    note: String,
    at_rest: Vec<std::sync::mpsc::Sender<()>>,
    failure: Option<Failure>,
}

/// Shows a window until it is closed.
///
/// # Errors
/// One line: no display, or what the window system or the renderer reported.
pub fn run(mut show: Show<'_>, settings: Settings) -> Result<(), Failure> {
    let no_display = |e: &dyn std::fmt::Display| {
        let text = e.to_string().replace('\n', " ");
        // Before the reason are lines of winit's source.
        let reason = text.rsplit(": ").next().unwrap_or_default().trim_end_matches('.');
        format!(
            "no window: {reason}; a display is needed, or without one --headless --out FILE.png, \
             or --terminal"
        )
    };
    let events = EventLoop::<Input>::with_user_event().build().map_err(|e| no_display(&e))?;
    let context = Context::new(events.owned_display_handle()).map_err(|e| no_display(&e))?;
    let is_scripted = settings.script.is_some();
    if let Some(lines) = settings.script.clone() {
        show.figures.keep();
        let proxy = events.create_proxy();
        std::thread::spawn(move || script::play(&lines, |input| proxy.send_event(input).is_ok()));
    }
    let mut app = App {
        show,
        settings,
        context,
        window: None,
        cursor: PhysicalPosition::default(),
        held: None,
        shift: false,
        note: String::new(),
        at_rest: Vec::new(),
        failure: None,
    };
    events.run_app(&mut app).map_err(|e| no_display(&e))?;
    if let Some(failure) = app.failure {
        return Err(failure);
    }
    if is_scripted {
        crate::say(&app.show.figures.json());
    }
    Ok(())
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

impl App<'_> {
    fn open(&mut self, events: &ActiveEventLoop) -> Result<(), Failure> {
        let size = match self.settings.size {
            Some([width, height]) => Size::Physical(PhysicalSize { width, height }),
            None => Size::Logical(fitting(self.show.view.size(), events)),
        };
        let title = self.title();
        let attributes = Window::default_attributes().with_title(title).with_inner_size(size);
        let window = Rc::new(events.create_window(attributes)?);
        let surface = Surface::new(&self.context, Rc::clone(&window))?;
        let PhysicalSize { width, height } = window.inner_size();
        self.window = Some((window, surface));
        self.show.resize([width, height]);
        Ok(())
    }

    fn title(&self) -> String {
        match self.note.as_str() {
            "" => format!("{} · pocketnerf", self.settings.name),
            note => format!("{note} · {} · pocketnerf", self.settings.name),
        }
    }

    /// Shows a message in the window, and prints it.
    fn say(&mut self, note: String) {
        crate::say(&note);
        self.note = note;
        if let Some((window, _)) = &self.window {
            window.set_title(&self.title());
            window.request_redraw();
        }
    }

    /// Renders for as long as a frame, and shows the picture.
    fn draw(&mut self) -> Result<(), Failure> {
        let Some((window, surface)) = &mut self.window else { return Ok(()) };
        let painted = self.show.work()?;
        let picture = self.show.shown();
        let (width, height) = (picture.width, picture.height);
        let (Some(w), Some(h)) = (NonZeroU32::new(width), NonZeroU32::new(height)) else {
            return Ok(());
        };
        surface.resize(w, h)?;
        let mut buffer = surface.buffer_mut()?;
        buffer.copy_from_slice(&picture.pixels);
        if self.settings.overlay {
            let text = status(&self.show, &self.settings.name, &self.note);
            let factor = window.scale_factor().round() as u32;
            overlay::draw(&mut buffer, [width, height], factor, &text);
        }
        window.pre_present_notify();
        buffer.present()?;
        if painted {
            self.show.presented();
        }
        Ok(())
    }

    fn handle(&mut self, input: Input, events: &ActiveEventLoop) -> Result<(), Failure> {
        let size = [self.show.shown().width, self.show.shown().height];
        match input {
            Input::Turn(way) => self.show.view.drag(way, size[1]),
            Input::Pull(way) => self.show.view.pull(way, size),
            Input::Approach(steps) => self.show.view.approach(input::nearer(steps)),
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
            Input::Quit => {
                events.exit();
                return Ok(());
            }
        }
        self.show.change();
        Ok(())
    }

    fn command(&mut self, command: Command, events: &ActiveEventLoop) -> Result<(), Failure> {
        let show = &mut self.show;
        match command {
            Command::Mode(mode) if !show.painter().shows(mode) => {
                self.say("only a scene in a box has normals".to_owned());
                return Ok(());
            }
            Command::Mode(mode) => show.mode = mode,
            Command::Quality(more) => {
                show.quality = ((show.quality + more) * 100.0).round().clamp(0.0, 100.0) / 100.0;
            }
            Command::NextQuality => {
                let next = QUALITIES.into_iter().find(|quality| *quality > show.quality);
                show.quality = next.unwrap_or(QUALITIES[0]);
            }
            Command::NextRate => {
                let next = RATES.into_iter().find(|fps| *fps > show.pace.fps);
                show.pace.fps = next.unwrap_or(RATES[0]);
            }
            Command::Reset => show.view.reset(),
            Command::Turn([right, up]) => show.view.turn(right, up),
            Command::Shift([right, up]) => show.view.shift(right, up),
            Command::Approach(steps) => show.view.approach(input::nearer(steps)),
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
                match screenshot::write(&path, &self.show.whole()?) {
                    Ok(()) => self.say(path.display().to_string()),
                    Err(reason) => self.say(reason),
                }
                return Ok(());
            }
            Command::Quit => {
                events.exit();
                return Ok(());
            }
        }
        self.show.change();
        Ok(())
    }

    fn event(&mut self, event: WindowEvent, events: &ActiveEventLoop) -> Result<(), Failure> {
        match event {
            WindowEvent::CloseRequested => events.exit(),
            WindowEvent::Resized(PhysicalSize { width, height }) => {
                self.show.resize([width, height]);
            }
            WindowEvent::RedrawRequested => self.draw()?,
            WindowEvent::ModifiersChanged(modifiers) => self.shift = modifiers.state().shift_key(),
            WindowEvent::MouseInput { state, button, .. } => {
                self.held = (state == ElementState::Pressed).then_some(button);
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

impl ApplicationHandler<Input> for App<'_> {
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
        events.set_control_flow(match self.show.next() {
            Next::At(time) => ControlFlow::WaitUntil(time),
            Next::Now | Next::Rest => ControlFlow::Wait,
        });
        match self.show.next() {
            // Pending events come before this.
            Next::Now => window.request_redraw(),
            Next::At(_) => {}
            // The receiver may be gone.
            Next::Rest => self.at_rest.drain(..).for_each(|sender| _ = sender.send(())),
        }
    }
}
