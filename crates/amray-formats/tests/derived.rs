//! Fields that follow from others: by expressions that users write and by those that files keep.

use std::path::PathBuf;
use std::sync::atomic::{AtomicU64, Ordering};

use amray::hierarchy::{Field, Residence, VoxelType};
use amray_formats::{DataSet, FormatError, OpenOptions, derived_fields, open, read_named};
use amray_testing::real_data;

struct Opened {
    path: PathBuf,
    data: Box<dyn DataSet>,
}

impl Opened {
    /// A real file, where it is there.
    fn real(name: &str) -> Option<Self> {
        let path = real_data(name)?;
        let data = open(&path, &OpenOptions::default()).unwrap_or_else(|error| panic!("{error}"));
        Some(Self { path, data })
    }

    fn read(&self, name: &str) -> Result<Field, FormatError> {
        read_named(&self.path, &*self.data, name, &|field| field, &|_| {})
    }

    fn field(&self, name: &str) -> Field {
        self.read(name).unwrap_or_else(|error| panic!("{error}"))
    }

    fn failure(&self, name: &str) -> String {
        let message = self.read(name).unwrap_err().to_string();
        message.strip_prefix(&format!("{}: ", self.path.display())).expect("an error starts with the path").to_owned()
    }

    /// Calls `visit` with the values of some fields in every cell.
    fn for_each_cell<const N: usize>(&self, names: [&str; N], mut visit: impl FnMut([f64; N])) {
        let fields = names.map(|name| self.field(name));
        for (place, brick) in self.data.hierarchy().bricks().enumerate() {
            for cell in brick.cells.iter() {
                let inside = std::array::from_fn(|axis| (cell[axis] - brick.cells.low[axis]) as usize);
                visit(std::array::from_fn(|field| fields[field].value(place, inside)));
            }
        }
    }
}

fn close(found: f64, expected: f64, digits: f64) -> bool {
    (found - expected).abs() <= digits * expected.abs().max(1.0)
}

#[test]
fn expressions_in_files_are_what_they_say() {
    for (file, digits) in [("explosion_small", 1e-13), ("explosion_f32series.000004", 1e-6), ("ramp_noncubic", 1e-13)] {
        let Some(opened) = Opened::real(&format!("chombo/{file}.3d.hdf5")) else { return };
        let stored = ["density", "x-momentum", "y-momentum", "z-momentum", "energy-density"];
        let [density, x, y, z, energy] = stored;
        let [pressure, soundspeed, entropy] = ["pressure", "soundspeed", "log10entropy"];
        opened.for_each_cell(
            [density, x, y, z, energy, pressure, soundspeed, entropy, "y-velocity", "velocity_z"],
            |[density, x, y, z, energy, pressure, soundspeed, entropy, y_velocity, velocity_z]| {
                let expected = 0.4 * (energy - (x * x + y * y + z * z) / (2.0 * density));
                assert!(close(pressure, expected, 10.0 * digits * energy), "{file}: {pressure}, expected {expected}");
                assert!(close(y_velocity, y / density, digits) && close(velocity_z, z / density, digits), "{file}");
                if file == "explosion_small" {
                    assert!(close(soundspeed, (1.4 * expected / density).sqrt(), 1e-11), "{soundspeed}");
                    assert!(close(entropy, expected.log10() - 1.4 * density.log10(), 1e-11), "{entropy}");
                }
            },
        );
        let single = opened.data.fields()[0].voxel_type == VoxelType::F32;
        assert_eq!(opened.field(pressure).voxel_type() == VoxelType::F32, single, "{file}");
    }
}

#[test]
fn derived_fields_are_those_that_can_be_evaluated() {
    let names = |file: &str| {
        let opened = Opened::real(file)?;
        Some(derived_fields(&*opened.data).into_iter().map(|derived| derived.name).collect::<Vec<_>>())
    };
    let Some(small) = names("chombo/explosion_small.3d.hdf5") else { return };
    let expected = "kinetic_energy log10entropy pressure soundspeed x-velocity y-velocity z-velocity velocity_x velocity_y \
                    velocity_z";
    assert_eq!(small.join(" "), expected);
    // Reduced to the density, from which none of its formulas follow; and files without formulas.
    for file in ["chombo/explosion_large.3d.hdf5", "chombo/bbh_small.3d.hdf5", "amrex/plt_small"] {
        assert_eq!(names(file).unwrap(), [""; 0], "{file}");
    }
}

