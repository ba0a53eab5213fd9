//! Formatting of numbers and lists.

/// Whether something is computed or skipped, its name, and why.
pub(crate) type Explained = (bool, String, String);

/// `1 link`, `2 links`.
pub(crate) fn counted(number: usize, what: &str) -> String {
    format!("{number} {what}{}", if number == 1 { "" } else { "s" })
}

/// `a, b and c`.
pub(crate) fn listed(items: impl IntoIterator<Item = String>) -> String {
    let mut items: Vec<String> = items.into_iter().collect();
    match items.pop() {
        Some(last) if !items.is_empty() => format!("{} and {last}", items.join(", ")),
        last => last.unwrap_or_default(),
    }
}

/// A fraction in percent.
pub(crate) fn percent(part: u64, whole: u64) -> String {
    // Avoid a division by zero.
    format!("{:4.1} %", 100.0 * part as f64 / whole.max(1) as f64)
}

/// A number with commas between thousands.
pub(crate) fn grouped(number: u64) -> String {
    let digits = number.to_string();
    let mut text = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

/// A number that is not negative with four significant digits, without zeros at the end; very small and large ones with an exponent.
pub(crate) fn significant(x: f64) -> String {
    const DIGITS: usize = 4;
    let trimmed = |text: &str| match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
        false => text.to_owned(),
    };
    if x == 0.0 || (1e-4..1e6).contains(&x) {
        let decimals = if x > 0.0 { (DIGITS as f64 - 1.0 - x.log10().floor()).max(0.0) as usize } else { 0 };
        return trimmed(&format!("{x:.decimals$}"));
    }
    let text = format!("{x:.*e}", DIGITS - 1);
    text.split_once('e')
        .map_or_else(|| text.clone(), |(digits, power)| format!("{}e{power}", trimmed(digits)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_and_lists_read_well() {
        assert_eq!([0, 999, 1000, 1_234_567].map(grouped), ["0", "999", "1,000", "1,234,567"]);
        assert_eq!([counted(1, "link"), counted(0, "link")], ["1 link", "0 links"]);
        let list = |n: usize| listed(["a", "b", "c"].into_iter().take(n).map(str::to_owned));
        assert_eq!([list(0), list(1), list(2), list(3)], ["", "a", "a and b", "a, b and c"]);
        assert_eq!([percent(1, 8), percent(0, 0)], ["12.5 %", " 0.0 %"]);
        let numbers = [0.0, 0.3, 9.81, 24.0, 12_345.678, 1e-6, 2.5e12, f64::INFINITY].map(significant);
        assert_eq!(numbers, ["0", "0.3", "9.81", "24", "12346", "1e-6", "2.5e12", "inf"]);
    }
}
