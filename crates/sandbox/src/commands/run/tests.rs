//! A run whose device is lost.

use clap::Parser;
use serde_json::Value;

use super::*;

#[derive(Parser)]
struct Line {
    #[command(flatten)]
    run: RunArgs,
}

#[test]
fn a_lost_device_ends_the_run_with_all_that_there_is() {
    let folder = tempfile::tempdir().unwrap();
    let place = |name: &str| folder.path().join(name).display().to_string();
    let scene = "(version: 1, gravity: (), bodies: [(name: \"ball\", shape: sphere(radius_m: 1))], \
                 emitters: [(on: gpu, rate_per_s: 50, life_s: 1, speed_m_s: 5)])";
    std::fs::write(place("rain.ron"), scene).unwrap();
    let (summary, film, frames) = (place("run.json"), place("film.png"), place("frames"));
    let words =
        ["run", &place("rain.ron"), "--size", "64x64", "--seconds", "2", "--summary", &summary];
    let words =
        words.into_iter().chain(["--film", &film, "--frames", &frames, "--frame-every", "10"]);
    let args = Line::try_parse_from(words).unwrap().run;
    let mut files = CommandFiles::default();
    let setup = Setup::new(&args, &mut files).unwrap();
    let paths = OutputPaths::claim(&args, None, &mut files).unwrap();
    let (mut session, ends, ticks) = setup.begin(&args).unwrap();
    let mut outputs = Outputs::open(&args, &paths, files, &session, ends.longest()).unwrap();
    let start = Summary::totals_at_start(&session.stage);
    let half = ticks.map(|ticks| ticks / 2);
    simulate(&args, &mut session, &mut outputs, FrameEnds::Constant { rate: 60.0 }, half, None)
        .unwrap();
    assert!(outputs.refused.is_ok());
    outputs.lose_device();
    simulate(&args, &mut session, &mut outputs, FrameEnds::Constant { rate: 60.0 }, ticks, None)
        .unwrap();
    let failure = outputs.finish(session, start).unwrap_err();
    assert!(
        matches!(&failure, Failure::NoAdapter(words) if words.contains("was lost")),
        "{failure}"
    );
    let summary: Value = serde_json::from_str(&std::fs::read_to_string(summary).unwrap()).unwrap();
    assert_eq!((&summary["scene"], &summary["swarms"]), (&"rain".into(), &Value::Null));
    let simulated = summary["ticks"].as_u64().unwrap();
    assert!(simulated >= half.unwrap() && simulated < ticks.unwrap(), "{simulated}");
    assert_eq!(
        std::fs::read_dir(frames).unwrap().count() as u64,
        summary["frames"].as_u64().unwrap()
    );
    assert!(summary["frames"].as_u64().unwrap() >= 6, "{summary}");
    let film = std::fs::read(film).unwrap();
    assert!(film.starts_with(b"\x89PNG") && film.ends_with(b"IEND\xaeB`\x82"));
}
