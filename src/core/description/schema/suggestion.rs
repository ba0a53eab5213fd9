//! Suggestions for unknown words.

use super::data::{Kind, Schema};

/// Smallest similarity (Jaro and Winkler 1990, 0 to 1) at which a known word is suggested.
const SIMILARITY: f64 = 0.8;

/// Symbols of formulas have no more letters.
const LONGEST_SYMBOL: usize = 2;

/// Symbols and words of other programs, and the names that they may stand for; the first that is known counts.
const SYMBOLS: &[(&str, &[&str])] = &[
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
    ("d", &["damping", "radius"]),
    ("D", &["radius"]),
    ("mu", &["friction"]),
    ("tau", &["torque", "retardation_time"]),
    ("F", &["force", "tip_force"]),
    ("M", &["moment", "tip_moment"]),
    ("T", &["tension", "t_end"]),
    ("p", &["pressure"]),
    ("f", &["frequency"]),
    ("diameter", &["radius", "outer", "area"]),
    ("outer_diameter", &["outer", "radius"]),
    ("inner_diameter", &["inner"]),
    ("wall_thickness", &["inner"]),
    ("thickness", &["inner"]),
    ("size", &["half_extents"]),
    ("radius", &["area"]),
    ("lower", &["limits"]),
    ("upper", &["limits"]),
    ("max_torque", &["limits"]),
    ("max_force", &["limits"]),
    ("effort", &["limits"]),
    ("com", &["centre"]),
    ("cog", &["centre"]),
    ("centre_of_mass", &["centre"]),
    ("center_of_mass", &["centre"]),
    ("offset", &["path", "position"]),
    ("translation", &["position", "base_position"]),
    ("origin", &["position", "base_position"]),
    ("pos", &["position", "base_position", "centre"]),
    ("xyz", &["position", "base_position"]),
    ("offsets", &["path"]),
    ("routing", &["path"]),
    ("points", &["path"]),
    ("bend", &["bend_y"]),
    ("bending", &["bend_y"]),
    ("curvature", &["bend_y"]),
    ("twist", &["torsion"]),
    ("twisting", &["torsion"]),
    ("stretching", &["stretch"]),
    ("extension", &["stretch"]),
    ("elongation", &["stretch"]),
    ("compression", &["stretch"]),
    ("axial", &["stretch"]),
    ("shear", &["shear_z"]),
    ("continuous", &["revolute"]),
    ("hinge", &["revolute"]),
    ("slide", &["prismatic"]),
    ("slider", &["prismatic"]),
    ("fixed", &["weld"]),
    ("rigid", &["weld"]),
    ("ball", &["spherical"]),
    ("floating", &["free"]),
    ("freejoint", &["free"]),
    ("damping", &["retardation_time"]),
    ("position", &["base_position", "pose"]),
    ("orientation", &["base_orientation", "pose"]),
    ("quat", &["orientation", "base_orientation"]),
    ("quaternion", &["orientation", "base_orientation"]),
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
    ("force", &["tension", "torque"]),
    ("pull", &["tension"]),
    ("pose", &["target"]),
    ("tension", &["u"]),
    ("tensions", &["u"]),
    ("pressures", &["u"]),
    ("torques", &["u"]),
    ("action", &["u"]),
    ("tendons", &["actuators"]),
    ("cables", &["actuators"]),
    ("muscles", &["actuators"]),
    ("motors", &["actuators"]),
    ("chambers", &["actuators"]),
    ("forces", &["loads"]),
    ("joints", &["links"]),
    ("fprime", &["jac"]),
    ("jacobian", &["jac"]),
    ("tip_load", &["tip_force"]),
    ("end_force", &["tip_force"]),
    ("tip_torque", &["tip_moment"]),
    ("t_span", &["t_end"]),
    ("t_max", &["t_end"]),
    ("tmax", &["t_end"]),
    ("t_stop", &["t_end"]),
    ("final_time", &["t_end"]),
    ("tspan", &["t_end"]),
    ("t_final", &["t_end"]),
    ("tf", &["t_end"]),
    ("duration", &["t_end"]),
    ("timestep", &["dt"]),
    ("time_step", &["dt"]),
    ("step", &["dt"]),
    ("h", &["dt"]),
    ("x0", &["q0", "q"]),
    ("y0", &["q0"]),
    ("start", &["q0"]),
    ("callback", &["progress"]),
    ("qd0", &["v0"]),
    ("u0", &["u"]),
    ("inputs", &["u", "control"]),
    ("input", &["inputs", "u", "control"]),
    ("targets", &["target", "pose"]),
    ("time", &["t"]),
    ("dt", &["duration", "max_step"]),
    ("controller", &["control"]),
    ("joint", &["kind"]),
    ("maxiter", &["max_iter"]),
    ("x", &["X", "at"]),
    ("X", &["at"]),
    ("s", &["X", "at"]),
    ("arc_length", &["X", "at"]),
    ("color", &["colour"]),
    ("std", &["noise"]),
    ("sigma", &["noise"]),
    ("frequency", &["rate"]),
    ("sample_rate", &["rate"]),
];

