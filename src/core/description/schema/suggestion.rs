//! Suggestions for unknown words.

/// Smallest similarity (Jaro and Winkler 1990, 0 to 1) at which a known word is suggested.
const SIMILARITY: f64 = 0.8;

/// Symbols of formulas have no more letters.
const LONGEST_SYMBOL: usize = 2;

/// Symbols and words of other programs, and the names that they may stand for; the first that is known counts.
const SYMBOLS: [(&str, &[&str]); 85] = [
    ("E", &["young_modulus"]),
    ("G", &["shear_modulus"]),
    ("nu", &["poisson_ratio"]),
    ("rho", &["density", "rho_inf"]),
    ("L", &["length"]),
    ("l", &["length"]),
    ("R", &["radius"]),
    ("r", &["radius"]),
    ("A", &["area", "amplitude"]),
    ("I", &["inertia"]),
    ("m", &["mass", "tip_mass"]),
    ("g", &["gravity"]),
    ("k", &["stiffness"]),
    ("c", &["damping"]),
    ("d", &["damping"]),
    ("mu", &["friction"]),
    ("tau", &["torque", "retardation_time"]),
    ("F", &["force", "tip_force"]),
    ("M", &["moment", "tip_moment"]),
    ("T", &["tension", "t_end"]),
    ("p", &["pressure"]),
    ("f", &["frequency"]),
    ("diameter", &["radius"]),
    ("damping", &["retardation_time"]),
    ("position", &["base_position"]),
    ("orientation", &["base_orientation"]),
    ("direction", &["base_orientation", "orientation"]),
    ("rotation", &["base_orientation", "orientation"]),
    ("explicit", &["rk45"]),
    ("implicit", &["newmark"]),
    ("stiff", &["radau"]),
    ("ode45", &["rk45"]),
    ("ode15s", &["radau"]),
    ("bdf", &["radau"]),
    ("lsoda", &["auto", "radau"]),
    ("trapezoidal", &["average_acceleration"]),
    ("verlet", &["central_difference"]),
    ("leapfrog", &["central_difference"]),
    ("hybr", &["trust_region"]),
    ("lm", &["trust_region"]),
    ("dogleg", &["trust_region"]),
    ("powell", &["trust_region"]),
    ("n_modes", &["modes"]),
    ("num_modes", &["modes"]),
    ("n_elem", &["modes"]),
    ("n_elements", &["modes"]),
    ("elements", &["modes"]),
    ("base_length", &["length"]),
    ("base_radius", &["radius"]),
    ("EI", &["section"]),
    ("GJ", &["section"]),
    ("EA", &["section"]),
    ("GA", &["section"]),
    ("bending_stiffness", &["section"]),
    ("flexural_rigidity", &["section"]),
    ("axial_stiffness", &["section"]),
    ("torsional_stiffness", &["section"]),
    ("mass_per_length", &["section"]),
    ("linear_density", &["section"]),
    ("t_span", &["t_end"]),
    ("tspan", &["t_end"]),
    ("t_final", &["t_end"]),
    ("tf", &["t_end"]),
    ("duration", &["t_end"]),
    ("timestep", &["dt"]),
    ("time_step", &["dt"]),
    ("step", &["dt"]),
    ("h", &["dt"]),
    ("x0", &["q0"]),
    ("y0", &["q0"]),
    ("qd0", &["v0"]),
    ("u0", &["u"]),
    ("inputs", &["u", "control"]),
    ("input", &["inputs", "u", "control"]),
    ("targets", &["target", "pose"]),
    ("time", &["t"]),
    ("dt", &["duration"]),
    ("controller", &["control"]),
    ("joint", &["kind"]),
    ("maxiter", &["max_iter"]),
    ("x", &["X", "at"]),
    ("X", &["at"]),
    ("s", &["X", "at"]),
    ("arc_length", &["X", "at"]),
    ("color", &["colour"]),
];

/// How to describe a segment by the stiffness of its sections.
const BY_STIFFNESS: &str = "a segment takes moduli and a radius, or what is per length as section=lissom.Section.given(stiffness=(GJ, EI_y, EI_z, EA, GA_y, GA_z), mass=...)";

