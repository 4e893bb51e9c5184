//! Numbers in a name that may be factors on its samples: `0.1 ay`, `10 ay`, `1/10 ay`.
//!
//! A number that counts sensors is whole: `ay 2`, `12 acc y`, `acc_y_10`. No name says whether a factor was
//! applied already, so that a person states the unit of what the column holds.

/// Returns the number of a name that may be a factor: one with a decimal sign, a power of ten before the
/// words, or a tenth, hundredth and so on as a fraction.
pub(super) fn factor_in(label: &str) -> Option<String> {
    let label = label.trim();
    let is_of_number = |c: char| c.is_ascii_digit() || matches!(c, '.' | ',' | '/');
    let mut rest = label;
    while let Some(start) = rest.find(|c: char| c.is_ascii_digit()) {
        let is_in_word = rest[..start].ends_with(|c: char| c.is_alphanumeric());
        let tail = &rest[start..];
        let end = tail.find(|c| !is_of_number(c)).unwrap_or(tail.len());
        let number = tail[..end].trim_end_matches(['.', ',', '/']);
        let begins = rest.len() == label.len() && start == 0;
        if !is_in_word && (is_fraction(number) || (begins && is_power_of_ten(number))) {
            return Some(number.to_string());
        }
        rest = &tail[end..];
    }
    None
}

/// True of `0.1`, `0,25`, `1/10`; false of whole numbers and of versions such as `1.2.3`.
fn is_fraction(number: &str) -> bool {
    let parts: Vec<&str> = number.split(['.', ',', '/']).collect();
    let [whole, part] = parts.as_slice() else {
        return false;
    };
    match number.contains('/') {
        // `1/2` may be the first of two.
        true => *whole == "1" && is_power_of_ten(part),
        false => !whole.is_empty() && !part.is_empty(),
    }
}

/// True of `10`, `100`, `1000`.
fn is_power_of_ten(number: &str) -> bool {
    number.len() > 1 && number.trim_end_matches('0') == "1"
}

#[cfg(test)]
mod tests {
    use super::factor_in;

    #[test]
    fn verif_factors_are_told_from_numbers_of_sensors() {
        for (name, factor) in [
            ("0.1 ay", Some("0.1")),
            ("0,1 ay", Some("0,1")),
            ("ay 0.25", Some("0.25")),
            ("ay (0.01)", Some("0.01")),
            ("10 ay", Some("10")),
            ("1000 ay", Some("1000")),
            ("1/10 ay", Some("1/10")),
            ("1 ay", None),
            ("2 ay", None),
            ("12 acc y", None),
            ("20 acc y", None),
            ("ay 10", None),
            ("acc_y_10", None),
            ("acc 1/2 y", None),
            ("acc 14/23 y", None),
            ("v1.2 ay", None),
            ("ay 1.2.3", None),
            ("ay.2", None),
            ("ay", None),
            ("", None),
        ] {
            assert_eq!(factor_in(name).as_deref(), factor, "{name}");
        }
    }
}
