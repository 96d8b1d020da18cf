//! Lessons: each is played by its own solution and by wrong ones, its claims are measured, and a person does the first by mouse.

use std::fs;

use cockpit::app::pupil::{Pupil, Runs};
use glam::DVec2;
use lab::lesson::{Quantities, RunLimit, run_lesson};
use sandbox::input::{Button, Input};
use sandbox::{Options, Order};
use scene::lesson::{Goal, Lesson, shipped};

use crate::rigs::{Cockpit, Said, answers, folder, sandbox};

/// A lesson of one step, with `more` keys in its first step.
fn lesson(more: &str) -> String {
    format!(
        r#"(
    version: 1, title: "T", about: "A.", page: "P", scene: "oscillator",
    measure: (x: position("ball", x)),
    runs: [(seconds: 1, measure: (e: energy))],
    steps: [
        (task: "Push it.", done: "x > x_before + 0.5", {more}
         solution: [push("ball", (5000, 0, 0))], wrong: [[press("G")], [push("ball", (-50, 0, 0))]],
         then: "At {{x}} m.", holds: "x > 3"),
    ],
)"#
    )
}

fn check(text: &str) -> Said {
    sandbox(folder([("my.ron", text)]), "lessons check my.ron")
}

#[test]
fn every_lesson_is_done_by_its_solution_and_not_by_wrong_ones_and_its_claims_hold_at_two_steps() {
    let names: Vec<_> = shipped().iter().map(|(name, _)| *name).collect();
    assert!(names.len() > 10, "{names:?}");
    std::thread::scope(|scope| {
        for half in names.chunks(names.len().div_ceil(2)) {
            scope.spawn(move || {
                for name in half {
                    let said = sandbox(".", &format!("lessons check {name}")).fine();
                    assert_eq!(said.matches(" Hz\n").count(), 2, "{said}");
                }
            });
        }
    });
}

#[test]
fn every_lesson_is_short_asks_something_and_says_what_it_measured() {
    for (name, text) in shipped() {
        let lesson = Lesson::parse(name, text).unwrap();
        assert!((3..=6).contains(&lesson.steps.len()), "{name}");
        assert!(lesson.wrong_ways() >= 2, "{name}");
        assert!(lesson.page.starts_with("Physics - Linear Motion"), "{name}");
        assert!(lesson.steps.iter().any(|step| !matches!(step.goal, Goal::Done { .. })), "{name}");
        assert!(lesson.steps.iter().any(|step| step.then.formulas().next().is_some()), "{name}");
        for step in &lesson.steps {
            let teaches = match &step.goal {
                Goal::Done { .. } => !step.missing.is_empty(),
                Goal::Number { wrong, .. } => wrong.iter().all(|wrong| !wrong.why.is_empty()),
                Goal::Choice { choices, solution } => {
                    choices.iter().all(|choice| choice.say == *solution || !choice.why.is_empty())
                }
            };
            assert!(teaches, "{name}: {} does not say what went wrong", step.task);
            let sentences = step.task.matches(['.', '?', '!', ':']).count();
            assert!(sentences <= 4, "{name}: {}", step.task);
        }
    }
}

/// Each case replaces lines by those that follow them.
#[test]
fn a_teachers_lesson_is_checked_and_its_faults_have_their_places_and_cures() {
    answers("lessons", |edits| {
        let edits: Vec<_> = edits.lines().collect();
        let text = edits.chunks(2).fold(lesson(""), |text, edit| {
            assert!(text.contains(edit[0]), "{edit:?}");
            text.replace(edit[0], edit.get(1).unwrap_or(&""))
        });
        let Said { code, out, err, .. } = check(&text);
        format!("{code}\n{out}{err}")
    });
    // A script has times.
    let folder = folder([("wait.ron", "[(at_s: 1, do: wait(2))]")]);
    sandbox(folder, "run tutorial --seconds 1 --script wait.ron")
        .fails(2, "a script does not wait");
}

