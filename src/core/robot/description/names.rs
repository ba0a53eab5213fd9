//! Default names of parts.

use std::collections::{HashMap, HashSet};

/// Makes default names distinct: the second "ball on box" becomes "ball on box 2". `parts` are names, and whether they are default
/// ones; names of users stay, so that validation rejects equal ones.
pub(crate) fn number_default_names<'a>(parts: impl Iterator<Item = (&'a mut String, bool)>) {
    let (defaults, given): (Vec<_>, Vec<_>) = parts.partition(|(_, is_default)| *is_default);
    let mut taken: HashSet<String> = given.into_iter().map(|(name, _)| name.clone()).collect();
    let mut last: HashMap<String, usize> = HashMap::new();
    for (name, _) in defaults {
        if taken.insert(name.clone()) {
            continue;
        }
        let number = last.entry(name.clone()).or_insert(1);
        let numbered = loop {
            *number += 1;
            let numbered = format!("{name} {number}");
            if taken.insert(numbered.clone()) {
                break numbered;
            }
        };
        *name = numbered;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn default_names_give_way_to_each_other_and_to_given_ones() {
        let mut names = ["a", "a", "a 2", "a", "b", "b", "b"].map(str::to_owned);
        let is_default = [true, true, false, true, false, false, true];
        number_default_names(names.iter_mut().zip(is_default));
        assert_eq!(names, ["a", "a 3", "a 2", "a 4", "b", "b", "b 2"]);
    }
}
