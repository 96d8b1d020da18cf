//! The tutorial's words in the tutorial's places, a cross-hair, and the state of the run. In the cockpit the bars say most of
//! this, and only legends and warnings are written here.

use egui::{Align2, Color32, Context, FontId, Id, Painter, Pos2, Rect, Sense, Stroke, Ui, Vec2};
use glam::{DVec2, DVec3};
use motion::clock::StepClock;
use motion::{Gravity, TimeStep};
use report::numbers::{digits, length_unit, pace_words, scene_time, tick_rate};

use crate::stage::Stage;
use crate::view::arrows::{VELOCITY_SCALE, color_of};
use crate::view::inks;
use crate::view::{Measured, Mode, View};

/// The light gray in which the tutorial's texts are drawn.
const TEXT: Color32 = Color32::from_rgb(191, 191, 191);

/// Color of the program's own words.
pub(crate) const THIN: Color32 = Color32::from_rgb(235, 235, 235);

const WARNING: Color32 = Color32::from_rgb(255, 200, 90);

/// The ground of words in the picture: so dark that they have a contrast of 4.5 to it on the brightest sky.
pub(crate) const PLATE: Color32 = Color32::from_rgba_unmultiplied_const(20, 24, 30, 208);

/// Space around words on a plate, as multiples of their size.
const PADDING: Vec2 = Vec2::new(0.43, 0.18);

/// Size of words in the cockpit, points.
pub(crate) const SIZE: f32 = 14.0;

/// Place of the click force in the tutorial: percent of width and height from the top left, to the lower left corner of the
/// words.
const CLICK_FORCE_AT: Vec2 = Vec2::new(10.0, 20.0);
/// Place of the hint about the lock in the tutorial, percent.
const LOCK_HINT_AT: Vec2 = Vec2::new(5.0, 80.0);
/// Place of the hint about the mode in the tutorial, percent.
const MODE_HINT_AT: Vec2 = Vec2::new(5.0, 85.0);
/// Place of the state of gravity in the tutorial, percent.
const GRAVITY_AT: Vec2 = Vec2::new(5.0, 95.0);

/// Place of notices, percent: below all words at the top, because a notice may be wide.
const NOTICES_AT: Vec2 = Vec2::new(50.0, 26.0);
/// Place of notices in the cockpit, percent.
const NOTICES_IN_COCKPIT_AT: Vec2 = Vec2::new(50.0, 3.0);

/// Distance from line to line, as a multiple of the size of the words.
const LINE: f32 = 1.3;

/// Space between two plates, points.
const BETWEEN: f32 = 3.0;

/// Widest line of a notice, as a fraction of the width of the window.
const NOTICE_WIDTH: f32 = 0.94;

/// Words at a place.
struct Words {
    at: Pos2,
    anchor: Align2,
    text: String,
    font: FontId,
    color: Color32,
    /// Whether they are words of the tutorial's picture, with a rim and no plate.
    rimmed: bool,
}

/// Size of the words, points: the tutorial's glyphs are 1.9 % of the width apart.
fn size(painter: &Painter, view: &View) -> f32 {
    match view.view_px {
        Some(_) => SIZE,
        None => (painter.clip_rect().width() * 0.019 / 0.6).clamp(10.0, 40.0) * 0.75,
    }
}

fn at(painter: &Painter, percent: Vec2) -> Pos2 {
    painter.clip_rect().min + painter.clip_rect().size() * percent / 100.0
}

/// Writes all words.
pub(crate) fn show(painter: &Painter, stage: &Stage, view: &View) {
    let (all, corner) = words(painter, stage, view);
    for Words { at, anchor, text: words, font, color, rimmed } in all {
        let write = if rimmed { rimmed_text } else { text };
        write(painter, at, anchor, &words, font, color);
    }
    let notices_at = match view.has_bars() {
        // Below the words in the corner, which may reach as far as a notice.
        true => at(painter, NOTICES_IN_COCKPIT_AT) + Vec2::Y * corner,
        false => at(painter, NOTICES_AT),
    };
    let small = if view.has_bars() { SIZE } else { size(painter, view) * 0.8 };
    notices(painter, notices_at, stage.notices.in_picture(view.has_bars()), small);
    if view.mode == Mode::Camera {
        cross_hair(painter, painter.clip_rect().center());
    }
}

