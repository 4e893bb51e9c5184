//! Places and axes of sensors spelt out, by tables in `codes/`: a code, a blank, its words.

/// Codes of NHTSA's databases: attachments, then what follows them.
const NHTSA: &str = include_str!("codes/nhtsa.txt");

/// Main locations of ISO/TS 13499.
const ISO_MME: &str = include_str!("codes/iso-mme.txt");

/// Returns the words of a place with its axis: of an attachment with its axis, `DSRF YG`, or of a
/// channel code of 16 characters; `None` where the tables do not know it.
pub fn spelt(code: &str) -> Option<String> {
    let code = code.trim();
    if code.len() == 16 && code.is_ascii() && !code.contains(' ') {
        let mut words = vec![word(ISO_MME, &code[2..6])?];
        let fine = [6, 8, 10].map(|start| fine_location(&code[start..start + 2]));
        let side = match code.as_bytes()[1] {
            b'1' | b'4' | b'7' => Some("left"),
            b'3' | b'6' | b'9' => Some("right"),
            _ => None,
        };
        let names_side = fine.contains(&Some("left")) || fine.contains(&Some("right"));
        words.extend(side.filter(|_| !names_side));
        words.extend(fine.into_iter().flatten());
        return Some(format!("{}{}", words.join(", "), axis(&code[14..15])));
    }
    let (place, direction) = code.split_once(' ')?;
    Some(format!("{}{}", word(NHTSA, place)?, axis(direction)))
}

/// Returns the word of a fine location of ISO/TS 13499, of which a code has three.
fn fine_location(code: &str) -> Option<&'static str> {
    Some(match code.to_ascii_uppercase().as_str() {
        "FR" => "front",
        "LE" => "left",
        "LO" => "lower",
        "MI" => "middle",
        "RE" => "rear",
        "RI" => "right",
        "UP" => "upper",
        _ => return None,
    })
}

fn axis(direction: &str) -> String {
    let letter = direction.chars().next().map(|c| match c {
        '1' => 'X',
        '2' => 'Y',
        '3' => 'Z',
        other => other.to_ascii_uppercase(),
    });
    match letter {
        Some(letter @ ('X' | 'Y' | 'Z')) if direction.ends_with(['L', 'l']) => {
            format!(", {letter} (local axes)")
        }
        Some(letter @ ('X' | 'Y' | 'Z')) => format!(", {letter}"),
        _ => String::new(),
    }
}

fn word(table: &'static str, code: &str) -> Option<&'static str> {
    let lines = table.lines().filter(|line| !line.starts_with('#'));
    let mut entries = lines.filter_map(|line| line.split_once(' '));
    let entry = entries.find(|(entry_code, _)| entry_code.eq_ignore_ascii_case(code));
    entry.map(|(_, words)| words)
}

#[cfg(test)]
mod tests {
    use super::spelt;

    #[test]
    fn val_codes_are_spelt_out_by_their_tables() {
        for (code, words) in [
            ("DSRF YG", Some("door sill, right front, Y")),
            ("VECG YG", Some("vehicle centre of gravity, Y")),
            ("11SILLLE0000ACYP", Some("door sill, left, Y")),
            ("11SILL000000ACYP", Some("door sill, left, Y")),
            ("11DOORLEFR00ACYP", Some("door, left, front, Y")),
            ("16BPILRILO00AC2P", Some("B-pillar, right, lower, Y")),
            ("ZZZZ YG", None),
            ("somewhere", None),
        ] {
            assert_eq!(spelt(code).as_deref(), words, "{code}");
        }
    }
}
