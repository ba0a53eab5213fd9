//! Functions of a segment's arc length: constant, linear, a table, or a polynomial approximation of a
//! function.

mod described;

use std::f64::consts::PI;

pub use described::Size;

use crate::error::{Checker, InvalidInput};

/// Maximum number of entries of a table: more could not be resolved by quadrature.
pub const MAX_STATIONS: usize = 4096;

/// Maximum degree of a polynomial that approximates a function: quadrature of a segment resolves no more.
pub const MAX_DEGREE: usize = 128;

/// Initial degree of the approximation.
const FIRST_DEGREE: usize = 8;

/// Coefficients below this fraction of the largest value are rounding errors: a few units in the last place
/// (Aurentz and Trefethen 2017, section 2, accept the same).
const ROUNDING: f64 = 16.0 * f64::EPSILON;

/// Points at which a polynomial is compared with its function in addition to the interpolation points:
/// without symmetry, to detect functions that vanish at all interpolation points (the "sample test" of
/// Chebfun; Driscoll, Hale and Trefethen 2014, section 8).
const TEST_PLACES: [f64; 2] = [0.178_392_652_145_97, 0.642_871_953_401_23];

/// Tolerance of this comparison, relative to the function's largest value.
const TEST_TOLERANCE: f64 = 1e-11;

/// The last station counts as the end of the segment within this fraction of its length.
const STATION_TOLERANCE: f64 = 1e-9;

/// `N` numbers as a function of the fraction x in [0, 1] of a segment's length.
#[derive(Clone, Debug, PartialEq)]
pub struct Profile<const N: usize> {
    kind: Kind<N>,
}

#[derive(Clone, Debug, PartialEq)]
enum Kind<const N: usize> {
    Constant([f64; N]),
    /// Values at base and tip.
    Linear([[f64; N]; 2]),
    Table(Table<N>),
    /// Chebyshev coefficients, of `T_k(2 x - 1)`, at least one.
    Polynomial(Vec<[f64; N]>),
}

/// A table interpolated by monotone cubics with continuous slope.
#[derive(Clone, Debug, PartialEq)]
struct Table<const N: usize> {
    /// Stations, increasing from zero, in any unit of length.
    stations: Vec<f64>,
    values: Vec<[f64; N]>,
    /// Derivatives with respect to the station.
    slopes: Vec<[f64; N]>,
}

