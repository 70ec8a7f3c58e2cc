//! Isosurfaces, slices and meshes in a picture, from the flags.

use std::path::PathBuf;
use std::str::FromStr;

use amray::Volume;
use amray::appearance::TransferFunction;
use amray::render::Axis;
use amray::scene::{Paint, Surface};
use amray_mesh::{Mesh, files};
use clap::Args;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::data::{DataArguments, Opened, VolumeArguments};
use crate::scene_file::{self, checked};
use crate::{note, number};

/// What else is in the picture.
#[derive(Clone, Debug, Default, Args, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub(crate) struct SurfaceArguments {
    /// An isosurface of the field: COLOR is a number for a grey, R,G,B or the name of a field whose colours it has
    /// [default: the transfer function's colour]; OPACITY is 0 to 1 [default: 1]. May be repeated
    #[arg(long = "iso", value_name = "VALUE[:COLOR[:OPACITY]]", value_parser = isosurface, allow_hyphen_values = true)]
    #[serde(rename = "iso", skip_serializing_if = "Vec::is_empty")]
    isosurfaces: Vec<Isosurface>,
    /// A slice with the field's colours: across AXIS (x, y or z), or with NORMAL X,Y,Z; through a place on the axis or
    /// a point X,Y,Z [default: the middle of the domain]. May be repeated
    #[arg(long = "slice", value_name = "AXIS|NORMAL[:PLACE[:OPACITY]]", value_parser = slice, allow_hyphen_values = true)]
    #[serde(rename = "slice", skip_serializing_if = "Vec::is_empty")]
    slices: Vec<Slice>,
    /// A surface of triangles (STL, OBJ, PLY or VTP), inside or outside of the domain; COLOR as with --iso [default:
    /// the mesh's own, or white]. May be repeated
    #[arg(long = "mesh", value_name = "FILE[:COLOR[:OPACITY]]", value_parser = mesh)]
    #[serde(rename = "mesh", skip_serializing_if = "Vec::is_empty")]
    meshes: Vec<MeshFile>,
    /// Show surfaces alone
    #[arg(long)]
    pub(crate) hide_volume: bool,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Isosurface {
    value: f64,
    #[serde(default, skip_serializing_if = "Color::is_own")]
    color: Color,
    #[serde(default = "opaque", deserialize_with = "checked::share")]
    opacity: f32,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct MeshFile {
    /// Relative to the scene file.
    path: PathBuf,
    #[serde(default, skip_serializing_if = "Color::is_own")]
    color: Color,
    #[serde(default = "opaque", deserialize_with = "checked::share")]
    opacity: f32,
}

fn opaque() -> f32 {
    1.0
}

/// What colour a surface has.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged, expecting = "expected red, green and blue, or the name of a field")]
enum Color {
    /// The transfer function's, or a mesh's own.
    #[default]
    Own,
    Plain([f32; 3]),
    OfField(String),
}

impl Color {
    fn is_own(&self) -> bool {
        *self == Self::Own
    }
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Slice {
    #[serde(deserialize_with = "checked::normal")]
    normal: [f64; 3],
    #[serde(default)]
    place: Place,
    #[serde(default = "opaque", deserialize_with = "checked::share")]
    opacity: f32,
}

/// Where a plane is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Place {
    /// Through the middle of the domain.
    #[default]
    Middle,
    /// Where it cuts an axis through the middle.
    OnAxis(Axis, f64),
    /// Through a point.
    Through([f64; 3]),
}

impl Place {
    /// A point on the plane, in a domain with these corners.
    pub(crate) fn point(self, [low, high]: [[f64; 3]; 2]) -> [f64; 3] {
        let mut point = std::array::from_fn(|axis| (low[axis] + high[axis]) / 2.0);
        match self {
            Self::Middle => {}
            Self::OnAxis(axis, at) => point[axis as usize] = at,
            Self::Through(through) => point = through,
        }
        point
    }
}

/// What surfaces are made of besides the field shown.
pub(crate) struct SurfaceData {
    /// The fields that they have their colours from, by name.
    fields: Vec<(String, Volume, TransferFunction)>,
    meshes: Vec<Mesh>,
}

impl SurfaceArguments {
    /// These surfaces; of kinds that there are none of, `others`.
    pub(crate) fn or(self, others: Self) -> Self {
        Self {
            isosurfaces: scene_file::or(self.isosurfaces, others.isosurfaces),
            slices: scene_file::or(self.slices, others.slices),
            meshes: scene_file::or(self.meshes, others.meshes),
            hide_volume: self.hide_volume || others.hide_volume,
        }
    }

    /// The files of meshes.
    pub(crate) fn paths_mut(&mut self) -> impl Iterator<Item = &mut PathBuf> {
        self.meshes.iter_mut().map(|mesh| &mut mesh.path)
    }

    /// Whether there are any.
    pub(crate) fn is_empty(&self) -> bool {
        self.isosurfaces.is_empty() && self.slices.is_empty() && self.meshes.is_empty()
    }

    /// Says on standard error which isosurfaces a volume does not have.
    pub(crate) fn warn(&self, volume: &Volume) {
        if self.isosurfaces.is_empty() {
            return;
        }
        let [low, high] = volume.leaf_range().unwrap_or([f64::NAN; 2]);
        for Isosurface { value, .. } in &self.isosurfaces {
            if !(low <= *value && *value <= high) {
                let name = volume.field().name();
                note(&format!("amray: warning: isosurface {value}: {name} is from {low} to {high}, nothing is drawn"));
            }
        }
    }

    /// Reads meshes, and the fields that surfaces are coloured by.
    pub(crate) fn data(
        &self,
        volume: &VolumeArguments,
        opened: &Opened,
        colors: impl Fn(&DataArguments, &Volume) -> anyhow::Result<TransferFunction>,
    ) -> anyhow::Result<SurfaceData> {
        let mut fields: Vec<(String, Volume, TransferFunction)> = Vec::new();
        let isosurfaces = self.isosurfaces.iter().map(|isosurface| &isosurface.color);
        for color in isosurfaces.chain(self.meshes.iter().map(|mesh| &mesh.color)) {
            if let Color::OfField(name) = color
                && !fields.iter().any(|(known, ..)| known == name)
            {
                let field = volume.other_field(opened, name)?;
                let function = colors(&volume.data(), &field)?;
                fields.push((name.clone(), field, function));
            }
        }
        let meshes = self.meshes.iter().map(MeshFile::read).collect::<anyhow::Result<_>>()?;
        Ok(SurfaceData { fields, meshes })
    }

    /// The surfaces in a scene with this volume.
    pub(crate) fn surfaces<'a>(
        &self,
        volume: &'a Volume,
        function: &TransferFunction,
        data: &'a SurfaceData,
    ) -> Vec<Surface<'a>> {
        let own = || Paint::Field(volume, function.clone());
        let isosurfaces = self.isosurfaces.iter().map(|Isosurface { value, color, opacity }| Surface {
            opacity: *opacity,
            ..Surface::isosurface(*value, data.paint(color, own()))
        });
        let bounds = volume.hierarchy().bounds();
        let slices = self.slices.iter().map(|Slice { normal, place, opacity }| Surface {
            opacity: *opacity,
            ..Surface::slice(place.point(bounds), *normal, own())
        });
        let meshes = self.meshes.iter().zip(&data.meshes).map(|(MeshFile { color, opacity, .. }, mesh)| {
            let paint = data.paint(color, Paint::Own);
            Surface { opacity: *opacity, paint, ..Surface::mesh(mesh) }
        });
        isosurfaces.chain(slices).chain(meshes).collect()
    }
}

