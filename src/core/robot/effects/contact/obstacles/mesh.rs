//! Bodies of any form with flat faces.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::distance_grid::MOST_VALUES;
use super::recent::Recent;
use super::{Cornered, Frame, Role, Shape, closed, shape};
use crate::description::schema::Reader;
use crate::error::{Checker, Number};
use crate::numerics::lie::Vector;
use crate::robot::effects::contact::shapes::distance_grid::DistanceGrid as Grid;
use crate::robot::effects::contact::shapes::level_set::LevelSet;
use crate::robot::effects::contact::shapes::obstacle::Solid;
use crate::robot::effects::contact::shapes::triangles::{Sampled, Triangles};

/// Number of cells along the longest side, unless they are given.
const CELLS: f64 = 64.0;

/// Cells around the mesh: at the border of a grid the spline is less accurate, by a factor of 0.27 less for each cell from there (the decay
/// of cubic splines; de Boor 2001, chapter XIII).
const MARGIN: usize = 4;

/// Middles of faces may be so far from the surface, in cells. Faces of a plate of one and a half cells are met to 0.09 cells, of two cells to
/// 0.04, of three to 0.035 (`tests/python/contact/test_contact_grids.py`).
const FARTHEST: f64 = 0.5;

/// Distances close to right-angled edges and corners are off by up to this part of a cell, wherever these lie between values (an L, by brute
/// force); close to blunter ones by less, in proportion to how far the normals of the faces are apart.
const ROUNDED: f64 = 0.35;

/// The deepest value of a mesh that cells resolve, in cells.
const DEEPEST: f64 = 0.5;

shape! {
    /// A body of any form with flat faces: a bowl, a hook, a bone, or several bodies. The mesh must be closed; one that is convex is
    /// computed faster, and with sharp edges, as a `ConvexMesh`.
    ///
    /// It is computed as the signed distances of a grid of cells (see `DistanceGrid`), when it is used for the first time. Edges and corners are
    /// rounded by a part of a cell, of which `Robot.explain` prints the largest, and walls must be two cells thick or more.
    #[part(tag = "mesh", called = "a mesh", positional = 3)]
    pub struct Mesh {
        /// Corners of faces.
        #[part(unit = "metres")]
        pub points: Vec<[f64; 3]>,
        /// Triangles, as indices into `points` (from 0). Every edge belongs to two of them. They are turned outwards, if necessary.
        pub faces: Vec<[usize; 3]>,
        /// Size of cells, by default 1/64 of the longest side of the box around the mesh. Half the size takes eight times the memory.
        #[part(unit = "metres", positive)]
        pub cell: Option<f64>,
    }
}

/// A mesh as a surface, at a place.
#[derive(Debug)]
struct Computed {
    surface: Arc<LevelSet>,
    corner: Vector<f64>,
    /// Largest distances from the surface, and places: of corners and middles of edges, and of middles of faces.
    of_edges: (f64, Vector<f64>),
    of_faces: (f64, Vector<f64>),
    /// Largest distance between unit normals of faces with a common edge, over that of a right angle.
    sharpness: f64,
}

/// Surfaces of the meshes that were used last; `None` for what is no closed surface.
static SURFACES: Recent<Mesh, Option<Computed>> = Recent::new();

impl Mesh {
    fn fits(&self, reader: &mut Reader) {
        let mut check = Checker::new();
        self.check(&mut check);
        reader.nested(check);
    }

    fn check(&self, check: &mut Checker) {
        if closed::oriented(check, &self.points, &self.faces).is_none() {
            return;
        }
        let (cell, sides) = (self.size_of_cell(), self.sides());
        let values: f64 = sides.map(|side| (side / cell).ceil() + (2 * MARGIN + 1) as f64).iter().product();
        let is_small = check.require(
            cell > 0.0 && values <= MOST_VALUES as f64,
            "cell",
            Number(cell),
            &format!("larger cells: {values:.1e} of these are around the mesh, and at most {MOST_VALUES} are possible"),
        );
        if !is_small {
            return;
        }
        let computed = self.computed();
        let Some(Computed { of_faces: (error, at), surface, .. }) = &*computed else { return };
        let found = format!(
            "{cell:.3e} m, with which the surface is {error:.1e} m beside the mesh at {} m",
            closed::place(*at)
        );
        let is_met = *error <= FARTHEST * cell && surface.depth() >= DEEPEST * cell;
        check.require(is_met, "cell", found, "half of the thickness of the thinnest wall, or less");
    }