/// The data of a profile.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Parts<'a, const N: usize> {
    /// The same everywhere.
    Constant(&'a [f64; N]),
    /// Values at base and tip, linear in between.
    Linear(&'a [[f64; N]; 2]),
    /// Stations starting at zero, and the values there.
    Table(&'a [f64], &'a [[f64; N]]),
    /// Chebyshev coefficients, of `T_k(2 x - 1)`.
    Polynomial(&'a [[f64; N]]),
}

/// Reason why a function has no polynomial approximation.
#[derive(Clone, Debug, PartialEq)]
pub enum Unsampled<E> {
    /// The function failed.
    Failed(E),
    /// The component `entry` at the fraction `x` is not finite.
    NonFinite {
        /// Fraction.
        x: f64,
        /// Index of the component.
        entry: usize,
        /// Value of the component.
        value: f64,
    },
    /// No polynomial up to degree [`MAX_DEGREE`] approximates the function to rounding; the largest error is
    /// near the fraction `x`.
    NotSmooth {
        /// Fraction with the largest error.
        x: f64,
    },
}

impl<const N: usize> From<[f64; N]> for Profile<N> {
    fn from(value: [f64; N]) -> Self {
        Self { kind: Kind::Constant(value) }
    }
}

impl From<f64> for Profile<1> {
    fn from(value: f64) -> Self {
        [value].into()
    }
}

impl<const R: usize, const C: usize, const N: usize> From<[[f64; C]; R]> for Profile<N> {
    /// A constant matrix, row by row: N = R C.
    fn from(rows: [[f64; C]; R]) -> Self {
        const { assert!(N == R * C, "as many numbers as the matrix has entries") };
        std::array::from_fn(|i| rows[i / C][i % C]).into()
    }
}

/// Variation of non-constant values along a segment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Variation<'a> {
    /// Polynomial degree between stations.
    pub(crate) degree: usize,
    /// Stations of a table; empty for smooth functions.
    pub(crate) stations: &'a [f64],
}

/// A function of the arc length, whatever its values are.
pub(crate) trait AlongSegment {
    /// Whether it is zero everywhere.
    fn is_zero(&self) -> bool;

    /// [`Profile::stations`].
    fn stations(&self) -> &[f64];

    /// Reports constants that are not finite, and what does not fit to a segment of this length.
    fn check(&self, check: &mut Checker, place: &str, length: f64);
}

impl<const N: usize> AlongSegment for Profile<N> {
    fn is_zero(&self) -> bool {
        self.constant() == Some([0.0; N])
    }

    fn stations(&self) -> &[f64] {
        self.stations()
    }

    fn check(&self, check: &mut Checker, place: &str, length: f64) {
        match self.constant() {
            Some(constant) => _ = check.finite(&constant, place),
            None => _ = check.nested(place, self.validate(length)),
        }
    }
}

impl<const N: usize> Profile<N> {
    /// Linear between the values at base and tip; constant if both are equal.
    pub fn linear(ends: [[f64; N]; 2]) -> Self {
        let [base, tip] = ends.map(|end| end.map(f64::to_bits));
        Self { kind: if base == tip { Kind::Constant(ends[0]) } else { Kind::Linear(ends) } }
    }

    /// Interpolates values at increasing stations from 0 to the segment's length by shape-preserving cubics
    /// with continuous slope (Fritsch and Butland 1984, the PCHIP of MATLAB and SciPy), exact for values on a
    /// line. Rejects invalid tables.
    pub fn table(stations: &[f64], values: &[[f64; N]]) -> Result<Self, InvalidInput> {
        let mut check = Checker::new();
        let number = stations.len();
        check.require(
            (2..=MAX_STATIONS).contains(&number),
            "stations",
            format_args!("{number} of them"),
            &format!("between 2 and {MAX_STATIONS} stations"),
        );
        check.require(
            values.len() == number,
            "values",
            format_args!("{} rows", values.len()),
            &format!("one row for each of the {number} stations"),
        );
        if check.finite(stations, "stations") && check.is_ok() {
            check.require(stations[0] == 0.0, "stations[0]", stations[0], "0, the segment's base");
            for (i, pair) in stations.windows(2).enumerate() {
                let expected = format!("more than stations[{i}] = {}", pair[0]);
                check.require(pair[0] < pair[1], &format!("stations[{}]", i + 1), pair[1], &expected);
            }
        }
        for (i, row) in values.iter().enumerate() {
            check.finite(row, &format!("values[{i}]"));
        }
        check.finish()?;
        let mut slopes = vec![[0.0; N]; number];
        for entry in 0..N {
            let column: Vec<f64> = values.iter().map(|row| row[entry]).collect();
            for (slope, found) in slopes.iter_mut().zip(slopes_of(stations, &column)) {
                slope[entry] = found;
            }
        }
        Ok(Self { kind: Kind::Table(Table { stations: stations.to_vec(), values: values.to_vec(), slopes }) })
    }

    /// The polynomial with these Chebyshev coefficients, of `T_k(2 x - 1)`.
    pub fn polynomial(coefficients: &[[f64; N]]) -> Result<Self, InvalidInput> {
        let mut check = Checker::new();
        let number = coefficients.len();
        check.require(
            (1..=MAX_DEGREE + 1).contains(&number),
            "coefficients",
            format_args!("{number} rows"),
            &format!("between 1 and {} rows", MAX_DEGREE + 1),
        );
        for (k, row) in coefficients.iter().enumerate() {
            check.finite(row, &format!("coefficients[{k}]"));
        }
        check.finish()?;
        Ok(Self::of_coefficients(coefficients.to_vec()))
    }

    fn of_coefficients(mut coefficients: Vec<[f64; N]>) -> Self {
        while coefficients.len() > 1 && coefficients.last() == Some(&[0.0; N]) {
            coefficients.pop();
        }
        match coefficients[..] {
            [only] => only.into(),
            _ => Self { kind: Kind::Polynomial(coefficients) },
        }
    }

    /// Approximates a function of the fraction x by a polynomial to rounding: interpolates at Chebyshev
    /// points, and doubles their number until the last coefficients are rounding errors (as in Chebfun:
    /// Battles and Trefethen 2004). Calls the function at most [`MAX_DEGREE`] + 3 times.
    pub fn sampled<E>(mut function: impl FnMut(f64) -> Result<[f64; N], E>) -> Result<Self, Unsampled<E>> {
        let mut sample = |x: f64| {
            let values = function(x).map_err(Unsampled::Failed)?;
            match values.iter().position(|value| !value.is_finite()) {
                Some(entry) => Err(Unsampled::NonFinite { x, entry, value: values[entry] }),
                None => Ok(values),
            }
        };
        let mut degree = FIRST_DEGREE;
        let mut values =
            (0..=degree).map(|j| sample(chebyshev_point(j, degree))).collect::<Result<Vec<_>, _>>()?;
        loop {
            let (coefficients, is_resolved) = resolve(&values);
            let profile = Self::of_coefficients(coefficients);
            if is_resolved {
                let mut farthest = (0.0, 0.0);
                for x in TEST_PLACES {
                    let distance = relative_distance(&profile.at(x), &sample(x)?, &largest(&values));
                    farthest = if distance > farthest.0 { (distance, x) } else { farthest };
                }
                if farthest.0 <= TEST_TOLERANCE {
                    return Ok(profile);
                }
            }
            if degree == MAX_DEGREE {
                // Error of the polynomial of half the degree at the additional points.
                let coarse = values.iter().copied().step_by(2).collect::<Vec<_>>();
                let coarse = Self::of_coefficients(resolve(&coarse).0);
                let sizes = largest(&values);
                let places = (0..=degree).map(|j| chebyshev_point(j, degree));
                let distances = places
                    .zip(&values)
                    .map(|(x, value)| (x, relative_distance(&coarse.at(x), value, &sizes)));
                let farthest = distances.fold((0.0, 0.0), |a, b| if b.1 > a.1 { b } else { a });
                return Err(Unsampled::NotSmooth { x: farthest.0 });
            }
            // The Chebyshev points of half the degree are every other point.
            degree *= 2;
            let mut known = values.into_iter();
            values = (0..=degree)
                .map(|j| match j % 2 {
                    0 => Ok(known.next().expect("every other point is known")),
                    _ => sample(chebyshev_point(j, degree)),
                })
                .collect::<Result<Vec<_>, _>>()?;
        }
    }

    /// The data of the profile.
    pub fn parts(&self) -> Parts<'_, N> {
        match &self.kind {
            Kind::Constant(value) => Parts::Constant(value),
            Kind::Linear(ends) => Parts::Linear(ends),
            Kind::Table(table) => Parts::Table(&table.stations, &table.values),
            Kind::Polynomial(coefficients) => Parts::Polynomial(coefficients),
        }
    }

    /// The value of a profile given as a constant.
    pub fn constant(&self) -> Option<[f64; N]> {
        if let Kind::Constant(value) = self.kind { Some(value) } else { None }
    }

    /// Values at base and tip of a profile given as linear or constant.
    pub fn ends(&self) -> Option<[[f64; N]; 2]> {
        match self.kind {
            Kind::Constant(value) => Some([value; 2]),
            Kind::Linear(ends) => Some(ends),
            _ => None,
        }
    }

    /// Whether the profile is constant.
    pub fn is_constant(&self) -> bool {
        (0..N).all(|entry| self.is_entry_constant(entry).is_some())
    }

    /// The component `entry` if it is constant.
    pub fn is_entry_constant(&self, entry: usize) -> Option<f64> {
        let first = match &self.kind {
            Kind::Constant(value) => value[entry],
            Kind::Linear([base, tip]) => (base[entry] == tip[entry]).then_some(base[entry])?,
            Kind::Table(table) => {
                let first = table.values[0][entry];
                table.values.iter().all(|row| row[entry] == first).then_some(first)?
            }
            Kind::Polynomial(coefficients) => {
                coefficients[1..].iter().all(|row| row[entry] == 0.0).then_some(coefficients[0][entry])?
            }
        };
        Some(first)
    }

    /// The last station of a table must be the end of a segment of this length.
    pub fn validate(&self, length: f64) -> Result<(), InvalidInput> {
        let mut check = Checker::new();
        if let Kind::Table(table) = &self.kind {
            let last = table.stations.len() - 1;
            let end = table.stations[last];
            let is_sensible = length.is_finite() && length > 0.0;
            check.require(
                !is_sensible || (end - length).abs() <= STATION_TOLERANCE * length,
                &format!("stations[{last}]"),
                end,
                &format!("{length}, the segment's length (metres)"),
            );
        }
        check.finish()
    }

    /// Values at the fraction `x` in [0, 1].
    pub fn at(&self, x: f64) -> [f64; N] {
        match &self.kind {
            Kind::Constant(value) => *value,
            Kind::Linear([base, tip]) => std::array::from_fn(|i| base[i] + (tip[i] - base[i]) * x),
            Kind::Table(table) => table.at(x),
            Kind::Polynomial(coefficients) => clenshaw(coefficients, 2.0 * x - 1.0),
        }
    }

    /// Values at the fraction `x` and their first two derivatives with respect to `x`.
    pub fn jet(&self, x: f64) -> [[f64; N]; 3] {
        match &self.kind {
            Kind::Constant(value) => [*value, [0.0; N], [0.0; N]],
            Kind::Linear([base, tip]) => [self.at(x), std::array::from_fn(|i| tip[i] - base[i]), [0.0; N]],
            Kind::Table(table) => table.jet(x),
            Kind::Polynomial(coefficients) => {
                let t = 2.0 * x - 1.0;
                let slope = derivative(coefficients);
                let bend = derivative(&slope);
                let [slope, bend] = [&slope, &bend].map(|coefficients| clenshaw(coefficients, t));
                [clenshaw(coefficients, t), slope.map(|slope| 2.0 * slope), bend.map(|bend| 4.0 * bend)]
            }
        }
    }

    /// Exact integrals of the values from the fraction 0 to `x`: `int_0^x p(y) dy`.
    pub fn integral(&self, x: f64) -> [f64; N] {
        match &self.kind {
            Kind::Constant(value) => value.map(|value| value * x),
            Kind::Linear([base, tip]) => {
                std::array::from_fn(|i| x * (base[i] + (tip[i] - base[i]) * x / 2.0))
            }
            Kind::Table(table) => table.integral(x),
            Kind::Polynomial(coefficients) => {
                let antiderivative = antiderivative(coefficients);
                let [from, to] = [-1.0, 2.0 * x - 1.0].map(|t| clenshaw(&antiderivative, t));
                std::array::from_fn(|i| 0.5 * (to[i] - from[i]))
            }
        }
    }

    /// Polynomial degree, between stations for a table; zero for a constant.
    pub fn degree(&self) -> usize {
        match &self.kind {
            Kind::Constant(_) => 0,
            Kind::Linear(_) => 1,
            Kind::Table(table) if table.stations.len() == 2 => 1,
            Kind::Table(_) => 3,
            Kind::Polynomial(coefficients) => coefficients.len() - 1,
        }
    }

    /// Stations of a table; empty for smooth functions.
    pub fn stations(&self) -> &[f64] {
        if let Kind::Table(table) = &self.kind { &table.stations } else { &[] }
    }

    /// Variation along the segment, if any.
    pub(crate) fn variation(&self) -> Option<Variation<'_>> {
        (!self.is_constant()).then(|| Variation { degree: self.degree(), stations: self.stations() })
    }

    /// The same function times a number.
    pub(crate) fn scaled(&self, factor: f64) -> Self {
        let times = |row: &[f64; N]| row.map(|entry| entry * factor);
        let rows = |rows: &[[f64; N]]| rows.iter().map(times).collect();
        let kind = match &self.kind {
            Kind::Constant(value) => Kind::Constant(times(value)),
            Kind::Linear(ends) => Kind::Linear(ends.each_ref().map(times)),
            Kind::Table(Table { stations, values, slopes }) => {
                Kind::Table(Table { stations: stations.clone(), values: rows(values), slopes: rows(slopes) })
            }
            Kind::Polynomial(coefficients) => Kind::Polynomial(rows(coefficients)),
        };
        Self { kind }
    }

    /// One profile per component.
    pub fn columns(&self) -> [Profile<1>; N] {
        let column =
            |rows: &[[f64; N]], entry: usize| rows.iter().map(|row| [row[entry]]).collect::<Vec<_>>();
        std::array::from_fn(|entry| match &self.kind {
            Kind::Constant(value) => [value[entry]].into(),
            Kind::Linear(ends) => Profile::linear(ends.map(|end| [end[entry]])),
            Kind::Table(Table { stations, values, slopes }) => Profile {
                kind: Kind::Table(Table {
                    stations: stations.clone(),
                    values: column(values, entry),
                    slopes: column(slopes, entry),
                }),
            },
            Kind::Polynomial(coefficients) => Profile { kind: Kind::Polynomial(column(coefficients, entry)) },
        })
    }
}

