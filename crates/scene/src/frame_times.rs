//! Frame times from a file: one length in seconds per line.

use crate::text::faults::{Faults, SceneError};

/// Reads the lengths of frames, s, each finite and at least 0. Ignores blank lines, and text after a `#`.
///
/// ```
/// assert_eq!(scene::parse_frame_times("t", "0.016 # first\n\n0.02\n"), Ok(vec![0.016, 0.02]));
/// ```
///
/// # Errors
///
/// With every line that is not a frame time, or if there are no frame times.
pub fn parse_frame_times(name: &str, text: &str) -> Result<Vec<f64>, SceneError> {
    let mut faults = Faults::default();
    let mut times = Vec::new();
    let mut start = 0;
    for line in text.split_inclusive('\n') {
        let content = line.split('#').next().unwrap_or_default();
        let number = content.trim();
        match number.parse::<f64>() {
            _ if number.is_empty() => {}
            Ok(seconds) if seconds >= 0.0 && seconds.is_finite() => times.push(seconds),
            _ => {
                let offset = start + content.len() - content.trim_start().len();
                let what = format!("{number:?} is not a frame time");
                faults.add_at(
                    None,
                    offset,
                    what,
                    "give seconds from 0 up, one number a line".to_owned(),
                );
            }
        }
        start += line.len();
    }
    faults.check(name, text, "")?;
    if times.is_empty() {
        return Err(SceneError::of_file(
            name,
            "there is no frame time",
            "give one number of seconds a line",
        ));
    }
    Ok(times)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_bad_line_is_named() {
        let error = parse_frame_times("t.txt", "0.01\r\n  -1\n# fine\n\nnan # no\n1e999\nx\n0.02")
            .unwrap_err();
        let cure = "give seconds from 0 up, one number a line";
        let expected = [("2:3", "-1"), ("5:1", "nan"), ("6:1", "1e999"), ("7:1", "x")];
        let expected = expected
            .map(|(at, what)| format!("t.txt:{at}: \"{what}\" is not a frame time; {cure}"));
        assert_eq!(error.to_string(), expected.join("\n"));
    }

    #[test]
    fn a_file_without_a_time_is_refused() {
        let error = parse_frame_times("t.txt", "# nothing\n").unwrap_err();
        assert_eq!(
            error.to_string(),
            "t.txt: there is no frame time; give one number of seconds a line"
        );
    }
}
