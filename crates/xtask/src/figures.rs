//! What the gallery shows. In flags, `DATA` is the folder of real files, `DEMO` the demo file; each picture's size and name
//! are added.

/// Pictures side by side.
pub(crate) struct Figure {
    /// Its file names begin with that.
    pub(crate) name: &'static str,
    pub(crate) caption: &'static str,
    pub(crate) pictures: &'static [Picture],
}

/// One picture.
pub(crate) struct Picture {
    pub(crate) title: &'static str,
    /// The command and its flags, as on the command line.
    pub(crate) flags: &'static str,
}

/// A picture by each of the methods that the paper compares, and amray's own.
macro_rules! by_method {
    ($flags:literal) => {
        &[
            Picture { title: "nearest", flags: concat!($flags, " --method nearest") },
            Picture { title: "current", flags: concat!($flags, " --method current") },
            Picture { title: "blend", flags: concat!($flags, " --method blend") },
            Picture { title: "basis", flags: concat!($flags, " --method basis") },
            Picture { title: "octant", flags: concat!($flags, " --method octant") },
            Picture { title: "prolong", flags: concat!($flags, " --method prolong") },
        ]
    };
}

/// All figures.
pub(crate) const FIGURES: &[Figure] = &[
    Figure {
        name: "methods",
        caption: "Reconstructions of one isosurface across levels, after the paper's figure 2: cells, seams, and none.",
        pictures: by_method!(
            "render DATA/amrex/plt_small --iso 1.02:0.85,0.55,0.3 --hide-volume --light ambient:0.25 --light \
             directional:-1,0.4,-1:0.9 --eye 1.9,-1.55,1.52 --target 0.6,0.4,0.62 --fovy 9 --spp 4"
        ),
    },
    Figure {
        name: "volumes",
        caption: "The same in a volume, after the paper's figure 5.",
        pictures: by_method!(
            "render DATA/chombo/explosion_small.3d.hdf5 --shading --eye 1.6,-0.9,1.5 --target 0.5,0.5,0.6 --fovy 9"
        ),
    },
    Figure {
        name: "light",
        caption: "A supernova remnant (demo data) in more and more light, after the paper's figure 8: it glows; it reflects; \
                  shadows and ambient occlusion; paths of light that is scattered any number of times.",
        pictures: &[
            Picture { title: "glowing", flags: "render DEMO" },
            Picture { title: "gradient shading", flags: "render DEMO --shading" },
            Picture { title: "shadows and occlusion", flags: "render DEMO --shading --shadows --ao 8" },
            Picture { title: "path tracing", flags: "render DEMO --mode path --spp 128 --anisotropy 0.3 --opacity 3" },
        ],
    },
    Figure {
        name: "scenes",
        caption: "Surfaces and volumes in one picture.",
        pictures: &[
            Picture {
                title: "isosurface in its volume",
                flags: "render DEMO --iso 0.6:0.9,0.6,0.3:0.5 --slice z:0.02 --shadows --spp 4",
            },
            Picture {
                title: "cut open",
                flags: "render DEMO --opacity 30 --cut-box 0.5,-1,0.5:2,0.5,2 --shading --shadows --ao 4 --outline --spp 4",
            },
            Picture {
                title: "bricks by level",
                flags: "render DEMO --hide-volume --slice y --brick-outlines --axes --color-bar --spp 4",
            },
            Picture {
                title: "from inside, all around",
                flags: "render DEMO --panorama --eye 0.5,0.45,0.5 --target 1,0.5,0.5 --size 1200x600",
            },
        ],
    },
    Figure {
        name: "fields",
        caption: "Several fields of a supernova remnant (demo data) in one march.",
        pictures: &[
            Picture { title: "density", flags: "render DEMO --field density --opacity 2 --color-bar" },
            Picture {
                title: "density, coloured by temperature",
                flags: "render DEMO --field density --opacity 2 --color-by temperature:turbo:0,1.5 --color-bar",
            },
            Picture {
                title: "density, and where it is hot",
                flags: "render DEMO --field density --tf gray --overlay temperature:inferno:3,4.5:4 --color-bar",
            },
            Picture {
                title: "light between surfaces and volume",
                flags: "render DEMO --mode path --spp 128 --iso 0.6:0.9,0.6,0.3 --slice z:0.02 --light ambient:0.5 --light \
                        directional:-1,0.5,-2:0.6",
            },
        ],
    },
    Figure {
        name: "codes",
        caption: "What simulations wrote, after the paper's figure 9, with no flags but the camera's.",
        pictures: &[
            Picture {
                title: "Chombo: an explosion",
                flags: "render DATA/chombo/explosion_large.3d.hdf5 --axes --color-bar",
            },
            Picture { title: "GRChombo: two black holes", flags: "render DATA/chombo/bbh_small.3d.hdf5 --color-bar" },
            Picture { title: "AMReX: advection", flags: "render DATA/amrex/plt_small --shading --color-bar" },
            Picture {
                title: "column density",
                flags: "project DATA/chombo/explosion_large.3d.hdf5 --reduction integral --orthographic",
            },
        ],
    },
];
