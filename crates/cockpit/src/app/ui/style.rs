//! How panels look: two themes, and the size of everything in them.

use std::sync::Arc;

use egui::style::{ScrollStyle, Spacing};
use egui::{Color32, Context, FontData, FontDefinitions, FontFamily, FontTweak, Theme, Visuals};

use crate::app::ui::Ui;

/// Sizes that a person chooses from, as multiples of the usual one.
const ZOOMS: [f32; 8] = [0.8, 0.9, 1.0, 1.15, 1.3, 1.5, 1.75, 2.0];

/// Index of the usual size in [`ZOOMS`].
pub(super) const USUAL: usize = 2;

/// Least width and height that remain when a person makes everything larger, points.
const LEAST_ROOM: [f32; 2] = [640.0, 360.0];

/// Width and height that the panels need, points; the help is the widest. A smaller picture has smaller points, down to
/// [`SMALLEST`].
const ROOM: [f32; 2] = [960.0, 540.0];
/// Least size of a point as a fraction of the usual one: below it no person could read the words.
const SMALLEST: f32 = 0.5;
/// The same for a picture that is higher than wide, as on a phone, which is held near but has few pixels: there, bars have more rows.
const SMALLEST_UPRIGHT: f32 = 0.9;

/// Pixels per point in a picture of `size_px`, on a display that has `scale` pixels per point.
#[expect(clippy::cast_precision_loss, reason = "pixels")]
pub(super) fn pixels_per_point(size_px: [u32; 2], scale: f32, zoom: usize) -> f32 {
    let fits = |[width, height]: [f32; 2]| {
        (size_px[0] as f32 / (width * scale)).min(size_px[1] as f32 / (height * scale))
    };
    let smallest = if size_px[1] > size_px[0] { SMALLEST_UPRIGHT } else { SMALLEST };
    let usual = fits(ROOM).clamp(smallest, 1.0);
    scale * (usual * ZOOMS[zoom]).clamp(smallest, fits(LEAST_ROOM).max(usual))
}

/// Names of two fonts of egui, the glyphs of them that the panels use, and their scale as egui has it. A program that has the whole
/// fonts, for what people write, uses these; a page would have to load them.
const ICONS: [(&str, &[u8], f32); 2] = [
    ("NotoEmoji-Regular", include_bytes!("../../../assets/fonts/NotoEmoji-Regular.ttf"), 0.81),
    ("emoji-icon-font", include_bytes!("../../../assets/fonts/emoji-icon-font.ttf"), 0.9),
];

/// Adds the icons that are missing, in the order of egui.
fn add_icons(fonts: &mut FontDefinitions) {
    for (name, bytes, scale) in ICONS {
        fonts.font_data.entry(name.to_owned()).or_insert_with(|| {
            fonts.families.values_mut().for_each(|family| family.push(name.to_owned()));
            let tweak = FontTweak { scale, ..FontTweak::default() };
            Arc::new(FontData::from_static(bytes).tweak(tweak))
        });
    }
    // It has a raised minus.
    fonts.families.entry(FontFamily::Proportional).or_default().push("Hack".to_owned());
}

/// Gives icons and both themes to `context`, which begins dark.
pub(super) fn install(context: &Context) {
    let mut fonts = FontDefinitions::default();
    add_icons(&mut fonts);
    context.set_fonts(fonts);
    // Pictures must not depend on how many frames ago a panel was opened.
    context.all_styles_mut(|style| {
        style.animation_time = 0.0;
        // A click beside a button goes into the scene.
        style.interaction.interact_radius = 0.0;
        // Seen without the pointer over it: what scrolls must look as if it does.
        style.spacing.scroll = ScrollStyle::thin();
    });
    let mut dark = Visuals::dark();
    // As bright as the tutorial's texts.
    dark.widgets.noninteractive.fg_stroke.color = Color32::from_gray(191);
    dark.weak_text_color = Some(Color32::from_gray(136));
    let mut light = Visuals::light();
    light.weak_text_color = Some(Color32::from_gray(100));
    context.set_visuals_of(Theme::Dark, dark);
    context.set_visuals_of(Theme::Light, light);
    context.set_theme(Theme::Dark);
}

