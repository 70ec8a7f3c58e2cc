//! The mesh files: the octree's grids of 2x2x2 cells, level by level and process by process.
//!
//! The layout is that of RAMSES' own `backup_amr`. Each process writes its own grids, copies of grids of other ones
//! around them, and those beyond the domain's boundaries.

use std::path::Path;

use super::fortran::{Records, real_of};
use crate::FormatError;
use crate::mapped_file::map;

/// Places on the finest level must be exact numbers.
const MOST_LEVELS: usize = 50;
const MOST_COARSE_CELLS: i32 = 1 << 9;
/// Records between the numbers of steps and the lists of grids, which do not matter here: energies, cosmology, expansion
/// and the mass of particles.
const OTHER_PARAMETERS: usize = 4;
/// Records of a grid's own number, and those of its neighbours in the list.
const LINKS: usize = 3;
/// Records after the grids' centres: the parent, its six neighbours, and for each cell its child, process and flag.
const RELATIONS: usize = 1 + 6 + 3 * 8;
/// Centres are written in the precision of the run: so many cells may they be off.
const TOLERANCE: f64 = 0.01;

/// The counts that all files share.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Header {
    pub(super) cpus: usize,
    /// Regions beyond the domain, whose grids are listed after those of the processes.
    pub(super) boundaries: usize,
    /// Coarse cells along each axis, those beyond the domain included.
    coarse: [i32; 3],
    /// As many as there may be.
    pub(super) levels: usize,
}

/// The grids of a process alone.
pub(super) struct Mesh {
    pub(super) header: Header,
    /// On each level (of which the first one has one grid in each coarse cell) the grids' places, in grids of the level.
    pub(super) levels: Vec<Vec<[i64; 3]>>,
}

impl Mesh {
    /// The grids that the process `cpu` (from 0 on) has in its file.
    pub(super) fn read(path: &Path, cpu: usize) -> Result<Self, FormatError> {
        let map = map(path)?;
        let mut records = Records::new(path, &map)?;
        let header = Header::read(&mut records)?;
        if cpu >= header.cpus {
            let problem = format!("{} processes, expected more than {cpu}", header.cpus);
            return Err(FormatError::malformed(path, "ncpu", problem));
        }
        let counts = counts(&mut records, &header)?;
        pass_domains(&mut records, &header)?;
        let mut levels = Vec::with_capacity(header.levels);
        for (level, counts) in counts.iter().enumerate() {
            let mut own = Vec::new();
            for (list, &count) in counts.iter().enumerate().filter(|(_, count)| **count > 0) {
                let what = format!("grids of level {}, list {}", level + 1, list + 1);
                if list == cpu {
                    own = own_grids(&mut records, &header, level, count, &what)?;
                } else {
                    pass_grids(&mut records, count, &what)?;
                }
            }
            levels.push(own);
        }
        Ok(Self { header, levels })
    }
}

impl Header {
    /// Reads what comes before the lists of grids.
    fn read(records: &mut Records) -> Result<Self, FormatError> {
        let cpus = count(records, "ncpu", 1..=i32::MAX)?;
        count(records, "ndim", 3..=3)?;
        let coarse = records.integers(3, "nx, ny, nz")?;
        let coarse = [coarse[0], coarse[1], coarse[2]];
        if coarse.iter().any(|cells| !(1..=MOST_COARSE_CELLS).contains(cells)) {
            let expected = format!("expected 1 to {MOST_COARSE_CELLS} along each axis");
            return Err(records.malformed("nx, ny, nz", &format!("{coarse:?} coarse cells, {expected}")));
        }
        let levels = count(records, "nlevelmax", 1..=MOST_LEVELS as i32)?;
        records.integer("ngridmax")?;
        let boundaries = count(records, "nboundary", 0..=i32::MAX)?;
        records.integer("ngrid_current")?;
        records.reals(1, "boxlen")?;
        records.integers(3, "noutput, iout, ifout")?;
        for what in ["tout", "aout"] {
            records.record(what)?;
        }
        records.reals(1, "t")?;
        for what in ["dtold", "dtnew"] {
            records.reals(levels, what)?;
        }
        records.integers(2, "nstep, nstep_coarse")?;
        for _ in 0..OTHER_PARAMETERS {
            records.record("parameters of the run")?;
        }
        Ok(Self { cpus, boundaries, coarse, levels })
    }
}

