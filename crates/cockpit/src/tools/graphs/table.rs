//! Samples as a table for other programs.

use glam::DVec3;
use motion::Method;

use crate::tools::graphs::state::{Graphed, Graphs, Run, Sample};

/// The vectors of a motion, and their units.
const QUANTITIES: [(&str, &str); 4] =
    [("position", "m"), ("velocity", "m_s"), ("acceleration", "m_s2"), ("force", "n")];

impl Graphs {
    /// Every sample that is drawn, as CSV. Has a column for the body if there are several curves, and columns for the run if
    /// there are ghosts.
    pub(super) fn csv(&self) -> String {
        let mut header = vec!["time_s".to_owned()];
        header.extend(self.has_several().then(|| "body".to_owned()));
        header
            .extend(["run", "method"].into_iter().filter(|_| self.has_ghosts()).map(str::to_owned));
        for (quantity, unit) in QUANTITIES {
            header.extend(["x", "y", "z"].map(|axis| format!("{quantity}_{axis}_{unit}")));
        }
        header.push("kinetic_energy_j".to_owned());
        let rows = self.bodies.iter().flat_map(|body| {
            let tracks = body.tracks.iter().filter(|track| track.shown);
            tracks.flat_map(move |track| {
                track.samples.iter().map(move |sample| self.row(body, track.run, sample))
            })
        });
        report::csv(&header.join(","), rows)
    }

    fn row(&self, body: &Graphed, run: Run, Sample { time, motion }: &Sample) -> Vec<String> {
        let mut row = vec![time.to_string()];
        row.extend(self.has_several().then(|| body.name.clone()));
        let run = match run {
            Run::Solid => "solid",
            Run::Ghost(Some(_)) => "ghost",
            Run::Ghost(None) => "reference",
        };
        let method = Method::name(motion.method);
        row.extend([run, method].into_iter().filter(|_| self.has_ghosts()).map(str::to_owned));
        let [acceleration, force] = motion.forced.map_or([None; 2], |forced| forced.map(Some));
        for vector in [Some(motion.position), Some(motion.velocity), acceleration, force] {
            row.extend(vector.map_or_else(Default::default, |DVec3 { x, y, z }| {
                [x, y, z].map(|number| number.to_string())
            }));
        }
        row.push(motion.kinetic_energy.to_string());
        row
    }
}
