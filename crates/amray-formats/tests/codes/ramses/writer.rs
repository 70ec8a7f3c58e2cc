//! Writes RAMSES outputs record by record, as the code's own routines do.

use std::collections::HashSet;
use std::fmt::Write;
use std::fs;
use std::path::Path;

/// The form of `hydro_file_descriptor.txt`.
#[derive(Clone, Copy)]
pub(super) enum Descriptor {
    /// `variable # 1: density`
    Lines,
    /// `1, density, d`
    Table,
}

const VARIABLES: [&str; 5] = ["density", "velocity_x", "velocity_y", "velocity_z", "pressure"];
const CPUS: usize = 3;
/// `nlevelmax`: more than there are.
const LEVELS: usize = 25;
/// The width of a coarse cell.
const WIDTH: f64 = 2.5;

/// A grid of 2x2x2 cells.
struct Grid {
    /// In grids of its level, from coarse cell 0 on.
    place: [i64; 3],
    /// The list that it is in: a process's, or after those a boundary's.
    list: usize,
    /// The child in each cell, 0 where there is none.
    sons: [i32; 8],
}

/// An output of several processes.
pub(super) struct Output {
    /// Coarse cells, and those of them that are inside the boundaries.
    coarse: [i32; 3],
    inner: [[i32; 3]; 2],
    boundaries: usize,
    pub(super) level_min: usize,
    /// By level, that of the coarse cells' grids first.
    levels: Vec<Vec<Grid>>,
    /// By process, the levels and places of the grids that it has or has copies of.
    known: Vec<HashSet<(usize, [i64; 3])>>,
    /// The finest level all of whose grids exist.
    full: usize,
    pub(super) single: bool,
    big_endian: bool,
    descriptor: Descriptor,
}

impl Output {
    /// A box, all of whose cells below the level `level_min` are refined, and others where `refined` says so of their
    /// level and centre (in boxes).
    pub(super) fn new(level_min: usize, refined: impl Fn(usize, [f64; 3]) -> bool) -> Self {
        Self::inside([1; 3], [[0; 3], [1; 3]], 0, level_min, refined)
    }

    /// As [`Output::new`], of several coarse cells.
    pub(super) fn inside(
        coarse: [i32; 3],
        inner: [[i32; 3]; 2],
        boundaries: usize,
        level_min: usize,
        refined: impl Fn(usize, [f64; 3]) -> bool,
    ) -> Self {
        let mut levels: Vec<Vec<Grid>> = Vec::new();
        let mut places = Vec::new();
        for (k, j, i) in product(coarse) {
            places.push([i, j, k].map(i64::from));
        }
        let mut number = 0;
        while !places.is_empty() {
            let level = levels.len() + 1;
            let (mut grids, mut children) = (Vec::new(), Vec::new());
            for place in places {
                let first = place.map(|index| index >> (level - 1));
                let is_inner =
                    (0..3).all(|axis| (i64::from(inner[0][axis])..i64::from(inner[1][axis])).contains(&first[axis]));
                // Boundaries lie along x.
                let beyond = usize::from(first[0] > i64::from(inner[0][0])).min(boundaries.saturating_sub(1));
                let list = if is_inner { (place[0] + 2 * place[1] + place[2]) as usize % CPUS } else { CPUS + beyond };
                let mut grid = Grid { place, list, sons: [0; 8] };
                for cell in 0..8 {
                    let index = cell_of(&grid, cell);
                    let center = index.map(|index| (index as f64 + 0.5) / 2f64.powi(level as i32));
                    let center = std::array::from_fn(|axis| center[axis] - f64::from(inner[0][axis]));
                    if is_inner && (level < level_min || refined(level, center)) {
                        number += 1;
                        grid.sons[cell] = number;
                        children.push(index);
                    }
                }
                grids.push(grid);
            }
            levels.push(grids);
            places = children;
        }
        let (single, big_endian, descriptor) = (false, false, Descriptor::Table);
        let (full, known) = (level_min, known(&levels));
        Self { coarse, inner, boundaries, level_min, levels, known, full, single, big_endian, descriptor }
    }

