//! Deterministic mutations of inputs.

use super::source::EXTREMES;

/// The generator of Steele, Lea and Flood (2014), SplitMix64.
#[derive(Debug)]
pub(crate) struct Random(pub(crate) u64);

impl Random {
    pub(crate) fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// A number below `end`; zero if `end` is zero.
    pub(crate) fn below(&mut self, end: usize) -> usize {
        (self.next() % (end.max(1) as u64)) as usize
    }

    pub(crate) fn bytes(&mut self, most: usize) -> Vec<u8> {
        (0..self.below(most + 1)).map(|_| self.next() as u8).collect()
    }
}

/// Changes random bytes.
pub(crate) fn mutate_bytes(random: &mut Random, input: &[u8], other: &[u8]) -> Vec<u8> {
    let mut bytes = input.to_vec();
    for _ in 0..1 + random.below(4) {
        let at = random.below(bytes.len() + 1);
        let end = (at + random.below(16)).min(bytes.len());
        match random.below(6) {
            0 => bytes.iter_mut().skip(at).take(1).for_each(|byte| *byte = random.next() as u8),
            1 => drop(bytes.drain(at..end)),
            2 => drop(bytes.splice(at..at, random.bytes(8))),
            3 => drop(bytes.splice(at..end, other.iter().copied().skip(at).take(16))),
            4 => drop(bytes.splice(at..at, bytes[at..end].to_vec())),
            _ => bytes.extend(random.bytes(64)),
        }
    }
    bytes
}

/// A replacement of a value: other types, extremes, sizes.
fn value(random: &mut Random) -> String {
    const VALUES: [&str; 22] = [
        "true",
        "\"text\"",
        "\"\"",
        "[]",
        "{}",
        "[[]]",
        "[0, 0, 0]",
        "[1.0]",
        "1979-05-27",
        "-1",
        "0",
        "inf",
        "-inf",
        "nan",
        "9223372036854775807",
        "1e400",
        "0x7fffffffffffffff",
        "\"auto\"",
        "[1e308, 1e308, 1e308]",
        "{ bend_y = 64 }",
        "{ stations = [0, 1], values = [1, 2] }",
        "\"\\u0000\"",
    ];
    match random.below(4) {
        0 => VALUES[random.below(VALUES.len())].to_owned(),
        1 => {
            let number = EXTREMES[random.below(EXTREMES.len())];
            if number.is_nan() { "nan".to_owned() } else { format!("{number:e}").replace("inf", "1e999") }
        }
        2 => format!("{}", random.below(1 << 20)),
        _ => format!("{:e}", f64::from_bits(random.next())).replace("NaN", "nan"),
    }
}

/// Changes a scene line by line: replaces values, repeats and removes lines, inserts lines of another scene,
/// and nests or repeats tables.
pub(crate) fn mutate_scene(random: &mut Random, input: &[u8], other: &[u8]) -> Vec<u8> {
    if random.below(5) == 0 {
        return mutate_bytes(random, input, other);
    }
    let text = String::from_utf8_lossy(input).into_owned();
    let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
    let other = String::from_utf8_lossy(other).into_owned();
    let others: Vec<&str> = other.lines().collect();
    for _ in 0..1 + random.below(3) {
        let at = random.below(lines.len());
        match random.below(12) {
            0..=5 => {
                if let Some(line) = lines.iter_mut().skip(at).find(|line| line.contains('='))
                    && let Some((key, _)) = line.clone().split_once('=')
                {
                    *line = format!("{key}= {}", value(random));
                }
            }
            6 => {
                // Changes one number of a line.
                if let Some(line) = lines.iter_mut().skip(at).find(|line| line.contains(['[', '='])) {
                    let starts: Vec<usize> = line
                        .char_indices()
                        .filter(|(i, c)| {
                            c.is_ascii_digit()
                                && !line[..*i].ends_with(|c: char| c.is_alphanumeric() || c == '.')
                        })
                        .map(|(i, _)| i)
                        .collect();
                    if let Some(&start) = starts.get(random.below(starts.len())) {
                        let is_of_number = |c: char| c.is_ascii_alphanumeric() || ".+-".contains(c);
                        let end =
                            line[start..].find(|c| !is_of_number(c)).map_or(line.len(), |end| start + end);
                        let number = value(random);
                        line.replace_range(start..end, &number);
                    }
                }
            }
            7 if !lines.is_empty() => drop(lines.remove(at)),
            8 if !lines.is_empty() => lines.insert(at, lines[at].clone()),
            9 if !others.is_empty() => {
                lines.insert(at, others[random.below(others.len())].to_owned());
            }
            10 => {
                let many = 1 << random.below(11);
                let block = lines[at..(at + 8).min(lines.len())].to_vec();
                for _ in 0..(many / block.len().max(1)).max(1) {
                    lines.extend(block.clone());
                }
            }
            _ => {
                let depth = 1 << random.below(10);
                let deep = match random.below(3) {
                    0 => format!("deep = {}1{}", "[".repeat(depth), "]".repeat(depth)),
                    1 => format!("{}deep = 1", "deep.".repeat(depth)),
                    _ => format!("[{}deep]", "rod.".repeat(depth)),
                };
                lines.insert(at, deep);
            }
        }
    }
    (lines.join("\n") + "\n").into_bytes()
}
