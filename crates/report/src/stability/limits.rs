//! The largest stable steps and the maps of steps, as parts of the page and as files.

use super::Section;
use super::maps::picture;
use super::tables::exact;
use crate::page::table;
use crate::tables::csv;
use lab::limits::{Limit, Map};

/// The parts of the page.
#[must_use]
pub fn sections(limits: &[Limit], maps: &[Map]) -> Vec<Section> {
    let header = ["system", "method", "measured", "closed form", "difference", "judged by"];
    let rows = limits.iter().map(|limit| limit.cells().into());
    let measured = format!(
        "<p>The largest stable w h, found by halving, beside the closed form. w is the frequency of the system, of a net its \
         largest. Judged by amplitude, a run stays within a thousand times its start; what grows too slowly for that is judged by \
         one tick: its spectral radius is at most 1, or it adds no energy.</p>\n{}",
        table("numbers", &header, rows)
    );
    let maps = maps.iter().map(|map| format!("<figure>\n{}</figure>\n", picture(map).inline())).collect();
    [("Largest stable steps", measured), ("Maps", maps)]
        .map(|(title, body)| Section { title: title.to_owned(), body })
        .into()
}

/// The table for programs: `system,method,measured,theory,criterion`; 0 is never stable, `inf` always.
#[must_use]
pub fn limits_csv(limits: &[Limit]) -> String {
    let row = |limit: &Limit| {
        let [measured, theory] = [limit.measured, limit.theory].map(exact);
        let criterion = limit.criterion.name().to_owned();
        vec![limit.system.clone(), limit.method.to_owned(), measured, theory, criterion]
    };
    csv("system,method,measured,theory,criterion", limits.iter().map(row))
}