    /// The same, to be written in another form.
    pub(super) fn in_form(self, single: bool, big_endian: bool, descriptor: Descriptor) -> Self {
        Self { single, big_endian, descriptor, ..self }
    }

    /// What is written of a variable at a position.
    pub(super) fn value([x, y, z]: [f64; 3], variable: usize) -> f64 {
        (variable as f64 + 1.0) * (1.0 + x + 10.0 * y + 100.0 * z)
    }

    /// Cells of each level of the hierarchy.
    pub(super) fn cells_by_level(&self) -> Vec<u64> {
        let inside = |grids: &Vec<Grid>| grids.iter().filter(|grid| grid.list < CPUS).count() as u64;
        self.levels.iter().skip(self.full - 1).map(|grids| 8 * inside(grids)).collect()
    }

    /// The centres of all leaf cells.
    pub(super) fn leaves(&self) -> Vec<[f64; 3]> {
        let levels = self.levels.iter().enumerate();
        let grids = levels.flat_map(|(level, grids)| grids.iter().map(move |grid| (level, grid)));
        let cells = grids.flat_map(|(level, grid)| (0..8).map(move |cell| (level, grid, cell)));
        let leaves = cells.filter(|(_, grid, cell)| grid.list < CPUS && grid.sons[*cell] == 0);
        leaves.map(|(level, grid, cell)| self.center(level, grid, cell)).collect()
    }

    /// The position of a cell.
    fn center(&self, level: usize, grid: &Grid, cell: usize) -> [f64; 3] {
        std::array::from_fn(|axis| {
            let index = cell_of(grid, cell)[axis] as f64 + 0.5;
            WIDTH * (index / 2f64.powi(level as i32 + 1) - f64::from(self.inner[0][axis]))
        })
    }

    pub(super) fn write(&self, directory: &Path) {
        fs::write(directory.join("info_00080.txt"), self.info()).unwrap();
        fs::write(directory.join("hydro_file_descriptor.txt"), self.names()).unwrap();
        for cpu in 0..CPUS {
            fs::write(directory.join(format!("amr_00080.out{:05}", cpu + 1)), self.mesh(cpu)).unwrap();
            fs::write(directory.join(format!("hydro_00080.out{:05}", cpu + 1)), self.values(cpu)).unwrap();
        }
    }

    fn info(&self) -> String {
        let mut text = String::new();
        let counts = [("ncpu", CPUS), ("ndim", 3), ("levelmin", self.level_min), ("levelmax", LEVELS)];
        for (key, count) in counts.into_iter().chain([("ngridmax", 100_000), ("nstep_coarse", 9)]) {
            writeln!(text, "{key:12}={count:11}").unwrap();
        }
        let numbers = [("boxlen", WIDTH), ("time", 0.75), ("aexp", 1.0), ("H0", 1.0)];
        let cosmology = ["omega_m", "omega_l", "omega_k", "omega_b"].map(|key| (key, 0.0));
        let units = [("unit_l", 4.0), ("unit_d", 0.5), ("unit_t", 2.0)];
        writeln!(text).unwrap();
        for (key, number) in [&numbers[..], &cosmology, &units].concat() {
            writeln!(text, "{key:12}={:>23}", fortran(number)).unwrap();
        }
        writeln!(text, "\nordering type={:80}", "hilbert").unwrap();
        writeln!(text, "   DOMAIN   ind_min                 ind_max").unwrap();
        for cpu in 0..CPUS {
            let [low, high] = [cpu, cpu + 1].map(|key| fortran(key as f64));
            writeln!(text, "{:8} {low:>23} {high:>23}", cpu + 1).unwrap();
        }
        text
    }

