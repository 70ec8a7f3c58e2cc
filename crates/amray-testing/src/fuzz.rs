//! Readers against damaged files: a corpus of data sets that must be read, and of nasty ones that must do no harm, and as
//! many changes of them as there is time for.
//!
//! A corpus is a directory with `seeds` and `nasty`, in each a directory per case, which holds one data set. What makes a
//! reader panic, take long or fill the memory becomes a nasty case. Inputs that lead to an error not met before are changed
//! further: so changes come deeper into a reader than chance alone would bring them.

use std::collections::HashSet;
use std::ffi::OsStr;
use std::fs;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use crate::Random;

/// For each seed, unless `AMRAY_FUZZ_SECONDS` says otherwise.
const SECONDS: f64 = 0.25;
/// What any input may take; readers of files this small take milliseconds.
const LONGEST: Duration = Duration::from_secs(10);
/// In bytes, beyond what was taken before.
const MOST_MEMORY: u64 = 1 << 30;
/// Changed inputs that are kept to be changed further, for each file.
const MOST_KEPT: usize = 500;

/// Reads what is at a path; errors are fine.
pub type Reader<'a> = &'a dyn Fn(&Path) -> Result<(), String>;

/// Reads all cases of a corpus, and changed ones.
///
/// # Panics
/// Where a seed cannot be read, or a reader panics, takes long or fills the memory; the message says where the input is.
pub fn fuzz(corpus: &Path, read: Reader) {
    for case in cases(&corpus.join("nasty")) {
        let _ = examined(&case, read).unwrap_or_else(|problem| panic!("{}: {problem}", case.display()));
    }
    let asked: Option<f64> = std::env::var("AMRAY_FUZZ_SECONDS").ok().and_then(|seconds| seconds.parse().ok());
    // Short runs are always the same, as far as they come.
    let start =
        asked.map_or(0, |_| SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |now| now.as_nanos() as u64));
    let seeds = cases(&corpus.join("seeds"));
    assert!(!seeds.is_empty(), "{}: no seeds", corpus.display());
    for seed in seeds {
        let case = Case::new(&seed);
        examined(&case.directory, read)
            .and_then(|read| read)
            .unwrap_or_else(|problem| panic!("{}: {problem}", seed.display()));
        case.change(&corpus.join("nasty"), asked.unwrap_or(SECONDS), Random(start), read);
    }
}

/// The directories in a directory, if there is one.
fn cases(directory: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(directory).into_iter().flatten().flatten();
    let mut cases: Vec<PathBuf> = entries.map(|entry| entry.path()).filter(|path| path.is_dir()).collect();
    cases.sort();
    cases
}

/// The files below a directory, as paths from it on.
fn files(directory: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut left = vec![PathBuf::new()];
    while let Some(below) = left.pop() {
        let mut names: Vec<_> =
            fs::read_dir(directory.join(&below)).unwrap().map(|entry| entry.unwrap().file_name()).collect();
        names.sort();
        for name in names {
            let path = below.join(name);
            if directory.join(&path).is_dir() { left.push(path) } else { found.push(path) }
        }
    }
    found
}

/// The data set in a directory: a file alone or the one beside a directory of its name, else the directory itself.
fn data_set(directory: &Path) -> PathBuf {
    let mut entries: Vec<PathBuf> = fs::read_dir(directory).unwrap().map(|entry| entry.unwrap().path()).collect();
    entries.sort();
    match &entries[..] {
        [file] => file.clone(),
        [directory, index] if index.is_file() && index.with_extension("") == *directory => index.clone(),
        _ => directory.into(),
    }
}

/// Reads a case: what the reader said, or what harm it did.
fn examined(case: &Path, read: Reader) -> Result<Result<(), String>, String> {
    let (before, start) = (peak_memory(), Instant::now());
    let result = catch_unwind(AssertUnwindSafe(|| read(&data_set(case)))).map_err(|panic| {
        let text = panic.downcast_ref::<String>().cloned();
        let text = text.or_else(|| panic.downcast_ref::<&str>().map(|text| (*text).to_owned()));
        format!("the reader panics: {}", text.unwrap_or_default())
    })?;
    let (taken, memory) = (start.elapsed(), peak_memory().saturating_sub(before));
    if taken > LONGEST {
        return Err(format!("the reader takes {} s", taken.as_secs()));
    }
    if memory > MOST_MEMORY {
        return Err(format!("the reader takes {memory} bytes of memory"));
    }
    Ok(result)
}

/// The most memory that this process ever had, in bytes; 0 where the system does not tell.
fn peak_memory() -> u64 {
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let peak = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    peak.and_then(|peak| peak.trim().trim_end_matches(" kB").parse::<u64>().ok()).unwrap_or(0) * 1024
}

