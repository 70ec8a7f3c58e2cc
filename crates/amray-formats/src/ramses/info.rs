//! What the info file of an output says.

use std::path::Path;

use crate::FormatError;
use crate::key_values::Text;

/// More processes than any machine runs.
const MOST_CPUS: usize = 1 << 22;

/// The run's parameters.
pub(super) struct Info {
    /// As many files of each kind there are.
    pub(super) cpus: usize,
    /// All cells below this level are refined.
    pub(super) level_min: usize,
    /// The width of a coarse cell: of the box, where there is but one.
    pub(super) box_length: f64,
    pub(super) time: f64,
    /// What numbers are to be multiplied by to be in CGS units.
    pub(super) units: Option<Units>,
}

/// The units of a run, in CGS units.
#[derive(Clone, Copy)]
pub(super) struct Units {
    length: f64,
    density: f64,
    time: f64,
}

impl Info {
    /// Whether the text is of an info file.
    pub(super) fn recognises(path: &Path) -> bool {
        let known = |text: Text| ["ncpu", "ndim", "levelmin"].iter().all(|key| text.find(key).is_ok());
        path.is_file() && Text::read(path).is_ok_and(known)
    }

    pub(super) fn read(path: &Path) -> Result<Self, FormatError> {
        let text = Text::read(path)?;
        let dimensions = text.find("ndim")?;
        if dimensions.number::<i64>()? != 3 {
            return Err(dimensions.malformed(&format!("{}, expected 3 dimensions", dimensions.value)));
        }
        let cpus = text.find("ncpu")?;
        let count = cpus.number()?;
        if !(1..=MOST_CPUS).contains(&count) {
            return Err(cpus.malformed(&format!("{count}, expected 1 to {MOST_CPUS}")));
        }
        let box_length = text.find("boxlen")?.number()?;
        let (level_min, time) = (text.find("levelmin")?.number()?, text.find("time")?.number()?);
        Ok(Self { cpus: count, level_min, box_length, time, units: Units::of(&text) })
    }
}

impl Units {
    /// `None` where one is missing, is no factor, or all are 1: the run has no units then.
    fn of(text: &Text) -> Option<Self> {
        let factor = |key| {
            let number: f64 = text.find(key).ok()?.number().ok()?;
            (number.is_finite() && number > 0.0).then_some(number)
        };
        let [length, density, time] = [factor("unit_l")?, factor("unit_d")?, factor("unit_t")?];
        ([length, density, time] != [1.0; 3]).then_some(Self { length, density, time })
    }

    /// The unit of a variable that RAMSES itself names.
    pub(super) fn of_variable(&self, name: &str) -> Option<String> {
        let velocity = self.length / self.time;
        let is = |start: &str| name.starts_with(start);
        let (factor, unit) = if name == "density" {
            (self.density, "g/cm^3")
        } else if is("velocity_") {
            (velocity, "cm/s")
        } else if is("momentum_") {
            (self.density * velocity, "g/(cm^2 s)")
        } else if ["pressure", "thermal_pressure"].contains(&name) || is("non_thermal_pressure_") {
            (self.density * velocity * velocity, "erg/cm^3")
        } else if is("B_left_") || is("B_right_") || is("B_x_") || is("B_y_") || is("B_z_") {
            // RAMSES leaves the 4 pi of Gauss out.
            ((4.0 * std::f64::consts::PI * self.density).sqrt() * velocity, "G")
        } else {
            return None;
        };
        factor.is_finite().then(|| format!("{factor:e} {unit}"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_of_known_variables() {
        let file = tempfile::NamedTempFile::new().unwrap();
        let units = |text: &str| {
            std::fs::write(file.path(), text).unwrap();
            Units::of(&Text::read(file.path()).unwrap())
        };
        let known = units("unit_l      =  0.4E+01\nunit_d      =  0.5E+00\nunit_t      =  0.2E+01\n").unwrap();
        let of = |name: &str| known.of_variable(name);
        assert_eq!(of("density").as_deref(), Some("5e-1 g/cm^3"));
        assert_eq!(of("velocity_x").as_deref(), Some("2e0 cm/s"));
        assert_eq!(of("momentum_y").as_deref(), Some("1e0 g/(cm^2 s)"));
        assert_eq!(
            [of("pressure"), of("thermal_pressure")],
            [Some("2e0 erg/cm^3".into()), Some("2e0 erg/cm^3".into())]
        );
        assert!(of("B_left_x").unwrap().ends_with(" G"));
        assert_eq!([of("metallicity"), of("scalar_01")], [None, None]);
        assert!(units("unit_l = 1\nunit_d = 1\nunit_t = 1\n").is_none());
        assert!(units("unit_l = 2\nunit_d = 0\nunit_t = 1\n").is_none());
        assert!(units("unit_l = 2\nunit_d = 3\n").is_none());
    }
}
