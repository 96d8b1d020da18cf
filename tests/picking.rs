//! Rays from pixels: what is selected, what is pushed.
