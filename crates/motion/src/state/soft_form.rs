//! Forms of soft bodies: points along up to three axes, and the springs between them.

use bevy_ecs::entity::Entity;
use glam::{IVec3, UVec3};

use crate::state::springs::{Elastic, Link, SoftBody};
use crate::units::Vector;

/// The form of a rope, a cloth or a block of jelly, of which [`soft_body`](Self::soft_body) makes a [`SoftBody`].
///
/// ```
/// use bevy_ecs::prelude::*;
/// use motion::prelude::*;
/// use motion::{SoftForm, Transform};
///
/// let mut world = World::new();
/// world.insert_resource(Gravity::EARTH);
/// // Three meters of rope, 0.3 kg, which hang by the first of 31 points.
/// let rope = SoftForm::rope(Vector::ZERO, Vector::X * 3.0, 31);
/// let rope = rope.soft_body(Elastic::new(3000.0, 0.0).damped(1.0), |position, [_, point, _]| {
///     let mass = if point == 0 { f64::INFINITY } else { 0.01 };
///     world.spawn((Transform::at(position), PhysicsBody::with_mass(mass))).id()
/// });
/// let end = rope.points[30];
/// world.spawn(rope);
/// let mut stepper = Stepper::new(&mut world, Method::ImplicitEuler, TimeStep(1.0 / 60.0));
/// (0..3600).for_each(|_| stepper.tick(&mut world));
/// // Each spring carries the weight below it: 0.01 kg times 1 + 2 + ... + 30, over 3 kN/m.
/// let longer = 0.01 * 9.8 * 465.0 / 3000.0;
/// assert!((world.get::<Transform>(end).unwrap().position.y + 3.0 + longer).abs() < 1e-3);
/// ```
pub struct SoftForm {
    points: UVec3,
    /// Offsets from a point to the points that it is joined to, so that each pair occurs once, and the stiffness of those springs,
    /// N/m, if not that of the body.
    steps: Vec<(IVec3, Option<f64>)>,
    /// The position of a point, m, by its fraction along each axis, 0 to 1.
    position: Box<dyn Fn([f64; 3]) -> Vector + Send + Sync>,
    surface: Surface,
}

/// The triangles that a form has.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Surface {
    None,
    Sheet,
    Block,
}

impl SoftForm {
    /// Ropes of `points` points along the second axis, as many as `ropes`, at the `position`, m, for fractions from 0 to 1 along
    /// both axes.
    pub fn ropes(
        ropes: u32,
        points: u32,
        position: impl Fn([f64; 2]) -> Vector + Send + Sync + 'static,
    ) -> Self {
        Self {
            points: UVec3::new(ropes, points, 1),
            steps: vec![(IVec3::Y, None)],
            position: Box::new(move |[rope, part, _]| position([rope, part])),
            surface: Surface::None,
        }
    }

    /// A rope of `points` points between two places, m.
    #[must_use]
    pub fn rope(from: Vector, to: Vector, points: u32) -> Self {
        Self::ropes(1, points, move |[_, part]| from + (to - from) * part)
    }

    /// A sheet of `rows` of `columns` points from `corner`, m. A row goes along the vector `along`, a column along `down`, m.
    /// Without [shear](Self::with_shear) and [bend](Self::with_bend) springs it folds like a net.
    #[must_use]
    pub fn cloth(corner: Vector, along: Vector, down: Vector, rows: u32, columns: u32) -> Self {
        let mut form =
            Self::ropes(rows, columns, move |[row, column]| corner + along * column + down * row);
        form.steps.push((IVec3::X, None));
        Self { surface: Surface::Sheet, ..form }
    }

    /// A block of `cells` cells along x, y and z around `center`, of `size` meters, every point joined to all that share a cell
    /// with it.
    #[must_use]
    pub fn block(center: Vector, size: Vector, cells: [u32; 3]) -> Self {
        // The 13 of the 26 neighbors that come later: edges, diagonals of faces and diagonals of cells.
        let steps = (14..27).map(|i| (IVec3::new(i / 9 - 1, i / 3 % 3 - 1, i % 3 - 1), None));
        Self {
            points: UVec3::from_array(cells).saturating_add(UVec3::ONE),
            steps: steps.collect(),
            position: Box::new(move |parts| center + size * (Vector::from_array(parts) - 0.5)),
            surface: Surface::Block,
        }
    }

    /// With springs along the diagonals of the cells of a cloth, of that stiffness, N/m, or that of the other springs. Other forms
    /// stay as they are.
    #[must_use]
    pub fn with_shear(self, stiffness: Option<f64>) -> Self {
        let diagonals = [IVec3::new(1, -1, 0), IVec3::new(1, 1, 0)];
        if self.is_sheet() { self.braced(&diagonals, stiffness) } else { self }
    }

    /// With springs between each point of a rope or cloth and the one after the next, of that stiffness, N/m, or that of the
    /// other springs. A block stays as it is.
    #[must_use]
    pub fn with_bend(self, stiffness: Option<f64>) -> Self {
        let along = self.steps.iter().filter(|(step, _)| step.abs().element_sum() == 1);
        let twice: Vec<_> = along.map(|(step, _)| *step * 2).collect();
        if self.surface == Surface::Block { self } else { self.braced(&twice, stiffness) }
    }

    fn braced(mut self, by: &[IVec3], stiffness: Option<f64>) -> Self {
        self.steps.retain(|(step, _)| !by.contains(step));
        self.steps.extend(by.iter().map(|step| (*step, stiffness)));
        self
    }

