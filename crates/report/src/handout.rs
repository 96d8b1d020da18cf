//! Lessons on paper: a page for each, with room for answers, a sheet of the measured answers, and an index of all.

use super::escape::html;
use super::page::document;

/// Rules of style beside those of all pages.
const RULES: &str = "section{break-inside:avoid;margin-bottom:1.5em}img{max-width:100%;border:1px solid #999}\
                     .room{height:3.5em;border-bottom:1px solid #999}.who{display:flex;gap:2em}\
                     .who span{flex:1;border-bottom:1px solid #999}th,td{padding:2px 8px;text-align:left;vertical-align:top}\n\
                     @page{size:A4;margin:14mm}@media print{body{font-size:10.5pt;padding:0}h1{font-size:17pt;margin:0}\
                     h2{font-size:12.5pt;margin:.6em 0 .2em}p{margin:.3em 0}ul{margin:.2em 0}tr{break-inside:avoid}}\n";

/// Additional rules for a page with steps: two steps fit on a sheet.
const TWO_TO_A_PAGE: &str = "@media print{section{margin:0}img{max-height:56mm;max-width:110mm}\
                             section:nth-of-type(2n){break-after:page}section:last-of-type{break-after:auto}}\n";

/// A place for the name of a pupil and the date.
const WHO: &str = "<p class=\"who\"><span>Name:</span><span>Date:</span></p>\n";

/// A lesson on paper, with the numbers that its solution gave.
#[derive(Clone, Debug)]
pub struct Handout {
    /// Title of the lesson.
    pub title: String,
    /// What it is about.
    pub about: String,
    /// The page of the tutorial that it belongs to.
    pub belongs_to: String,
    /// Its duration, minutes.
    pub minutes: u32,
    /// Name of the file of its page.
    pub page: String,
    /// Address at which it is played, if there is one.
    pub played_at: Option<String>,
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
    /// The unit of the number that the step asks for, if any.
    pub unit: Option<String>,
    /// Name of the file of its picture, beside the page; `None` for a question, which changes nothing that could be
    /// seen.
    pub picture: Option<String>,
    /// What was measured when the solution was played.
    pub measured: String,
    /// Whether the measured numbers depend on how the step is done.
    pub depends: bool,
    /// The right answer of a question.
    pub answer: Option<String>,
}

/// The page of a lesson, without answers.
#[must_use]
pub fn handout(lesson: &Handout) -> String {
    let sections: String =
        (1..).zip(&lesson.steps).map(|(number, step)| section(number, step)).collect();
    let mut lead = format!("{} Belongs to: {}.", html(&lesson.about), html(&lesson.belongs_to));
    if let Some(address) = lesson.played_at.as_deref().map(html) {
        lead += &format!(" Play it: <a href=\"{address}\">{address}</a>");
    }
    document(&lesson.title, &lead, &format!("{RULES}{TWO_TO_A_PAGE}"), WHO, &sections, "")
}

/// A page with a link to that of each lesson, and to the sheet of answers in the file `answers`.
#[must_use]
pub fn index(lessons: &[Handout], answers: &str) -> String {
    let row = |lesson: &Handout| {
        format!(
            "<tr><td><a href=\"{}\">{}</a></td><td>{} min</td><td>{}</td><td>{}</td></tr>\n",
            html(&lesson.page),
            html(&lesson.title),
            lesson.minutes,
            html(&lesson.about),
            html(&lesson.belongs_to),
        )
    };
    let rows: String = lessons.iter().map(row).collect();
    let table = format!(
        "<table>\n<tr><th>lesson</th><th>takes</th><th>about</th><th>belongs to</th></tr>\n{rows}</table>\n\
         <p><a href=\"{answers}\">The answers</a>, for teachers.</p>\n"
    );
    document("Lessons", "Each prints on A4, two steps to a page.", RULES, "", &table, "")
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
    let image = picture.as_deref().map_or_else(String::new, |picture| {
        format!("<img src=\"{}\" alt=\"the scene after this step\">\n", html(picture))
    });
    format!(
        "<section>\n<h2>{number}. {}</h2>\n<p>{}</p>\n{image}{room}</section>\n",
        html(task),
        html(watch),
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
                let unit =
                    step.unit.as_deref().filter(|_| step.answer.is_some()).unwrap_or_default();
                let example =
                    if step.depends && !step.measured.is_empty() { "For example: " } else { "" };
                format!(
                    "<tr><td>{number}</td><td>{}</td><td>{} {}</td><td>{example}{}</td></tr>\n",
                    html(&step.task),
                    html(answer),
                    html(unit),
                    html(&step.measured)
                )
            })
            .collect();
        format!(
            "<section>\n<h2>{}</h2>\n<table>\n<tr><th>step</th><th>task</th><th>answer</th><th>measured</th></tr>\n{rows}</table>\n</section>\n",
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
            picture: Some("a-1.png".to_owned()),
            measured: "It goes at 17.5 m/s.".to_owned(),
            depends: answer.is_none(),
            answer: answer.map(str::to_owned),
        };
        let steps = vec![
            step(&[], None, None),
            step(&["one", "two"], None, Some("two")),
            step(&[], Some("m/s"), Some("17.5")),
        ];
        let lesson = Handout {
            played_at: None,
            title: "A".to_owned(),
            about: "B.".to_owned(),
            belongs_to: "C".to_owned(),
            minutes: 5,
            page: "a.html".to_owned(),
            steps,
        };
        let page = handout(&lesson);
        assert!(
            page.contains("Push &lt;it&gt;.")
                && page.contains("____ m/s")
                && page.contains("\u{2610} two")
        );
        assert!(!page.contains("17.5"), "the page does not say the answer");
        assert!(page.contains("Name:") && page.contains("Date:"));
        let all = index(std::slice::from_ref(&lesson), "answers.html");
        assert!(all.contains("<a href=\"a.html\">A</a>") && all.contains("answers.html"), "{all}");
        let sheet = answers(&[lesson]);
        assert_eq!(sheet.matches("For example: It goes").count(), 1, "{sheet}");
        assert_eq!(sheet.matches("Push &lt;it&gt;.").count(), 3, "{sheet}");
        assert!(sheet.contains("<td>17.5 m/s</td>") && sheet.contains("<td>two </td>"), "{sheet}");
    }
}