#[test]
fn a_name_that_there_is_wins_over_an_expression() {
    let Some(opened) = Opened::real("chombo/edge_negative_lo.3d.hdf5") else { return };
    let name = "linear x+10y+100z";
    assert_eq!(opened.field(name).bytes(Residence::Owned), 0, "mapped, not evaluated");
    // In a formula it stands in brackets; alone in brackets it stays where it is.
    let bracketed = opened.field("<linear x+10y+100z>");
    assert_eq!((bracketed.name(), bracketed.bytes(Residence::Owned)), ("<linear x+10y+100z>", 0));
    opened.for_each_cell([name, "<linear x+10y+100z> * 2"], |[one, two]| assert_eq!(two, 2.0 * one));
}

#[test]
fn each_input_is_prepared_and_progress_goes_up() {
    let Some(opened) = Opened::real("chombo/explosion_small.3d.hdf5") else { return };
    let Opened { path, data } = &opened;
    let told = AtomicU64::new(0);
    let progress = |share: f64| {
        assert!((0.0..=1.0).contains(&share));
        told.fetch_max(share.to_bits(), Ordering::Relaxed);
    };
    let restrict = |field: Field| field.restricted(data.hierarchy());
    read_named(path, &**data, "gradient_magnitude(pressure)", &restrict, &progress).unwrap();
    assert_eq!(f64::from_bits(told.into_inner()), 1.0);
    let doubled = |field: Field| {
        let value = field.value(0, [0; 3]);
        Field::from_fn(field.name(), data.hierarchy(), |_, _| 2.0 * value)
    };
    let found = read_named(path, &**data, "density + 1", &doubled, &|_| {}).unwrap();
    assert_eq!(found.value(0, [0; 3]), 2.0 * (2.0 * opened.field("density").value(0, [0; 3]) + 1.0));
}

#[test]
fn errors_list_the_fields_and_suggest_the_nearest() {
    let Some(opened) = Opened::real("amrex/plt_small") else { return };
    let known: Vec<&str> = opened.data.fields().iter().map(|field| field.name.as_str()).collect();
    let (first, known) = (known[0], known.join(", "));
    let typo = &first[..first.len() - 1];
    for (text, expected) in [
        ("sqrt(x", format!("expression \"sqrt(x\": column 7: expected ')'; the fields are {known}")),
        (typo, format!("no field \"{typo}\", did you mean \"{first}\"?; the fields are {known}")),
        (
            &format!("2*{typo}"),
            format!(
                "expression \"2*{typo}\": column 3: no field \"{typo}\", did you mean \"{first}\"?; the fields are {known}"
            ),
        ),
        ("qqq+1", format!("expression \"qqq+1\": column 1: no field \"qqq\"; the fields are {known}")),
    ] {
        assert_eq!(opened.failure(text), expected);
    }
    let long = opened.failure(&"(".repeat(1 << 20));
    assert!(long.len() < 500 && long.contains("expected at most 4096"), "{long}");
    assert!(opened.read("x^2 + level").is_ok(), "no field is needed");
}

#[test]
fn what_is_meant_by_a_dash_and_what_a_formula_lacks_is_said() {
    let Some(opened) = Opened::real("chombo/explosion_small.3d.hdf5") else { return };
    let message = opened.failure("x-momentun");
    assert!(message.contains("column 3: no field \"momentun\", did you mean \"x-momentum\"?"), "{message}");
    let Some(reduced) = Opened::real("chombo/explosion_large.3d.hdf5") else { return };
    let message = reduced.failure("pressure");
    assert!(message.contains("in pressure = ") && message.contains("no field \"energy-density\""), "{message}");
}
