//! Reading points: positions to sample at, from CSV or NumPy files.

use std::fs;
use std::path::Path;

use crate::FormatError;

/// Reads n world positions: a NumPy array of shape (n, 3), or text with three numbers a line, separated by commas,
/// semicolons or blanks, where one line of column names may come first and lines that start with `#` are comments.
///
/// # Errors
/// [`FormatError`] names the line that is no point.
pub fn read_points(path: &Path) -> Result<Vec<[f64; 3]>, FormatError> {
    let bytes = fs::read(path).map_err(FormatError::io(path, "read"))?;
    if bytes.starts_with(b"\x93NUMPY") { array_points(path, &bytes) } else { text_points(path, &bytes) }
}

fn array_points(path: &Path, bytes: &[u8]) -> Result<Vec<[f64; 3]>, FormatError> {
    let broken = |problem: String| FormatError::malformed(path, "NumPy array", problem);
    let array = || npyz::NpyFile::new(bytes).map_err(|error| broken(error.to_string()));
    let shape = array()?.shape().to_vec();
    let rows = match shape[..] {
        [rows, 3] if rows <= bytes.len() as u64 => rows as usize,
        _ => return Err(broken(format!("shape {shape:?}, expected (n, 3)"))),
    };
    let order = array()?.order();
    let numbers: Vec<f64> = match array()?.into_vec::<f64>() {
        Ok(numbers) => numbers,
        Err(_) => array()?
            .into_vec::<f32>()
            .map_err(|error| broken(format!("{error}, expected float64 or float32")))?
            .into_iter()
            .map(f64::from)
            .collect(),
    };
    if numbers.len() != 3 * rows {
        return Err(broken(format!("{} numbers, expected {}", numbers.len(), 3 * rows)));
    }
    let place = |row: usize, axis: usize| match order {
        npyz::Order::C => 3 * row + axis,
        npyz::Order::Fortran => rows * axis + row,
    };
    Ok((0..rows).map(|row| std::array::from_fn(|axis| numbers[place(row, axis)])).collect())
}

fn text_points(path: &Path, bytes: &[u8]) -> Result<Vec<[f64; 3]>, FormatError> {
    let mut points = Vec::new();
    let mut may_be_header = true;
    for (number, line) in String::from_utf8_lossy(bytes).lines().enumerate() {
        let line = line.trim();
        if line.is_empty() || line.starts_with('#') {
            continue;
        }
        let words: Vec<&str> = match line.contains([',', ';']) {
            // A place without a number is one that was forgotten.
            true => line.split([',', ';']).map(str::trim).collect(),
            false => line.split_whitespace().collect(),
        };
        let numbers: Option<Vec<f64>> = words.iter().map(|word| word.parse().ok()).collect();
        match numbers.as_deref() {
            Some(&[x, y, z]) => points.push([x, y, z]),
            _ if may_be_header && words.iter().all(|word| !word.is_empty() && word.parse::<f64>().is_err()) => {}
            _ => {
                let shown: String = line.chars().take(40).collect();
                let problem = format!("{shown:?} is no point, expected three numbers");
                return Err(FormatError::malformed(path, format!("line {}", number + 1), problem));
            }
        }
        may_be_header = false;
    }
    Ok(points)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(name: &str, content: &[u8]) -> Result<Vec<[f64; 3]>, FormatError> {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join(name);
        fs::write(&path, content).unwrap();
        read_points(&path)
    }

    #[test]
    fn text_in_several_dialects() {
        let expected = [[1.0, -2.0, 3e5], [4.0, 5.0, 6.0]];
        assert_eq!(read("p.csv", b"x,y,z\n1, -2, 3e5\n4,5,6\n").unwrap(), expected);
        assert_eq!(read("p.txt", b"# points\n\n1 -2 3e5\r\n4\t5 6").unwrap(), expected);
        assert_eq!(read("p.csv", b"").unwrap(), [[0.0; 3]; 0]);
    }

    #[test]
    fn a_bad_line_is_named() {
        let error = read("p.csv", b"x,y,z\n1,2,3\n1,2\n").unwrap_err().to_string();
        assert!(error.ends_with("p.csv: line 3: \"1,2\" is no point, expected three numbers"), "{error}");
        for bad in ["1,2,x", "0.5,,0.5,0.5", ",1,2,3", "1,2,3,", "1;;2;3", "1 2,3", ",,"] {
            assert!(read("p.csv", bad.as_bytes()).is_err(), "{bad}");
        }
        assert!(read("p.csv", b"x,y,z\nx,y,z\n").is_err());
    }

    #[test]
    fn arrays_of_either_precision() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("p.npy");
        crate::picture::write_array(&path, &[2, 3], &[1f32, 2.0, 3.0, 4.0, 5.0, 6.0]).unwrap();
        assert_eq!(read_points(&path).unwrap(), [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]);
        crate::picture::write_array(&path, &[3, 2], &[0f64; 6]).unwrap();
        let error = read_points(&path).unwrap_err().to_string();
        assert!(error.ends_with("shape [3, 2], expected (n, 3)"), "{error}");
        let bytes = fs::read(&path).unwrap();
        for length in 6..bytes.len() {
            assert!(read("t.npy", &bytes[..length]).is_err());
        }
    }
}