    fn names(&self) -> String {
        let mut text = match self.descriptor {
            Descriptor::Lines => format!("nvar        ={:11}\n", VARIABLES.len()),
            Descriptor::Table => "# version:  1\n# ivar, variable_name, variable_type\n".into(),
        };
        for (place, name) in VARIABLES.iter().enumerate() {
            match self.descriptor {
                Descriptor::Lines => writeln!(text, "variable #{:2}: {name}", place + 1),
                Descriptor::Table => writeln!(text, "{:3}, {name}, {}", place + 1, if self.single { "f" } else { "d" }),
            }
            .unwrap();
        }
        text
    }

    /// The grids of a list that a process knows, on a level.
    fn known(&self, cpu: usize, level: usize, list: usize) -> Vec<&Grid> {
        let of_list = self.levels.get(level).into_iter().flatten().filter(|grid| grid.list == list);
        let is_known = |grid: &&Grid| list >= CPUS || self.known[cpu].contains(&(level, grid.place));
        of_list.filter(is_known).collect()
    }

    /// How many grids there are in each list of each level.
    fn counts(&self, cpu: usize, lists: std::ops::Range<usize>) -> Vec<i32> {
        let levels = (0..LEVELS).flat_map(|level| lists.clone().map(move |list| (level, list)));
        levels.map(|(level, list)| self.known(cpu, level, list).len() as i32).collect()
    }

    fn mesh(&self, cpu: usize) -> Vec<u8> {
        let mut file = self.file();
        file.integers(&[CPUS as i32]);
        file.integers(&[3]);
        file.integers(&self.coarse);
        for number in [LEVELS as i32, 100_000, self.boundaries as i32, 77] {
            file.integers(&[number]);
        }
        file.reals(&[WIDTH]);
        file.integers(&[2, 1, 80]);
        file.reals(&[0.5, 1.0]);
        file.reals(&[1.0, 1.0]);
        file.reals(&[0.75]);
        file.reals(&[0.1; LEVELS]);
        file.reals(&[0.1; LEVELS]);
        file.integers(&[9, 9]);
        for numbers in [3, 7, 5, 1] {
            file.reals(&vec![0.0; numbers]);
        }
        for count in [CPUS, self.boundaries].into_iter().filter(|count| *count > 0) {
            let lists = if count == CPUS { 0..CPUS } else { CPUS..CPUS + count };
            let counts = self.counts(cpu, lists.clone());
            file.integers(&counts);
            file.integers(&counts);
            file.integers(&counts);
            if lists.start == 0 {
                file.integers(&[0; 10 * LEVELS]);
            }
        }
        file.integers(&[1, 2, 3, 4, 5]);
        file.record(format!("{:128}", "hilbert").as_bytes());
        file.reals(&[0.0; CPUS + 1]);
        let coarse_cells = self.coarse.iter().product::<i32>() as usize;
        for _ in 0..3 {
            file.integers(&vec![1; coarse_cells]);
        }
        for (level, list) in self.lists() {
            let grids = self.known(cpu, level, list);
            if !grids.is_empty() {
                write_grids(&mut file, level, &grids);
            }
        }
        file.bytes
    }

    fn values(&self, cpu: usize) -> Vec<u8> {
        let mut file = self.file();
        for number in [CPUS, VARIABLES.len(), 3, LEVELS, self.boundaries] {
            file.integers(&[number as i32]);
        }
        file.reals(&[1.4]);
        for (level, list) in self.lists() {
            let grids = self.known(cpu, level, list);
            file.integers(&[level as i32 + 1]);
            file.integers(&[grids.len() as i32]);
            for cell in (0..8).filter(|_| !grids.is_empty()) {
                for variable in 0..VARIABLES.len() {
                    // Values of copies must not be looked at.
                    let value = |grid: &&Grid| match list == cpu {
                        true => Self::value(self.center(level, grid, cell), variable),
                        false => f64::NAN,
                    };
                    file.reals(&grids.iter().map(value).collect::<Vec<f64>>());
                }
            }
        }
        file.bytes
    }