#[test]
fn a_step_says_what_is_missing_and_begins_where_the_person_changed_the_run() {
    let text = lesson("begin: [reset, pause], hint: \"Push harder.\",")
        .replace("x > x_before + 0.5", "x < x_before - 0.5");
    let lesson = Lesson::parse("my.ron", &text).unwrap();
    let mut cockpit = Cockpit::of("oscillator", [1280, 720]);
    cockpit.drive.ticks(100);
    cockpit.drive.session.begin_lesson(lesson, Quantities::default());
    cockpit.drive.ticks(3);
    let step = |cockpit: &Cockpit| cockpit.session().tools.lesson().unwrap().step;
    let says = |cockpit: &Cockpit, words: &str| {
        cockpit.session().controls().iter().any(|control| control.name.contains(words))
    };
    let x = cockpit.drive.x("ball").x;
    cockpit.drive.ticks(5);
    assert_eq!((x, cockpit.drive.x("ball").x), (3.0, 3.0), "reset and paused");
    // Nothing was done for a while.
    assert!(!says(&cockpit, "Not yet"));
    cockpit.drive.run(11, 1.0);
    assert!(says(
        &cockpit,
        "Not yet: the x of ball is 3 m and has to be below 2.5 m; the run is paused: Play continues it."
    ));
    assert!(says(&cockpit, "Hint: Push harder.") && !says(&cockpit, "Show me"));
    cockpit.drive.run(20, 1.0);
    assert!(says(&cockpit, "Show me"));
    // It swings by more than half a meter, but that is over when it is pushed.
    cockpit.press("P");
    cockpit.drive.give([crate::rigs::push("ball", [-1.0, 0.0, 0.0])]).ticks(3);
    assert!(says(&cockpit, "Not yet") && step(&cockpit) == 0);
    let before = cockpit.drive.x("ball").x;
    cockpit.drive.give([crate::rigs::push("ball", [-9000.0, 0.0, 0.0])]).ticks(2);
    assert_eq!(step(&cockpit), 1, "{before} m, {} m", cockpit.drive.x("ball").x);
    // What is not true is not said, and that it is not.
    assert!(
        !says(&cockpit, "At ")
            && says(&cockpit, "It did not come out as usual this time (the x of ball is ")
    );
    assert!(says(&cockpit, "Previous lets you try again.") && !says(&cockpit, "✔"));
    // Again from the start, though the step has no beginning of its own.
    cockpit.click("Previous");
    cockpit.drive.ticks(2);
    assert_eq!((step(&cockpit), cockpit.drive.x("ball").x), (0, 3.0));
}

#[test]
fn what_is_missing_of_a_marked_body_is_said_of_the_body_with_the_ring() {
    let text = lesson("point_at: \"ball\",").replace("x > x_before + 0.5", "x > 30");
    let mut cockpit = Cockpit::of("oscillator", [1280, 720]);
    cockpit
        .drive
        .session
        .begin_lesson(Lesson::parse("my.ron", &text).unwrap(), Quantities::default());
    cockpit.press("P");
    cockpit.drive.run(11, 1.0);
    let words = "Not yet: the x of the body with the ring is 2.99";
    let said: Vec<_> =
        cockpit.session().controls().into_iter().map(|control| control.name).collect();
    assert!(said.iter().any(|said| said.starts_with(words)), "{said:?}");
}

#[test]
fn the_names_at_which_lessons_point_are_controls() {
    let mut cockpit = Cockpit::of("tutorial", [1600, 900]);
    cockpit.drive.ticks(3);
    let names = |cockpit: &Cockpit| -> Vec<String> {
        cockpit.session().controls().iter().map(|control| control.name.clone()).collect()
    };
    let mut seen = names(&cockpit);
    cockpit.press("P");
    seen.extend(names(&cockpit));
    for tab in ["Measure", "Build", "Past", "Look"] {
        cockpit.click(tab);
        cockpit.drive.ticks(3);
        seen.extend(names(&cockpit));
    }
    // The list of methods is called by what is chosen, and Follow comes when all has left the view.
    for name in sandbox::pointable().filter(|name| !["method", "Follow"].contains(name)) {
        assert!(seen.iter().any(|seen| seen == name), "{name}: {seen:?}");
    }
}