/// What to know of values that are not those of the word: words, names that are known, of which the first is meant, and the remark.
const REMARKS: &[(&[&str], &[&str], &str)] = &[
    (DIAMETERS, &["radius"], "It is half the diameter"),
    (DIAMETERS, &["outer"], "It is a radius, half the diameter"),
    (DIAMETERS, &["inner"], "It is a radius, half the diameter"),
    (&["wall_thickness", "thickness"], &["inner"], "It is the outer radius less the thickness"),
    (&["size"], &["half_extents"], "They are half the lengths of the edges"),
    (&["radius"], &["area"], "It is pi radius^2"),
    (&["diameter"], &["area"], "It is pi/4 diameter^2"),
    (
        &["lower", "upper"],
        &["limits", "limit_stiffness"],
        "They are the pair (lower, upper), with the `limit_stiffness` of the stops",
    ),
    (
        &["lower", "upper", "max_torque", "max_force", "effort"],
        &["limits"],
        "They are the pair of the lowest and the highest torque or force",
    ),
    (
        &["offset", "offsets", "routing", "points"],
        &["path"],
        "It is a list of parts: along a rod with `offset` (y, z) from its axis, and points between which the tendon runs straight",
    ),
    (
        &["bend", "bending", "curvature"],
        &["bend_y", "bend_z"],
        "It bends in the plane of x and z, `bend_z` in that of x and y",
    ),
    (&["shear"], &["shear_z", "shear_y"], "It goes with `bend_y`, `shear_y` with `bend_z`"),
];

/// What to write in place of words that stand for no single name: the words, names that are known, and the sentence.
const SENTENCES: &[(&[&str], &[&str], &str)] = &[
    (&["material"], &["young_modulus", "density"], MATERIALS),
    (&["radius", "r", "diameter", "d", "D"], &["stiffness", "mass", "inertia", "centre"], NO_RADIUS),
    (&["radius", "r", "diameter", "d", "D"], &["centre_of_volume"], NO_SURFACE),
];

/// The same in words of Python.
const SENTENCES_OF_PYTHON: &[(&[&str], &[&str], &str)] = &[
    (&["bracket", "bounds", "x1"], &["fun", "x0"], NO_BRACKET),
    (&["radius", "angle", "distance"], &["path", "tension"], NO_ANGLE),
    (&["M", "C", "K", "mass", "stiffness", "damping", "force"], &["residual", "t_span"], NO_MATRICES),
    (&["kp", "kd", "kv", "Kp", "Kd"], &["gains", "position"], "gains=(kp, kd), with a `position` to hold"),
    (
        &["min", "max", "low", "high", "lower", "upper", "limits"],
        &["name", "default"],
        "`limits` belong to what it drives, such as a Motor",
    ),
    (&["omega", "w"], &["amplitude", "frequency"], "frequency=omega / (2 * pi), in Hz"),
    (&["save", "output", "filename", "path"], &["model", "t_end"], "the result has `save(path)`"),
    (
        &["accuracy"],
        &["load_steps", "space_error"],
        "the accuracy of the shape is `rtol`, relative to the length",
    ),
    (&["gravity", "g"], &["model", "u"], "it belongs to the model: lissom.Rod(..., gravity=(0, 0, 0))"),
    (
        &["output_dt", "save_every", "sample_time", "n_steps", "steps", "num_steps"],
        &["t_end", "t_eval"],
        NO_STEPS,
    ),
];

/// Words for a diameter.
const DIAMETERS: &[&str] = &["d", "D", "diameter", "outer_diameter", "inner_diameter"];

/// What a start of a search and a bracket are.
const NO_BRACKET: &str = "it searches from one start, such as x0=0.5 * (a + b); `scipy.optimize.brentq(fun, a, b)` takes a bracket";

/// How equations of motion are given.
const NO_MATRICES: &str =
    "equations are a function, of matrices `lambda t, q, v, a: M @ a + C @ v + K @ q - f(t)`";

/// How times of results are given.
const NO_STEPS: &str = "times of the result are t_eval=numpy.linspace(t0, t_end, 101)";

