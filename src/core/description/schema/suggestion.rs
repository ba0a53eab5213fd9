//! Suggestions for unknown words.

/// Smallest similarity (Jaro and Winkler 1990, 0 to 1) at which a known word is suggested.
const SIMILARITY: f64 = 0.8;

/// Symbols and words of other programs, and the names that they may stand for; the first that is known counts.
const SYMBOLS: [(&str, &[&str]); 35] = [
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
    ("T", &["tension"]),
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
    ("lsoda", &["auto"]),
];

/// The known word that a symbol stands for, or the one most similar to `word`, if any is similar enough; the first one of
/// equals.
pub fn suggestion<'a>(word: &str, known: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    let known: Vec<_> = known.collect();
    if let Some((_, names)) = SYMBOLS.iter().find(|(symbol, _)| *symbol == word)
        && let Some(found) = names.iter().find_map(|name| known.iter().find(|other| *other == name))
    {
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
    }
}