impl<const N: usize> Table<N> {
    /// Index of the interval that contains a station, offset of the station from its start, and length of the
    /// interval.
    fn interval(&self, x: f64) -> (usize, f64, f64) {
        let last = self.stations.len() - 1;
        let station = x * self.stations[last];
        let i = self.stations.partition_point(|&other| other <= station).clamp(1, last) - 1;
        (i, station - self.stations[i], self.stations[i + 1] - self.stations[i])
    }

    /// Coefficients of the cubic of interval `i`, in increasing powers of the offset.
    fn cubic(&self, i: usize, entry: usize) -> [f64; 4] {
        let width = self.stations[i + 1] - self.stations[i];
        let secant = (self.values[i + 1][entry] - self.values[i][entry]) / width;
        let [start, end] = [self.slopes[i][entry], self.slopes[i + 1][entry]];
        let square = (3.0 * secant - 2.0 * start - end) / width;
        [self.values[i][entry], start, square, (start + end - 2.0 * secant) / (width * width)]
    }

    fn at(&self, x: f64) -> [f64; N] {
        let (i, s, _) = self.interval(x);
        std::array::from_fn(|entry| {
            let [a, b, c, d] = self.cubic(i, entry);
            a + s * (b + s * (c + s * d))
        })
    }

    fn jet(&self, x: f64) -> [[f64; N]; 3] {
        let (i, s, _) = self.interval(x);
        let end = self.stations[self.stations.len() - 1];
        let cubics: [[f64; 4]; N] = std::array::from_fn(|entry| self.cubic(i, entry));
        [
            cubics.map(|[a, b, c, d]| a + s * (b + s * (c + s * d))),
            cubics.map(|[_, b, c, d]| end * (b + s * (2.0 * c + s * 3.0 * d))),
            cubics.map(|[_, _, c, d]| end * end * (2.0 * c + s * 6.0 * d)),
        ]
    }

