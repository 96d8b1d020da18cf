//! Pictures as files, with the settings that made them.

use render::Image;

use crate::app::bundle::PROGRAM;
use crate::stage::Stage;

/// Encodes a picture as a PNG with the settings that made it.
#[must_use]
pub fn png(image: &Image, stage: &Stage) -> Vec<u8> {
    let png = with_settings(stage, |text| image.png(text));
    png.expect("the keywords are those below, and memory takes every byte")
}

/// Calls `png` with the settings and the state of a stage, as keyword and value pairs.
pub fn with_settings<T>(stage: &Stage, png: impl FnOnce(&[(&str, &str)]) -> T) -> T {
    let text = [
        ("Software", PROGRAM.to_owned()),
        ("Scene", stage.sim().scene.name.clone()),
        ("Tick", stage.sim().ticks().to_string()),
        ("Method", stage.sim().stepper.method().name().to_owned()),
        ("StateHash", format!("{:016x}", stage.sim().hash())),
    ];
    let text: Vec<_> = text.iter().map(|(name, value)| (*name, value.as_str())).collect();
    png(&text)
}