/// Height of buttons for fingers, points.
const FINGER: f32 = 32.0;
/// Width of a screen below which fingers have larger buttons, points.
const NARROW: f32 = 700.0;

impl Ui {
    /// Whether panels are light.
    pub fn is_light(&self) -> bool {
        self.context.theme() == Theme::Light
    }

    /// Number of sizes from the usual one up to the current one; negative if the current one is smaller.
    pub fn sizes_above_usual(&self) -> isize {
        self.zoom.cast_signed() - USUAL.cast_signed()
    }

    /// Makes buttons on a narrow screen as high as a finger needs them, or as usual.
    pub fn fit_hand(&mut self, by_finger: bool) {
        let usual = Spacing::default().interact_size.y;
        let height = if by_finger && self.width() < NARROW { FINGER } else { usual };
        if self.context.global_style().spacing.interact_size.y != height {
            self.context.all_styles_mut(|style| style.spacing.interact_size.y = height);
        }
    }

    /// Changes between light and dark panels.
    pub fn toggle_theme(&mut self) {
        let theme = if self.is_light() { Theme::Dark } else { Theme::Light };
        self.context.set_theme(theme);
    }

    /// Goes `steps` sizes up or down, as far as there is room. Returns the new size as a multiple of the usual one.
    pub fn zoom_by(&mut self, steps: isize) -> f32 {
        let (before, zoom) = (self.pixels_per_point(), self.zoom);
        self.zoom = zoom.saturating_add_signed(steps).min(ZOOMS.len() - 1);
        let now = self.pixels_per_point();
        if now.total_cmp(&before).is_eq() {
            self.zoom = zoom;
        }
        // The pointer stays at its pixel.
        self.pointer *= before / now;
        // Everything has to be measured, as at the first layout.
        self.laid_out = false;
        now / pixels_per_point(self.size_px, self.scale, USUAL)
    }
}

#[cfg(test)]
mod tests {
    use std::collections::{BTreeMap, BTreeSet};
    use std::fs;
    use std::path::Path;

    use crate::clock::FrameClock;
    use egui::epaint::{Fonts, text::TextOptions};
    use egui::{FontId, Rect, Shape};
    use motion::Method;

    use super::*;
    use scene::lesson::Lesson;

    use crate::actions::{Act, key_of_word};
    use crate::app::pupil::{Pupil, Runs};
    use crate::app::session::Session;
    use crate::input::{Input, InputFrame};
    use crate::intent::Intent;
    use crate::panels::Tab;
    use crate::stage::options::Options;
    use crate::view::hud::{PLATE, SIZE};
    use crate::view::inks::{WORDS, contrast};

    /// The shapes that a layout paints, in order.
    #[derive(Default)]
    struct Painted {
        /// Areas and their colors.
        areas: Vec<(Rect, Color32)>,
        /// Words with their color, what is behind them, and their size.
        words: Vec<(String, Color32, Color32, f32)>,
    }

    impl Painted {
        fn of(ui: &Ui) -> Self {
            let ground = ui.context.global_style().visuals.panel_fill;
            let mut painted = Self::default();
            for shape in &ui.output.as_ref().expect("it was laid out").shapes {
                painted.add(&shape.shape, shape.clip_rect, ground, ui.view);
            }
            painted
        }

        fn add(&mut self, shape: &Shape, clip: Rect, ground: Color32, view: Rect) {
            match shape {
                Shape::Vec(shapes) => {
                    shapes.iter().for_each(|shape| self.add(shape, clip, ground, view));
                }
                Shape::Rect(area) => self.areas.push((area.rect.intersect(clip), area.fill)),
                Shape::Text(text) => {
                    let middle = text.visual_bounding_rect().center();
                    let under: Vec<_> =
                        self.areas.iter().filter(|(area, _)| area.contains(middle)).collect();
                    // Words in the scene have their own rim.
                    if !clip.contains(middle) || (view.contains(middle) && under.is_empty()) {
                        return;
                    }
                    let behind =
                        under.into_iter().fold(ground, |behind, (_, fill)| behind.blend(*fill));
                    for section in &text.galley.job.sections {
                        let own = section.format.color;
                        let own =
                            if own == Color32::PLACEHOLDER { text.fallback_color } else { own };
                        let color = text
                            .override_text_color
                            .unwrap_or(own)
                            .gamma_multiply(text.opacity_factor);
                        let words = text.galley.job.text.clone();
                        self.words.push((words, color, behind, section.format.font_id.size));
                    }
                }
                _ => {}
            }
        }
    }