    /// Lengths of the box around its faces.
    fn sides(&self) -> [f64; 3] {
        std::array::from_fn(|axis| {
            let places = || self.faces.iter().flatten().map(|&p| self.points[p][axis]);
            places().fold(f64::NEG_INFINITY, f64::max) - places().fold(f64::INFINITY, f64::min)
        })
    }

    fn size_of_cell(&self) -> f64 {
        self.cell.unwrap_or_else(|| self.sides().into_iter().fold(0.0, f64::max) / CELLS)
    }

    fn computed(&self) -> Arc<Option<Computed>> {
        SURFACES.get(self, || self.compute())
    }

    fn compute(&self) -> Option<Computed> {
        let faces = closed::oriented(&mut Checker::new(), &self.points, &self.faces)?;
        let points: Vec<_> = self.points.iter().map(|&point| Vector::from(point)).collect();
        let cell = self.size_of_cell();
        let Sampled { values, shape, corner } = Triangles::new(&points, &faces).sample(cell, MARGIN);
        let surface = LevelSet::new(&values, shape, [cell; 3]);
        let farthest = |places: &mut dyn Iterator<Item = Vector<f64>>| {
            let errors = places.map(|place| (surface.error_at(place - corner), place));
            errors.fold((0.0, corner), |most, found| if found.0 > most.0 { found } else { most })
        };
        let middle = |ends: &[usize]| {
            let sum = ends.iter().fold(Vector::zero(), |sum, &p| sum + points[p]);
            sum * (ends.len() as f64).recip()
        };
        let of_edges = farthest(&mut faces.iter().flat_map(|&[a, b, c]| {
            [middle(&[a]), middle(&[b]), middle(&[c]), middle(&[a, b]), middle(&[b, c]), middle(&[c, a])]
        }));
        let of_faces = farthest(&mut faces.iter().map(|face| middle(face)));
        let sharpness = sharpness_of(&points, &faces);
        Some(Computed { surface: Arc::new(surface), corner, of_edges, of_faces, sharpness })
    }
}

/// Largest distance between unit normals of faces with a common edge, over that of a right angle.
fn sharpness_of(points: &[Vector<f64>], faces: &[[usize; 3]]) -> f64 {
    let mut beside = BTreeMap::new();
    let mut sharpest = 0.0_f64;
    for &[a, b, c] in faces {
        let across = (points[b] - points[a]).cross(points[c] - points[a]);
        let normal = across * across.dot(across).sqrt().recip();
        for (p, q) in [(a, b), (b, c), (c, a)] {
            if let Some(other) = beside.insert((p.min(q), p.max(q)), normal) {
                let apart: Vector<f64> = normal - other;
                sharpest = sharpest.max(apart.dot(apart).sqrt());
            }
        }
    }
    sharpest * std::f64::consts::FRAC_1_SQRT_2
}

impl Shape for Mesh {
    fn label(&self) -> String {
        format!("a mesh of {} faces", self.faces.len())
    }

    fn rounding(&self) -> Option<f64> {
        self.computed().as_ref().as_ref().map(|computed| {
            let rounded = ROUNDED * computed.sharpness * self.size_of_cell();
            computed.of_edges.0.max(computed.of_faces.0).max(rounded)
        })
    }

    /// The nearest point may be anywhere.
    fn lies_across(&self, _axis: usize, _height: f64) -> bool {
        false
    }

    fn thickness(&self) -> f64 {
        self.computed().as_ref().as_ref().map_or(0.0, |computed| computed.surface.depth())
    }

    fn solid(&self, frame: &Frame) -> Solid {
        let computed = self.computed();
        let Computed { surface, corner, .. } =
            computed.as_ref().as_ref().expect("described meshes are closed");
        let axes = frame.axes([1.0, 0.0, 0.0, 0.0]);
        Solid::DistanceGrid(Arc::new(Grid::new(surface.clone(), frame.place(corner.to_array()), axes)))
    }

    fn corners(&self) -> Option<&dyn Cornered> {
        None
    }

    fn role(&self) -> Role {
        Role::Ground
    }
}
