//! Distances from the ground below a surface given by heights on a rectangular grid.
//!
//! The surface is the natural cubic spline through the heights, in both directions: its second derivatives
//! are continuous, and zero across the edges of the rectangle, beyond which it continues linearly (de Boor
//! 2001, chapter IV). Newton's method finds nearest points; a tree of bounding boxes around cells, and bounds
//! of the squared distance in parts of cells, find the global minimum, over the rectangle and over strips beyond its edges.

use super::bernstein::{
    DEGREE, VALUES, bernstein, continued, differences, halves, part_of, squared, squared_line,
    through_thirds, transposed,
};
use super::distance::Distance;
use super::spline::{bounds, coefficients_of, weights};
use crate::numerics::lie::{Rotation, Symmetric, Vector};

/// Maximum number of Newton steps, and of halvings of one step.
const MOST_STEPS: usize = 40;
const MOST_HALVINGS: usize = 30;

/// Newton steps up to the first fraction of distance and cell size are taken without a descent test, because
/// values are equal to rounding; the iteration ends with steps below the second fraction, after which the
/// error is its square.
const NEAR: f64 = 1e-5;
const SAME_PLACE: f64 = 1e-9;

/// A candidate must be nearer by this fraction of the squared distance to be examined: at first, and at most. The fraction doubles
/// each time a search has examined [`PATIENCE`] more parts, so that it ends where a large part of the surface is almost equally near,
/// as at the centre of curvature of a dome. The relative error of the distance is at most this fraction.
const NEARER: f64 = 1e-10;
const MOST_NEARER: f64 = 1e-5;
const PATIENCE: usize = 16;

/// After this many parts, a search bounds distances of squares of cells by their cubics; before, bounds by heights are faster.
const FEW_PARTS: usize = 16;

/// Smallest determinant over the product of the diagonal entries at which a second derivative counts as positive definite; otherwise the
/// Gauss-Newton matrix replaces it.
const DEFINITE: f64 = 1e-6;

/// Sufficient decrease of a step (Nocedal and Wright 2006, section 3.1).
const DECREASE: f64 = 1e-4;

/// Up to this relative difference from the distance, the component along the normal replaces it: it has no cancellation close to the
/// surface. The second number is for a distance of zero.
const ALONG_NORMAL: [f64; 2] = [1e-9, 1e-300];

/// Maximum number of subdivisions of a cell into four, if the nearest point is not certain.
const MOST_DIVISIONS: usize = 10;

/// If the curvature times the distance is below this value, the nearest point is unique.
const CERTAINLY_CONVEX: f64 = 0.99;

/// A point counts as nearest up to this fraction of the radius of curvature, on the concave side: beyond,
/// several points are nearest.
const LEAST_STRETCH: f64 = 0.01;

/// The region below a surface.
#[derive(Clone, Debug)]
pub(crate) struct HeightField {
    /// Position of the first height, and the axes, in the frame of the plan.
    corner: Vector<f64>,
    axes: Rotation<f64>,
    spacing: [f64; 2],
    /// Number of heights along each axis.
    shape: [usize; 2],
    /// Coefficients of the cubic B-splines, with one more at each end than heights; the second axis varies
    /// fastest.
    coefficients: Vec<f64>,
    /// Minimum and maximum of each cell, then of squares of two by two cells, and so on up to the whole
    /// rectangle.
    levels: Vec<Level>,
    /// Upper bounds of slopes and of second derivatives in all directions.
    steepest: f64,
    most_bent: f64,
}

/// Its mixed second derivatives are 6 x 6 times the differences of coefficients, those along an axis 6 x 5
/// times.
const MIXED: f64 = DEGREE as f64 / (DEGREE - 1) as f64;

/// A part of a cell.
struct Patch {
    from: [f64; 2],
    size: [f64; 2],
    /// Bernstein coefficients of half the squared distance: the values lie between the least and the greatest
    /// one, and those of derivatives are differences.
    values: [[f64; VALUES]; VALUES],
    /// Upper bound of the error of the values.
    error: f64,
}

/// An interval that contains values.
#[derive(Clone, Copy)]
struct Range([f64; 2]);

#[derive(Clone, Debug)]
struct Level {
    shape: [usize; 2],
    ranges: Vec<[f64; 2]>,
    /// Surfaces close to those of the squares; none for cells, whose surfaces are exact.
    surfaces: Vec<Cubic>,
}

/// A surface close to that of a square of cells.
#[derive(Clone, Debug)]
struct Cubic {
    /// Its Bernstein coefficients.
    heights: [[f64; 4]; 4],
    /// Upper bound of the difference in height.
    error: f64,
}

