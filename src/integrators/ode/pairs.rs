//! The explicit pairs by name.

use super::dormand_prince_5::DORMAND_PRINCE_5;
use super::dormand_prince_8::DORMAND_PRINCE_8;
use super::options::Method;
use super::pair::{Pair, Row};

/// The tableau of an explicit method, in the notation of Hairer, Norsett and Wanner (1993), section II.1.
#[derive(Clone, Debug, PartialEq)]
pub struct Tableau {
    /// Coefficients of the stages, s rows of s.
    pub a: Vec<Vec<f64>>,
    /// Weights of the stages, s.
    pub b: Vec<f64>,
    /// Times of the stages, s.
    pub c: Vec<f64>,
}

/// The pair of an explicit method; `None` for an implicit one.
pub(super) fn pair(method: Method) -> Option<&'static Pair> {
    match method {
        Method::Rk45 => Some(&DORMAND_PRINCE_5),
        Method::Dop853 => Some(&DORMAND_PRINCE_8),
        Method::Radau => None,
    }
}

/// Approximate stability limit of `|h lambda|` for an explicit method; `None` for an implicit one.
pub(crate) fn stability_limit(method: Method) -> Option<f64> {
    pair(method).map(|pair| pair.stability_limit)
}

/// The tableau of an explicit method; `None` for an implicit one.
pub fn tableau(method: Method) -> Option<Tableau> {
    let pair = pair(method)?;
    let dense = |row: Row| {
        let mut values = vec![0.0; pair.stages()];
        row.iter().for_each(|&(stage, weight)| values[stage] = weight);
        values
    };
    Some(Tableau { a: pair.a.iter().map(|row| dense(row)).collect(), b: dense(pair.b), c: pair.c.to_vec() })
}