    /// The soft body whose points are those that `point` makes, of their position, m, and their index along each axis: rope
    /// and point, row and column, or x, y and z. Its springs have `elastic`, and their length there is their rest length.
    ///
    /// # Panics
    /// If there are 2^32 points or more.
    pub fn soft_body(
        &self,
        elastic: Elastic,
        mut point: impl FnMut(Vector, [u32; 3]) -> Entity,
    ) -> SoftBody {
        let count = u32::try_from(self.count()).expect("fewer than 2^32 points");
        let positions: Vec<_> = (0..count).map(|number| self.position(number)).collect();
        let points = (0..count).zip(&positions);
        let points = points.map(|(number, at)| point(*at, self.place(number).to_array())).collect();
        let links = self.links(elastic, |number| positions[number as usize]);
        SoftBody::new(points, links).with_surface(self.triangles(), self.is_sheet())
    }

    /// Whether its surface is a sheet, against which air flows.
    #[must_use]
    pub fn is_sheet(&self) -> bool {
        self.surface == Surface::Sheet
    }

    /// Points along each axis.
    #[must_use]
    pub const fn points(&self) -> UVec3 {
        self.points
    }

    /// Number of points.
    #[must_use]
    pub fn count(&self) -> u64 {
        self.points.to_array().into_iter().map(u64::from).fold(1, u64::saturating_mul)
    }

    /// Number of springs.
    #[must_use]
    pub fn springs(&self) -> u64 {
        // A step of n along an axis has n fewer starting points there.
        let places = |step: &IVec3| {
            let along = self.points.saturating_sub(step.abs().as_uvec3()).to_array();
            along.into_iter().map(u64::from).fold(1, u64::saturating_mul)
        };
        self.steps.iter().map(|(step, _)| places(step)).fold(0, u64::saturating_add)
    }

    /// Every spring, sorted by its first end, of fewer than 2^32 points at these positions, m.
    pub fn links(&self, elastic: Elastic, position: impl Fn(u32) -> Vector) -> Vec<Link> {
        let mut links = Vec::with_capacity(self.springs() as usize);
        for point in 0..self.count() as u32 {
            let place = self.place(point).as_ivec3();
            for (step, stiffness) in &self.steps {
                let to = (place + *step).as_uvec3();
                // A negative coordinate becomes a number far above all numbers of points.
                if to.cmplt(self.points).all() {
                    let ends = [point, self.number(to)];
                    // Computed as a step computes it, so that no spring pulls at the start.
                    let [from, to] = ends.map(&position);
                    let stiffness = stiffness.unwrap_or(elastic.stiffness);
                    let rest_length = (to - from).length();
                    links.push(Link {
                        ends,
                        elastic: Elastic { stiffness, rest_length, ..elastic },
                    });
                }
            }
        }
        links
    }

    /// The position of a point, m.
    #[must_use]
    pub fn position(&self, point: u32) -> Vector {
        let place = self.place(point);
        let part = |axis: usize| f64::from(place[axis]) / f64::from((self.points[axis] - 1).max(1));
        (self.position)([0, 1, 2].map(part))
    }

    /// The number of the point with these indices along the axes, of which the last is the inner loop.
    const fn number(&self, place: UVec3) -> u32 {
        (place.x * self.points.y + place.y) * self.points.z + place.z
    }

    /// The index of a point along each axis.
    #[must_use]
    pub fn place(&self, point: u32) -> UVec3 {
        let UVec3 { y, z, .. } = self.points;
        UVec3::new(point / (y * z), point / z % y, point % z)
    }

    /// The surface, by numbers of points.
    #[must_use]
    pub fn triangles(&self) -> Vec<[u32; 3]> {
        match self.surface {
            Surface::None => Vec::new(),
            Surface::Sheet => self.sheet(),
            Surface::Block => self.sides(),
        }
    }

    fn sheet(&self) -> Vec<[u32; 3]> {
        let UVec3 { x: rows, y: columns, .. } = self.points;
        let mut triangles = Vec::new();
        for row in 1..rows {
            for column in 1..columns {
                let (below, above) = (row * columns + column, (row - 1) * columns + column);
                let [a, b, c, d] = [above - 1, above, below - 1, below];
                // Diagonals alternate, so that the sheet folds as easily in one direction as in the other.
                if (row + column) % 2 == 0 {
                    triangles.extend([[a, c, d], [a, d, b]]);
                } else {
                    triangles.extend([[a, c, b], [b, c, d]]);
                }
            }
        }
        triangles
    }

    fn sides(&self) -> Vec<[u32; 3]> {
        let mut triangles = Vec::new();
        for (axis, far) in [(0, false), (0, true), (1, false), (1, true), (2, false), (2, true)] {
            let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
            let level = if far { self.points[axis].saturating_sub(1) } else { 0 };
            for i in 1..self.points[u] {
                for j in 1..self.points[v] {
                    let corner = |i: u32, j: u32| {
                        let mut place = UVec3::ZERO;
                        (place[axis], place[u], place[v]) = (level, i, j);
                        self.number(place)
                    };
                    let [a, b, c, d] =
                        [corner(i - 1, j - 1), corner(i, j - 1), corner(i, j), corner(i - 1, j)];
                    // a, b, c, d goes round counterclockwise as seen from the far side of the axis.
                    if far {
                        triangles.extend([[a, b, c], [a, c, d]]);
                    } else {
                        triangles.extend([[a, c, b], [a, d, c]]);
                    }
                }
            }
        }
        triangles
    }
}