#[test]
fn the_lesson_of_the_document_is_one() {
    let page = fs::read_to_string(crate::rigs::root().join("docs/lessons.md")).unwrap();
    let text = page.split_once("```ron\n").unwrap().1.split_once("```").unwrap().0;
    check(text).fine();
}

/// Begins the lesson that was ordered, as the window does: it is the first one.
fn begin_ordered(cockpit: &mut Cockpit) {
    let session = &mut cockpit.drive.session;
    assert_eq!(session.stage.take_orders(), [Order::Lesson("force".to_owned())]);
    let lesson = scene::lesson::load("force").unwrap();
    let of_runs = run_lesson(&lesson, 1.0, RunLimit::USUAL).unwrap();
    session.open(scene::load("tutorial").unwrap());
    session.begin_lesson(lesson, of_runs);
}

#[test]
fn the_first_lesson_is_done_by_mouse_alone() {
    let mut cockpit = Cockpit::of("tutorial", [1280, 720]);
    cockpit.press("F");
    cockpit.click("Learn");
    cockpit.drive.ticks(3);
    cockpit.click("What a force does");
    cockpit.drive.ticks(3);
    begin_ordered(&mut cockpit);
    cockpit.press("F");
    let step = |cockpit: &Cockpit| cockpit.session().tools.lesson().unwrap().step;
    // A click on another body does not do it.
    let click = |cockpit: &mut Cockpit, body: &str, button| {
        let at = cockpit.seen(body);
        cockpit
            .drive
            .give([Input::Mouse(at.x, at.y), Input::ButtonDown(button)])
            .give([Input::ButtonUp(button)]);
        cockpit.drive.ticks(4);
    };
    click(&mut cockpit, "player", Button::Left);
    assert_eq!(step(&cockpit), 0);
    click(&mut cockpit, "grid.x0.z4", Button::Left);
    assert_eq!(step(&cockpit), 1);
    assert!(cockpit.has("✔ It stands still: 0 m/s. No force, no change."));
    click(&mut cockpit, "grid.x0.z4", Button::Right);
    assert_eq!(step(&cockpit), 2);
    let ball = cockpit.seen("grid.x0.z4");
    cockpit.drive.give([Input::Mouse(ball.x, ball.y), Input::Wheel(2.0)]);
    click(&mut cockpit, "grid.x0.z4", Button::Right);
    assert_eq!(step(&cockpit), 3);
    cockpit.click("answer");
    cockpit.drive.give([Input::Text("0.05".to_owned())]).ticks(2);
    cockpit.click("Answer");
    cockpit.drive.ticks(3);
    assert_eq!(step(&cockpit), 3, "a wrong answer");
    assert!(cockpit.has("You multiplied by the mass: divide by it."));
    cockpit.click("answer");
    for _ in 0..5 {
        cockpit.press("Backspace");
    }
    cockpit.drive.give([Input::Text("5".to_owned())]).ticks(2);
    cockpit.press("Enter");
    assert_eq!(step(&cockpit), 4);
    assert!(cockpit.has("✔ Measured in a run: 5 m/s. Force times time over mass says 5 m/s."));
    assert!(cockpit.session().arrangement().contains("lesson_done force\n"));
    cockpit.click("Next: Mass and inverse mass");
    cockpit.drive.ticks(3);
    let orders = cockpit.drive.session.stage.take_orders();
    assert_eq!(orders, [Order::Lesson("mass".to_owned())]);
}