/// How a tendon is laid along a rod.
const NO_ANGLE: &str = "it runs along a rod at the distances (y, z) from its axis: at radius r and angle phi \
     path=[lissom.Along(offset=(r * cos(phi), r * sin(phi)))]";

/// What to give for a material.
const MATERIALS: &str = "materials have no names, their numbers are given: `young_modulus` in Pa, `poisson_ratio` or \
     `shear_modulus`, and `density` in kg/m^3, such as 2.1e11, 0.3 and 7850 for steel, 1e6, 0.49 and 1100 for rubber";

/// What the size of a given section is.
const NO_RADIUS: &str = "a given section has no radius: what touches is the ellipse of its `mass` m and `inertia`, \
     (m r^2 / 2, m r^2 / 4, m r^2 / 4) of a circle, whose radius r is half the diameter";

/// What the size of a body is.
const NO_SURFACE: &str = "a body has no surface: what touches is a ball, sphere, box or capsule on its link, and its size is in its `inertia`";

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

/// Whether a row is about this word where these names are known.
fn fits((words, names, _): &(&[&str], &[&str], &str), word: &str, known: &[&str]) -> bool {
    words.contains(&word) && names.iter().all(|name| known.contains(name))
}

/// The name that an unknown word may stand for, between these marks, and what to know of its value; `None` if nothing is like it.
pub fn did_you_mean<'a>(word: &str, known: impl Iterator<Item = &'a str>, mark: &str) -> Option<String> {
    let known: Vec<_> = known.collect();
    if let Some((.., sentence)) = SENTENCES.iter().find(|row| fits(row, word, &known)) {
        return Some((*sentence).to_owned());
    }
    let meant = suggestion(word, known.iter().copied())?;
    let remark = REMARKS
        .iter()
        .find(|row| fits(row, word, &known) && row.1[0] == meant)
        .map_or_else(String::new, |(.., remark)| format!(" {remark}"));
    Some(format!("did you mean {mark}{meant}{mark}?{remark}"))
}

/// The end of a message about an unknown word: the name that it may stand for, or nothing.
pub fn or_meant<'a>(word: &str, known: impl Iterator<Item = &'a str>) -> String {
    did_you_mean(word, known, "'").map_or_else(String::new, |meant| format!("; {meant}"))
}

/// Symbols have a case, words of other programs do not: `BDF` is `bdf`.
fn stood_for(word: &str) -> Option<&'static [&'static str]> {
    let of = |word: &str| SYMBOLS.iter().find(|(symbol, _)| *symbol == word).map(|(_, names)| *names);
    of(word).or_else(|| (word.len() > LONGEST_SYMBOL).then(|| of(&word.to_lowercase())).flatten())
}

/// What to write in place of an unknown keyword, in words of Python; `None` if nothing is like it.
fn keyword(word: &str, known: &[&str]) -> Option<String> {
    if let Some((.., sentence)) = SENTENCES_OF_PYTHON.iter().find(|row| fits(row, word, known)) {
        return Some((*sentence).to_owned());
    }
    let is_of_sections = SYMBOLS.iter().any(|(symbol, names)| *symbol == word && *names == ["section"]);
    if is_of_sections && known.contains(&"section") {
        return Some(BY_STIFFNESS.to_owned());
    }
    did_you_mean(word, known.iter().copied(), "'")
}

/// What is said of keywords that a call does not take, all of them at once, in words of Python; `elsewhere` says where a word belongs
/// that is like none of those that are known.
pub fn unexpected(words: &[&str], known: &[&str], elsewhere: impl Fn(&str) -> Option<String>) -> String {
    let expected = known.join(", ");
    if let [word] = words {
        let meant = keyword(word, known).or_else(|| elsewhere(word));
        let meant = meant.map_or_else(String::new, |meant| format!("; {meant}"));
        return format!("got an unexpected keyword argument '{word}', expected {expected}{meant}");
    }
    let own: Vec<_> = words.iter().map(|word| keyword(word, known)).collect();
    // A sentence about several words is said once.
    let each = |(i, word): (usize, &&str)| match &own[i] {
        Some(_) if own[i + 1..].contains(&own[i]) => format!("'{word}'"),
        Some(meant) => format!("'{word}' ({meant})"),
        None => elsewhere(word).map_or(format!("'{word}'"), |meant| format!("'{word}' ({meant})")),
    };
    let all: Vec<_> = words.iter().enumerate().map(each).collect();
    format!("got unexpected keyword arguments {}, expected {expected}", all.join(", "))
}