    fn integral(&self, x: f64) -> [f64; N] {
        let (i, s, _) = self.interval(x);
        let end = self.stations[self.stations.len() - 1];
        std::array::from_fn(|entry| {
            let part = |i: usize, s: f64| {
                let [a, b, c, d] = self.cubic(i, entry);
                s * (a + s * (b / 2.0 + s * (c / 3.0 + s * d / 4.0)))
            };
            let before: f64 = (0..i).map(|i| part(i, self.stations[i + 1] - self.stations[i])).sum();
            (before + part(i, s)) / end
        })
    }
}

/// Slopes of a table: the weighted harmonic mean of the secants on both sides, zero between secants of
/// different signs (Fritsch and Butland 1984). At the ends the slope of the parabola through three values,
/// limited to prevent overshoot (Moler 2004, section 3.6).
fn slopes_of(stations: &[f64], values: &[f64]) -> Vec<f64> {
    let last = stations.len() - 1;
    let widths: Vec<f64> = stations.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let secants: Vec<f64> = (0..last).map(|i| (values[i + 1] - values[i]) / widths[i]).collect();
    if last == 1 {
        return vec![secants[0]; 2];
    }
    let end = |[h0, h1]: [f64; 2], [d0, d1]: [f64; 2]| {
        let slope = ((2.0 * h0 + h1) * d0 - h0 * d1) / (h0 + h1);
        if slope * d0 <= 0.0 {
            0.0
        } else if d0 * d1 <= 0.0 && slope.abs() > 3.0 * d0.abs() {
            3.0 * d0
        } else {
            slope
        }
    };
    let inside = |i: usize| {
        let ([h0, h1], [d0, d1]) = ([widths[i - 1], widths[i]], [secants[i - 1], secants[i]]);
        if d0 * d1 <= 0.0 {
            return 0.0;
        }
        let (w0, w1) = (2.0 * h1 + h0, h1 + 2.0 * h0);
        (w0 + w1) / (w0 / d0 + w1 / d1)
    };
    (0..=last)
        .map(|i| match i {
            0 => end([widths[0], widths[1]], [secants[0], secants[1]]),
            i if i == last => {
                end([widths[last - 1], widths[last - 2]], [secants[last - 1], secants[last - 2]])
            }
            i => inside(i),
        })
        .collect()
}

