//! A scene document with its data open: what pictures are taken of.

use std::sync::Arc;
use std::time::Instant;

use amray::Volume;
use amray::appearance::{Picture, TransferFunction, automatic, color_bar};
use amray::index::Index;
use amray::render::{Engine, Film, PathError, RenderOptions, RenderStatistics};
use amray::scene::{Camera, CameraError, Lighting, LightingError, Scene, Shading, ShownField};
use amray_mesh::Mesh;

use crate::annotations;
use crate::appearance::AppearanceArguments;
use crate::data::{Opened, Source, VolumeArguments};
use crate::fields::OtherFields;
use crate::memory::Watch;
use crate::progress::with_spinner;
use crate::scene_file::SceneDocument;
use crate::surfaces::SurfaceData;

/// Pixels of a picture, where nothing says so.
pub(crate) const SIZE: [usize; 2] = [1024; 2];
const PANORAMA_SIZE: [usize; 2] = [2048, 1024];

/// Everything that a picture needs but the camera.
pub(crate) struct Stage {
    document: SceneDocument,
    pub(crate) volume: Volume,
    /// The field's name with its unit.
    title: String,
    function: TransferFunction,
    fields: OtherFields,
    surfaces: SurfaceData,
    unit_distance: f64,
    pub(crate) options: RenderOptions,
    /// Seconds to open the files and read or map the field.
    pub(crate) open_seconds: f64,
    /// Seconds to build the index and its value ranges.
    pub(crate) index_seconds: f64,
    /// Only held.
    _watch: Option<Watch>,
}

impl Stage {
    /// Reads the data of a document from their `source`; they share an `index` of the same mesh.
    pub(crate) fn open(
        document: SceneDocument,
        data: &VolumeArguments,
        source: Source,
        index: Option<Arc<Index>>,
    ) -> anyhow::Result<Self> {
        document.light_paths.check()?;
        let picture = &document.picture;
        let size = picture.size.unwrap_or(if document.camera.panorama { PANORAMA_SIZE } else { SIZE });
        let opened = data.read_from(source, index)?;
        document.surfaces.warn(&opened.volume);
        let colors = |data: &_, volume: &_| AppearanceArguments::default().transfer_function(data, volume);
        let surfaces = document.surfaces.data(data, &opened, colors)?;
        let fields = document.fields.open(data, &opened)?;
        let Opened { volume, title, open_seconds, index_seconds, watch, .. } = opened;
        let start = Instant::now();
        with_spinner("value ranges", || volume.ranges());
        let index_seconds = index_seconds + start.elapsed().as_secs_f64();
        let function = document.appearance.transfer_function(&data.data(), &volume)?;
        let longest = volume.hierarchy().longest_side();
        let options = RenderOptions {
            size,
            samples_per_cell: picture.samples_per_cell.unwrap_or(1.0),
            samples_per_pixel: picture.spp.unwrap_or(1).into(),
            seed: picture.seed.unwrap_or(0),
            engine: document.sampling.engine(&volume, 1 + document.fields.count(), data.memory()),
            integration: document.sampling.integration(),
            adaptive: !document.sampling.every_cell,
        };
        let unit_distance = picture.unit_distance.unwrap_or(longest / automatic::UNIT_DISTANCES);
        Ok(Self {
            document,
            volume,
            title,
            function,
            fields,
            surfaces,
            unit_distance,
            options,
            open_seconds,
            index_seconds,
            _watch: watch,
        })
    }

    /// The camera that the document describes.
    pub(crate) fn camera(&self) -> Result<Camera, CameraError> {
        self.document.camera.camera(&self.volume, self.options.size, self.document.annotations.room())
    }

    fn lighting(&self, camera: &Camera) -> Result<Lighting, LightingError> {
        let longest = self.volume.hierarchy().longest_side();
        self.document.lighting.lighting(camera, longest, self.document.light_paths.is_path())
    }

    /// The document with nothing left to be chosen.
    pub(crate) fn resolved(&self, camera: &Camera) -> anyhow::Result<SceneDocument> {
        let mut document = self.document.clone();
        document.data.field = Some(self.volume.field().name().into());
        document.data.method = Some(self.volume.method());
        document.camera = document.camera.resolved(camera);
        document.appearance = AppearanceArguments::of(self.function.clone());
        document.fields = document.fields.resolved(&self.fields);
        document.lighting = document.lighting.resolved(&self.lighting(camera)?);
        document.picture = document.picture.resolved(self.options.size, self.unit_distance);
        document.sampling = document.sampling.resolved(self.options.engine);
        Ok(document)
    }

    /// The lines that explain a picture by `camera`.
    pub(crate) fn outlines(&self, camera: &Camera) -> anyhow::Result<Option<Mesh>> {
        let SceneDocument { annotations, picture, .. } = &self.document;
        annotations.outlines(self.volume.hierarchy(), camera, self.options.size, picture.background())
    }

