//! Stiffness of the strains of a piece of a segment, integrated along it.

use super::piece;
use super::piece::Piece;
use super::quadrature::Gauss;
use super::section::Section;
use super::segment::Segment;
use super::strain::STRAINS;
use crate::numerics::linalg::{Matrix, condition_number};

/// Number of nodes beyond the modes for a stiffness that is not a polynomial along the rod. Quotients of
/// sizes converge according to their nearest pole; these nodes reach rounding for tapers up to 1 to 10.
const NODES_FOR_QUOTIENTS: usize = 30;

pub(crate) fn is_tapered(piece: &Piece) -> bool {
    !piece.segment.section.is_constant()
}

/// Largest condition number of the stiffness of a strain, in the 2-norm.
pub(crate) fn condition_of_stiffness(segment: &Segment) -> f64 {
    let condition = |piece: Piece| {
        let present = (0..STRAINS).filter(|&strain| piece.modes[strain] > 0);
        let of_strain = |strain: usize| condition_number(&stiffness(&piece, [strain; 2]));
        present.map(of_strain).fold(1.0, f64::max)
    };
    piece::of(segment).map(condition).fold(1.0, f64::max)
}

/// Generalised stiffness K of a segment: the material's forces for coordinates q are `K q`.
///
/// Symmetric and block diagonal, with one block per piece.
pub fn generalised_stiffness(segment: &Segment) -> Matrix {
    let n = segment.coordinates();
    let mut whole = Matrix::zeros(n, n);
    let mut first = 0;
    for piece in piece::of(segment) {
        let start = |strain: usize| first + piece.modes[..strain].iter().sum::<usize>();
        for strain in (0..STRAINS).filter(|&strain| piece.modes[strain] > 0) {
            let block = stiffness(&piece, [strain; 2]);
            whole.view_mut((start(strain), start(strain)), block.shape()).copy_from(&block);
        }
        for strains in coupled(&piece) {
            let block = stiffness(&piece, strains);
            let [row, column] = strains.map(start);
            whole.view_mut((row, column), block.shape()).copy_from(&block);
            let (rows, columns) = block.shape();
            whole.view_mut((column, row), (columns, rows)).copy_from(&block.transpose());
        }
        first += piece.modes.iter().sum::<usize>();
    }
    whole
}

/// Pairs of strains with modes that the stiffness couples.
pub(crate) fn coupled(piece: &Piece) -> Vec<[usize; 2]> {
    match &piece.segment.section {
        Section::Given(given) => given.coupled(&piece.modes).collect(),
        Section::Shape(_) => Vec::new(),
    }
}

/// `int phi_j H phi_k` for one strain component or between two: exact for circles, given sections and
/// constant sections.
pub(crate) fn stiffness(piece: &Piece, strains: [usize; 2]) -> Matrix {
    let [rows, columns] = strains.map(|strain| piece.modes[strain]);
    let modes = rows.max(columns);
    // Degree 2 (modes - 1) + 4 for the fourth power of a linear radius, and 4 for each further degree.
    let beyond = if piece.segment.section.is_polynomial() { 3 } else { NODES_FOR_QUOTIENTS };
    let beyond = beyond + 2 * piece.degree_of_section().saturating_sub(1);
    let gauss = Gauss::composite(piece.basis.degree(modes) + beyond, &piece.breaks_of_stiffness(modes));
    let mut stiffness = Matrix::zeros(rows, columns);
    let mut phi = vec![0.0; modes];
    let is_orthogonal = !is_tapered(piece) && piece.basis.is_orthogonal();
    for (&x, &weight) in gauss.nodes.iter().zip(&gauss.weights) {
        piece.basis.values(x, &mut phi);
        let [row, column] = strains;
        let scale = piece.length() * weight * piece.section(x).stiffness[row][column];
        for j in 0..rows {
            for k in 0..columns {
                // Off-diagonal entries of an orthogonal basis are rounding errors if the section is constant.
                if j == k || !is_orthogonal {
                    stiffness[(j, k)] += scale * phi[j] * phi[k];
                }
            }
        }
    }
    stiffness
}