/// Where a word belongs that a part does not take: the nearest part within it that takes it, or what the word stands for.
pub fn within(part: &'static Schema, word: &str) -> Option<String> {
    let stands_for = SYMBOLS.iter().find(|(symbol, _)| *symbol == word).map_or(&[][..], |(_, names)| names);
    let mut seen = vec![part];
    let mut next = 0;
    while let Some(schema) = seen.get(next).copied() {
        next += 1;
        if next > 1 {
            let class = schema.maker();
            if schema.index(word).is_some() {
                return Some(format!("it belongs to lissom.{class}"));
            }
            if let Some(name) = stands_for.iter().find(|name| schema.index(name).is_some()) {
                let meant = did_you_mean(word, [*name].into_iter(), "'")?.replacen(
                    '?',
                    &format!(" of lissom.{class}?"),
                    1,
                );
                return Some(meant);
            }
        }
        for schema in schema.fields.iter().flat_map(|field| parts_of(&field.kind)) {
            if !seen.iter().any(|known| std::ptr::eq(*known, schema)) {
                seen.push(schema);
            }
        }
    }
    None
}

/// The parts that a value of this kind consists of.
fn parts_of(kind: &'static Kind) -> Vec<&'static Schema> {
    match kind {
        Kind::Part(schema) => vec![*schema],
        Kind::List(inner) | Kind::Optional(inner) | Kind::Open(inner) => parts_of(inner),
        Kind::OneOf(_, kinds) => kinds.iter().flat_map(parts_of).collect(),
        _ => Vec::new(),
    }
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
    match did_you_mean(word, words.iter().copied(), "\"") {
        Some(meant) if meant.ends_with('?') => format!("{meant} Expected {expected}"),
        Some(meant) => format!("{meant}. Expected {expected}"),
        None => format!("expected {expected}"),
    }
}

/// Advice for an unknown name: all valid names, unless there are many.
pub fn expected_name(name: &str, names: &[&str], what: &str) -> String {
    if names.len() <= LISTED {
        return expected_one_of(name, names);
    }
    match did_you_mean(name, compared(names), "\"") {
        Some(meant) => meant,
        None => format!("expected one of {} {what}s, such as \"{}\"", names.len(), names[0]),
    }
}

/// The names among which a similar one is searched: none if they are too many.
pub fn compared<'a>(names: &'a [&'a str]) -> impl Iterator<Item = &'a str> {
    let names = if names.len() <= COMPARED { names } else { &[] };
    names.iter().copied()
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
    fn values_that_are_others_than_those_of_the_word_are_explained() {
        let said = |word| did_you_mean(word, OF_SEGMENT.into_iter(), "`");
        let expected = "did you mean `radius`? It is half the diameter";
        assert_eq!(["diameter", "d", "D"].map(said), [(); 3].map(|()| Some(expected.to_owned())));
        assert_eq!(said("r"), Some("did you mean `radius`?".to_owned()));
        // A tube says which radius.
        assert_eq!(
            did_you_mean("inner_diameter", ["outer", "inner"].into_iter(), "'"),
            Some("did you mean 'inner'? It is a radius, half the diameter".to_owned())
        );
    }

    #[test]
    fn all_unknown_words_are_answered_at_once() {
        assert_eq!(
            unexpected(&["E", "zzz", "diameter"], &OF_SEGMENT, |_| None),
            "got unexpected keyword arguments 'E' (did you mean 'young_modulus'?), 'zzz', 'diameter' (did you mean 'radius'? It is \
             half the diameter), expected length, radius, young_modulus, shear_modulus, retardation_time"
        );
        assert_eq!(
            unexpected(&["zzz"], &["a", "b"], |_| Some("it belongs to c".to_owned())),
            "got an unexpected keyword argument 'zzz', expected a, b; it belongs to c"
        );
    }

    #[test]
    fn remarks_are_of_words_that_stand_for_the_name() {
        for (words, names, _) in REMARKS {
            for word in *words {
                let symbol = SYMBOLS.iter().find(|(symbol, _)| symbol == word);
                let meant = |(_, meant): &(&str, &[&str])| meant.contains(&names[0]);
                // Not every word for a diameter is one of every radius.
                assert!(symbol.is_some_and(meant) || DIAMETERS.contains(word), "{word}: {names:?}");
            }
        }
    }

    #[test]
    fn stiffnesses_of_sections_say_how_segments_take_them() {
        let said = |word| keyword(word, &[&OF_SEGMENT[..], &["section", "modes"]].concat());
        assert_eq!(said("EI"), Some(BY_STIFFNESS.to_owned()));
        assert_eq!(said("n_modes"), Some("did you mean 'modes'?".to_owned()));
        assert_eq!(said("nonsense"), None);
    }
}