/// Writes `words` at the bottom and, into pictures without bars, the time of the scene and a scale bar at the top. Returns where
/// words are.
pub(crate) fn caption(painter: &Painter, stage: &Stage, view: &View, words: &str) -> Vec<Rect> {
    let font = FontId::proportional(if view.has_bars() { SIZE } else { caption_size(painter) });
    let write = |percent, anchor, words: &str| {
        text(painter, at(painter, percent), anchor, words, font.clone(), Color32::WHITE)
    };
    let mut places = Vec::new();
    let widest = (NOTICE_WIDTH * painter.clip_rect().width()).min(WIDEST * font.size);
    if !words.is_empty() {
        let lines = wrapped(painter, words, &font, widest);
        places.push(write(Vec2::new(2.0, 98.0), Align2::LEFT_BOTTOM, &lines));
    }
    if !view.has_bars() {
        let seconds = stage.sim().world.resource::<StepClock>().scene_seconds();
        let step = stage.sim().world.resource::<TimeStep>().0;
        let time = format!("t = {}", scene_time(seconds, step));
        places.push(write(Vec2::new(2.0, 3.0), Align2::LEFT_TOP, &time));
        scale_bar(painter, stage, view, &font);
    }
    places
}

/// Widest line of a caption, as a multiple of the size of its words.
const WIDEST: f32 = 48.0;

/// Size of the words of a caption in a picture, points: they are read where the picture is half as large.
fn caption_size(painter: &Painter) -> f32 {
    (0.018 * painter.clip_rect().width()).clamp(11.0, 48.0)
}

/// `words` in lines that are no wider than `width` points.
fn wrapped(painter: &Painter, words: &str, font: &FontId, width: f32) -> String {
    let galley = painter.layout(words.to_owned(), font.clone(), THIN, width);
    galley.rows.iter().map(|row| row.text().trim_end().to_owned()).collect::<Vec<_>>().join("\n")
}

/// Longest scale bar, as a fraction of the width of the picture.
const SCALE_BAR: f32 = 0.2;

/// Draws a scale bar of 1, 2 or 5 times a power of ten of its unit, at the scale of the middle of what moves.
#[expect(clippy::cast_possible_truncation, reason = "points")]
fn scale_bar(painter: &Painter, stage: &Stage, view: &View, font: &FontId) {
    let Some(pixels) = view.pixels_per_meter(stage) else { return };
    let meter = pixels as f32 / painter.ctx().pixels_per_point();
    let longest = f64::from(SCALE_BAR * painter.clip_rect().width() / meter);
    let unit = length_unit(longest);
    let meters = round_below(longest / unit.1) * unit.1;
    let end = at(painter, Vec2::new(98.0, 6.0));
    let start = end - Vec2::X * (meters as f32 * meter);
    for (width, color) in [(4.0, Color32::from_black_alpha(160)), (2.0, THIN)] {
        let stroke = Stroke::new(width, color);
        painter.line_segment([start, end], stroke);
        for place in [start, end] {
            painter.line_segment([place - Vec2::Y * 4.0, place + Vec2::Y * 4.0], stroke);
        }
    }
    let words = format!("{} {}", digits(meters / unit.1), unit.0);
    text(
        painter,
        start.lerp(end, 0.5) - Vec2::Y * 4.0,
        Align2::CENTER_BOTTOM,
        &words,
        font.clone(),
        THIN,
    );
}

/// The largest of 1, 2 and 5 times a power of ten that is no more than `value`.
fn round_below(value: f64) -> f64 {
    let ten = 10_f64.powf(value.log10().floor());
    [5.0, 2.0, 1.0].map(|part| part * ten).into_iter().find(|part| *part <= value).unwrap_or(ten)
}

