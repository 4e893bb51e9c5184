//! Names of columns as programs rewrite them to be names of variables: every sign becomes a point in R
//! (`make.names`: `ay (m/s^2)` is `ay..m.s.2.`) and an underscore in MATLAB (`ay_m_s_2_`).

use super::is_known_unit;

/// Returns name and unit of a rewritten `name (unit)`; `None` unless the unit is known.
pub(super) fn name_and_unit(cell: &str) -> Option<(String, String)> {
    let (mark, gap) = match cell.chars().last()? {
        '.' => ('.', ".."),
        '_' => ('_', "_"),
        _ => return None,
    };
    let inside = cell.strip_suffix(mark)?;
    let mut gaps = inside.match_indices(gap);
    gaps.find_map(|(index, _)| {
        let (name, written) = (&inside[..index], &inside[index + gap.len()..]);
        let unit = unit_of_parts(&written.split(mark).collect::<Vec<_>>())?;
        let is_name = name.contains(char::is_alphabetic) && !name.ends_with(mark);
        (is_name && is_known_unit(&unit)).then(|| (name.to_string(), unit))
    })
}

/// Returns the unit whose signs were lost between its parts: `m`, `s`, `2` is m/s^2.
fn unit_of_parts(parts: &[&str]) -> Option<String> {
    Some(match parts {
        [unit] => (*unit).to_string(),
        [length, time] => format!("{length}/{time}"),
        [length, time, "2"] => format!("{length}/{time}^2"),
        [length, time, again] if time == again => format!("{length}/{time}^2"),
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::name_and_unit;

    #[test]
    fn verif_units_of_rewritten_names_are_read() {
        for (cell, expected) in [
            ("ay..g.", Some(("ay", "g"))),
            ("ay_g_", Some(("ay", "g"))),
            ("acc_y_g_", Some(("acc_y", "g"))),
            ("ay..m.s.2.", Some(("ay", "m/s^2"))),
            ("ay_m_s_2_", Some(("ay", "m/s^2"))),
            ("ay..m.s2.", Some(("ay", "m/s2"))),
            ("ay_m_s_s_", Some(("ay", "m/s^2"))),
            ("t..s.", Some(("t", "s"))),
            ("Time_ms_", Some(("Time", "ms"))),
            ("ay..V.", None),
            ("ay_", None),
            ("ay.", None),
            ("_g_", None),
            ("..g.", None),
            ("ay..m.s.3.", None),
        ] {
            let read = name_and_unit(cell);
            let read = read.as_ref().map(|(name, unit)| (&**name, &**unit));
            assert_eq!(read, expected, "{cell}");
        }
    }
}
