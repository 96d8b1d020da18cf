//! The list of all panels, one line each: what opens beside the picture, by which key, under which title.

/// How a panel is named and opened.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PanelRow {
    /// Its name in scripts.
    pub name: &'static str,
    /// The keys that open and close it.
    pub keys: &'static [&'static str],
    /// Its title.
    pub title: &'static str,
    /// What it is, for the person.
    pub what: &'static str,
}

/// Hands the list to a macro, for each panel: its tool type, module, script name, keys, title, description.
macro_rules! with_panels {
    ($callback:ident) => {
        $callback! {
            Editor in editor: "toggle_editor", ["M"], "Editor", "editor: add, move, join and remove bodies, change every value, undo, save as a scene file";
            Settings in settings: "settings", ["Tab"], "Settings", "settings: gravity, damping, tick rate, methods, the selection's mass and velocity";
            Effects in effects: "toggle_effects_panel", ["E"], "Effects", "effects: which are on, why, on how many bodies, at what cost; on and off";
            Cost in cost: "toggle_cost_panel", ["C"], "Accuracy and cost", "accuracy and cost: one dot per method and step, measured on a copy of the scene; click one to use it";
            Ghosts in ghosts: "toggle_ghosts", ["T"], "Ghosts", "ghosts: the same run by every method, and how far each is from a fine reference";
            Ledger in ledger: "toggle_ledger_panel", ["B"], "Ledger", "ledger: where energy, momentum and angular momentum go, and what the method invents";
            Forecast in forecast: "toggle_forecast_panel", ["V"], "Forecast", "forecast: how near every spring, damper and well is to instability, and what would help";
            Graphs in graphs: "toggle_graphs", ["Y"], "Graphs", "graphs: position, velocity, acceleration, force and energy of bodies and their ghosts over the last seconds";
            Learn in learn: "toggle_lessons", ["N"], "Learn", "lessons: what to do, what to watch, and questions whose answers are measured";
            Timeline in timeline: "toggle_timeline_panel", ["R"], "Timeline", "timeline: go anywhere in the last minute; what went wrong, and saving it";
            Help in help: "help", ["H", "?"], "Keys and mouse", "this help";
            Finder in finder: "find_scene", ["Ctrl+O"], "Open", "find a scene by name, or open a file of a scene or lesson";
        }
    };
}
pub(crate) use with_panels;

macro_rules! panels {
    ($($Tool:ident in $tool:ident: $name:literal, $key:tt, $title:literal, $what:literal;)*) => {
        /// A panel, which a key opens beside the picture.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        #[expect(missing_docs, reason = "the rows say what each is")]
        pub enum Panel {
            $($Tool,)*
        }

        /// A row for every panel, in their order.
        pub(crate) const PANELS: &[(Panel, PanelRow)] =
            &[$((Panel::$Tool, PanelRow { name: $name, keys: &$key, title: $title, what: $what }),)*];
    };
}

with_panels!(panels);

/// A tab of the dock: panels of one role.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Tab {
    /// The selection: its forces and graphs.
    #[default]
    Look,
    /// What accuracy costs, and where energy goes.
    Measure,
    /// The scene and its settings.
    Build,
    /// The last minute.
    Past,
}

impl Tab {
    pub const ALL: [Self; 4] = [Self::Look, Self::Measure, Self::Build, Self::Past];

    /// Its icon, its name, and what it is for.
    pub const fn words(self) -> [&'static str; 3] {
        match self {
            Self::Look => ["👁", "Look", "the selection, its forces, and graphs"],
            Self::Measure => {
                ["📏", "Measure", "accuracy and cost, ghosts, energy, stability, effects"]
            }
            Self::Build => ["🔨", "Build", "change the scene and its settings"],
            Self::Past => ["⏱", "Past", "go back, and save what went wrong"],
        }
    }
}

impl Panel {
    /// The tab of the dock that has it; `None` for a window over the picture.
    pub(crate) const fn tab(self) -> Option<Tab> {
        match self {
            Self::Help | Self::Finder | Self::Learn => None,
            Self::Graphs => Some(Tab::Look),
            Self::Effects | Self::Cost | Self::Ghosts | Self::Ledger | Self::Forecast => {
                Some(Tab::Measure)
            }
            Self::Editor | Self::Settings => Some(Tab::Build),
            Self::Timeline => Some(Tab::Past),
        }
    }

    /// Whether a saved arrangement leaves it out: ghosts end with their scene, lessons with the window, help and finder are soon
    /// closed again.
    pub(crate) const fn is_transient(self) -> bool {
        matches!(self, Self::Ghosts | Self::Help | Self::Finder | Self::Learn)
    }

    /// How it is named and opened.
    #[must_use]
    pub fn row(self) -> &'static PanelRow {
        &PANELS[self as usize].1
    }
}