/// Chebyshev point `j` of `degree + 1` points on [0, 1], in ascending order.
fn chebyshev_point(j: usize, degree: usize) -> f64 {
    // By the sine, which is symmetric to rounding.
    let angle = PI * (2.0 * j as f64 - degree as f64) / (2 * degree) as f64;
    0.5 + 0.5 * angle.sin()
}

/// Largest magnitude of each component.
fn largest<const N: usize>(values: &[[f64; N]]) -> [f64; N] {
    std::array::from_fn(|entry| values.iter().fold(0.0, |size: f64, row| size.max(row[entry].abs())))
}

/// Largest difference of two rows relative to these sizes.
fn relative_distance<const N: usize>(a: &[f64; N], b: &[f64; N], sizes: &[f64; N]) -> f64 {
    (0..N).map(|i| if a[i] == b[i] { 0.0 } else { (a[i] - b[i]).abs() / sizes[i] }).fold(0.0, f64::max)
}

/// Coefficients of the polynomial through values at Chebyshev points, without those that are rounding errors,
/// and whether the last quarter of them is rounding.
fn resolve<const N: usize>(values: &[[f64; N]]) -> (Vec<[f64; N]>, bool) {
    let degree = values.len() - 1;
    let sizes = largest(values);
    let mut coefficients = vec![[0.0; N]; degree + 1];
    for entry in 0..N {
        let is_constant = values.iter().all(|row| row[entry] == values[0][entry]);
        if is_constant {
            // Avoids rounding errors of the sums, so that planar strains stay planar.
            coefficients[0][entry] = values[0][entry];
            continue;
        }
        // Discrete cosine transform (Trefethen 2013, chapter 3): t_j = -cos(pi j / degree), T_k(t_j) = (-1)^k cos(pi
        // j k / degree).
        for (k, row) in coefficients.iter_mut().enumerate() {
            let is_end = |index: usize| index == 0 || index == degree;
            let sum: f64 = values
                .iter()
                .enumerate()
                .map(|(j, value)| {
                    let cosine = (PI * ((j * k) % (2 * degree)) as f64 / degree as f64).cos();
                    value[entry] * cosine * if is_end(j) { 0.5 } else { 1.0 }
                })
                .sum();
            let sign = if k % 2 == 0 { 1.0 } else { -1.0 };
            row[entry] = sign * sum * if is_end(k) { 1.0 } else { 2.0 } / degree as f64;
        }
    }
    let is_rounding = |row: &[f64; N]| (0..N).all(|i| row[i].abs() <= ROUNDING * sizes[i]);
    let kept = coefficients.iter().rposition(|row| !is_rounding(row)).map_or(1, |last| last + 1);
    let is_resolved = 4 * kept <= 3 * degree;
    coefficients.truncate(kept);
    for row in &mut coefficients {
        for (value, size) in row.iter_mut().zip(sizes) {
            if value.abs() <= ROUNDING * size {
                *value = 0.0;
            }
        }
    }
    (coefficients, is_resolved)
}

