//! The largest error due to the finite number of modes along a path of equilibria.

use super::path::Path;
use super::space_error::{Effort, Rest, SpaceError, error_at_rest, scales_with_loads};
use crate::error::Interrupted;
use crate::model::Model;

/// Number of points of a path that are looked at, evenly among all, the last one included: the error varies as smoothly as the path, and
/// functions of time of the user are called for each.
const POINTS: usize = 16;

/// The error of the point of a path where it is largest, and the index of the point: the displacements by missing strains of up to
/// sixteen points say where to look, with and without the amplification by the forces. Costs an evaluation of the forces for each, and
/// two estimates. The path is one at the time `t` and with the inputs `u`, if not those by default; a path of inputs has its own, and leaves
/// the model with those of a point. Points of growing loads in models with constraints or supports count under the full load alone.
pub fn error_along<M: Model + Clone>(
    model: &mut M,
    path: &Path,
    (t, u): (f64, Option<&[f64]>),
) -> Result<Option<(usize, SpaceError)>, Interrupted> {
    let (n, m) = (model.facts().n, path.load_factor.len());
    let entries = path.inputs.len() / m.max(1);
    let inputs = |i: usize| (entries > 0).then(|| &path.inputs[i * entries..(i + 1) * entries]);
    let scales = scales_with_loads(model);
    let rest = |i: usize| Rest {
        q: &path.q[i * n..(i + 1) * n],
        lowest: path.lowest[i],
        stability: path.stability[i],
        load_factor: if entries > 0 { 1.0 } else { path.load_factor[i] },
    };
    let mut most = [None::<(f64, usize)>; 2];
    let every = m.div_ceil(POINTS).max(1);
    for i in (0..m).rev().step_by(every) {
        let rest = rest(i);
        if !scales && rest.load_factor != 1.0 {
            continue;
        }
        set(model, inputs(i), t)?;
        let Some(missing) = model.missing_strain(rest.q, rest.load_factor) else { return Ok(None) };
        for (most, size) in most.iter_mut().zip([missing.displacement, rest.enlarged(missing)]) {
            if most.is_none_or(|(largest, _)| size > largest) {
                *most = Some((size, i));
            }
        }
    }
    let mut found: Option<(usize, SpaceError)> = None;
    let [by_strains, enlarged] = most.map(|most| most.map(|(_, i)| i));
    let again = enlarged.filter(|i| Some(*i) != by_strains);
    for i in by_strains.into_iter().chain(again) {
        set(model, inputs(i), t)?;
        let error = error_at_rest(model, rest(i), (t, inputs(i).or(u)), Effort::Little)?;
        if let Some(error) = error
            && found.as_ref().is_none_or(|(_, largest)| error.relative > largest.relative)
        {
            found = Some((i, error));
        }
    }
    Ok(found)
}

/// Sets the inputs of a point, if the path has its own.
fn set<M: Model>(model: &mut M, inputs: Option<&[f64]>, t: f64) -> Result<(), Interrupted> {
    let Some(inputs) = inputs else { return Ok(()) };
    model.set_inputs(inputs);
    model.set_time(t)
}
