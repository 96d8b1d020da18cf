//! The README's section on what accuracy costs says what the committed report says, number by number.

use lab::cost::Report;

use crate::harness::root;

#[test]
fn the_readme_says_what_the_report_says() {
    let read = |path: &str| std::fs::read_to_string(root().join(path)).unwrap();
    let report: Report = serde_json::from_str(&read("docs/cost/report.json")).unwrap();
    assert!(report.complete && report.command == "sandbox cost kepler --quick", "{}", report.command);
    let [study] = &report.studies[..] else { panic!("one study") };
    let readme = read("README.md");
    let between = readme.split_once("<!-- cost: begin").unwrap().1.split_once("<!-- cost: end").unwrap().0;
    let text = between.split_once("-->\n").unwrap().1;
    assert_eq!(text, report::brief(study, &report.machine), "run scripts/readme-cost");
    let everything = format!("## kepler\n\n{}", report::markdown(study, &report.machine));
    assert_eq!(read("docs/cost/summary.md"), everything, "run scripts/readme-cost");

    let figure = readme
        .split_once("![error")
        .unwrap()
        .1
        .split_once("](docs/cost/")
        .unwrap()
        .1
        .split_once(')')
        .unwrap()
        .0;
    let picture = std::fs::read(root().join("docs/cost").join(figure)).unwrap();
    assert!(picture.starts_with(b"\x89PNG"));
}
