//! The lights of a scene, as paths look for them.
//!
//! A light's colour is how bright a medium with an albedo of 1 that scatters alike in all directions becomes where the
//! light arrives undimmed: the same unit as in pictures without scattered light.

use glam::DVec3;

use super::random::Random;
use crate::hierarchy::Hierarchy;
use crate::scene::{Light, Projection, Scene};

/// All lights of a picture.
pub(super) struct Lights {
    /// What comes from every direction alike.
    pub(super) ambient: DVec3,
    lamps: Vec<Lamp>,
    /// The sum of the lamps' shares.
    total: f64,
    /// Of the finest level, in world units.
    cell_size: DVec3,
}

/// A light that comes from one place.
struct Lamp {
    color: DVec3,
    source: Source,
    /// How often it is looked for, beside the others: as often as it is bright.
    share: f64,
}

/// Where light comes from.
enum Source {
    /// This direction, of length 1.
    Far(DVec3),
    /// A place in cells of the finest level; and the distance in world units at which the light has its colour.
    Near(DVec3, Option<f64>),
}

/// A light as it is seen from a place.
pub(super) struct Seen {
    /// What arrives if nothing lies between, on average over the choice of lights.
    pub(super) color: DVec3,
    /// Of length 1, in world units.
    pub(super) toward: DVec3,
    /// In world units.
    pub(super) distance: f64,
}

impl Lights {
    pub(super) fn new(scene: &Scene, hierarchy: &Hierarchy) -> Self {
        let finest = hierarchy.finest_level();
        let cells = |place| DVec3::from_array(hierarchy.to_cells(finest, place));
        let (mut ambient, mut lamps) = (DVec3::ZERO, Vec::new());
        for light in &scene.lighting.lights {
            let color = DVec3::from_array(light.color().map(f64::from));
            let source = match *light {
                Light::Ambient { .. } => {
                    ambient += color;
                    continue;
                }
                Light::Headlight { .. } => match scene.camera.viewpoint().projection {
                    Projection::Perspective { .. } | Projection::Panorama => {
                        Source::Near(cells(scene.camera.viewpoint().eye), None)
                    }
                    Projection::Orthographic { .. } => {
                        Source::Far(DVec3::from_array(scene.camera.direction([0.0, 0.0, -1.0])))
                    }
                },
                Light::Directional { direction, .. } => Source::Far(-DVec3::from_array(direction).normalize()),
                Light::Point { position, reach, .. } => Source::Near(cells(position), reach),
            };
            lamps.push(Lamp { color, source, share: color.max_element() });
        }
        lamps.retain(|lamp| lamp.share > 0.0);
        let cell_size = DVec3::from_array(hierarchy.levels()[finest].cell_size());
        Self { ambient, total: lamps.iter().map(|lamp| lamp.share).sum(), lamps, cell_size }
    }

    /// One of the lights that come from one place, as it is seen from a place in cells of the finest level.
    pub(super) fn choose(&self, place: [f64; 3], random: &mut Random) -> Option<Seen> {
        let mut left = if self.lamps.len() > 1 { random.unit() * self.total } else { 0.0 };
        let chosen = self.lamps.iter().find(|lamp| {
            left -= lamp.share;
            left < 0.0
        });
        // Rounding may leave a little at the end.
        let lamp = chosen.or(self.lamps.last())?;
        let color = lamp.color * (self.total / lamp.share);
        match lamp.source {
            Source::Far(toward) => Some(Seen { color, toward, distance: f64::INFINITY }),
            Source::Near(position, reach) => {
                let between = (position - DVec3::from_array(place)) * self.cell_size;
                let distance = between.length();
                // At the light itself no direction is more likely than others.
                let toward = if distance > 0.0 { between / distance } else { DVec3::X };
                // In reach the light is no brighter: no point burns out.
                let falloff = reach.map_or(1.0, |reach| (reach / distance).min(1.0).powi(2));
                Some(Seen { color: color * falloff, toward, distance })
            }
        }
    }
}
