//! How a field looks where nobody said so: what is not given follows from the data.

use thiserror::Error;

use crate::Volume;
use crate::appearance::{ColorMap, Histogram, Opacity, OpacityPoint, RangeError, Scale, TransferFunction, automatic};

/// What is known of how a field is to look.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Look {
    /// The colour map; diverging for values on both sides of 0, else sequential, where it is not given.
    pub color_map: Option<ColorMap>,
    /// The values that it spans; those with structure where it is not given.
    pub range: Option<[f64; 2]>,
    /// Whether colours and opacities are logarithmic. Where neither this nor a range is given, the values decide.
    pub log: bool,
}

/// Values that no look can be found for.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum LookError {
    /// Nothing but holes and numbers that are none.
    #[error("no finite value to choose colours for")]
    NoFiniteValue,
    /// A logarithm of values that have none.
    #[error("a log scale needs positive values; the highest value is {highest}")]
    NotPositive {
        /// The highest finite value.
        highest: f64,
    },
    /// A range that suits no scale.
    #[error(transparent)]
    Range(#[from] RangeError),
}

impl Look {
    /// The transfer function for a volume: opacities from the volume-weighted histogram of its leaf cells, of a unit
    /// distance of a hundredth of the domain's longest side.
    ///
    /// # Errors
    /// [`LookError`] where there is no value to show, or the range does not suit the scale.
    pub fn transfer_function(&self, volume: &Volume) -> Result<TransferFunction, LookError> {
        Ok(automatic::transfer_function(&self.histogram(volume)?, self.color_map, self.range))
    }

    /// The volume-weighted histogram of a volume's leaf cells, over the range and on the scale of this look.
    ///
    /// # Errors
    /// [`LookError`] where there is no value to show, or the range does not suit the scale.
    pub fn histogram(&self, volume: &Volume) -> Result<Histogram, LookError> {
        let [low, high] = volume.leaf_range().ok_or(LookError::NoFiniteValue)?;
        let scale = self.scale([low, high]);
        let [low, high] = match self.range {
            Some(range) => range,
            None if scale == Scale::Log10 && low <= 0.0 => [smallest_positive(volume, high)?, high],
            None => [low, high],
        };
        let empty = Histogram::new(low, high, scale, automatic::HISTOGRAM_BINS)?;
        Ok(volume.fold_leaf_cells(
            || empty.clone(),
            |histogram, cell| histogram.add(cell.value, cell.volume),
            |mut sum, part| {
                sum.merge(&part);
                sum
            },
        ))
    }

    /// The colours alone, for pictures in which every value is opaque; `values` are those shown.
    ///
    /// # Errors
    /// [`LookError`] where there is no value to show, or the range does not suit the scale.
    pub fn colors(&self, values: &[f64]) -> Result<TransferFunction, LookError> {
        let finite = || values.iter().copied().filter(|value| value.is_finite());
        let highest = finite().reduce(f64::max).ok_or(LookError::NoFiniteValue)?;
        let shown = finite().filter(|value| !self.log || *value > 0.0);
        let lowest = shown.reduce(f64::min).ok_or(LookError::NotPositive { highest })?;
        let scale = self.scale([lowest, highest]);
        let [low, high] = self.range.unwrap_or([lowest, highest]);
        // A histogram knows what range a single value gets.
        let range = Histogram::new(low, high, scale, 1)?.range();
        let map = self.color_map.unwrap_or_else(|| automatic::color_map(range));
        let opaque = Opacity::PerUnitDistance(vec![OpacityPoint { value: range[0], opacity: 1.0 }]);
        Ok(TransferFunction::from_color_map(map, range, scale, opaque).expect("a histogram's range suits its scale"))
    }

    /// A range that was asked for is shown as it was asked for: linear.
    fn scale(&self, [low, high]: [f64; 2]) -> Scale {
        match self {
            Self { log: true, .. } => Scale::Log10,
            Self { range: Some(_), .. } => Scale::Linear,
            _ => automatic::scale(low, high),
        }
    }
}

fn smallest_positive(volume: &Volume, highest: f64) -> Result<f64, LookError> {
    if highest <= 0.0 {
        return Err(LookError::NotPositive { highest });
    }
    Ok(volume.fold_leaf_cells(
        || f64::INFINITY,
        |smallest, cell| {
            if cell.value > 0.0 {
                *smallest = smallest.min(cell.value);
            }
        },
        f64::min,
    ))
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::hierarchy::{Field, Hierarchy, IndexBox, LevelDescription};
    use crate::index::Index;
    use crate::reconstruction::Method;

    fn volume(value: impl Fn(i64) -> f64) -> Volume {
        let cells = IndexBox::new([0; 3], [16, 4, 4]);
        let level = LevelDescription { ratio: [1; 3], cell_size: [1.0; 3], domain: cells, bricks: vec![cells] };
        let hierarchy = Arc::new(Hierarchy::new([0.0; 3], vec![level]).unwrap());
        let field = Field::from_fn("value", &hierarchy, |_, cell| value(cell[0]));
        Volume::new(Arc::new(Index::build(hierarchy)), field, Method::Nearest)
    }

    #[test]
    fn what_is_given_is_kept_and_the_rest_follows_from_the_data() {
        let linear = volume(|i| i as f64);
        let found = Look::default().transfer_function(&linear).unwrap();
        assert!(found.scale() == Scale::Linear && (found.range()[1] - 15.0).abs() < 1e-3);
        let look = Look { range: Some([2.0, 1e9]), ..Look::default() };
        let found = look.transfer_function(&linear).unwrap();
        assert_eq!((found.scale(), found.range()), (Scale::Linear, [2.0, 1e9]));
        let decades = volume(|i| 10f64.powi(i as i32));
        assert_eq!(Look::default().transfer_function(&decades).unwrap().scale(), Scale::Log10);
        let log = Look { log: true, ..Look::default() };
        assert_eq!(log.transfer_function(&volume(|i| i as f64 - 3.0)).unwrap().scale(), Scale::Log10);
    }

    #[test]
    fn values_without_a_look_are_refused() {
        let log = Look { log: true, ..Look::default() };
        let nothing = Look::default().transfer_function(&volume(|_| f64::NAN));
        assert_eq!(nothing.unwrap_err(), LookError::NoFiniteValue);
        let negative = log.transfer_function(&volume(|i| -(i as f64)));
        assert_eq!(negative.unwrap_err(), LookError::NotPositive { highest: 0.0 });
        assert_eq!(log.colors(&[-1.0, f64::NAN]).unwrap_err(), LookError::NotPositive { highest: -1.0 });
        let range = Look { range: Some([-1.0, 1.0]), ..log }.transfer_function(&volume(|i| i as f64));
        assert!(matches!(range, Err(LookError::Range(_))));
    }

    #[test]
    fn colors_span_what_is_shown() {
        let found = Look::default().colors(&[3.0, f64::NAN, 5.0]).unwrap();
        assert_eq!(found.range(), [3.0, 5.0]);
        let constant = Look::default().colors(&[4.0]).unwrap().range();
        assert!(constant[0] < 4.0 && 4.0 < constant[1]);
        assert_eq!(Look::default().colors(&[]).unwrap_err(), LookError::NoFiniteValue);
    }
}