/// Height, first derivatives, and second derivatives (along the first axis, mixed, along the second).
struct Local {
    height: f64,
    slope: [f64; 2],
    bend: [f64; 3],
}

/// A point of the surface: its coordinates, and half its squared distance.
#[derive(Clone, Copy)]
struct Best {
    place: [f64; 2],
    value: f64,
}

/// A search for the point nearest to another one.
struct Search {
    point: [f64; 3],
    /// The nearest point found so far.
    best: Best,
    /// Number of parts of the surface that it has examined.
    parts: usize,
}

impl Search {
    /// Half the squared distance below which a part is examined.
    fn limit(&self) -> f64 {
        let nearer = NEARER * f64::powi(2.0, (self.parts / PATIENCE).min(30) as i32);
        self.best.value * (1.0 - nearer.min(MOST_NEARER))
    }
}

impl HeightField {
    /// The surface through heights, with the second axis varying fastest; at least two along each axis.
    pub(crate) fn new(
        heights: &[f64],
        shape: [usize; 2],
        spacing: [f64; 2],
        corner: Vector<f64>,
        axes: Rotation<f64>,
    ) -> Self {
        let [rows, columns] = shape;
        let along: Vec<f64> = heights.chunks_exact(columns).flat_map(coefficients_of).collect();
        let width = columns + 2;
        let mut coefficients = vec![0.0; (rows + 2) * width];
        for j in 0..width {
            let column: Vec<f64> = (0..rows).map(|i| along[i * width + j]).collect();
            for (i, coefficient) in coefficients_of(&column).into_iter().enumerate() {
                coefficients[i * width + j] = coefficient;
            }
        }
        let [steepest, most_bent] = bounds(&coefficients, [rows + 2, width], spacing);
        let levels = Vec::new();
        let mut field = Self { corner, axes, spacing, shape, coefficients, levels, steepest, most_bent };
        let cells = shape.map(|n| n - 1);
        let ranges = (0..cells[0] * cells[1]).map(|c| field.range(c / cells[1], c % cells[1])).collect();
        field.levels.push(Level { shape: cells, ranges, surfaces: Vec::new() });
        while let Some(mut coarser) = field.levels.last().and_then(Level::coarser) {
            coarser.surfaces = field.surfaces_of(&coarser);
            field.levels.push(coarser);
        }
        field
    }

    /// Upper bound of its curvature, per metre.
    pub(crate) fn most_bent(&self) -> f64 {
        self.most_bent
    }

    /// Coefficients on which a cell depends, row by row.
    fn of_cell(&self, i: usize, j: usize) -> [&[f64]; 4] {
        let width = self.shape[1] + 2;
        std::array::from_fn(|row| &self.coefficients[(i + row) * width + j..][..4])
    }

    /// Bernstein coefficients of a cell, row by row.
    fn bernstein_of_cell(&self, i: usize, j: usize) -> [[f64; 4]; 4] {
        let of_rows = self.of_cell(i, j).map(|row| bernstein([row[0], row[1], row[2], row[3]]));
        transposed(transposed(of_rows).map(bernstein))
    }

    /// Interval that contains the heights of a cell.
    fn range(&self, i: usize, j: usize) -> [f64; 2] {
        Range::of(&self.bernstein_of_cell(i, j)).0
    }

    /// Corner and size of a square of cells, without the part of it that lies beyond the rectangle.
    fn extent(&self, level: usize, square: [usize; 2]) -> [[f64; 2]; 2] {
        let cells = 1 << level;
        let ends: [[f64; 2]; 2] = std::array::from_fn(|axis| {
            let from = square[axis] * cells;
            let to = (from + cells).min(self.shape[axis] - 1);
            [from, to].map(|i| i as f64 * self.spacing[axis])
        });
        [ends.map(|[from, _]| from), ends.map(|[from, to]| to - from)]
    }

    /// The bicubic surface through the heights at the corners of a square and at the thirds between them.
    fn cubic_of(&self, level: usize, square: [usize; 2]) -> [[f64; 4]; 4] {
        let [from, size] = self.extent(level, square);
        let heights: [[f64; 4]; 4] = std::array::from_fn(|i| {
            std::array::from_fn(|j| {
                let third = |axis: usize, k: usize| from[axis] + k as f64 / 3.0 * size[axis];
                self.at([third(0, i), third(1, j)]).height
            })
        });
        transposed(transposed(heights.map(through_thirds)).map(through_thirds))
    }