/// `sum_k c_k T_k(t)` (Clenshaw 1955).
fn clenshaw<const N: usize>(coefficients: &[[f64; N]], t: f64) -> [f64; N] {
    std::array::from_fn(|entry| {
        let (mut here, mut before) = (0.0, 0.0);
        for row in coefficients[1..].iter().rev() {
            (here, before) = (row[entry] + 2.0 * t * here - before, here);
        }
        coefficients[0][entry] + t * here - before
    })
}

/// Coefficients of an antiderivative with respect to t: `int T_k = T_{k+1} / (2 (k+1)) - T_{k-1} / (2
/// (k-1))`.
fn antiderivative<const N: usize>(coefficients: &[[f64; N]]) -> Vec<[f64; N]> {
    let of = |k: usize, entry: usize| coefficients.get(k).map_or(0.0, |row| row[entry]);
    (0..=coefficients.len())
        .map(|k| {
            std::array::from_fn(|entry| match k {
                0 => 0.0,
                1 => of(0, entry) - of(2, entry) / 2.0,
                k => (of(k - 1, entry) - of(k + 1, entry)) / (2 * k) as f64,
            })
        })
        .collect()
}

/// Coefficients of the derivative with respect to t: `c_{k-1} = c_{k+1} + 2 k a_k`, half of it for k = 1.
fn derivative<const N: usize>(coefficients: &[[f64; N]]) -> Vec<[f64; N]> {
    let number = coefficients.len().max(2) - 1;
    let mut of_slope = vec![[0.0; N]; number + 2];
    for k in (1..coefficients.len()).rev() {
        for entry in 0..N {
            of_slope[k - 1][entry] = of_slope[k + 1][entry] + 2.0 * k as f64 * coefficients[k][entry];
        }
    }
    of_slope[0] = of_slope[0].map(|first| 0.5 * first);
    of_slope.truncate(number);
    of_slope
}

#[cfg(test)]
mod tests {
    use std::convert::Infallible;

    use super::*;

    fn sampled(f: impl Fn(f64) -> [f64; 2]) -> Result<Profile<2>, Unsampled<Infallible>> {
        Profile::sampled(|x| Ok(f(x)))
    }

