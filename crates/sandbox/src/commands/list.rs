//! `sandbox list`: scenes, hard cases, methods, laws and keys.

use clap::{Args, ValueEnum};
use motion::{LAWS, METHODS};
use report::aligned;
use scene::{ShippedScene, key_of_law};
use serde_json::{Value, json};

use crate::failure::Failure;
use crate::output::show;
use cockpit::actions::input_rows;
use cockpit::methods::COLUMNS;

/// What can be listed.
#[derive(Clone, Copy, Debug, Default, ValueEnum)]
enum Listed {
    #[default]
    Scenes,
    Cases,
    Methods,
    Laws,
    Keys,
}

pub(super) const EXAMPLES: &str = "\
Examples:
  sandbox list scenes
  sandbox list methods --format json";

/// Lists what there is.
#[derive(Args, Clone, Copy, Debug)]
pub(crate) struct ListArgs {
    /// What to list
    #[arg(value_enum, default_value_t)]
    what: Listed,
    /// As a table or as JSON
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

/// Does what `sandbox list` says.
pub(crate) fn run(args: ListArgs) -> Result<(), Failure> {
    show(&listed(args.what, args.format))
}

/// How it is written.
#[derive(Clone, Copy, Debug, Default, ValueEnum)]
pub(crate) enum Format {
    #[default]
    Table,
    Json,
}

/// A cell: its name in JSON, its value for programs, and its text for people.
type Cell = (&'static str, Value, String);

fn text(name: &'static str, text: impl Into<String>) -> Cell {
    let text = text.into();
    (name, json!(text), text)
}

fn rows(what: Listed) -> Vec<Vec<Cell>> {
    match what {
        Listed::Scenes => scenes("scene", scene::shipped()),
        Listed::Cases => scenes("case", scene::cases()),
        Listed::Methods => METHODS
            .iter()
            .map(|claims| {
                let cell = |column: &cockpit::methods::Column| {
                    (column.name, column.value(claims), column.text(claims))
                };
                COLUMNS.iter().map(cell).collect()
            })
            .collect(),
        Listed::Laws => LAWS
            .iter()
            .map(|&(law, what)| {
                vec![text("law", law), text("key", key_of_law(law)), text("what", what)]
            })
            .collect(),
        Listed::Keys => input_rows()
            .map(|row| {
                vec![
                    text("input", row.inputs.join(" ")),
                    text("when", row.when.words()),
                    text("name", row.name.unwrap_or_default()),
                    text("what", row.what),
                ]
            })
            .collect(),
    }
}

fn scenes(what: &'static str, embedded: &[ShippedScene]) -> Vec<Vec<Cell>> {
    let row = |shipped: &ShippedScene| {
        let description =
            shipped.load().map_or_else(|error| error.to_string(), |scene| scene.description);
        vec![text(what, shipped.name), text("description", description)]
    };
    embedded.iter().map(row).collect()
}

/// Headings of the tables that cannot be understood without them.
fn headings(what: Listed) -> Option<Vec<&'static str>> {
    match what {
        Listed::Methods => Some(COLUMNS.iter().map(|column| column.heading).collect()),
        Listed::Laws => Some(vec!["law", "key of the scene file", "what it is"]),
        Listed::Scenes | Listed::Cases | Listed::Keys => None,
    }
}

/// The list as it is printed.
fn listed(what: Listed, format: Format) -> String {
    let rows = rows(what);
    match format {
        Format::Json => {
            let objects: Vec<_> = rows
                .into_iter()
                .map(|row| {
                    row.into_iter().map(|(name, value, _)| (name.to_owned(), value)).collect()
                })
                .map(Value::Object)
                .collect();
            format!(
                "{}\n",
                serde_json::to_string_pretty(&objects).expect("strings and numbers are JSON")
            )
        }
        Format::Table => {
            let heading = headings(what).map(|row| row.into_iter().map(str::to_owned).collect());
            let rows = rows.into_iter().map(|row| row.into_iter().map(|(.., text)| text).collect());
            aligned(&heading.into_iter().chain(rows).collect::<Vec<_>>(), false)
        }
    }
}