/// The rectangles of words that do not come and go.
pub(crate) fn places(painter: &Painter, stage: &Stage, view: &View) -> Vec<Rect> {
    let place = |Words { at, anchor, text, font, .. }| {
        anchor.anchor_size(at, plate_size(painter, &text, &font))
    };
    words(painter, stage, view).0.into_iter().map(place).collect()
}

/// The words, and the height of those in the corner at the top, points.
fn words(painter: &Painter, stage: &Stage, view: &View) -> (Vec<Words>, f32) {
    let size = size(painter, view);
    let mut all = Vec::new();
    let rimmed = !view.has_bars();
    let small = FontId::proportional(if rimmed { size * 0.8 } else { SIZE });
    if !view.has_bars() {
        all.extend(tutorial(stage, view).into_iter().map(|(percent, text)| Words {
            at: at(painter, percent),
            anchor: Align2::LEFT_BOTTOM,
            text,
            font: FontId::monospace(size),
            color: TEXT,
            rimmed: true,
        }));
        all.push(Words {
            at: at(painter, Vec2::new(99.0, 97.0)),
            anchor: Align2::RIGHT_BOTTOM,
            text: "H help   Tab settings".to_owned(),
            font: small.clone(),
            color: THIN,
            rimmed: true,
        });
    }
    let (corner, mut height) = (at(painter, Vec2::new(99.0, 2.0)), 0.0);
    for (text, color) in state(stage, view) {
        let at = corner + Vec2::Y * height;
        let anchor = Align2::RIGHT_TOP;
        all.push(Words { at, anchor, text, font: small.clone(), color, rimmed });
        let plate = if rimmed { 0.0 } else { 2.0 * PADDING.y * small.size + BETWEEN };
        height += small.size * LINE + plate;
    }
    (all, height)
}

/// The words of the tutorial, and their places.
fn tutorial(stage: &Stage, view: &View) -> Vec<(Vec2, String)> {
    let mut all = Vec::new();
    if stage.sim().scene.push.is_some() {
        all.push((CLICK_FORCE_AT, format!("Click Force:{:.6}", view.click_force)));
    }
    match (view.locked, stage.selection()) {
        (Some(_), _) => all.push((LOCK_HINT_AT, "Press L to unlock object!".to_owned())),
        (None, Some(_)) => all.push((LOCK_HINT_AT, "Press L to lock selected object!".to_owned())),
        _ => {}
    }
    let other = match view.mode {
        Mode::Camera => "select",
        Mode::Selection => "camera",
    };
    all.push((MODE_HINT_AT, format!("Press Q to change to {other} mode!")));
    if let Some(gravity) = stage.sim().world.get_resource::<Gravity>() {
        all.push((GRAVITY_AT, format!("(G)ravity {}", if gravity.on { "on" } else { "off" })));
    }
    all
}

/// Writes notices one below the other; a notice that is wider than the window has several lines.
fn notices<'a>(
    painter: &Painter,
    mut place: Pos2,
    notices: impl Iterator<Item = &'a str>,
    size: f32,
) {
    let font = FontId::proportional(size);
    let widest = painter.clip_rect().width() * NOTICE_WIDTH;
    for notice in notices {
        let lines = wrapped(painter, notice, &font, widest);
        let plate = text(painter, place, Align2::CENTER_TOP, &lines, font.clone(), WARNING);
        place.y = plate.bottom() + BETWEEN;
    }
}

/// The number of bodies and of particles of emitters, in words.
pub(crate) fn bodies(stage: &Stage) -> String {
    let scene = &stage.sim().scene;
    let bodies = stage.sim().bodies.len() - scene.particles_in_pools();
    let particles = scene.particles_in_pools() + scene.particles_on_device();
    let more = if particles > 0 { format!(", {particles} particles") } else { String::new() };
    format!("{bodies} {}{more}", if bodies == 1 { "body" } else { "bodies" })
}