/// The known word that a symbol stands for, one that ends with the word (`orientation` may mean `base_orientation`), or the one
/// most similar to it, if any is similar enough; the first one of equals.
pub fn suggestion<'a>(word: &str, known: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    let known: Vec<_> = known.collect();
    if let Some(names) = stood_for(word)
        && let Some(found) = names.iter().find_map(|name| known.iter().find(|other| *other == name))
    {
        return Some(found);
    }
    let is_end = |name: &&&str| name.strip_suffix(word).is_some_and(|begin| begin.ends_with('_'));
    if let Some(found) = known.iter().find(is_end) {
        return Some(found);
    }
    let word = word.to_lowercase();
    known
        .into_iter()
        .map(|other| (strsim::jaro_winkler(&word, other), other))
        .filter(|(similarity, _)| *similarity >= SIMILARITY)
        .min_by(|a, b| b.0.total_cmp(&a.0))
        .map(|(_, other)| other)
}

/// Symbols have a case, words of other programs do not: `BDF` is `bdf`.
fn stood_for(word: &str) -> Option<&'static [&'static str]> {
    let of = |word: &str| SYMBOLS.iter().find(|(symbol, _)| *symbol == word).map(|(_, names)| *names);
    of(word).or_else(|| (word.len() > LONGEST_SYMBOL).then(|| of(&word.to_lowercase())).flatten())
}

/// What to write in place of an unknown keyword, in words of Python; `None` if nothing is like it.
pub fn keyword<'a>(word: &str, known: impl Iterator<Item = &'a str>) -> Option<String> {
    let meant = suggestion(word, known)?;
    let is_of_sections = meant == "section" && SYMBOLS.iter().any(|(symbol, _)| *symbol == word);
    Some(if is_of_sections { BY_STIFFNESS.to_owned() } else { format!("did you mean '{meant}'?") })
}

/// Maximum number of names listed in messages.
pub const LISTED: usize = 12;

/// Maximum number of names among which a similar one is searched: every unknown name is compared with all of them.
const COMPARED: usize = 300;

/// Words in quotes, separated by this.
pub fn quoted(words: &[&str], between: &str) -> String {
    words.iter().map(|word| format!("\"{word}\"")).collect::<Vec<_>>().join(between)
}

/// Advice for an unknown word.
pub fn expected_one_of(word: &str, words: &[&str]) -> String {
    let expected = quoted(words, " or ");
    match suggestion(word, words.iter().copied()) {
        Some(similar) => format!("did you mean \"{similar}\"? Expected {expected}"),
        None => format!("expected {expected}"),
    }
}

/// Advice for an unknown name: all valid names, unless there are many.
pub fn expected_name(name: &str, names: &[&str], what: &str) -> String {
    if names.len() <= LISTED {
        return expected_one_of(name, names);
    }
    match similar(name, names) {
        Some(similar) => format!("did you mean \"{similar}\"?"),
        None => format!("expected one of {} {what}s, such as \"{}\"", names.len(), names[0]),
    }
}

/// The most similar of some names, unless they are too many to compare.
pub fn similar<'a>(name: &str, names: &[&'a str]) -> Option<&'a str> {
    if names.len() <= COMPARED { suggestion(name, names.iter().copied()) } else { None }
}

#[cfg(test)]
mod tests {
    use super::*;

    const OF_SEGMENT: [&str; 5] = ["length", "radius", "young_modulus", "shear_modulus", "retardation_time"];

    #[test]
    fn symbols_stand_for_names_that_are_known() {
        let meant = |word| suggestion(word, OF_SEGMENT.into_iter());
        assert_eq!(
            ["E", "G", "L", "r", "tau", "damping"].map(meant),
            [2, 3, 0, 1, 4, 4].map(|i| Some(OF_SEGMENT[i]))
        );
        // Neither symbols of what is not there, nor their letters in other words.
        assert_eq!(["rho", "F", "e"].map(meant), [None; 3]);
        assert_eq!(meant("youngs_modulus"), Some("young_modulus"));
        assert_eq!(meant("modulus"), Some("young_modulus"));
        // Words are written in any case, symbols are not.
        let method = |word| suggestion(word, ["rk45", "dop853", "radau", "section"].into_iter());
        assert_eq!(["BDF", "LSODA"].map(method), [Some("radau"); 2]);
        assert_eq!(["Ode45", "RK4"].map(method), [Some("rk45"); 2]);
        assert_eq!(method("ei"), None);
    }

    #[test]
    fn stiffnesses_of_sections_say_how_segments_take_them() {
        let said = |word| keyword(word, OF_SEGMENT.into_iter().chain(["section", "modes"]));
        assert_eq!(said("EI"), Some(BY_STIFFNESS.to_owned()));
        assert_eq!(said("n_modes"), Some("did you mean 'modes'?".to_owned()));
        assert_eq!(said("nonsense"), None);
    }
}
