//! What explains a picture: outlines of the domain and of bricks, and axes.

use amray::appearance::{Picture, Rectangle, TextSize};
use amray::hierarchy::Hierarchy;
use amray::render::draw_axes;
use amray::scene::{Camera, Outline, Surface, level_color, outline_mesh};
use amray_mesh::Mesh;
use clap::Args;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How wide lines are, in pixels.
const WIDTH: f64 = 1.5;

#[derive(Clone, Debug, Default, Args, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub(crate) struct AnnotationArguments {
    /// Outline the domain
    #[arg(long)]
    outline: bool,
    /// Outline all bricks in colours of their levels, which a legend (.png) names
    #[arg(long)]
    brick_outlines: bool,
    /// Axes around the domain with ticks in world units (.png), and its outline
    #[arg(long)]
    pub(crate) axes: bool,
    /// Draw a colour bar beside the picture (.png)
    #[arg(long)]
    pub(crate) color_bar: bool,
}

impl AnnotationArguments {
    /// All of these and of `others`.
    pub(crate) fn or(self, others: Self) -> Self {
        Self {
            outline: self.outline || others.outline,
            brick_outlines: self.brick_outlines || others.brick_outlines,
            axes: self.axes || others.axes,
            color_bar: self.color_bar || others.color_bar,
        }
    }

    /// Whether there are lines in the scene.
    pub(crate) fn has_outlines(&self) -> bool {
        self.outline || self.brick_outlines || self.axes
    }

    /// By how much the camera should be farther away, so that there is room around the domain.
    pub(crate) fn room(&self) -> f64 {
        if self.axes { 1.25 } else { 1.0 }
    }

    /// The outlines, for a picture of `size` pixels by `camera` in front of a background.
    pub(crate) fn outlines(
        &self,
        hierarchy: &Hierarchy,
        camera: &Camera,
        size: [usize; 2],
        background: [f32; 4],
    ) -> anyhow::Result<Option<Mesh>> {
        let mut outlines = if self.brick_outlines { Outline::of_bricks(hierarchy) } else { Vec::new() };
        if self.outline || self.axes {
            let luma: f32 = background[..3].iter().sum::<f32>() / 3.0;
            outlines.push(Outline::of_domain(hierarchy, [if luma > 0.5 { 0.0 } else { 1.0 }; 3]));
        }
        match outlines.is_empty() {
            true => Ok(None),
            false => Ok(Some(Mesh::new(outline_mesh(&outlines, camera, size, WIDTH))?)),
        }
    }

    /// Draws what lies over the picture.
    pub(crate) fn draw(&self, picture: &mut Picture, hierarchy: &Hierarchy, camera: &Camera, background: [u8; 4]) {
        if self.axes {
            draw_axes(picture, camera, hierarchy.bounds(), background);
        }
        if self.brick_outlines {
            draw_legend(picture, hierarchy.levels().len());
        }
    }
}

/// Outlines as they lie in a scene.
pub(crate) fn surface(mesh: &Mesh) -> Surface<'_> {
    Surface { material: None, casts_shadows: false, ..Surface::mesh(mesh) }
}

/// Names the levels in their colours, in the lower left corner.
fn draw_legend(picture: &mut Picture, levels: usize) {
    let text = TextSize::of_picture(picture.height());
    let line = text.height();
    for level in 0..levels {
        let Some(top) = picture.height().checked_sub((levels - level) * line + line / 2) else { continue };
        let [red, green, blue] = level_color(level).map(|channel| (channel * 255.0).round() as u8);
        let color = [red, green, blue, u8::MAX];
        let mark = Rectangle { left: line / 2, top: top + line / 2, width: line, height: (line / 8).max(2) };
        picture.fill(mark, color);
        picture.text(2 * line, top, text, &format!("level {level}"), color);
    }
}
