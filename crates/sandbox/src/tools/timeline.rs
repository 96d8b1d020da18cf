//! The timeline: going back in the last minute.

pub(crate) mod panel;
