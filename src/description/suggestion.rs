//! Suggestions for unknown words.

/// Smallest similarity (Jaro and Winkler 1990, 0 to 1) at which a known word is suggested.
const SIMILARITY: f64 = 0.8;

/// The known word most similar to `word`, if any is similar enough; the first one of equals.
pub(crate) fn suggestion<'a>(word: &str, known: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    let word = word.to_lowercase();
    known
        .map(|other| (strsim::jaro_winkler(&word, other), other))
        .filter(|(similarity, _)| *similarity >= SIMILARITY)
        .min_by(|a, b| b.0.total_cmp(&a.0))
        .map(|(_, other)| other)
}
