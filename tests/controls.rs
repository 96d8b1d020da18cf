//! Keys, modes, clocks and panels, through sessions.
