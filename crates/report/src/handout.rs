//! Lessons on paper: a page for each, with room for answers, and a sheet of the measured answers.

use super::escape::html;
use super::page::document;

/// Rules of style beside those of all pages.
const RULES: &str = "section{break-inside:avoid;margin-bottom:1.5em}img{max-width:100%;border:1px solid #999}\
                     .room{height:3.5em;border-bottom:1px solid #999}\n";

/// A lesson, played by its solution.
#[derive(Clone, Debug)]
pub struct Handout {
    /// What it is called.
    pub title: String,
    /// What it is about.
    pub about: String,
    /// The page of the tutorial that it belongs to.
    pub belongs_to: String,
    /// Its steps.
    pub steps: Vec<HandoutStep>,
}

/// A step of a lesson.
#[derive(Clone, Debug)]
pub struct HandoutStep {
    /// What to do, or the question.
    pub task: String,
    /// What to watch.
    pub watch: String,
    /// What can be chosen; empty if nothing is chosen.
    pub choices: Vec<String>,
    /// The unit of a number that is asked for.
    pub unit: Option<String>,
    /// Name of the file of its picture, beside the page.
    pub picture: String,
    /// What was measured.
    pub measured: String,
    /// The right answer of a question.
    pub answer: Option<String>,
}

/// The page of a lesson, without answers.
#[must_use]
pub fn handout(lesson: &Handout) -> String {
    let sections: String = (1..).zip(&lesson.steps).map(|(number, step)| section(number, step)).collect();
    let lead = format!("{} Belongs to: {}.", html(&lesson.about), html(&lesson.belongs_to));
    document(&lesson.title, &lead, RULES, "", &sections, "")
}

fn section(number: usize, step: &HandoutStep) -> String {
    let HandoutStep { task, watch, choices, unit, picture, .. } = step;
    let boxes: String =
        choices.iter().map(|choice| format!("<li>\u{2610} {}</li>\n", html(choice))).collect();
    let room = match unit {
        Some(unit) => format!("<p>Answer: ____________ {}</p>\n", html(unit)),
        None if choices.is_empty() => "<div class=\"room\">What I saw:</div>\n".to_owned(),
        None => format!("<ul style=\"list-style:none\">\n{boxes}</ul>\n"),
    };
    format!(
        "<section>\n<h2>{number}. {}</h2>\n<p>{}</p>\n<img src=\"{}\" alt=\"the scene after this step\">\n{room}</section>\n",
        html(task),
        html(watch),
        html(picture),
    )
}

/// The answers of all lessons.
#[must_use]
pub fn answers(lessons: &[Handout]) -> String {
    let lesson = |lesson: &Handout| {
        let rows: String = (1..)
            .zip(&lesson.steps)
            .map(|(number, step)| {
                let answer = step.answer.as_deref().unwrap_or_default();
                let unit = step.unit.as_deref().filter(|_| step.answer.is_some()).unwrap_or_default();
                format!(
                    "<tr><td>{number}</td><td>{} {}</td><td>{}</td></tr>\n",
                    html(answer),
                    html(unit),
                    html(&step.measured)
                )
            })
            .collect();
        format!(
            "<section>\n<h2>{}</h2>\n<table>\n<tr><th>step</th><th>answer</th><th>measured</th></tr>\n{rows}</table>\n</section>\n",
            html(&lesson.title)
        )
    };
    let sections: String = lessons.iter().map(lesson).collect();
    document(
        "Answers",
        "The answers are those of the lesson, and were accepted by what its runs measured.",
        RULES,
        "",
        &sections,
        "",
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_page_asks_and_the_sheet_answers() {
        let step = |choices: &[&str], unit: Option<&str>, answer: Option<&str>| HandoutStep {
            task: "Push <it>.".to_owned(),
            watch: String::new(),
            choices: choices.iter().map(|&choice| choice.to_owned()).collect(),
            unit: unit.map(str::to_owned),
            picture: "a-1.png".to_owned(),
            measured: "It goes at 17.5 m/s.".to_owned(),
            answer: answer.map(str::to_owned),
        };
        let steps = vec![
            step(&[], None, None),
            step(&["one", "two"], None, Some("two")),
            step(&[], Some("m/s"), Some("17.5")),
        ];
        let lesson =
            Handout { title: "A".to_owned(), about: "B.".to_owned(), belongs_to: "C".to_owned(), steps };
        let page = handout(&lesson);
        assert!(
            page.contains("Push &lt;it&gt;.") && page.contains("____ m/s") && page.contains("\u{2610} two")
        );
        assert!(!page.contains("17.5"), "the page does not say the answer");
        let sheet = answers(&[lesson]);
        assert!(sheet.contains("<td>17.5 m/s</td>") && sheet.contains("<td>two </td>"), "{sheet}");
    }
}