    #[test]
    fn jets_are_derivatives() {
        let wave = sampled(|x| [(5.0 * x).sin(), x.exp()]).unwrap();
        for x in [0.0, 0.3, 0.77, 1.0_f64] {
            let jet = wave.jet(x);
            let wanted = [
                [(5.0 * x).sin(), x.exp()],
                [5.0 * (5.0 * x).cos(), x.exp()],
                [-25.0 * (5.0 * x).sin(), x.exp()],
            ];
            for (order, (found, wanted)) in jet.iter().zip(wanted).enumerate() {
                let tolerance = [1e-13, 1e-11, 1e-9][order];
                assert!((0..2).all(|i| (found[i] - wanted[i]).abs() < tolerance), "{order}: {found:?}");
            }
        }
        assert_eq!(Profile::linear([[1.0], [4.0]]).jet(0.5), [[2.5], [3.0], [0.0]]);
        assert_eq!(Profile::from(2.0).jet(0.5), [[2.0], [0.0], [0.0]]);
        let line = Profile::polynomial(&[[1.0], [2.0]]).unwrap();
        assert_eq!(line.jet(0.25), [[0.0], [4.0], [0.0]]);
        let table = Profile::table(&[0.0, 1.0, 3.0], &[[0.0], [1.0], [0.5]]).unwrap();
        let step = 1e-5;
        for x in [0.1, 0.2, 0.5, 0.9] {
            let [before, here, after] = [x - step, x, x + step].map(|x| table.jet(x));
            assert!(((after[0][0] - before[0][0]) / (2.0 * step) - here[1][0]).abs() < 1e-8);
            assert!(((after[1][0] - before[1][0]) / (2.0 * step) - here[2][0]).abs() < 1e-8);
        }
    }

