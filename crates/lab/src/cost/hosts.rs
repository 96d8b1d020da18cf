//! Hosts of a subject: a world of entities, or a loop over arrays.

use super::record::{Failure, Host, Setting};
use super::runner::Runner;
use super::subject::Subject;

/// Makes the run of a setting, or says why it cannot.
pub type Make = dyn Fn(&Subject, Setting, Host) -> Result<Box<dyn Runner>, Failure> + Send;

/// The [`Make`] of the program, with runs in a world or in a loop. Tests have others.
///
/// # Errors
/// If the method cannot solve what the subject declares, or no loop was written for it.
pub fn make(subject: &Subject, setting: Setting, host: Host) -> Result<Box<dyn Runner>, Failure> {
    if let Some(why) = subject.refusal(setting.method) {
        return Err(Failure::Unsolvable { why });
    }
    match host {
        Host::World => Ok(Box::new(subject.run(setting))),
        Host::Arithmetic => {
            let why = || Failure::Unsolvable { why: "no loop was written for it".to_owned() };
            subject.in_loop().map(|make| make(&subject.scene, setting)).ok_or_else(why)
        }
    }
}