#[test]
fn a_lesson_tells_the_same_numbers_at_every_rate_of_frames() {
    // A ball on a spring is pushed, and goes on until it is far out; the extremes of the way are between frames.
    let text = lesson("begin: [reset, pause],")
        .replace(
            "x: position(\"ball\", x)",
            "x: position(\"ball\", x), v: speed(\"ball\"), t: time",
        )
        .replace("x > x_before + 0.5", "t > 1.3")
        .replace("[push(\"ball\", (5000, 0, 0))]", "[push(\"ball\", (700, 0, 0)), press(\"P\")]")
        .replace(
            "At {x} m.",
            "At {x} m after {t} s, {x_most} m, {x_least} m, {v_most} m/s, {v} m/s.",
        );
    let own = Lesson::parse("my.ron", &text).unwrap();
    for lesson in [own, scene::lesson::load("feather").unwrap()] {
        let runs = Runs::new(&lesson, 1.0).unwrap();
        let told = [4.0, 10.0, 60.0].map(|fps| {
            let options = Options { pictures: false, ..Options::default() };
            let mut pupil = Pupil::begin(&lesson, &runs, options).unwrap();
            pupil.fps = fps;
            let mut told = Vec::new();
            while pupil.solve(&lesson).unwrap() {
                let state = pupil.session.tools.lesson().unwrap();
                told.push((state.said, state.holds));
            }
            assert_eq!(told.len(), lesson.steps.len(), "{fps}: {told:?}");
            told
        });
        assert_eq!(told[0], told[2], "{}", lesson.name);
        assert_eq!(told[1], told[2], "{}", lesson.name);
    }
}

#[test]
fn a_person_who_is_stuck_is_shown_the_solution() {
    let mut cockpit = Cockpit::of("tutorial", [1280, 720]);
    cockpit.drive.ticks(3);
    let lesson = scene::lesson::load("force").unwrap();
    let of_runs = run_lesson(&lesson, 1.0, RunLimit::USUAL).unwrap();
    cockpit.drive.session.begin_lesson(lesson, of_runs);
    cockpit.drive.ticks(3);
    let step = |cockpit: &Cockpit| cockpit.session().tools.lesson().unwrap().step;
    for number in 0..3 {
        assert!(!cockpit.has("Show me"));
        cockpit.drive.run(31, 1.0);
        assert_eq!(step(&cockpit), number);
        cockpit.click("Show me");
        cockpit.drive.frames(420);
        let said: Vec<_> =
            cockpit.session().controls().into_iter().map(|control| control.name).collect();
        assert_eq!(step(&cockpit), number + 1, "{said:?}");
    }
    // Two wrong answers, one of which has words of its own.
    for (answer, says) in [
        ("7", "\"7\" is more than was measured."),
        ("60 m/s", "That is the force. It acts for 1/120 s, on 0.1 kg."),
    ] {
        assert!(!cockpit.has("Show me"));
        cockpit.drive.session.tools.lessons().answer(answer);
        cockpit.drive.ticks(2);
        assert!(cockpit.has(says), "{answer}");
    }
    cockpit.click("Show me");
    cockpit.drive.ticks(3);
    assert_eq!(step(&cockpit), 4);
    assert!(!cockpit.session().arrangement().contains("lesson_done force"));
    let left = |steps| {
        format!("The lesson is marked ✔ once you do this yourself (Previous): step {steps}.")
    };
    assert!(cockpit.has(&left("1, 2, 3, 4")));
    cockpit.click("Previous");
    cockpit.drive.ticks(3);
    cockpit.drive.session.tools.lessons().answer("5");
    cockpit.drive.ticks(3);
    assert!(cockpit.has(&left("1, 2, 3")));
}