/// A record of one integer in a range.
fn count(records: &mut Records, what: &str, range: std::ops::RangeInclusive<i32>) -> Result<usize, FormatError> {
    let found = records.integer(what)?;
    let expected = || match (*range.start(), *range.end()) {
        (least, i32::MAX) => format!("{least} or more"),
        (least, most) if least == most => least.to_string(),
        (least, most) => format!("{least} to {most}"),
    };
    match usize::try_from(found) {
        Ok(count) if range.contains(&found) => Ok(count),
        _ => Err(records.malformed(what, &format!("{found}, expected {}", expected()))),
    }
}

/// The numbers of grids in each list of each level.
fn counts(records: &mut Records, header: &Header) -> Result<Vec<Vec<usize>>, FormatError> {
    let of_cpus = lists(records, header.cpus, header.levels, ["headl", "taill", "numbl"])?;
    records.record("numbtot")?;
    let of_boundaries = if header.boundaries > 0 {
        lists(records, header.boundaries, header.levels, ["headb", "tailb", "numbb"])?
    } else {
        vec![Vec::new(); header.levels]
    };
    // Three lists of nothing, where boundaries are switched on but there are none.
    while header.boundaries == 0 && records.next_length("free memory")? == 0 {
        records.record("free memory")?;
    }
    Ok(of_cpus.into_iter().zip(of_boundaries).map(|(cpus, boundaries)| [cpus, boundaries].concat()).collect())
}

/// The third of three records with a number per list and level, the lists' first: how many grids there are.
fn lists(
    records: &mut Records,
    count: usize,
    levels: usize,
    [first, last, number]: [&str; 3],
) -> Result<Vec<Vec<usize>>, FormatError> {
    let all = count.saturating_mul(levels);
    for what in [first, last] {
        records.alike(1, all.saturating_mul(4), what)?;
    }
    let numbers = records.integers(all, number)?;
    let positive = |&found: &i32| {
        usize::try_from(found).map_err(|_| records.malformed(number, &format!("{found}, expected 0 or more before")))
    };
    numbers.chunks(count).map(|level| level.iter().map(positive).collect()).collect()
}

/// Passes over the free memory, the processes' domains and the coarse cells.
fn pass_domains(records: &mut Records, header: &Header) -> Result<(), FormatError> {
    records.record("free memory")?;
    let ordering = records.record("ordering")?;
    let boundaries = if ordering.trim_ascii() == b"bisection" { 5 } else { 1 };
    for _ in 0..boundaries {
        records.record("domains of processes")?;
    }
    let cells: usize = header.coarse.iter().map(|cells| cells.unsigned_abs() as usize).product();
    for what in ["son", "flag1", "cpu_map"] {
        records.alike(1, cells * 4, what)?;
    }
    Ok(())
}

/// The places of grids.
fn own_grids(
    records: &mut Records,
    header: &Header,
    level: usize,
    count: usize,
    what: &str,
) -> Result<Vec<[i64; 3]>, FormatError> {
    records.alike(LINKS, count.saturating_mul(4), what)?;
    let per_coarse_cell = 2f64.powi(level as i32);
    let mut places = Vec::new();
    for axis in 0..3 {
        let centers = records.reals(count, what)?;
        places.resize(count, [0; 3]);
        for (place, center) in places.iter_mut().zip(centers) {
            let index = center * per_coarse_cell - 0.5;
            let inside = index.round() >= 0.0 && index.round() < f64::from(header.coarse[axis]) * per_coarse_cell;
            if !inside || (index - index.round()).abs() > TOLERANCE {
                let problem = format!("a centre at {center}, expected that of a cell of the level below in the domain");
                return Err(records.malformed(what, &problem));
            }
            place[axis] = index.round() as i64;
        }
    }
    records.alike(RELATIONS, count.saturating_mul(4), what)?;
    Ok(places)
}

/// Passes over grids of others.
fn pass_grids(records: &mut Records, count: usize, what: &str) -> Result<(), FormatError> {
    records.alike(LINKS, count.saturating_mul(4), what)?;
    let length = records.next_length(what)?;
    if real_of(length, count).is_none() {
        return Err(records.malformed(what, &format!("a record of {length} bytes, expected {count} reals")));
    }
    records.alike(3, length, what)?;
    records.alike(RELATIONS, count.saturating_mul(4), what)?;
    Ok(())
}
