//! The legend beside the frame: a row a method, a precision, or a kind of mark.

use motion::Method;

use super::{
    BUDGET, CROSS, Chart, FRONT, INK, LEGEND, RING, SOFT, TOP, WIDTH, dashes, escaped, mark, stroke,
};
use lab::cost::Precision;

impl Chart {
    /// The next row of the legend: a sample of 34 pixels around its middle, and words.
    fn row(&mut self, sample: &str, words: &str) {
        let y = f64::from(TOP) + 8.0 + 23.0 * f64::from(self.legend_rows);
        self.legend_rows += 1;
        let x = f64::from(WIDTH - LEGEND) + 44.0;
        self.legend += &format!(
            "<g transform=\"translate({x:.1},{y:.1})\">{sample}<text class=\"ink\" fill=\"{INK}\" x=\"27\" y=\"4.5\">{}\
             </text></g>\n",
            escaped(words)
        );
    }

    /// A curve of a method, in the legend.
    pub(crate) fn legend_method(&mut self, method: Method, words: &str) {
        let style = stroke(method, Precision::F64);
        let sample =
            format!("<path d=\"M-18,0 H18\" fill=\"none\" {style}/>{}", mark(method, 0.0, 0.0, words));
        self.row(&sample, words);
    }

    /// How a precision is dashed, in the legend.
    pub(crate) fn legend_precision(&mut self, precision: Precision, words: &str) {
        let dash = dashes(precision);
        self.row(
            &format!("<path class=\"dash\" d=\"M-18,0 H18\" stroke=\"{SOFT}\" stroke-width=\"2\" {dash}/>"),
            words,
        );
    }

    /// Empty row.
    pub(crate) const fn legend_gap(&mut self) {
        self.legend_rows += 1;
    }

    /// The front, in the legend.
    pub(crate) fn legend_front(&mut self, words: &str) {
        self.row(&format!("<path class=\"front\" d=\"M-18,0 H18\" {FRONT}/>"), words);
    }

    /// The ring, in the legend.
    pub(crate) fn legend_ring(&mut self, words: &str) {
        self.row(&format!("<circle class=\"ring\" r=\"10\" {RING}/>"), words);
    }

    /// The budget, in the legend.
    pub(crate) fn legend_budget(&mut self, words: &str) {
        self.row(&format!("<path class=\"budget\" d=\"M0,-9 V9\" {BUDGET}/>"), words);
    }

    /// Failures, in the legend.
    pub(crate) fn legend_failure(&mut self, words: &str) {
        self.row(
            &format!("<path class=\"dash\" d=\"{CROSS}\" stroke=\"{SOFT}\" stroke-width=\"2.4\"/>"),
            words,
        );
    }

    /// More about the row before, in the legend.
    pub(crate) fn legend_detail(&mut self, words: &str) {
        let y = f64::from(TOP) + 8.0 + 23.0 * f64::from(self.legend_rows);
        self.legend_rows += 1;
        let x = f64::from(WIDTH - LEGEND) + 71.0;
        self.legend += &format!(
            "<text class=\"soft\" fill=\"{SOFT}\" x=\"{x:.1}\" y=\"{y:.1}\">{}</text>\n",
            escaped(words)
        );
    }

    /// Words alone, in the legend.
    pub(crate) fn legend_note(&mut self, words: &str) {
        let y = f64::from(TOP) + 12.0 + 23.0 * f64::from(self.legend_rows);
        self.legend_rows += 1;
        let x = f64::from(WIDTH - LEGEND) + 26.0;
        self.legend += &format!(
            "<text class=\"soft\" fill=\"{SOFT}\" x=\"{x:.1}\" y=\"{y:.1}\">{}</text>\n",
            escaped(words)
        );
    }
}
