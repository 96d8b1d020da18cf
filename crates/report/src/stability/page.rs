//! The matrix as one self-contained page.

use lab::stability::{Class, Matrix};
use scene::Measure;

use super::{heat_map, tables};
use crate::chart::Drawing;
use crate::escape::html;
use crate::page::{document, folded, titled};

/// The page of a matrix.
pub(super) fn page(matrix: &Matrix) -> String {
    let lead = "Every method of integration on every hard case: what became of the run, the number that says so, and the \
        bound that it is held to.";
    let main = [
        "<section>\n<h2>Matrix</h2>\n".to_owned(),
        tables::counts(matrix).html(),
        figure(
            &heat_map::drawing(matrix),
            "One field per run, with its class and its number; under the pointer it says why.",
        ),
        reading(),
        titled(&tables::cases(matrix)),
        folded(&tables::details(matrix)),
        "</section>\n".to_owned(),
    ];
    document("Survival of hard cases", lead, "", "", &main.concat(), "")
}

fn figure(drawing: &Drawing, caption: &str) -> String {
    format!("<figure>\n{}<figcaption>{caption}</figcaption>\n</figure>\n", drawing.inline())
}

/// Explains the classes and measures.
fn reading() -> String {
    let class = |class: Class| match class {
        Class::Exact => "as exact as rounding lets it be, all the way",
        Class::Bounded => "within its bound, all the way: of use",
        Class::Drifts => "beyond its bound at some time",
        Class::Decays => "what was to be kept is lost at the end, by more than the bound",
        Class::Explodes => {
            "beyond all bounds, or not finite: the run was given up, or a body quarantined"
        }
        Class::Refused => "the method cannot solve what the scene declares, and says so",
    };
    let measure = |measure: Measure| match measure {
        Measure::Energy => {
            "energy that the method invented (positive) or lost, relative to that at the start"
        }
        Measure::Reference => {
            "farthest that a body is from where a fine run has it, relative to the longest way"
        }
        Measure::Origin => "the same from where the method itself has it at the origin",
        Measure::Rest => "kinetic energy of what should be at rest, relative to m g L",
        Measure::Stretch => "largest strain of a spring",
        Measure::TerminalSpeed => {
            "speed at the end relative to the terminal one, minus 1: -1 stands, below -1 rises"
        }
    };
    let classes = Class::ALL.map(|it| (it.name(), class(it)));
    let measures = Measure::ALL.map(|it| (it.name(), measure(it)));
    let rows = classes.into_iter().chain(measures);
    let rows: String =
        rows.map(|(word, what)| format!("<dt>{word}</dt><dd>{}</dd>\n", html(what))).collect();
    format!("<h3>How to read it</h3>\n<dl>\n{rows}</dl>\n")
}