    /// Surfaces close to those of the squares of a level, which follows the last one.
    fn surfaces_of(&self, coarser: &Level) -> Vec<Cubic> {
        let level = self.levels.len();
        let finer = &self.levels[level - 1];
        let surface = |square: [usize; 2]| {
            let heights = self.cubic_of(level, square);
            let [start, whole] = self.extent(level, square);
            let mut error = 0.0_f64;
            for child in children(square, finer.shape) {
                let [from, size] = self.extent(level - 1, child);
                let ends: [[f64; 2]; 2] = std::array::from_fn(|axis| {
                    [from[axis], from[axis] + size[axis]].map(|x| (x - start[axis]) / whole[axis])
                });
                let part = part_of(&heights, ends);
                let (exact, rest) = match finer.surfaces.get(child[0] * finer.shape[1] + child[1]) {
                    Some(cubic) => (cubic.heights, cubic.error),
                    None => (self.bernstein_of_cell(child[0], child[1]), 0.0),
                };
                let differences = part.iter().flatten().zip(exact.iter().flatten());
                let most = differences.fold(0.0_f64, |most, (a, b)| most.max((a - b).abs()));
                error = error.max(most + rest);
            }
            Cubic { heights, error }
        };
        let [rows, columns] = coarser.shape;
        (0..rows * columns).map(|k| surface([k / columns, k % columns])).collect()
    }

    /// A square of cells, as seen from a point.
    fn patch(&self, point: [f64; 3], level: usize, square: [usize; 2]) -> Patch {
        let Level { shape, surfaces, .. } = &self.levels[level];
        let (heights, error) = match surfaces.get(square[0] * shape[1] + square[1]) {
            Some(cubic) => (cubic.heights, cubic.error),
            None => (self.bernstein_of_cell(square[0], square[1]), 0.0),
        };
        Patch::new(point, self.extent(level, square), &heights, error)
    }

    /// Searches for nearer points beyond the edges, where the surface continues linearly: in a strip beyond each cell at an edge, and
    /// in the rectangles beyond the corners.
    fn search_beyond_edges(&self, search: &mut Search) {
        let reach = (2.0 * search.best.value).sqrt();
        let cells = self.shape.map(|n| n - 1);
        // Cells from which strips begin, by axis and side, and how wide these are.
        let widths: [[f64; 2]; 2] = std::array::from_fn(|axis| {
            let end = cells[axis] as f64 * self.spacing[axis];
            [reach - search.point[axis], search.point[axis] + reach - end].map(|width| width.max(0.0))
        });
        let near: [std::ops::Range<usize>; 2] = std::array::from_fn(|axis| {
            let [first, last] = [-reach, reach].map(|way| (search.point[axis] + way) / self.spacing[axis]);
            (first.max(0.0) as usize)..(last.ceil().max(0.0) as usize).min(cells[axis])
        });
        let strips = |axis: usize| {
            let edges = [(0, 0), (cells[axis] - 1, 1)].into_iter();
            edges.filter(move |&(_, side)| widths[axis][side] > 0.0).map(|(cell, side)| (cell, Some(side)))
        };
        let inner = |axis: usize| near[axis].clone().map(|cell| (cell, None));
        for (i, along) in strips(0).chain(inner(0)) {
            for (j, across) in strips(1).chain(inner(1)) {
                let sides = [along, across];
                if sides == [None; 2] {
                    continue;
                }
                let ([mut from, mut size], mut heights) =
                    (self.extent(0, [i, j]), self.bernstein_of_cell(i, j));
                for axis in 0..2 {
                    let Some(side) = sides[axis] else { continue };
                    let width = widths[axis][side];
                    let beyond = |line| continued(line, side, width / size[axis]);
                    heights = match axis {
                        0 => transposed(transposed(heights).map(beyond)),
                        _ => heights.map(beyond),
                    };
                    from[axis] += if side == 0 { -width } else { size[axis] };
                    size[axis] = width;
                }
                let ways =
                    (0..2).map(|axis| apart(search.point[axis], [from[axis], from[axis] + size[axis]]));
                let across = apart(search.point[2], Range::of(&heights).0);
                if 0.5 * (ways.map(|way| way * way).sum::<f64>() + across * across) < search.limit() {
                    let patch = Patch::new(search.point, [from, size], &heights, 0.0);
                    self.search_patch(&patch, MOST_DIVISIONS, search);
                }
            }
        }
    }

