//! Polynomials by their Bernstein coefficients: parts, products and halves of cubics and of bicubic surfaces.

/// Degree of half the squared distance in each coordinate, twice that of the surface.
pub(super) const DEGREE: usize = 6;

/// Number of its coefficients in each coordinate.
pub(super) const VALUES: usize = DEGREE + 1;

/// Bernstein coefficients of the cubic with these values at 0, 1/3, 2/3 and 1.
pub(super) fn through_thirds([a, b, c, d]: [f64; 4]) -> [f64; 4] {
    [a, (-5.0 * a + 18.0 * b - 9.0 * c + 2.0 * d) / 6.0, (2.0 * a - 9.0 * b + 18.0 * c - 5.0 * d) / 6.0, d]
}

/// Converts the B-spline coefficients of a cubic to Bernstein coefficients.
pub(super) fn bernstein([a, b, c, d]: [f64; 4]) -> [f64; 4] {
    [(a + 4.0 * b + c) / 6.0, (2.0 * b + c) / 3.0, (b + 2.0 * c) / 3.0, (b + 4.0 * c + d) / 6.0]
}

/// Bernstein coefficients of the tangent of a cubic at one of its ends, over a width beyond this end in lengths of the cubic.
pub(super) fn continued(line: [f64; 4], side: usize, width: f64) -> [f64; 4] {
    let [start, rise] = match side {
        0 => [line[0] - width * 3.0 * (line[1] - line[0]), line[1] - line[0]],
        _ => [line[3], line[3] - line[2]],
    };
    std::array::from_fn(|k| start + k as f64 * width * rise)
}

/// Bernstein coefficients of a part of a surface: along each axis from one fraction to another one.
pub(super) fn part_of(heights: &[[f64; 4]; 4], [rows, columns]: [[f64; 2]; 2]) -> [[f64; 4]; 4] {
    let along_columns = heights.map(|row| part_of_line(row, columns));
    transposed(transposed(along_columns).map(|column| part_of_line(column, rows)))
}

/// The same of a cubic, by its blossom (Ramshaw 1989, "Blossoms are polar forms").
pub(super) fn part_of_line(line: [f64; 4], [from, to]: [f64; 2]) -> [f64; 4] {
    std::array::from_fn(|k| {
        let mut values = line;
        for round in 0..3 {
            let x = if round < k { to } else { from };
            for i in 0..3 - round {
                values[i] += x * (values[i + 1] - values[i]);
            }
        }
        values[0]
    })
}

pub(super) fn transposed<const N: usize, const M: usize>(rows: [[f64; N]; M]) -> [[f64; M]; N] {
    std::array::from_fn(|j| std::array::from_fn(|i| rows[i][j]))
}

/// Differences of successive rows of a table.
pub(super) fn differences<const N: usize, const M: usize, const FEWER: usize>(
    rows: &[[f64; N]; M],
) -> [[f64; N]; FEWER] {
    std::array::from_fn(|i| std::array::from_fn(|k| rows[i + 1][k] - rows[i][k]))
}

/// Bernstein coefficients of the square of a surface with these ones (Farouki and Rajan 1988, "Algorithms for
/// polynomials in Bernstein form", section 3).
pub(super) fn squared(heights: &[[f64; 4]; 4]) -> [[f64; VALUES]; VALUES] {
    const CUBIC: [f64; 4] = [1.0, 3.0, 3.0, 1.0];
    const SEXTIC: [f64; VALUES] = [1.0, 6.0, 15.0, 20.0, 15.0, 6.0, 1.0];
    let weighted: [[f64; 4]; 4] =
        std::array::from_fn(|i| std::array::from_fn(|j| CUBIC[i] * CUBIC[j] * heights[i][j]));
    let mut square = [[0.0; VALUES]; VALUES];
    for (i, row) in weighted.iter().enumerate() {
        for (k, other) in weighted.iter().enumerate() {
            for (j, a) in row.iter().enumerate() {
                for (l, b) in other.iter().enumerate() {
                    square[i + k][j + l] += a * b;
                }
            }
        }
    }
    for (row, of_row) in square.iter_mut().zip(SEXTIC) {
        row.iter_mut().zip(SEXTIC).for_each(|(value, of_column)| *value /= of_row * of_column);
    }
    square
}

/// The same coefficients of the square of a line with these values at its ends.
pub(super) fn squared_line([a, b]: [f64; 2]) -> [f64; VALUES] {
    let degree = DEGREE as f64;
    std::array::from_fn(|k| {
        let (k, left) = (k as f64, degree - k as f64);
        (left * (left - 1.0) * a * a + 2.0 * k * left * a * b + k * (k - 1.0) * b * b)
            / (degree * (degree - 1.0))
    })
}

/// Bernstein coefficients along the columns for both halves (de Casteljau).
pub(super) fn halves<const N: usize>(rows: &[[f64; N]; N]) -> [[[f64; N]; N]; 2] {
    let mut ends = [*rows; 2];
    let mut left = *rows;
    for k in 1..N {
        for i in 0..N - k {
            for column in 0..N {
                left[i][column] = 0.5 * (left[i][column] + left[i + 1][column]);
            }
        }
        ends[0][k] = left[0];
        ends[1][N - 1 - k] = left[N - 1 - k];
    }
    ends
}
