//! What tests build on: worlds made by hand, sessions that are driven, pictures, and the program.

mod bare;
mod cockpit;
mod command_lines;
mod dice;
mod drive;
mod environment;
mod film;
mod lab;
pub mod net;
mod program;
mod step_matrix;

use scene::Scene;

pub use bare::Bare;
pub use cockpit::Cockpit;
pub use command_lines::{command_lines, contents, without_display};
pub use dice::Dice;
pub use drive::*;
pub use environment::*;
pub use film::*;
pub use lab::*;
pub use net::{Net, State, chain, elastic, extrapolated, pendulum, ring, tetrahedron};
pub use program::*;
pub use step_matrix::{Matrix, by_columns, product, step_matrix, yoshida_steps};

/// Free bodies, a group of two on an anchor, particles that come and go; laws of position, velocity and time.
pub fn mixed() -> Scene {
    let text = r#"(
        version: 1, step_hz: 60, seed: 3, push: (),
        gravity: (acceleration_m_s2: (0, -9.8, 0), on_at_start: false),
        damping: (model: clamped, rate_per_s: 0.2), drag: (quadratic_per_m: 0.02),
        wells: [(position_m: (0, 5, -4), strength_m3_s2: 60, softening_m: 1)],
        thrusts: [(body: "box", curve: sine(amplitude_n: (0, 3, 1), angular_frequency_rad_s: 5, phase_rad: 0.3))],
        camera: (position_m: (0, 4, 24), pitch_deg: 0, yaw_deg: 0),
        bodies: [
            (name: "anchor", shape: cuboid(half_extents_m: (0.3, 0.3, 0.3)), position_m: (-6, 8, 0), immovable: true),
            (name: "ball", shape: sphere(radius_m: 1), position_m: (4, 4, 0), velocity_m_s: (0, 3, -1)),
            (name: "box", shape: cuboid(half_extents_m: (0.5, 0.6, 0.7)), position_m: (8, 6, 0), rotation_deg: (0, 30, 0)),
            (name: "first", shape: sphere(radius_m: 0.4), position_m: (-6, 5, 0), mass_kg: 2),
            (name: "second", shape: sphere(radius_m: 0.4), position_m: (-4, 3, 0), velocity_m_s: (0, 0, 2)),
            (name: "dust", position_m: (1, 9, 1), velocity_m_s: (-2, 0, 0), mass_kg: 0.1),
            (name: "spare", position_m: (1, 1, 1), velocity_m_s: (0, 1, 0)),
        ],
        emitters: [(rate_per_s: 20, position_m: (0, 0, -3), speed_m_s: 8, spread_deg: 15, life_s: 0.7)],
        springs: [
            (between: ("anchor", "first"), stiffness_n_m: 60, damping_n_s_m: 0.1, rest_length_m: 2.5),
            (between: ("first", "second"), stiffness_n_m: 30, damping_n_s_m: 0.1),
        ],
    )"#;
    scene_of(text)
}