#[test]
fn every_lesson_has_a_card_and_goes_on_where_it_was_left() {
    for size in [[1024, 600], [2560, 1440]] {
        let mut cockpit = Cockpit::of("tutorial", size);
        cockpit.drive.ticks(3);
        cockpit.click("Learn");
        cockpit.drive.ticks(3);
        for (name, text) in shipped() {
            let title = Lesson::parse(name, text).unwrap().title;
            assert!(cockpit.has(&title), "{name}");
        }
    }
    let mut cockpit = Cockpit::of("tutorial", [1280, 720]);
    cockpit.drive.give([Input::Arrange("lesson_left force 2\n".to_owned())]).ticks(3);
    cockpit.click("Learn");
    cockpit.drive.ticks(3);
    cockpit.click("Continue at step 3");
    cockpit.drive.ticks(3);
    begin_ordered(&mut cockpit);
    cockpit.drive.ticks(3);
    assert_eq!(cockpit.session().tools.lesson().unwrap().step, 2);
    cockpit.click("Skip");
    cockpit.drive.ticks(3);
    assert!(cockpit.session().arrangement().contains("lesson_left force 3\n"));
    cockpit.click("Leave");
    cockpit.drive.ticks(3);
    cockpit.click("Start again");
    cockpit.drive.ticks(3);
    begin_ordered(&mut cockpit);
    cockpit.drive.ticks(3);
    assert_eq!(cockpit.session().tools.lesson().unwrap().step, 0);
    assert!(!cockpit.session().arrangement().contains("lesson_left"));
}

