//! What reaches the program from outside in one frame: the same events from a window, a script or a test.

use motion::effects::Effect;
use motion::{Method, Request};

use crate::actions::Key;

/// A button of the mouse.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[expect(missing_docs, reason = "they say it themselves")]
pub enum Button {
    Left,
    Right,
    Middle,
}

/// One event.
#[derive(Clone, Debug)]
pub enum Input {
    /// A key went down.
    KeyDown(Key),
    /// A key went up.
    KeyUp(Key),
    /// Text was typed; read only by a text field that has the focus.
    Text(String),
    /// In selection mode the pointer is at this pixel, from the top left; in camera mode the mouse moved by so
    /// many counts, right and down.
    Mouse(f64, f64),
    /// A button went down.
    ButtonDown(Button),
    /// A button went up.
    ButtonUp(Button),
    /// The wheel turned by so many notches, away from the person.
    Wheel(f64),
    /// The window lost the keyboard: nothing is held any more.
    FocusLost,
    /// The picture has this many pixels now.
    Resized([u32; 2]),
    /// Pixels of the picture a point of the panels, as the display has it.
    Scaled(f64),
    /// An experiment on the bodies.
    Experiment(Experiment),
}

/// A change that a script or a panel asks for.
#[derive(Clone, Debug)]
pub enum Experiment {
    /// Pushes a body, named, with these newtons for one tick.
    Push(String, [f64; 3]),
    /// Asks for a change of one body, named.
    OfBody(String, fn(bevy_ecs::entity::Entity, glam::DVec3) -> Request, [f64; 3]),
    /// Asks for a change of the world.
    OfWorld(Request),
    /// Removes a body, named.
    Remove(String),
    /// Sets the damping rate, 1/s, and keeps the model.
    DampingRate(f64),
    /// Goes on with another method of the scene.
    Method(Method),
    /// Gives a body, named, a method of its own, or the scene's.
    BodyMethod(String, Option<Method>),
    /// Switches an effect off or on again.
    SwitchEffect(Effect, bool),
    /// Writes the picture of this frame to a file of this name.
    Screenshot(String),
}

/// Everything that happened since the last frame, in order.
#[derive(Clone, Debug, Default)]
pub struct InputFrame {
    /// The events.
    pub events: Vec<Input>,
}

impl InputFrame {
    /// A frame in which nothing happened.
    pub const NOTHING: Self = Self { events: Vec::new() };
}

impl FromIterator<Input> for InputFrame {
    fn from_iter<I: IntoIterator<Item = Input>>(events: I) -> Self {
        Self { events: events.into_iter().collect() }
    }
}