impl SurfaceData {
    /// A colour as paint; `own` where none is given.
    fn paint<'a>(&'a self, color: &Color, own: Paint<'a>) -> Paint<'a> {
        match color {
            Color::Own => own,
            Color::Plain(color) => Paint::Plain(*color),
            Color::OfField(name) => match self.fields.iter().find(|(known, ..)| known == name) {
                Some((_, field, function)) => Paint::Field(field, function.clone()),
                None => own,
            },
        }
    }
}

impl MeshFile {
    /// Reads the mesh; says on standard error what of it is not drawn.
    fn read(&self) -> anyhow::Result<Mesh> {
        let name = self.path.display();
        let description = files::open(&self.path)?;
        let mesh = Mesh::new(description).map_err(|error| anyhow::anyhow!("{name}: {error}"))?;
        match (mesh.triangle_count(), mesh.left_out()) {
            (0, _) => note(&format!("amray: warning: {name}: there are no triangles, nothing is drawn")),
            (_, 0) => {}
            (_, count) => note(&format!("amray: warning: {name}: {count} triangles have no area and are not drawn")),
        }
        Ok(mesh)
    }
}

/// `VALUE[:COLOR[:OPACITY]]`.
fn isosurface(text: &str) -> Result<Isosurface, String> {
    let parts: Vec<&str> = text.split(':').collect();
    let (value, color, opacity) = match parts[..] {
        [value] => (value, None, None),
        [value, color] => (value, Some(color), None),
        [value, color, opacity] => (value, Some(color), Some(opacity)),
        _ => return Err("expected VALUE[:COLOR[:OPACITY]]".into()),
    };
    Ok(Isosurface { value: number::finite(value)?, color: named_color(color)?, opacity: share(opacity)? })
}

/// `FILE[:COLOR[:OPACITY]]`.
fn mesh(text: &str) -> Result<MeshFile, String> {
    let parts: Vec<&str> = text.split(':').collect();
    let (path, color, opacity) = match parts[..] {
        [path] => (path, None, None),
        [path, color] => (path, Some(color), None),
        [path, color, opacity] => (path, Some(color), Some(opacity)),
        _ => return Err("expected FILE[:COLOR[:OPACITY]]".into()),
    };
    Ok(MeshFile { path: path.into(), color: named_color(color)?, opacity: share(opacity)? })
}