#[test]
fn back_and_skip_work_and_a_lesson_waits_in_another_scene() {
    let mut cockpit = Cockpit::of("tutorial", [1024, 600]);
    let text = shipped()[0].1;
    let lesson = Lesson::parse("force", text).unwrap();
    cockpit.drive.session.begin_lesson(lesson, Quantities::default());
    cockpit.drive.ticks(3);
    let step = |cockpit: &Cockpit| cockpit.session().tools.lesson().unwrap().step;
    for (button, then) in [("Skip", 1), ("Skip", 2), ("Previous", 1), ("Previous", 0)] {
        cockpit.click(button);
        cockpit.drive.ticks(3);
        assert_eq!(step(&cockpit), then);
        // Nothing was done, so nothing was measured.
        assert!(!cockpit.session().controls().iter().any(|control| control.name.contains('✔')));
    }
    cockpit.drive.session.open(scene::load("oscillator").unwrap());
    cockpit.drive.ticks(3);
    cockpit.click("Open its scene");
    assert_eq!(format!("{:?}", cockpit.drive.session.stage.take_orders()), r#"[Open("tutorial")]"#);
    cockpit.click("Leave");
    cockpit.drive.ticks(3);
    assert!(cockpit.session().tools.lesson().is_none());
    cockpit.click("Close");
    cockpit.drive.ticks(3);
    assert!(cockpit.session().open_panels().is_empty());
}

#[test]
fn the_first_start_shows_a_card_until_a_lesson_begins() {
    let start = |cockpit: &mut Cockpit| {
        cockpit.drive.give([Input::Arrange("welcome on\n".to_owned())]).ticks(3);
        assert!(cockpit.has("Drag a ball."));
    };
    let mut cockpit = Cockpit::of("tutorial", [1280, 720]);
    cockpit.press("F");
    assert!(!cockpit.has("Drag a ball."));
    start(&mut cockpit);
    let ball = cockpit.seen("grid.x0.z4");
    cockpit.drag(Button::Left, ball, ball + DVec2::new(60.0, 0.0));
    cockpit.drive.ticks(3);
    assert!(cockpit.has("✔ Drag a ball."));
    assert!(!cockpit.session().arrangement().contains("welcome"));
    cockpit.click("Start the first lesson (2 min)");
    cockpit.drive.ticks(3);
    begin_ordered(&mut cockpit);
    cockpit.drive.ticks(3);
    assert_eq!(cockpit.session().tools.lesson().unwrap().name, "force");
    assert!(!cockpit.has("✔ Drag a ball."));
}

#[test]
fn a_run_shows_every_lesson_to_its_end() {
    for (name, text) in shipped() {
        let scene = Lesson::parse(name, text).unwrap().scene;
        let said = sandbox(".", &format!("run {scene} --lesson {name} --seconds 120 --fps 30"));
        assert!(!said.err.contains("steps were done"), "{name}: {}", said.err);
    }
}

#[test]
fn a_run_shows_a_lesson_in_its_scene() {
    let folder = tempfile::tempdir().unwrap();
    let line = "run tutorial --lesson force --seconds 16 --fps 4 --size 320x180 --film f.png --captions --summary s.json";
    sandbox(&folder, line).fine();
    sandbox(&folder, "run tutorial --seconds 2 --size 320x180 --film f.gif").fine();
    let gif = fs::read(folder.path().join("f.gif")).unwrap();
    assert!(gif.starts_with(b"GIF89a") && gif.ends_with(b";"), "{} bytes", gif.len());
    let film = fs::read(folder.path().join("f.png")).unwrap();
    assert!(film.windows(4).any(|word| word == b"acTL"));
    let summary: serde_json::Value =
        serde_json::from_slice(&fs::read(folder.path().join("s.json")).unwrap()).unwrap();
    let momentum = summary["momentum_kg_m_s"].as_array().map(|parts| parts[2].as_f64().unwrap());
    assert!(momentum.unwrap_or_default() < -0.5, "the ball was pushed: {summary}");
    let message = "sandbox: the lesson force plays in tutorial, not in orbit; run tutorial\n";
    sandbox(&folder, "run orbit --lesson force").says(2, message);
}

#[test]
fn a_teachers_lesson_is_printed_opened_as_a_file_and_no_scene() {
    let text = lesson("");
    let folder = folder([("my.ron", text.as_str())]);
    let path = folder.path().join("my.ron");
    let other = folder.path().join("other");
    fs::create_dir(&other).unwrap();
    fs::copy(&path, other.join("my.ron")).unwrap();
    let page = "https://example.org/play.html";
    sandbox(&folder, &format!("lessons --html out --page {page} my.ron force")).fine();
    let out = folder.path().join("out");
    let mut files: Vec<_> = fs::read_dir(&out)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    files.sort();
    let mut expected = ["answers.html", "force.html", "index.html", "my.html", "my-1.png"]
        .map(str::to_owned)
        .to_vec();
    expected.extend((1..=3).map(|step| format!("force-{step}.png")));
    expected.sort();
    assert_eq!(files, expected);
    let read = |name: &str| fs::read_to_string(out.join(name)).unwrap();
    assert!(read("force.html").contains(&format!("<a href=\"{page}#lesson=force\">")));
    assert!(!read("my.html").contains(page), "a web page has the lessons of the program");
    let index = read("index.html");
    assert!(
        index.contains("my.html") && index.contains("force.html") && !index.contains("mass.html")
    );
    // Pictures are on white.
    let picture = render::Image::decode_png(std::io::BufReader::new(
        fs::File::open(out.join("my-1.png")).unwrap(),
    ))
    .unwrap();
    assert_eq!(picture.pixel(2, 2), Some([255; 4]));
    let twice = "two lessons would have the page my.html; rename the file of one";
    sandbox(&folder, "lessons --html more my.ron other/my.ron").fails(2, twice);
    for line in ["run my.ron --seconds 1", "plan my.ron"] {
        let message = "sandbox: my.ron: this is a lesson, not a scene; `sandbox --lesson my.ron` plays it, `sandbox lessons check my.ron` checks it\n";
        sandbox(&folder, line).says(2, message);
    }
}

#[test]
fn pages_ask_and_the_sheet_answers() {
    let folder = tempfile::tempdir().unwrap();
    sandbox(&folder, "lessons --html out").fine();
    let read = |name: &str| fs::read_to_string(folder.path().join("out").join(name)).unwrap();
    let sheet = read("answers.html");
    for (name, text) in shipped() {
        let lesson = Lesson::parse(name, text).unwrap();
        let page = read(&format!("{name}.html"));
        for (number, step) in (1..).zip(&lesson.steps) {
            let picture = format!("{name}-{number}.png");
            // A question changes nothing that could be seen.
            let has_picture = matches!(step.goal, Goal::Done { .. });
            assert_eq!(page.contains(&picture), has_picture, "{picture}");
            let written = folder.path().join("out").join(picture).metadata();
            assert_eq!(written.is_ok_and(|file| file.len() > 1000), has_picture);
        }
        assert!(sheet.contains(&lesson.title));
    }
    assert!(sheet.contains("<td>5 m/s</td>"));
    assert!(!read("force.html").contains("5 m/s"));
}