    /// Searches for nearer points in a part of a cell by branch and bound (Hansen and Walster 2004, chapter
    /// 12), with bounds by Bernstein coefficients of half the squared distance itself (Garloff 1993, "The
    /// Bernstein algorithm"): where many places are almost equally near, as below the top of a dome, bounds
    /// by intervals of heights, slopes and second derivatives are far wider than what they bound. Parts that
    /// are too far away, or in which half the squared distance is monotonic or nowhere convex, contain none;
    /// parts in which it is convex everywhere contain at most one. Other parts are subdivided.
    fn search_patch(&self, patch: &Patch, divisions: usize, search: &mut Search) {
        let Patch { from, size, values, .. } = patch;
        search.parts += 1;
        if !patch.is_nearer_than(search) {
            return;
        }
        let slopes: [[[f64; VALUES]; DEGREE]; 2] = [differences(values), differences(&transposed(*values))];
        let is_monotonic = slopes.iter().any(|slopes| !Range::of(slopes).holds_zero());
        let [a, b] = slopes.map(|slopes| Range::of::<VALUES, { DEGREE - 1 }>(&differences(&slopes)));
        if is_monotonic || a.0[1] < 0.0 || b.0[1] < 0.0 {
            return;
        }
        let mixed = Range::of::<DEGREE, DEGREE>(&differences(&transposed(slopes[0]))).size();
        let is_hollow = a.0[0] > 0.0 && b.0[0] > 0.0 && a.0[0] * b.0[0] > (MIXED * mixed).powi(2);
        if is_hollow || divisions == 0 {
            let place = self.descend_to_nearer(patch.middle(), search);
            let is_within = (0..2).all(|axis| (from[axis]..=from[axis] + size[axis]).contains(&place[axis]));
            if is_within || divisions == 0 {
                return;
            }
        }
        for part in patch.parts() {
            self.search_patch(&part, divisions - 1, search);
        }
    }

    fn at(&self, place: [f64; 2]) -> Local {
        let [(i, of_row), (j, of_column)] = [0, 1].map(|axis| {
            let x = place[axis] / self.spacing[axis];
            let cell = (x.floor().max(0.0) as usize).min(self.shape[axis] - 2);
            (cell, weights(x - cell as f64))
        });
        let rows = self.of_cell(i, j);
        let sum = |along: usize, across: usize| -> f64 {
            let of_row = rows.iter().zip(of_row[along]).map(|(row, weight)| {
                weight * row.iter().zip(of_column[across]).map(|(c, w)| c * w).sum::<f64>()
            });
            of_row.sum()
        };
        let [dx, dy] = self.spacing;
        Local {
            height: sum(0, 0),
            slope: [sum(1, 0) / dx, sum(0, 1) / dy],
            bend: [sum(2, 0) / (dx * dx), sum(1, 1) / (dx * dy), sum(0, 2) / (dy * dy)],
        }
    }

    /// A nearest point by Newton's method from a start, with half its squared distance.
    fn descend(&self, point: [f64; 3], mut place: [f64; 2]) -> Best {
        let [x, y, z] = point;
        let value_at = |place: [f64; 2], height: f64| {
            let way = [place[0] - x, place[1] - y, height - z];
            0.5 * way.iter().map(|w| w * w).sum::<f64>()
        };
        let mut local = self.at(place);
        let mut value = value_at(place, local.height);
        let size = self.spacing[0].min(self.spacing[1]);
        for _ in 0..MOST_STEPS {
            let Local { height, slope: [a, b], bend: [aa, ab, bb] } = local;
            let rise = height - z;
            let gradient = [place[0] - x + rise * a, place[1] - y + rise * b];
            let full = [1.0 + a * a + rise * aa, a * b + rise * ab, 1.0 + b * b + rise * bb];
            let is_definite = |h: &[f64; 3]| h[0] > 0.0 && h[0] * h[2] - h[1] * h[1] > DEFINITE * h[0] * h[2];
            // Gauss-Newton matrix if Newton's is not positive definite.
            let is_newton = is_definite(&full);
            let [h_aa, h_ab, h_bb] = if is_newton { full } else { [1.0 + a * a, a * b, 1.0 + b * b] };
            let determinant = h_aa * h_bb - h_ab * h_ab;
            let step = [
                -(h_bb * gradient[0] - h_ab * gradient[1]) / determinant,
                -(h_aa * gradient[1] - h_ab * gradient[0]) / determinant,
            ];
            let length = step[0].hypot(step[1]) / (size + value.sqrt());
            if is_newton && length <= NEAR {
                place = [place[0] + step[0], place[1] + step[1]];
                local = self.at(place);
                value = value_at(place, local.height);
                if length <= SAME_PLACE {
                    break;
                }
                continue;
            }
            let falls = gradient[0] * step[0] + gradient[1] * step[1];
            let mut part = 1.0;
            let mut is_lower = false;
            for _ in 0..MOST_HALVINGS {
                let next = [place[0] + part * step[0], place[1] + part * step[1]];
                let there = self.at(next);
                let found = value_at(next, there.height);
                if found <= value + DECREASE * part * falls {
                    is_lower = found < value;
                    (place, local, value) = (next, there, found);
                    break;
                }
                part *= 0.5;
            }
            if !is_lower || part * length <= SAME_PLACE {
                break;
            }
        }
        Best { place, value }
    }

