//! Worlds that are built by hand: bodies, and the forces and laws on all of them.

use crate::rigs::Bare;
use glam::DVec3;
use motion::internals::Solver;
use motion::{
    BodyState, Curve, Damping, Drag, EvaluationTime, Gravity, Jacobians, Law, Method,
    MutualGravity, PhysicsBody, Substeps, Thrust, Transform, Well, Wells,
};

use crate::rigs::Lab;

/// A body at the start of a run.
#[derive(Clone, Copy, Debug)]
pub struct Start {
    pub x: DVec3,
    pub v: DVec3,
    pub w: f64,
}

impl Start {
    pub const fn held(x: DVec3) -> Self {
        Self { x, v: DVec3::ZERO, w: 0.0 }
    }

    pub fn components(self) -> (Transform, PhysicsBody) {
        (Transform::at(self.x), PhysicsBody { velocity: self.v, inverse_mass: self.w })
    }

    pub const fn of(mass: f64, x: DVec3, v: DVec3) -> Self {
        Self { x, v, w: 1.0 / mass }
    }
}

type Formulas<T> = Box<dyn Fn(EvaluationTime, BodyState) -> T + Send + Sync>;

/// A law of a formula, by default of places alone, of whose derivatives solvers are told nothing.
pub struct Formula {
    name: &'static str,
    acceleration: Formulas<DVec3>,
    jacobians: Formulas<Jacobians>,
    of_velocity: bool,
    jumps: Vec<f64>,
}

impl Formula {
    pub fn new(
        name: &'static str,
        acceleration: impl Fn(EvaluationTime, BodyState) -> DVec3 + Send + Sync + 'static,
    ) -> Self {
        let (acceleration, jacobians) =
            (Box::new(acceleration), Box::new(|_, _| Jacobians::zero()));
        Self { name, acceleration, jacobians, of_velocity: false, jumps: Vec::new() }
    }

    pub fn with_jacobians(
        self,
        jacobians: impl Fn(BodyState) -> Jacobians + Send + Sync + 'static,
    ) -> Self {
        Self { jacobians: Box::new(move |_, body| jacobians(body)), ..self }
    }

    pub fn of_velocity(self, of_velocity: bool) -> Self {
        Self { of_velocity, ..self }
    }

    /// Its acceleration at a time, s.
    pub fn at(&self, time: f64, body: BodyState) -> DVec3 {
        (self.acceleration)(EvaluationTime { time, within_step: time }, body)
    }

    /// It jumps at that time, s.
    pub fn jumping_at(self, time: f64) -> Self {
        Self { jumps: vec![time], ..self }
    }
}

impl std::fmt::Debug for Formula {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name)
    }
}

impl Law for Formula {
    fn name(&self) -> &'static str {
        self.name
    }
    fn acceleration(&self, at: EvaluationTime, body: BodyState) -> DVec3 {
        (self.acceleration)(at, body)
    }
    fn jacobians(&self, at: EvaluationTime, body: BodyState) -> Jacobians {
        (self.jacobians)(at, body)
    }
    fn depends_on_velocity(&self) -> bool {
        self.of_velocity
    }
    fn discontinuities(&self) -> &[f64] {
        &self.jumps
    }
}

pub fn pull(acceleration: DVec3) -> Gravity {
    Gravity { acceleration, on: true }
}

/// An engine that is always on, its force this polynomial of time, N, N/s and so on.
pub fn engine(newtons: impl Into<Vec<DVec3>>) -> Thrust {
    Thrust::new(Curve::Polynomial(newtons.into()), f64::NEG_INFINITY, f64::INFINITY)
}

/// Two wells, softened, so that no orbit is hard to integrate.
pub fn wells() -> Wells {
    let well = |position, strength| Well { position, strength, softening: 0.5 };
    Wells(vec![well(DVec3::ZERO, 3.0), well(DVec3::new(1.0, -2.0, 0.5), -1.0)])
}

/// Forces and laws on all bodies.
#[derive(Clone, Debug, Default)]
pub struct Environment {
    pub gravity: Option<Gravity>,
    pub drag: Option<Drag>,
    pub wells: Option<Wells>,
    pub attraction: Option<MutualGravity>,
    pub damping: Option<Damping>,
    pub substeps: Option<u32>,
    pub solver: Option<Solver>,
}

impl Environment {
    pub fn falling() -> Self {
        Self { gravity: Some(Gravity::EARTH), ..Self::default() }
    }

    pub fn orbiting() -> Self {
        Self { wells: Some(wells()), ..Self::default() }
    }

    pub fn pull(g: DVec3) -> Self {
        Self { gravity: Some(pull(g)), ..Self::default() }
    }

    pub fn solved(solver: Solver) -> Self {
        Self { solver: Some(solver), ..Self::default() }
    }

    /// A world without bodies yet.
    pub fn lab(&self, method: Method, h: f64) -> Lab {
        let mut lab = Lab::new(method, h);
        let Self { gravity, drag, wells, attraction, damping, substeps, solver } = self.clone();
        let world = &mut lab.world;
        gravity.into_iter().for_each(|gravity| world.insert_resource(gravity));
        drag.into_iter().for_each(|drag| world.insert_resource(drag));
        wells.into_iter().for_each(|wells| world.insert_resource(wells));
        attraction.into_iter().for_each(|attraction| world.insert_resource(attraction));
        damping.into_iter().for_each(|damping| world.insert_resource(damping));
        substeps.into_iter().for_each(|substeps| world.insert_resource(Substeps(substeps)));
        solver.into_iter().for_each(|solver| world.insert_resource(solver));
        lab.recompile();
        lab
    }

    /// The same by rows.
    pub fn bare(&self, method: Method, step: f64) -> Bare {
        let mut bare = Bare::new(method, step).with_substeps(self.substeps.unwrap_or(1));
        if let Some(gravity) = self.gravity {
            bare = bare.with_law(gravity);
        }
        if let Some(drag) = self.drag {
            bare = bare.with_law(drag);
        }
        if let Some(wells) = self.wells.clone() {
            bare = bare.with_law(wells);
        }
        match self.damping {
            Some(damping) => bare.with_damping(damping),
            None => bare,
        }
    }
}