/// A line for the scene, one for its clock and, unless the run is paused, one for what the shell measured.
fn clock(stage: &Stage, view: &View) -> Vec<String> {
    let (stepper, world) = (&stage.sim().stepper, &stage.sim().world);
    let own = if stepper.plan().own.is_empty() { "" } else { " and bodies' own" };
    let method = stepper.method().claims().title;
    let scene_s = world.resource::<StepClock>().scene_seconds();
    let step = world.resource::<TimeStep>().0;
    let mut lines = vec![
        format!("{}   {}   {method}{own}", stage.sim().scene.name, bodies(stage)),
        format!("{} at {}", scene_time(scene_s, step), tick_rate(step)),
    ];
    // Paused, frames are drawn when something changes.
    if let Some(measured) = view.measured.filter(|_| !stage.playback().paused()) {
        let Measured { frames_per_second, tick, simulated_over_real } = measured;
        let tick = tick * 1e6;
        lines.push(format!(
            "{frames_per_second:.0} frames/s   tick {tick:.1} us   {simulated_over_real:.2} x real time"
        ));
    }
    lines
}

/// The state of the run, for the top right corner.
fn state(stage: &Stage, view: &View) -> Vec<(String, Color32)> {
    let mut lines = Vec::new();
    if !view.has_bars() {
        lines.extend(clock(stage, view).into_iter().map(|line| (line, THIN)));
    }
    if view.has_bars() && view.velocity_arrows {
        lines.push((format!("velocity arrows: 1 m is {} m/s", VELOCITY_SCALE.recip()), THIN));
    }
    if view.margins {
        lines.push(("springs: green is calm, red at the limit of stability (V)".to_owned(), THIN));
    }
    if let Some(newtons) = view.force_scale {
        lines.push((format!("force arrows: 1 m is {newtons} N"), THIN));
        lines.extend(
            view.force_causes
                .iter()
                .map(|cause| (cause.replace('_', " "), as_in_picture(color_of(cause)))),
        );
    }
    let pace = stage.playback().pace();
    if !view.has_bars() && pace != stage.playback().usual_pace() {
        lines.push((format!("{} speed", pace_words(pace)), WARNING));
    }
    if stage.playback().paused() {
        lines.push(("paused: P continues, \".\" steps".to_owned(), WARNING));
    }
    if let Some(thing) = view.locked.and_then(|thing| thing.entity(stage.sim())) {
        lines.push((format!("following {}: L stops", stage.name(thing)), THIN));
    }
    if let Some((some, all)) = view.trail.left_out().filter(|_| view.trails) {
        lines.push((format!("trails of the first {some} of {all} bodies"), THIN));
    }
    lines.extend(dropped(stage).map(|words| (words, WARNING)));
    match stage.quarantines().here().len() {
        0 => {}
        1 => lines.push(("1 body quarantined: press R to see why".to_owned(), WARNING)),
        many => lines.push((format!("{many} bodies quarantined: press R to see why"), WARNING)),
    }
    if cfg!(debug_assertions) && view.measured.is_some() {
        lines.push(("debug build: slow".to_owned(), WARNING));
    }
    lines
}

/// Words for the time that the last frame dropped, and the push that was not applied in it.
pub(crate) fn dropped(stage: &Stage) -> Option<String> {
    let dropped_s = stage.playback().dropped_lately();
    let newtons: DVec3 = stage.here().pushes().iter().map(|push| push.newtons).sum();
    let push = match newtons.length() {
        0.0 => String::new(),
        newtons => format!(", with the push of {} N in it", digits(newtons)),
    };
    let dropped = digits(dropped_s);
    (dropped_s > 0.0)
        .then(|| format!("slower than real time: {dropped} s of this frame are dropped{push}"))
}

fn cross_hair(painter: &Painter, center: Pos2) {
    for (width, color) in [(3.0, Color32::from_black_alpha(160)), (1.0, Color32::WHITE)] {
        let stroke = Stroke::new(width, color);
        for arm in [Vec2::X, Vec2::Y] {
            for side in [-1.0, 1.0] {
                painter
                    .line_segment([center + arm * 3.0 * side, center + arm * 10.0 * side], stroke);
            }
        }
    }
}

