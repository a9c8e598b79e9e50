//! Which column is what: as the user says, or by a name that many loggers use.

use super::Quantity;

/// A column that the user named.
#[derive(Clone, Debug, PartialEq)]
pub struct Mapping {
    /// What it holds.
    pub quantity: Quantity,
    /// Its name.
    pub column: String,
    /// What makes an SI unit of its unit, if the user gave one.
    pub factor: Option<f64>,
}

/// Reads `left_counts=enc_l,t_s=stamp:ns`; the error says what is wrong and what would be right.
pub fn parse_mappings(text: &str) -> Result<Vec<Mapping>, String> {
    text.split(',').map(|part| parse_mapping(part.trim())).collect()
}

fn parse_mapping(text: &str) -> Result<Mapping, String> {
    let example =
        "must be NAME=COLUMN or NAME=COLUMN:UNIT, for example left_counts=enc_l,t_s=stamp:ns";
    let (name, column) = text.split_once('=').ok_or(example)?;
    let (name, column) = (name.trim(), column.trim());
    if column.is_empty() {
        return Err(example.to_owned());
    }
    let Some(quantity) = Quantity::ALL.into_iter().find(|known| known.name() == name) else {
        let known: Vec<&str> = Quantity::ALL.iter().map(|known| known.name()).collect();
        return Err(format!("`{name}` is none of {}", known.join(", ")));
    };
    let Some((column, unit)) = column.rsplit_once(':') else {
        return Ok(Mapping { quantity, column: column.to_owned(), factor: None });
    };
    match quantity.factor(unit.trim()) {
        Some(factor) => {
            Ok(Mapping { quantity, column: column.trim().to_owned(), factor: Some(factor) })
        }
        None if quantity.units().is_empty() => Err(format!("{name} has no unit")),
        None => {
            let known: Vec<&str> = quantity.units().iter().map(|(name, _)| *name).collect();
            Err(format!("`{unit}` is not a unit of {name}, which may be in {}", known.join(", ")))
        }
    }
}

/// A column as its header names it: what it holds, if that is certain, and the factor of its unit, if the name has one.
///
/// `timestamp [ns]`, `yaw_deg`, `x_mm`, `p_RS_R_x [m]`.
pub(crate) fn by_name(header: &str) -> Option<(Quantity, Option<f64>)> {
    let name = header.to_ascii_lowercase();
    let (name, bracket) = match name.split_once(['[', '(']) {
        Some((name, unit)) => {
            (name.trim().to_owned(), Some(unit.trim_end_matches([']', ')']).trim().to_owned()))
        }
        None => (name.trim().to_owned(), None),
    };
    for quantity in Quantity::ALL {
        let is_named =
            |plain: &str| quantity.name() == plain || quantity.usual_names().contains(&plain);
        if is_named(&name) {
            let unit = match &bracket {
                Some(unit) => quantity.factor(unit),
                // Our own names have their unit at their end.
                None if quantity.name() == name && !quantity.units().is_empty() => Some(1.0),
                None => None,
            };
            return Some((quantity, unit));
        }
        if let Some((plain, unit)) = name.rsplit_once('_')
            && let (true, Some(factor)) =
                (is_named(plain) || is_stem(quantity, plain), quantity.factor(unit))
        {
            return Some((quantity, Some(factor)));
        }
    }
    None
}

/// `x` of `x_m`.
fn is_stem(quantity: Quantity, plain: &str) -> bool {
    !quantity.units().is_empty()
        && quantity.name().rsplit_once('_').is_some_and(|(stem, _)| stem == plain)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mapping_has_a_quantity_a_column_and_perhaps_a_unit() {
        let parsed = parse_mappings("left_counts=enc_l, t_s=stamp:ns").unwrap();
        assert_eq!(
            parsed[0],
            Mapping { quantity: Quantity::LeftCounts, column: "enc_l".into(), factor: None }
        );
        assert_eq!(
            parsed[1],
            Mapping { quantity: Quantity::Time, column: "stamp".into(), factor: Some(1e-9) }
        );
        for (wrong, says) in [
            ("left", "must be NAME=COLUMN"),
            ("t_s=", "must be NAME=COLUMN"),
            ("links=a", "is none of t_s,"),
            ("t_s=stamp:h", "which may be in s, ms, us, ns"),
            ("left_counts=enc:rad", "has no unit"),
        ] {
            let error = parse_mappings(wrong).unwrap_err();
            assert!(error.contains(says), "{wrong}: {error}");
        }
    }

    #[test]
    fn usual_names_are_known_with_their_units() {
        let degree = std::f64::consts::PI / 180.0;
        for (header, quantity, factor) in [
            ("t_s", Quantity::Time, Some(1.0)),
            ("timestamp [ns]", Quantity::Time, Some(1e-9)),
            ("time_ms", Quantity::Time, Some(1e-3)),
            ("Time", Quantity::Time, None),
            ("x_mm", Quantity::X, Some(1e-3)),
            ("p_RS_R_y [m]", Quantity::Y, Some(1.0)),
            ("yaw_deg", Quantity::Heading, Some(degree)),
            ("q_RS_w []", Quantity::QuaternionW, None),
            ("left_deg", Quantity::LeftAngle, Some(degree)),
            ("left_counts", Quantity::LeftCounts, None),
        ] {
            assert_eq!(by_name(header), Some((quantity, factor)), "{header}");
        }
        assert_eq!(by_name("left_current_a"), None);
    }
}
