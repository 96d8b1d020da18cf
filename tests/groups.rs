//! Groups: springs, soft bodies, mutual gravity and air on sheets, integrated by every method.

mod called;
mod conserved;
mod cords;
mod direct_sum;
mod hostile;
mod implicit;
mod manufactured;
mod members;
mod orders;
mod rest;
mod side_by_side;
mod stability;
mod structure;
mod threads;
mod totals;
mod wind;
