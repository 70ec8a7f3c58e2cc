//! What is rendered: cameras and transfer functions, from views in a file or from the data.

use amray::Volume;
use amray::appearance::{TransferFunction, automatic};
use amray::scene::{Camera, Look as DataLook};
use anyhow::bail;

use super::transfer_functions;
use crate::view::ViewArguments;
use crate::view_file::{View, ViewName};

/// A transfer function and a camera.
pub(super) struct Look {
    pub(super) name: String,
    pub(super) transfer_function: TransferFunction,
    pub(super) unit_distance: f64,
    pub(super) camera: Camera,
}

/// Views with their names, all of one field.
pub(super) struct Views(Vec<(String, View)>);

impl Views {
    pub(super) fn read(names: &[ViewName]) -> anyhow::Result<Self> {
        let views =
            names.iter().map(|name| Ok((name.to_string(), name.read()?))).collect::<anyhow::Result<Vec<_>>>()?;
        let views = Self(views);
        if let Some((name, view)) = views.0.iter().find(|(_, view)| view.field.as_deref() != views.field()) {
            let [first, other] = [views.field(), view.field.as_deref()].map(|field| field.unwrap_or("the first field"));
            bail!("--view {name} is of {other}, --view {} of {first}; expected views of one field", views.0[0].0);
        }
        Ok(views)
    }

    /// The field that they name.
    pub(super) fn field(&self) -> Option<&str> {
        self.0.first()?.1.field.as_deref()
    }

    /// The size of the first one's pictures.
    pub(super) fn size(&self) -> Option<[usize; 2]> {
        self.0.first()?.1.size
    }

    /// The looks, for pictures of `size` pixels; where there are no views, those that follow from the volume.
    pub(super) fn looks(&self, volume: &Volume, size: [usize; 2]) -> anyhow::Result<Vec<Look>> {
        let unit_distance = volume.hierarchy().longest_side() / automatic::UNIT_DISTANCES;
        let look = |name: &str, transfer_function, view: &ViewArguments| {
            Ok(Look { name: name.into(), transfer_function, unit_distance, camera: view.camera(volume, size, 1.0)? })
        };
        if !self.0.is_empty() {
            let views = self.0.iter();
            return views.map(|(name, view)| look(name, view.transfer_function.clone(), &view.into())).collect();
        }
        let histogram = DataLook::default().histogram(volume)?;
        let [low, high] = volume.hierarchy().bounds();
        let diagonal = (0..3).map(|axis| (high[axis] - low[axis]).powi(2)).sum::<f64>().sqrt();
        transfer_functions::of_data(&histogram, diagonal)
            .into_iter()
            .map(|(name, function)| look(name, function, &ViewArguments::default()))
            .collect()
    }
}