    /// The scene as `camera` sees it: with one eye or with two.
    pub(crate) fn scenes<'a>(&'a self, camera: Camera, outlines: Option<&'a Mesh>) -> anyhow::Result<Vec<Scene<'a>>> {
        let Self { document, volume, function, fields, unit_distance, .. } = self;
        let lighting = self.lighting(&camera)?;
        self.check(&lighting)?;
        let mut surfaces = document.surfaces.surfaces(volume, function, &self.surfaces);
        surfaces.extend(outlines.map(annotations::surface));
        let opacity = if document.surfaces.hide_volume { 0.0 } else { document.picture.opacity.unwrap_or(1.0) };
        let function = function.scaled_opacity(opacity);
        let clips = document.clips.clips(volume);
        let (colors, overlays) = (fields.colors(), fields.overlays(opacity));
        let scene = Scene {
            colors,
            overlays,
            lighting,
            surfaces,
            clips,
            ..Scene::new(volume, function, *unit_distance, camera)
        };
        Ok(match document.camera.stereo {
            None => vec![scene],
            Some(stereo) => stereo.pair(&camera)?.map(|camera| Scene { camera, ..scene.clone() }).to_vec(),
        })
    }

    /// Finds out whether what is asked for can be drawn together.
    fn check(&self, lighting: &Lighting) -> anyhow::Result<()> {
        let SceneDocument { fields, surfaces, annotations, light_paths, .. } = &self.document;
        let has_fields = fields.count() > 0;
        let is_query = self.options.engine == Engine::Query;
        let has_surfaces = !surfaces.is_empty() || annotations.has_outlines();
        if light_paths.is_path() && (is_query || has_fields) {
            anyhow::bail!("--mode path is for one field, and marches: drop --color-by, --overlay and --engine query");
        }
        if is_query && (lighting.shading != Shading::Emissive || has_surfaces || has_fields) {
            anyhow::bail!(
                "--engine query draws one field that glows, and nothing else: drop --color-by, --overlay, --shading, \
                 --shadows, --ao, --light, --iso, --slice, --mesh, outlines and axes, or march"
            );
        }
        Ok(())
    }

    /// Lays values out for marching; the seconds that took.
    pub(crate) fn prepare(&self) -> f64 {
        let start = Instant::now();
        if let Engine::March(layout) = self.options.engine {
            with_spinner("preparing", || {
                self.volume.prepare(layout);
                self.fields.prepare(layout);
            });
        }
        start.elapsed().as_secs_f64()
    }

    /// Bytes of memory that marching needs besides the fields.
    pub(crate) fn layout_bytes(&self) -> u64 {
        match self.options.engine {
            Engine::March(layout) => self.volume.layout_bytes(layout) + self.fields.layout_bytes(layout),
            Engine::Query => 0,
        }
    }

    /// Renders each of the scenes; `what` is on the progress bar.
    pub(crate) fn films(&self, scenes: &[Scene], what: &str) -> Result<(Vec<Film>, RenderStatistics), PathError> {
        let (mut films, mut statistics) = (Vec::new(), RenderStatistics::default());
        for scene in scenes {
            let (film, more) = self.document.light_paths.film(scene, &self.options, what)?;
            films.push(film);
            statistics = statistics + more;
        }
        Ok((films, statistics))
    }

    /// The films of scenes as one picture, with all that explains it.
    pub(crate) fn picture(&self, films: &[Film], scenes: &[Scene]) -> Picture {
        let background = self.document.picture.background();
        let behind = background.map(|channel| (channel * 255.0).round() as u8);
        let annotations = &self.document.annotations;
        let drawn = films.iter().zip(scenes).map(|(film, scene)| {
            let ([width, height], pixels) = (film.size(), film.over(background));
            let mut picture = Picture::from_pixels(width, height, pixels).expect("a film has its size's pixels");
            annotations.draw(&mut picture, self.volume.hierarchy(), &scene.camera, behind);
            if annotations.color_bar {
                let own = ShownField { volume: &self.volume, transfer_function: scene.transfer_function.clone() };
                for ShownField { volume, transfer_function } in
                    std::iter::once(scene.colors.as_ref().unwrap_or(&own)).chain(&scene.overlays)
                {
                    let is_own = std::ptr::eq(*volume, &self.volume);
                    let name = if is_own { &self.title } else { volume.field().name() };
                    let bar = color_bar(transfer_function, name, height, behind);
                    picture = picture.beside(&bar, behind);
                }
            }
            picture
        });
        drawn.reduce(|left, right| left.beside(&right, behind)).expect("there is a scene for each eye")
    }
}