    fn lists(&self) -> impl Iterator<Item = (usize, usize)> {
        let lists = CPUS + self.boundaries;
        (0..LEVELS).flat_map(move |level| (0..lists).map(move |list| (level, list)))
    }

    fn file(&self) -> Records {
        Records { bytes: Vec::new(), big_endian: self.big_endian, single: self.single }
    }
}

/// By process, the levels and places of its grids, of all that they lie in, and of their children.
fn known(levels: &[Vec<Grid>]) -> Vec<HashSet<(usize, [i64; 3])>> {
    let mut known = vec![HashSet::new(); CPUS];
    for (level, grid) in
        levels.iter().enumerate().flat_map(|(level, grids)| grids.iter().map(move |grid| (level, grid)))
    {
        let Some(of_cpu) = known.get_mut(grid.list) else { continue };
        of_cpu.extend((0..=level).map(|up| (level - up, grid.place.map(|index| index >> up))));
        let children = (0..8).filter(|cell| grid.sons[*cell] > 0);
        of_cpu.extend(children.map(|cell| (level + 1, cell_of(grid, cell))));
    }
    known
}

/// The place of a grid's cell, in cells of its level.
fn cell_of(grid: &Grid, cell: usize) -> [i64; 3] {
    std::array::from_fn(|axis| 2 * grid.place[axis] + (cell >> axis & 1) as i64)
}

/// What a file of a mesh has of the grids of a list.
fn write_grids(file: &mut Records, level: usize, grids: &[&Grid]) {
    let numbers: Vec<i32> = (1..=grids.len() as i32).collect();
    for _ in 0..3 {
        file.integers(&numbers);
    }
    for axis in 0..3 {
        let center = |grid: &&Grid| (grid.place[axis] as f64 + 0.5) / 2f64.powi(level as i32);
        file.reals(&grids.iter().map(center).collect::<Vec<f64>>());
    }
    for _ in 0..7 {
        file.integers(&numbers);
    }
    for cell in 0..8 {
        file.integers(&grids.iter().map(|grid| grid.sons[cell]).collect::<Vec<i32>>());
    }
    for _ in 0..2 * 8 {
        file.integers(&numbers);
    }
}

/// A number as the format E23.15 has it, for which its first digit is a tenth.
fn fortran(number: f64) -> String {
    let exponent = if number == 0.0 { 0 } else { number.log10().floor() as i32 + 1 };
    format!("{:.15}E{exponent:+03}", number / 10f64.powi(exponent))
}

/// A file of Fortran's records.
struct Records {
    bytes: Vec<u8>,
    big_endian: bool,
    single: bool,
}

impl Records {
    fn record(&mut self, content: &[u8]) {
        let mark = self.ordered((content.len() as u32).to_le_bytes());
        self.bytes.extend([&mark, content, &mark].concat());
    }

    fn integers(&mut self, numbers: &[i32]) {
        let content: Vec<u8> = numbers.iter().flat_map(|number| self.ordered(number.to_le_bytes())).collect();
        self.record(&content);
    }

    fn reals(&mut self, numbers: &[f64]) {
        let content: Vec<u8> = match self.single {
            true => numbers.iter().flat_map(|&number| self.ordered((number as f32).to_le_bytes())).collect(),
            false => numbers.iter().flat_map(|&number| self.ordered(number.to_le_bytes())).collect(),
        };
        self.record(&content);
    }

    fn ordered<const N: usize>(&self, mut bytes: [u8; N]) -> [u8; N] {
        if self.big_endian {
            bytes.reverse();
        }
        bytes
    }
}

fn product([x, y, z]: [i32; 3]) -> impl Iterator<Item = (i32, i32, i32)> {
    (0..z).flat_map(move |k| (0..y).flat_map(move |j| (0..x).map(move |i| (k, j, i))))
}