/// A number for a grey, `r,g,b`, or the name of a field or an expression.
fn named_color(text: Option<&str>) -> Result<Color, String> {
    let Some(text) = text.filter(|text| !text.is_empty()) else { return Ok(Color::Own) };
    match (f32::from_str(text), number::list::<3>(text)) {
        (Ok(grey), _) => Ok(Color::Plain([grey; 3])),
        (_, Ok(color)) => Ok(Color::Plain(color.map(|channel| channel as f32))),
        // In an expression, commas stand in calls or vectors.
        _ if text.contains(',') && !text.contains(['(', '{', '<']) => {
            Err(format!("{text:?} is no colour: expected a number or r,g,b"))
        }
        _ => Ok(Color::OfField(text.into())),
    }
}

/// `AXIS|NORMAL[:PLACE[:OPACITY]]`.
fn slice(text: &str) -> Result<Slice, String> {
    let parts: Vec<&str> = text.split(':').collect();
    let (across, place, opacity) = match parts[..] {
        [across] => (across, None, None),
        [across, place] => (across, Some(place), None),
        [across, place, opacity] => (across, Some(place), Some(opacity)),
        _ => return Err("expected AXIS|NORMAL[:PLACE[:OPACITY]]".into()),
    };
    let (normal, place) = plane(across, place)?;
    Ok(Slice { normal, place, opacity: share(opacity)? })
}

/// The normal and the place of `AXIS|NORMAL[:PLACE]`.
pub(crate) fn plane(across: &str, place: Option<&str>) -> Result<([f64; 3], Place), String> {
    let place = place.filter(|place| !place.is_empty());
    if let Ok(axis) = across.parse::<Axis>() {
        let mut normal = [0.0; 3];
        normal[axis as usize] = 1.0;
        let place = match place {
            Some(place) => Place::OnAxis(axis, number::finite(place)?),
            None => Place::Middle,
        };
        return Ok((normal, place));
    }
    let normal =
        number::list::<3>(across).map_err(|_| format!("{across:?} is no axis x, y or z and no normal x,y,z"))?;
    let normal = number::normal(normal)?;
    let place = match place {
        Some(place) => Place::Through(number::list(place)?),
        None => Place::Middle,
    };
    Ok((normal, place))
}

/// An opacity; 1 where it is not given.
fn share(text: Option<&str>) -> Result<f32, String> {
    number::share(text.map_or(Ok(1.0), number::finite)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn surfaces_are_read() {
        let expected = |value, color, opacity| Ok(Isosurface { value, color, opacity });
        assert_eq!(isosurface("-2.5"), expected(-2.5, Color::Own, 1.0));
        assert_eq!(isosurface("1e3:0.5"), expected(1e3, Color::Plain([0.5; 3]), 1.0));
        assert_eq!(isosurface("0:1,0.5,0:0.25"), expected(0.0, Color::Plain([1.0, 0.5, 0.0]), 0.25));
        assert_eq!(isosurface("0::0.25"), expected(0.0, Color::Own, 0.25));
        assert_eq!(isosurface("7:pressure:1"), expected(7.0, Color::OfField("pressure".into()), 1.0));
        assert_eq!(isosurface("7:max(x,y)"), expected(7.0, Color::OfField("max(x,y)".into()), 1.0));
        let file = |path: &str, color, opacity| Ok(MeshFile { path: path.into(), color, opacity });
        assert_eq!(mesh("a/b.stl"), file("a/b.stl", Color::Own, 1.0));
        assert_eq!(mesh("b.ply:pressure:0.5"), file("b.ply", Color::OfField("pressure".into()), 0.5));
        let expected = |normal, place, opacity| Ok(Slice { normal, place, opacity });
        assert_eq!(slice("y"), expected([0.0, 1.0, 0.0], Place::Middle, 1.0));
        assert_eq!(slice("z:-0.5:0.3"), expected([0.0, 0.0, 1.0], Place::OnAxis(Axis::Z, -0.5), 0.3));
        assert_eq!(slice("1,1,0:0,0,2"), expected([1.0, 1.0, 0.0], Place::Through([0.0, 0.0, 2.0]), 1.0));
    }

    #[test]
    fn what_is_no_surface_is_explained() {
        for (text, part) in [
            ("high", "high"),
            ("1:1,2", "no colour"),
            ("1:1:2", "expected a number from 0 to 1"),
            ("1:1:1:1", "VALUE[:COLOR[:OPACITY]]"),
        ] {
            let message = isosurface(text).unwrap_err();
            assert!(message.contains(part), "{text}: {message}");
        }
        for (text, part) in [("w", "no axis"), ("0,0,0", "other than 0"), ("x:a", "a"), ("x:1:1:1", "AXIS|NORMAL")] {
            let message = slice(text).unwrap_err();
            assert!(message.contains(part), "{text}: {message}");
        }
    }
}