    #[test]
    fn linear_profiles_are_tables_of_two_stations() {
        let line = Profile::linear([[1.0, 5.0], [4.0, 5.0]]);
        let table = Profile::table(&[0.0, 2.0], &[[1.0, 5.0], [4.0, 5.0]]).unwrap();
        for x in [0.0, 0.3, 1.0] {
            assert_eq!(line.at(x), table.at(x));
            let difference = line.integral(x)[0] - table.integral(x)[0];
            assert!(difference.abs() < 1e-15 && (line.integral(x)[1] - 5.0 * x).abs() < 1e-15);
        }
        assert_eq!((line.degree(), line.ends()), (1, Some([[1.0, 5.0], [4.0, 5.0]])));
        assert_eq!([line.is_entry_constant(0), line.is_entry_constant(1)], [None, Some(5.0)]);
        assert_eq!(line.columns(), [Profile::linear([[1.0], [4.0]]), 5.0.into()]);
        assert_eq!(Profile::linear([[2.0]; 2]), 2.0.into());
        assert_eq!((table.ends(), table.variation().map(|variation| variation.degree)), (None, Some(1)));
        let matrix: Profile<6> = [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]].into();
        assert_eq!(matrix.constant(), Some([1.0, 2.0, 3.0, 4.0, 5.0, 6.0]));
    }

    #[test]
    fn constants_and_lines_are_exact() {
        let constant = Profile::from([1.5, -2.0]);
        assert!(constant.is_constant() && constant.at(0.3) == [1.5, -2.0]);
        assert_eq!(constant.integral(0.5), [0.75, -1.0]);
        let flat = Profile::table(&[0.0, 0.1, 0.4], &[[1.5], [1.5], [1.5]]).unwrap();
        assert!(flat.is_constant() && flat.at(0.7) == [1.5] && flat.constant().is_none());
        for stations in [vec![0.0, 2.0], vec![0.0, 0.1, 0.7, 2.0], vec![0.0, 0.5, 1.0, 1.9, 2.0]] {
            let values: Vec<[f64; 1]> = stations.iter().map(|s| [3.0 - 2.0 * s]).collect();
            let line = Profile::table(&stations, &values).unwrap();
            assert!(!line.is_constant());
            for x in [0.0, 0.01, 0.3, 0.62, 1.0] {
                assert!((line.at(x)[0] - (3.0 - 4.0 * x)).abs() < 1e-14, "{x}");
                assert!((line.integral(x)[0] - (3.0 * x - 2.0 * x * x)).abs() < 1e-14, "{x}");
            }
        }
    }

    #[test]
    fn tables_keep_their_values_and_do_not_overshoot() {
        let stations = [0.0, 0.2, 0.3, 0.7, 1.1, 1.5];
        let values = [[0.0], [0.1], [2.0], [2.1], [2.1], [-1.0]];
        let table = Profile::table(&stations, &values).unwrap();
        for (station, value) in stations.iter().zip(values) {
            assert!((table.at(station / 1.5)[0] - value[0]).abs() < 1e-14);
        }
        let fine: Vec<f64> = (0..=1500).map(|i| table.at(f64::from(i) / 1500.0)[0]).collect();
        for (i, pair) in fine.windows(2).enumerate() {
            assert!(if i < 700 { pair[1] >= pair[0] - 1e-14 } else { pair[1] <= pair[0] + 1e-12 }, "{i}");
            assert!((pair[1] - pair[0]).abs() < 0.05, "continuous at {i}");
        }
        // The trapezoidal rule, compared with the exact integral.
        let sum: f64 = fine.windows(2).map(|pair| 0.5 * (pair[0] + pair[1]) / 1500.0).sum();
        assert!((table.integral(1.0)[0] - sum).abs() < 1e-5);
    }

    #[test]
    fn smooth_functions_become_polynomials() {
        let profile = sampled(|x| [(3.0 * x).sin(), 2.0 * x * x - x]).unwrap();
        assert!(profile.degree() < 20 && !profile.is_constant());
        for x in [0.0, 0.123, 0.5, 0.87, 1.0] {
            let [sine, square] = profile.at(x);
            assert!((sine - (3.0 * x).sin()).abs() < 1e-14 && (square - 2.0 * x * x + x).abs() < 1e-14);
            let [sine, square] = profile.integral(x);
            assert!((sine - (1.0 - (3.0 * x).cos()) / 3.0).abs() < 1e-14);
            assert!((square - (2.0 * x.powi(3) / 3.0 - x * x / 2.0)).abs() < 1e-14);
        }
        assert_eq!(sampled(|x| [x, 7.0]).unwrap().is_entry_constant(1), Some(7.0));
        assert_eq!(sampled(|_| [1.0, 7.0]).unwrap().constant(), Some([1.0, 7.0]));
    }

    #[test]
    fn rough_functions_are_refused_where_they_are_rough() {
        for kink in [0.25, 0.4] {
            let Err(Unsampled::NotSmooth { x }) = sampled(|x| [(x - kink).abs(), 1.0]) else {
                panic!("smooth")
            };
            assert!((x - kink).abs() < 0.02, "{x} is not near {kink}");
            let step = sampled(|x| [if x < kink { 0.0 } else { 1.0 }, 1.0]);
            let Err(Unsampled::NotSmooth { x }) = step else { panic!("smooth") };
            assert!((x - kink).abs() < 0.02, "{x} is not near {kink}");
        }
        // Zero at the first points, but not between them.
        let hidden = sampled(|x| [((2.0 * x - 1.0).acos() * 8.0).sin(), 0.0]);
        assert!(matches!(hidden, Err(Unsampled::NotSmooth { .. })));
        let pole = sampled(|x| [1.0, 1.0 / (x - 0.5)]);
        assert!(matches!(pole, Err(Unsampled::NonFinite { x: 0.5, entry: 1, .. })));
        let failed: Result<Profile<1>, _> = Profile::sampled(|x| if x < 0.9 { Ok([x]) } else { Err("no") });
        assert_eq!(failed, Err(Unsampled::Failed("no")));
    }

    #[test]
    fn tables_that_are_none_are_refused() {
        let message =
            |stations: &[f64], values: &[[f64; 1]]| Profile::table(stations, values).unwrap_err().to_string();
        assert!(message(&[0.0], &[[1.0]]).contains("between 2 and"));
        assert!(message(&[0.0, 1.0], &[[1.0]]).contains("one row for each of the 2 stations"));
        assert!(message(&[0.1, 1.0], &[[1.0], [2.0]]).starts_with("stations[0]: got 0.1, expected 0"));
        assert!(message(&[0.0, 1.0, 1.0], &[[1.0]; 3]).contains("stations[2]: got 1, expected more than"));
        assert!(message(&[0.0, 1.0], &[[1.0], [f64::NAN]]).contains("values[1][0]: got NaN"));
        let table = Profile::table(&[0.0, 1.0], &[[1.0], [2.0]]).unwrap();
        assert!(table.validate(1.0).is_ok());
        let error = table.validate(2.0).unwrap_err().to_string();
        assert_eq!(error, "stations[1]: got 1, expected 2, the segment's length (metres)");
        assert!(Profile::<1>::polynomial(&[]).is_err());
    }

    #[test]
    fn columns_are_profiles_of_their_own() {
        let table = Profile::table(&[0.0, 0.3, 1.0], &[[1.0, 4.0], [2.0, 3.0], [2.5, -1.0]]).unwrap();
        let polynomial = sampled(|x| [x.exp(), x.cos()]).unwrap();
        for profile in [table, polynomial, [1.0, 2.0].into()] {
            for (entry, column) in profile.columns().iter().enumerate() {
                assert_eq!(column.at(0.4)[0], profile.at(0.4)[entry]);
                assert_eq!(column.integral(0.4)[0], profile.integral(0.4)[entry]);
            }
        }
    }
}