    /// The place where a descent from a start ends, which becomes the best one if it is nearer.
    fn descend_to_nearer(&self, start: [f64; 2], search: &mut Search) -> [f64; 2] {
        let found = self.descend(search.point, start);
        if found.value < search.best.value {
            search.best = found;
        }
        found.place
    }

    /// Whether a stationary point is the unique nearest one: half the squared distance, with the second
    /// derivatives `1 + h_i h_j + (h - z) h_ij`, is convex in the whole region that could contain nearer
    /// points.
    fn is_only_one(&self, point: [f64; 3], best: &Best) -> bool {
        let reach = (2.0 * best.value).sqrt();
        let lies_inside = (0..2).all(|axis| {
            let end = self.spacing[axis] * (self.shape[axis] - 1) as f64;
            point[axis] - reach >= 0.0 && point[axis] + reach <= end
        });
        let [x, y, z] = point;
        lies_inside
            && ((self.at([x, y]).height - z).abs() + self.steepest * reach) * self.most_bent
                < CERTAINLY_CONVEX
    }

    /// Searches for nearer points in a square of cells.
    fn search_cells(&self, level: usize, square: [usize; 2], search: &mut Search) {
        if self.bound(search.point, level, square) >= search.limit() {
            return;
        }
        if level == 0 {
            self.search_patch(&self.patch(search.point, 0, square), MOST_DIVISIONS, search);
            return;
        }
        if search.parts >= FEW_PARTS {
            search.parts += 1;
            if !self.patch(search.point, level, square).is_nearer_than(search) {
                return;
            }
        }
        let mut squares = [(f64::INFINITY, [0, 0]); 4];
        for (known, child) in squares.iter_mut().zip(children(square, self.levels[level - 1].shape)) {
            *known = (self.bound(search.point, level - 1, child), child);
        }
        squares.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        for (least, square) in squares {
            if least < search.best.value {
                self.search_cells(level - 1, square, search);
            }
        }
    }

    /// Lower bound of half the squared distance of a square of cells, by its heights.
    fn bound(&self, point: [f64; 3], level: usize, square: [usize; 2]) -> f64 {
        let Level { shape, ranges, .. } = &self.levels[level];
        let way = square.into_iter().enumerate().map(|(axis, i)| {
            let size = self.spacing[axis] * (1_u64 << level) as f64;
            let from = i as f64 * size;
            apart(point[axis], [from, from + size])
        });
        let across = apart(point[2], ranges[square[0] * shape[1] + square[1]]);
        0.5 * (way.map(|w| w * w).sum::<f64>() + across * across)
    }

    /// Whether a point is above the ground and certainly farther from it than `reach`, by the heights of squares of cells.
    pub(crate) fn is_certainly_beyond(&self, point: Vector<f64>, reach: f64) -> bool {
        let point = self.axes.apply_transposed(point - self.corner).to_array();
        let [x, y, z] = point;
        let top = self.levels.len() - 1;
        let reach = reach.max(0.0);
        let [_, high] = self.levels[top].ranges[0];
        // Beyond the edges it rises by no more than its slopes, and beyond a corner by their change as well.
        let [along, across] = [0, 1].map(|axis| {
            let end = self.spacing[axis] * (self.shape[axis] - 1) as f64;
            (reach - point[axis]).max(point[axis] + reach - end).max(0.0)
        });
        if along > 0.0 || across > 0.0 {
            let rise = self.steepest * along.hypot(across) + self.most_bent * along * across;
            return z - reach > high + rise;
        }
        z - reach > high || z > self.at([x, y]).height && self.is_square_beyond(point, reach, top, [0, 0])
    }

    /// Whether a square of cells is farther from a point than `reach`, by its heights.
    fn is_square_beyond(&self, point: [f64; 3], reach: f64, level: usize, square: [usize; 2]) -> bool {
        if self.bound(point, level, square) > 0.5 * reach * reach {
            return true;
        }
        level > 0
            && children(square, self.levels[level - 1].shape)
                .all(|child| self.is_square_beyond(point, reach, level - 1, child))
    }

