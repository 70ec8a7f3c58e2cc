//! Units of fields, as the parameter file of a dump states them.

use std::collections::BTreeMap;

use crate::key_values::Text;

/// What the file says of the field with a number.
#[derive(Default)]
struct Label {
    name: String,
    /// In words.
    unit: Option<String>,
    /// What values are to be multiplied by to be in CGS units.
    factor: Option<f64>,
}

/// Units by the fields' names: in words or, where there are none, as a factor to CGS units.
pub(super) fn of_fields(parameters: &Text) -> BTreeMap<String, String> {
    let mut labels: BTreeMap<u32, Label> = BTreeMap::new();
    for entry in parameters.entries() {
        // Factors are written as comments.
        let indexed = entry.key.trim_start_matches('#').strip_suffix(']').and_then(|key| key.split_once('['));
        let Some((key, Ok(number))) = indexed.map(|(key, number)| (key, number.parse())) else { continue };
        let value = entry.value.replace(char::is_control, " ");
        match key {
            "DataLabel" => labels.entry(number).or_default().name = value,
            "DataUnits" if !["", "(null)", "none"].contains(&&*value) => {
                labels.entry(number).or_default().unit = Some(value);
            }
            "DataCGSConversionFactor" => labels.entry(number).or_default().factor = value.parse().ok(),
            _ => {}
        }
    }
    let unit = |Label { name, unit, factor }: Label| {
        let factor = factor.filter(|factor| factor.is_finite() && *factor != 1.0);
        Some((name, unit.or_else(|| factor.map(|factor| format!("{factor:e} CGS")))?))
    };
    labels.into_values().filter_map(unit).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_are_words_or_factors() {
        let file = tempfile::NamedTempFile::new().unwrap();
        let text = "DataLabel[0] = Density\n#DataCGSConversionFactor[0] = 1.673e-20\nDataLabel[1] = Energy\n\
                    DataUnits[1] = erg/g\n#DataCGSConversionFactor[1] = 2\nDataLabel[2] = x-velocity\n\
                    DataUnits[2] = (null)\n#DataCGSConversionFactor[3] = 5\nDataLabel[x] = y\n";
        std::fs::write(file.path(), text).unwrap();
        let units = of_fields(&Text::read(file.path()).unwrap());
        let unit = |name: &str| units.get(name).map(String::as_str);
        assert_eq!([unit("Density"), unit("Energy")], [Some("1.673e-20 CGS"), Some("erg/g")]);
        assert_eq!([unit("x-velocity"), unit("y")], [None, None]);
    }
}