/// Offsets of the dark rim of words.
const RIM: [Vec2; 4] =
    [Vec2::new(1.0, 1.0), Vec2::new(-1.0, 1.0), Vec2::new(1.0, -1.0), Vec2::new(-1.0, -1.0)];

/// Key in egui's memory of whether pictures are for paper.
fn on_paper() -> Id {
    Id::unique("words on paper")
}

/// Sets whether the next words are for paper, which is white.
pub(crate) fn write_on_paper(context: &Context, paper: bool) {
    context.data_mut(|data| data.insert_temp(on_paper(), paper));
}

/// Writes words on a plate, within the picture; on paper they are black and have none. Returns the place of the plate.
pub(crate) fn text(
    painter: &Painter,
    at: Pos2,
    anchor: Align2,
    words: &str,
    font: FontId,
    color: Color32,
) -> Rect {
    let padding = font.size * PADDING;
    if is_on_paper(painter) {
        return painter.text(at, anchor, words, font, Color32::BLACK).expand2(padding);
    }
    let color = inks::on_plate(PLATE, color);
    let lines = painter.layout_no_wrap(words.to_owned(), font, color);
    let plate = anchor.anchor_size(at, lines.size() + 2.0 * padding);
    let screen = painter.clip_rect();
    let plate = plate.translate((screen.min - plate.min).max(Vec2::ZERO));
    let plate = plate.translate((screen.max - plate.max).min(Vec2::ZERO));
    painter.rect_filled(plate, 4.0, PLATE);
    painter.galley(plate.min + padding, lines, color);
    plate
}

/// The size of the plate of words, points.
pub(crate) fn plate_size(painter: &Painter, words: &str, font: &FontId) -> Vec2 {
    let size = painter.layout_no_wrap(words.to_owned(), font.clone(), THIN).size();
    size + 2.0 * font.size * PADDING
}

/// Writes words of the tutorial's picture with a dark rim, readable on sky and checker alike; on paper they are black.
fn rimmed_text(
    painter: &Painter,
    at: Pos2,
    anchor: Align2,
    words: &str,
    font: FontId,
    color: Color32,
) -> Rect {
    if is_on_paper(painter) {
        return painter.text(at, anchor, words, font, Color32::BLACK);
    }
    for corner in RIM {
        painter.text(at + corner, anchor, words, font.clone(), Color32::from_black_alpha(200));
    }
    painter.text(at, anchor, words, font, color)
}

fn is_on_paper(painter: &Painter) -> bool {
    painter.ctx().data(|data| data.get_temp(on_paper())).unwrap_or(false)
}

/// Converts a pixel of the picture, from its top left, to points.
#[expect(clippy::cast_possible_truncation, reason = "pixels")]
pub(crate) fn point(painter: &Painter, pixel: DVec2) -> Pos2 {
    Pos2::new(pixel.x as f32, pixel.y as f32) / painter.ctx().pixels_per_point()
}

/// Converts a color of the picture, with red, green, blue and alpha from 0 to 1, to one for panels.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 to 255")]
pub(crate) fn as_in_picture(color: [f32; 4]) -> Color32 {
    let [red, green, blue, _] = color.map(|part| (part * 255.0).round() as u8);
    Color32::from_rgb(red, green, blue)
}

/// Lays out a small square of that color.
pub(crate) fn swatch(ui: &mut Ui, color: Color32) {
    let (place, _) = ui.allocate_exact_size(Vec2::splat(12.0), Sense::hover());
    ui.painter().rect(place, 2.0, color, Stroke::new(1.0, Color32::GRAY), egui::StrokeKind::Inside);
}

/// Says how to click in a panel while the pointer turns the camera.
pub(crate) fn mouse_hint(ui: &mut Ui, view: &View) {
    if view.mode == Mode::Camera {
        ui.weak("Press Q to use the mouse here.");
    }
}