    /// Distance of a point from the ground.
    pub(crate) fn distance(&self, point: Vector<f64>) -> Distance {
        let beside = self.axes.apply_transposed(point - self.corner).to_array();
        let [x, y, z] = beside;
        let mut search = Search { point: beside, best: self.descend(beside, [x, y]), parts: 0 };
        let is_below = z < self.at([x, y]).height;
        if !self.is_only_one(beside, &search.best) {
            self.search_cells(self.levels.len() - 1, [0, 0], &mut search);
            self.search_beyond_edges(&mut search);
        }
        let best = search.best;
        let Local { height, slope: [a, b], bend } = self.at(best.place);
        let length = (2.0 * best.value).sqrt() * if is_below { -1.0 } else { 1.0 };
        let stretch = (1.0 + a * a + b * b).sqrt();
        let normal = Vector::new(-a, -b, 1.0) * stretch.recip();
        let way = Vector::new(x - best.place[0], y - best.place[1], z - height);
        // Close to the surface, the component along the normal avoids cancellation.
        let along = way.dot(normal);
        let is_along = (along - length).abs() <= ALONG_NORMAL[0] * length.abs() + ALONG_NORMAL[1];
        let value = if is_along { along } else { length };
        let curvature = turning([a, b], bend.map(|x| x / stretch), value);
        let axes = &self.axes;
        let [row_x, row_y, row_z] = curvature.rows();
        let whole = Symmetric::square(axes.x) * row_x.x
            + Symmetric::square(axes.y) * row_y.y
            + Symmetric::square(axes.z) * row_z.z
            + Symmetric::product(axes.x, axes.y) * row_x.y
            + Symmetric::product(axes.x, axes.z) * row_x.z
            + Symmetric::product(axes.y, axes.z) * row_y.z;
        Distance { value, normal: axes.apply(normal), curvature: whole }
    }
}

impl Patch {
    /// A surface with these Bernstein coefficients over a rectangle, given by its corner and size, as seen from a point.
    fn new(point: [f64; 3], [from, size]: [[f64; 2]; 2], heights: &[[f64; 4]; 4], error: f64) -> Self {
        let rise = heights.map(|row| row.map(|height| height - point[2]));
        let steep = Range::of(&rise).size();
        let rise = squared(&rise);
        let [along, across] = [0, 1].map(|axis| {
            let way = from[axis] - point[axis];
            squared_line([way, way + size[axis]])
        });
        Self {
            from,
            size,
            values: std::array::from_fn(|i| {
                std::array::from_fn(|j| 0.5 * (along[i] + across[j] + rise[i][j]))
            }),
            // (r + e)^2 / 2 >= r^2 / 2 - |r| e.
            error: steep * error,
        }
    }

    /// Whether a place in it may be nearer than the best one.
    fn is_nearer_than(&self, search: &Search) -> bool {
        Range::of(&self.values).0[0] - self.error < search.limit()
    }

    /// Its centre.
    fn middle(&self) -> [f64; 2] {
        std::array::from_fn(|axis| self.from[axis] + 0.5 * self.size[axis])
    }

    /// The four quarters of the patch.
    fn parts(&self) -> [Self; 4] {
        let [left, right] = halves(&self.values);
        let [left, right] = [left, right].map(|half| halves(&transposed(half)).map(transposed));
        let size = self.size.map(|size| 0.5 * size);
        let [[a, b], [c, d]] = [left, right];
        let part = |k: [usize; 2], values| Self {
            from: std::array::from_fn(|axis| self.from[axis] + k[axis] as f64 * size[axis]),
            size,
            values,
            error: self.error,
        };
        [part([0, 0], a), part([0, 1], b), part([1, 0], c), part([1, 1], d)]
    }
}

impl Range {
    fn of<const N: usize, const M: usize>(values: &[[f64; N]; M]) -> Self {
        let values = values.iter().flatten();
        Self(values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], &x| [low.min(x), high.max(x)]))
    }

    fn holds_zero(self) -> bool {
        self.0[0] <= 0.0 && self.0[1] >= 0.0
    }

    /// Largest magnitude.
    fn size(self) -> f64 {
        self.0[0].abs().max(self.0[1].abs())
    }
}

impl Level {
    /// Squares of two by two, if there is more than one.
    fn coarser(&self) -> Option<Self> {
        if self.ranges.len() == 1 {
            return None;
        }
        let shape = self.shape.map(|n| n.div_ceil(2));
        let mut ranges = vec![[f64::INFINITY, f64::NEG_INFINITY]; shape[0] * shape[1]];
        for (c, [low, high]) in self.ranges.iter().enumerate() {
            let (i, j) = (c / self.shape[1], c % self.shape[1]);
            let range = &mut ranges[i / 2 * shape[1] + j / 2];
            *range = [range[0].min(*low), range[1].max(*high)];
        }
        Some(Self { shape, ranges, surfaces: Vec::new() })
    }
}

