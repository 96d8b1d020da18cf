//! The tutorial's two loops, written out again, against the schedule.