    /// The cockpit with every tool of `tab`, above each other in a high window.
    fn painted(scene: &str, keys: &[&str], tab: Tab) -> Painted {
        let options = Options { pictures: false, size_px: [1600, 4000], ..Options::default() };
        let mut session = Session::new(scene::load(scene).expect("it is shipped"), options);
        let mut clock = FrameClock::default();
        let tools = [
            "toggle_editor",
            "settings",
            "toggle_effects_panel",
            "toggle_cost_panel",
            "toggle_ghosts",
            "toggle_graphs",
        ];
        let more =
            ["toggle_ledger_panel", "toggle_forecast_panel", "toggle_timeline_panel", "frame"];
        session.stage.keep_timeline();
        let words = ["toggle_cockpit"].iter().chain(keys).chain(&tools).chain(&more);
        press(&mut session, &mut clock, 0.02, &words.copied().collect::<Vec<_>>());
        for _ in 0..5 {
            session.ui.cockpit.next_tab = Some(tab);
            press(&mut session, &mut clock, 0.02, &[""]);
        }
        Painted::of(&session.ui)
    }

    const SIZES: [[u32; 2]; 4] = [[1024, 600], [1280, 720], [1920, 1080], [390, 844]];

    /// Presses a key in each frame of that length, s, and none for an empty word.
    fn press(session: &mut Session, clock: &mut FrameClock, length: f64, words: &[&str]) {
        for word in words {
            let key = key_of_word(word).ok();
            let events =
                key.into_iter().flat_map(|key| [Input::KeyDown(key.clone()), Input::KeyUp(key)]);
            let time = clock.advance_by(length).expect("a time");
            session.advance(&InputFrame::from_iter(events), time);
        }
    }

    /// Number of plates over the picture, none of which overlaps another or leaves what bars leave of it.
    fn plates_apart(session: &Session, what: &str) -> usize {
        let areas = Painted::of(&session.ui).areas;
        let free = session.ui.cockpit.free.expand(1.0);
        let plates = areas.iter().filter(|(_, fill)| *fill == PLATE).map(|(area, _)| *area);
        let plates: Vec<_> = plates.map(|area| area.shrink(0.5)).collect();
        for (i, plate) in plates.iter().enumerate() {
            let other = plates[..i].iter().find(|other| other.intersects(*plate));
            assert_eq!(other, None, "{what} {plate}");
            assert!(free.contains_rect(*plate), "{what} {plate} in {free}");
        }
        plates.len()
    }

    #[test]
    fn plates_over_the_picture_never_overlap() {
        let mut seen = 0;
        // The last one explodes.
        let cape = scene::embedded("cape").expect("it is shipped");
        let scenes = scene::shipped().iter().map(|scene| (scene, None));
        for (shipped, method) in scenes.chain([(cape, Some(Method::ExplicitEuler))]) {
            for size_px in SIZES {
                let mut scene = shipped.load().expect("it is shipped");
                scene.method = method.unwrap_or(scene.method);
                let options = Options { size_px, ..Options::default() };
                let mut session = Session::new(scene, options);
                let keys = ["toggle_cockpit", "next_body", "frame", "pause", "", ""];
                let mut clock = FrameClock::default();
                if method.is_some() {
                    session.stage.keep_timeline();
                    press(&mut session, &mut clock, 0.5, &[""; 20]);
                }
                press(&mut session, &mut clock, 0.5, &keys);
                seen += plates_apart(&session, &format!("{} {size_px:?}", shipped.name));
                let has_fault = session.stage.recorder().fault().is_some();
                assert_eq!(has_fault, method.is_some(), "{}", shipped.name);
            }
        }
        assert!(seen > 300, "{seen}");
    }

