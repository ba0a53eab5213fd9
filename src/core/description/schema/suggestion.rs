//! Suggestions for unknown words.

/// Smallest similarity (Jaro and Winkler 1990, 0 to 1) at which a known word is suggested.
const SIMILARITY: f64 = 0.8;

/// The known word most similar to `word`, if any is similar enough; the first one of equals.
pub fn suggestion<'a>(word: &str, known: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    let word = word.to_lowercase();
    known
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