/// A copy of a seed, whose files are changed. It stays where it is when the process dies: the last input is in it.
struct Case {
    directory: PathBuf,
    name: String,
    files: Vec<PathBuf>,
}

impl Case {
    fn new(seed: &Path) -> Self {
        let name = seed.file_name().map(OsStr::to_string_lossy).unwrap_or_default().into_owned();
        let directory = std::env::temp_dir().join(format!("amray-fuzz-{}-{name}", std::process::id()));
        let files = files(seed);
        copy(seed, &files, &directory);
        Self { directory, name, files }
    }

    /// Changes a file again and again.
    fn change(&self, nasty: &Path, seconds: f64, mut random: Random, read: Reader) {
        let end = Instant::now() + Duration::from_secs_f64(seconds);
        let mut pools: Vec<Vec<Vec<u8>>> =
            self.files.iter().map(|file| vec![fs::read(self.directory.join(file)).unwrap()]).collect();
        let mut met = HashSet::new();
        while Instant::now() < end {
            let number = random.integer(0, self.files.len() as i64 - 1) as usize;
            let pool = &mut pools[number];
            // Half of the time a seed, else one of what came out of it.
            let base = if random.chance(0.5) { 0 } else { random.integer(0, pool.len() as i64 - 1) as usize };
            let mut content = pool[base].clone();
            for _ in 0..random.integer(1, 4) {
                mutate(&mut content, &mut random);
            }
            let file = self.directory.join(&self.files[number]);
            fs::write(&file, &content).unwrap();
            match examined(&self.directory, read) {
                Err(harm) => {
                    let kept = nasty.join(format!("{}-{:08x}", self.name, random.bits() as u32));
                    copy(&self.directory, &self.files, &kept);
                    panic!("{harm}; the input is in {}", kept.display());
                }
                Ok(said) => {
                    let said = said.err().unwrap_or_default();
                    let shape: String = said.chars().filter(|character| character.is_alphabetic()).collect();
                    if met.insert(shape) && pool.len() < MOST_KEPT {
                        pool.push(content);
                    }
                }
            }
            fs::write(&file, &pools[number][0]).unwrap();
        }
    }
}

impl Drop for Case {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.directory);
    }
}

fn copy(from: &Path, files: &[PathBuf], to: &Path) {
    for file in files {
        let target = to.join(file);
        fs::create_dir_all(target.parent().unwrap()).unwrap();
        fs::write(target, fs::read(from.join(file)).unwrap()).unwrap();
    }
}

/// Numbers that programs get wrong, in text.
const NUMBERS: [&str; 14] = [
    "0",
    "-1",
    "1",
    "7",
    "nan",
    "inf",
    "1e999",
    "-1e-320",
    "2147483647",
    "2147483648",
    "4294967295",
    "9223372036854775807",
    "18446744073709551615",
    "99999999999999999999999",
];

/// Makes one change.
fn mutate(content: &mut Vec<u8>, random: &mut Random) {
    if content.is_empty() {
        content.push(random.bits() as u8);
        return;
    }
    let length = content.len();
    let place = random.integer(0, length as i64 - 1) as usize;
    let short = random.integer(1, 32.min(length as i64)) as usize;
    let end = (place + short).min(length);
    match random.integer(0, 9) {
        0 | 1 => content[place] = random.bits() as u8,
        2 => content[place] ^= 1 << random.integer(0, 7),
        3 => content[place] = [0, 1, 0x7f, 0x80, 0xff][random.integer(0, 4) as usize],
        4 => {
            let number = [0, 1, 2, u64::MAX, 1 << 31, 1 << 32, 1 << 63, (1 << 31) - 1, length as u64]
                [random.integer(0, 8) as usize];
            let bytes = if random.chance(0.5) { number.to_le_bytes() } else { number.to_be_bytes() };
            let width = [2, 4, 8][random.integer(0, 2) as usize].min(length - place);
            content[place..place + width].copy_from_slice(&bytes[..width]);
        }
        5 => drop(content.drain(place..end)),
        6 => {
            let copied = content[place..end].to_vec();
            let at = random.integer(0, length as i64) as usize;
            content.splice(at..at, copied);
        }
        7 => content.truncate(place),
        // Another number instead of one that is written out.
        _ => {
            let digit = |byte: &u8| byte.is_ascii_digit();
            let Some(start) = content[place..].iter().position(digit).map(|from| place + from) else { return };
            let end = content[start..].iter().position(|byte| !digit(byte)).map_or(length, |count| start + count);
            let number = NUMBERS[random.integer(0, NUMBERS.len() as i64 - 1) as usize];
            content.splice(start..end, number.bytes());
        }
    }
}