    #[test]
    fn the_steps_of_lessons_are_laid_out_in_words_that_never_overlap() {
        let mut seen = 0;
        for (name, text) in scene::lesson::shipped() {
            let lesson = Lesson::parse(name, text).expect("it is shipped");
            let runs = Runs::new(&lesson, 1.0).expect("it is shipped");
            let options = Options { size_px: SIZES[1], ..Options::default() };
            let mut pupil = Pupil::begin(&lesson, &runs, options).expect("it is shipped");
            pupil.session.carry_out(Intent::Act(Act::ToggleCockpit));
            loop {
                for size_px in SIZES.into_iter().chain([SIZES[1]]) {
                    pupil.resize(size_px);
                    let what = format!("{name} {} {size_px:?}", pupil.step() + 1);
                    seen += plates_apart(&pupil.session, &what);
                    for (words, ..) in Painted::of(&pupil.session.ui).words {
                        let has = |part| words.contains(part);
                        assert!(!["_", "[", "--", "w h"].into_iter().any(has), "{what}: {words}");
                    }
                }
                if !pupil.solve(&lesson).expect("it can be played") {
                    break;
                }
            }
            assert_eq!(pupil.step(), lesson.steps.len(), "{name}");
        }
        assert!(seen > 100, "{seen}");
    }

    #[test]
    fn words_stand_out_in_both_themes() {
        for keys in [&[][..], &["toggle_theme"]] {
            for scene in ["tutorial", "bridge"] {
                let painted: Vec<_> = Tab::ALL.map(|tab| painted(scene, keys, tab)).into();
                // Fainter ones belong to what cannot be used now, and to marks between marks.
                let words = painted.iter().flat_map(|painted| &painted.words);
                let full = words.filter(|(_, color, ..)| color.a() == 255);
                let mut seen = 0;
                for (words, color, behind, _) in full {
                    let contrast = contrast(*color, *behind);
                    assert!(
                        contrast >= WORDS,
                        "{keys:?} {scene}: {words:?} {color:?} on {behind:?}: {contrast}"
                    );
                    seen += 1;
                }
                assert!(seen > 300, "{seen}");
            }
        }
    }

    #[test]
    fn widgets_stand_out_in_every_state_in_both_themes() {
        let context = Context::default();
        install(&context);
        for theme in [Theme::Dark, Theme::Light] {
            let visuals = &context.style_of(theme).visuals;
            let widgets = &visuals.widgets;
            for state in [&widgets.inactive, &widgets.hovered, &widgets.active, &widgets.open] {
                for behind in [state.bg_fill, state.weak_bg_fill, visuals.selection.bg_fill] {
                    let contrast = contrast(state.text_color(), behind);
                    assert!(
                        contrast >= WORDS,
                        "{theme:?} {:?} on {behind:?}: {contrast}",
                        state.text_color()
                    );
                }
            }
            let selection = &visuals.selection;
            assert!(contrast(selection.stroke.color, selection.bg_fill) >= WORDS);
            // The frame around the control that has the keyboard.
            assert!(contrast(selection.stroke.color, visuals.panel_fill) >= WORDS);
        }
    }

    #[test]
    fn no_panel_shows_an_identifier() {
        // On two threads, because it takes longer than all other tests of the crate.
        let all = scene::shipped();
        let halves = all.split_at(all.len() / 2);
        let seen: usize = std::thread::scope(|scope| {
            let first = scope.spawn(|| plain_words(halves.0));
            plain_words(halves.1) + first.join().expect("no panel of the first half does")
        });
        assert!(seen > 5000, "{seen}");
    }