/// The two by two squares, of `rows` by `columns`, that make up a coarser one.
fn children([i, j]: [usize; 2], [rows, columns]: [usize; 2]) -> impl Iterator<Item = [usize; 2]> {
    let all = (0..4).map(move |k| [2 * i + k / 2, 2 * j + k % 2]);
    all.filter(move |child| child[0] < rows && child[1] < columns)
}

/// Distance of a number from an interval.
fn apart(x: f64, [low, high]: [f64; 2]) -> f64 {
    (low - x).max(x - high).max(0.0)
}

/// Second derivative of the distance of a point from a surface with this slope and second fundamental form at
/// the nearest point: `-T (G B^-1 G - d G)^-1 T^T` with the tangents T, the first fundamental form G and the
/// second one B.
fn turning([a, b]: [f64; 2], bend: [f64; 3], mut distance: f64) -> Symmetric<f64> {
    let form = [1.0 + a * a, a * b, 1.0 + b * b];
    let determinant = |m: &[f64; 3]| m[0] * m[2] - m[1] * m[1];
    let of_form = determinant(&form);
    // G - d B has no negative eigenvalues at a nearest point.
    let seen = |d: f64| [0, 1, 2].map(|k| form[k] - d * bend[k]);
    let mut left = seen(distance);
    for _ in 0..60 {
        if determinant(&left) >= LEAST_STRETCH * of_form && left[0] > 0.0 {
            break;
        }
        distance *= 0.5;
        left = seen(distance);
    }
    let inverse = |m: [f64; 3]| {
        let over = determinant(&m).recip();
        [[m[2] * over, -m[1] * over], [-m[1] * over, m[0] * over]]
    };
    let times = |p: [[f64; 2]; 2], q: [[f64; 2]; 2]| -> [[f64; 2]; 2] {
        std::array::from_fn(|i| std::array::from_fn(|j| p[i][0] * q[0][j] + p[i][1] * q[1][j]))
    };
    let bend = [[bend[0], bend[1]], [bend[1], bend[2]]];
    let [[p, q], [r, s]] = times(times(inverse(form), bend), inverse(left));
    let tangents = [Vector::new(1.0, 0.0, a), Vector::new(0.0, 1.0, b)];
    let sum = Symmetric::square(tangents[0]) * p
        + Symmetric::square(tangents[1]) * s
        + Symmetric::product(tangents[0], tangents[1]) * (0.5 * (q + r));
    sum * -1.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::lie::Quaternion;
    use proptest::prelude::*;

    fn field(heights: &[f64], shape: [usize; 2]) -> HeightField {
        let axes = Quaternion::from_array([0.8, 0.36, -0.48, 0.0]).rotation();
        HeightField::new(heights, shape, [0.1, 0.15], Vector::new(0.3, -0.2, 0.1), axes)
    }

    fn in_space(field: &HeightField, x: f64, y: f64, z: f64) -> Vector<f64> {
        field.corner + field.axes.apply(Vector::new(x, y, z))
    }

    /// The spline interpolates its heights, and reproduces planes, also beyond the edges.
    #[test]
    fn heights_are_met_and_planes_are_planes() {
        let heights: Vec<f64> = (0..30).map(|k| (f64::from(k) * 1.7).sin()).collect();
        let bumpy = field(&heights, [6, 5]);
        for (k, height) in heights.iter().enumerate() {
            let place = [(k / 5) as f64 * 0.1, (k % 5) as f64 * 0.15];
            assert!((bumpy.at(place).height - height).abs() < 1e-14);
        }
        let slope = |x: f64, y: f64| 0.2 + 0.5 * x - 0.3 * y;
        let heights: Vec<f64> =
            (0..12).map(|k| slope(f64::from(k / 4) * 0.1, f64::from(k % 4) * 0.15)).collect();
        let plane = field(&heights, [3, 4]);
        for (x, y, z) in [(0.05, 0.1, 0.7), (-3.0, 0.2, -1.0), (2.0, 5.0, 0.3), (0.1, 0.1, 0.0)] {
            let Distance { value, normal, curvature } = plane.distance(in_space(&plane, x, y, z));
            let stretch = (1.0_f64 + 0.25 + 0.09).sqrt();
            assert!((value - (z - slope(x, y)) / stretch).abs() < 1e-13);
            let wanted = plane.axes.apply(Vector::new(-0.5, 0.3, 1.0)) * stretch.recip();
            assert!((normal - wanted).to_array().iter().all(|x| x.abs() < 1e-13));
            assert!(curvature.rows().iter().all(|row| row.dot(*row) < 1e-20));
        }
    }

    /// Below the top of a dome all places are almost equally near.
    #[test]
    fn the_centre_of_a_dome_is_at_the_distance_of_its_radius() {
        const RADIUS: f64 = 3.0;
        let height = |x: f64, y: f64| (RADIUS * RADIUS - x * x - y * y).sqrt() - RADIUS;
        let heights: Vec<f64> =
            (0..441).map(|k| height(f64::from(k / 21) * 0.1 - 1.0, f64::from(k % 21) * 0.1 - 1.0)).collect();
        let axes = Quaternion::from_array([1.0, 0.0, 0.0, 0.0]).rotation();
        let dome = HeightField::new(&heights, [21, 21], [0.1; 2], Vector::new(-1.0, -1.0, 0.0), axes);
        // Above the centre the nearest place lies on the ray from there.
        let known = |x: f64, rise: f64| Some(RADIUS - x.hypot(rise));
        let none = None;
        for (x, rise, expected) in
            [(0.0, 0.0, known(0.0, 0.0)), (0.1, 0.5, known(0.1, 0.5)), (1e-3, 0.0, none), (0.2, -0.5, none)]
        {
            let point = Vector::new(x, 0.0, rise - RADIUS);
            let found = dome.distance(point);
            let mut tried = f64::INFINITY;
            for k in 0..=200 * 200 {
                let [x, y] = [k / 200, k % 200].map(|k| f64::from(k) * 0.01 - 1.0);
                let way = Vector::new(x, y, dome.at([x + 1.0, y + 1.0]).height) - point;
                tried = tried.min(way.dot(way).sqrt());
            }
            assert!(found.value < 0.0 && found.value.abs() <= tried + 1e-12, "{} {tried}", found.value);
            // The natural spline misses the dome at its edges.
            let is_known = expected.is_none_or(|expected: f64| (found.value + expected).abs() < 1e-3);
            assert!(is_known, "{} {expected:?}", found.value);
        }
    }

    /// Beyond the corner, where another place of the rectangle's corner cell is a local minimum.
    #[test]
    fn places_beyond_corners_are_found() {
        let mut heights = [0.0; 30];
        (heights[23], heights[29]) = (0.057_204_822_830_160_984, 0.099_269_003_979_965_41);
        let field = field(&heights, [6, 5]);
        let point = [0.424_390_137_884_305_8, 0.529_185_304_027_699_3, 0.303_510_704_654_372_74];
        let found = field.distance(in_space(&field, point[0], point[1], point[2]));
        assert!(found.value <= 0.229_011_451_043_781_73, "{}", found.value);
    }

    proptest! {
        /// Distances are at most those of many points over the rectangle and beyond, and agree with their derivatives.
        #[test]
        fn distances_are_those_of_the_nearest_place(
            heights in proptest::collection::vec(-0.1..0.1, 30),
            (x, y, z) in (-0.1..0.6, -0.1..0.7, -0.1..0.5),
        ) {
            let field = field(&heights, [6, 5]);
            let point = in_space(&field, x, y, z);
            let found = field.distance(point);
            let mut tried = f64::INFINITY;
            for i in -50..=175 {
                for j in -50..=200 {
                    let place = [f64::from(i) * 0.004, f64::from(j) * 0.004];
                    let way = [place[0] - x, place[1] - y, field.at(place).height - z];
                    tried = tried.min(way.iter().map(|w| w * w).sum::<f64>().sqrt());
                }
            }
            prop_assert!((found.value < 0.0) == (z < field.at([x, y]).height));
            prop_assert!(found.value.abs() <= tried + 1e-12, "{} {tried}", found.value);
            prop_assert!((found.normal.dot(found.normal) - 1.0).abs() < 1e-12);
            for reach in [0.0, 0.03, 0.1, 0.3, 1.0] {
                prop_assert!(!field.is_certainly_beyond(point, reach) || found.value > reach, "{reach} {found:?}");
            }
            let h = 1e-6;
            for axis in [Vector::new(1.0, 0.0, 0.0), Vector::new(0.0, 1.0, 0.0), Vector::new(0.0, 0.0, 1.0)] {
                let [ahead, behind] = [h, -h].map(|h| field.distance(point + axis * h));
                let jump = (ahead.normal - behind.normal).to_array().iter().fold(0.0_f64, |m, x| m.max(x.abs()));
                // Where two points are (almost) equally near, the normal jumps or rotates fast.
                if jump < 1e-4 {
                    let slope = (ahead.value - behind.value) / (2.0 * h);
                    prop_assert!((slope - found.normal.dot(axis)).abs() < 1e-7);
                    let change = (ahead.normal - behind.normal) * (0.5 / h) - found.curvature.times(axis);
                    prop_assert!(change.dot(change).sqrt() < 2e-3, "{change:?} {found:?}");
                }
            }
        }
    }
}