    /// The number of words in panels of these scenes, none of which is an identifier.
    fn plain_words(scenes: &[scene::ShippedScene]) -> usize {
        let mut seen = 0;
        for shipped in scenes {
            let scene = shipped.load().expect("it is shipped");
            // Large scenes show the words of small ones, and take long.
            if scene.bodies.len() > 3000 {
                continue;
            }
            let ids = 0..u32::try_from(scene.bodies.len()).expect("there are few");
            let names = ids.filter_map(|id| scene.names.get(id));
            let names: Vec<_> = names.filter(|name| name.contains('_')).collect();
            for tab in Tab::ALL {
                for (words, ..) in painted(shipped.name, &["next_body"], tab).words {
                    let is_named = names.iter().any(|name| words.contains(&**name));
                    let is_file = words.ends_with(".ron") || words.ends_with(shipped.name);
                    let has = |part| words.contains(part);
                    let is_plain = !["_", "[", "--", "w h", ", line "].into_iter().any(has);
                    let curve = |kind| words.starts_with(kind);
                    let is_curve = ["polynomial(", "sine(", "table("].into_iter().any(curve);
                    let is_value = tab == Tab::Build && (words.starts_with(['[', '(']) || is_curve);
                    assert!(
                        is_plain || is_named || is_file || is_value,
                        "{}: {words:?}",
                        shipped.name
                    );
                    seen += 1;
                }
            }
        }
        seen
    }

    #[test]
    fn words_have_at_most_three_sizes() {
        let painted = Tab::ALL.map(|tab| painted("bridge", &["help"], tab));
        let words = painted.iter().flat_map(|painted| &painted.words);
        // Words over the picture have a size of their own.
        let in_panels = words.filter(|(_, _, _, size)| size.total_cmp(&SIZE).is_ne());
        let sizes: BTreeMap<_, _> =
            in_panels.map(|(words, _, _, size)| (format!("{size}"), words)).collect();
        assert!(sizes.len() <= 3, "{sizes:?}");
    }

    /// The texts of the files in a folder and in its folders.
    fn texts(folder: &Path) -> Vec<String> {
        let entries = fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("a file"));
        let of = |path: &Path| match path.is_dir() {
            true => texts(path),
            false => vec![fs::read_to_string(path).expect("a text")],
        };
        entries.flat_map(|entry| of(&entry.path())).collect()
    }

    #[test]
    fn the_panels_have_every_character_without_the_fonts_of_a_desktop() {
        let mut fonts = FontDefinitions::default();
        for (name, ..) in ICONS {
            fonts.font_data.remove(name);
            fonts.families.values_mut().for_each(|family| family.retain(|other| other != name));
        }
        add_icons(&mut fonts);
        let mut fonts = Fonts::new(TextOptions::default(), fonts);
        let mut fonts = fonts.with_pixels_per_point(1.0);
        let place = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
        let written: BTreeSet<char> =
            texts(&place).iter().flat_map(|text| text.chars()).filter(|c| !c.is_ascii()).collect();
        assert!(written.contains(&'\u{2630}') && !written.contains(&'\u{1f389}'));
        let font = FontId::default();
        let missing: Vec<_> = written.iter().filter(|c| !fonts.has_glyph(&font, **c)).collect();
        assert!(missing.is_empty(), "{missing:?}");
        assert!(!fonts.has_glyph(&font, '\u{1f389}'), "the fonts are those of a desktop");
    }

    #[test]
    fn a_larger_size_leaves_room_and_the_usual_one_is_that_of_the_display() {
        for (size, scale) in
            [([1024, 600], 1.0), ([1280, 720], 1.5), ([2560, 1440], 2.0), ([640, 360], 1.0)]
        {
            let of = |zoom| pixels_per_point(size, scale, zoom);
            let all: Vec<_> = (0..ZOOMS.len()).map(of).collect();
            assert!(all.is_sorted(), "{all:?}");
            assert!(all[USUAL] <= scale);
            let points = size.map(f64::from).map(|side| side / f64::from(all[ZOOMS.len() - 1]));
            let usual = size.map(f64::from).map(|side| side / f64::from(all[USUAL]));
            assert!(points[0] >= f64::from(LEAST_ROOM[0]).min(usual[0]) - 1e-3, "{points:?}");
            assert!(points[1] >= f64::from(LEAST_ROOM[1]).min(usual[1]) - 1e-3, "{points:?}");
        }
        assert_eq!(pixels_per_point([2560, 1440], 1.0, USUAL), 1.0);
    }
}
