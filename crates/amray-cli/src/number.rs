//! Parsing the numbers and lists of numbers of the command line, and showing numbers.

/// `COUNT` finite numbers, separated by commas.
pub(crate) fn list<const COUNT: usize>(text: &str) -> Result<[f64; COUNT], String> {
    let numbers = text.split(',').map(|word| finite(word.trim())).collect::<Result<Vec<f64>, String>>()?;
    let found = numbers.len();
    numbers.try_into().map_err(|_| format!("expected {COUNT} numbers separated by commas, found {found}"))
}

/// A finite number.
pub(crate) fn finite(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(number) if number.is_finite() => Ok(number),
        _ => Err(format!("{text:?} is not a finite number")),
    }
}

/// A finite number above 0.
pub(crate) fn positive(text: &str) -> Result<f64, String> {
    match finite(text)? {
        number if number > 0.0 => Ok(number),
        _ => Err("expected a number above 0".into()),
    }
}

/// An angle in degrees, above 0 and below 180.
pub(crate) fn angle(text: &str) -> Result<f64, String> {
    match finite(text)? {
        degrees if degrees > 0.0 && degrees < 180.0 => Ok(degrees),
        _ => Err("expected an angle above 0 and below 180 degrees".into()),
    }
}

/// A number of bytes: `512M`, `4G`, or plain; K, M, G and T are powers of 1000.
pub(crate) fn byte_count(text: &str) -> Result<u64, String> {
    let wrong = || "expected a number of bytes such as 512M or 4G".to_owned();
    let digits = text.trim_end_matches(['K', 'M', 'G', 'T']);
    let unit = match &text[digits.len()..] {
        "" => 1.0,
        "K" => 1e3,
        "M" => 1e6,
        "G" => 1e9,
        "T" => 1e12,
        _ => return Err(wrong()),
    };
    Ok((positive(digits).map_err(|_| wrong())? * unit) as u64)
}

/// How many samples a cell width takes.
pub(crate) fn samples_per_cell(text: &str) -> Result<f64, String> {
    match finite(text)? {
        // More would hardly ever end; fewer miss whole bricks.
        samples if (0.01..=1000.0).contains(&samples) => Ok(samples),
        _ => Err("expected a number from 0.01 to 1000".into()),
    }
}

/// A range: two numbers, the lower one first.
pub(crate) fn range(text: &str) -> Result<[f64; 2], String> {
    match list(text)? {
        [low, high] if low < high => Ok([low, high]),
        [low, high] => Err(format!("expected low,high with low < high, found {low},{high}")),
    }
}

/// Red, green, blue and, where it is given, alpha, each 0 to 1.
pub(crate) fn color(text: &str) -> Result<[f32; 4], String> {
    let channels = if text.split(',').count() == 3 {
        let [red, green, blue] = list(text)?;
        [red, green, blue, 1.0]
    } else {
        list(text).map_err(|_| "expected r,g,b or r,g,b,a with numbers from 0 to 1".to_owned())?
    };
    if channels.iter().any(|channel| !(0.0..=1.0).contains(channel)) {
        return Err("expected numbers from 0 to 1".into());
    }
    Ok(channels.map(|channel| channel as f32))
}

/// An opacity.
pub(crate) fn share(opacity: f64) -> Result<f32, String> {
    match (0.0..=1.0).contains(&opacity) {
        true => Ok(opacity as f32),
        false => Err(format!("the opacity is {opacity}, expected a number from 0 to 1")),
    }
}

/// A direction across a plane.
pub(crate) fn normal(normal: [f64; 3]) -> Result<[f64; 3], String> {
    match normal {
        [0.0, 0.0, 0.0] => Err("the normal is 0,0,0, expected a vector other than 0".into()),
        normal => Ok(normal),
    }
}

/// The most pixels along a side: a square film of them takes 4 GB of memory, anything larger is a slip.
pub(crate) const SIZE_LIMIT: usize = 16_384;

/// `1024x768`, or `1024` for a square picture.
pub(crate) fn size(text: &str) -> Result<[usize; 2], String> {
    let (width, height) = text.split_once('x').unwrap_or((text, text));
    let side = |word: &str| match word.trim().parse::<usize>() {
        Ok(pixels) if (1..=SIZE_LIMIT).contains(&pixels) => Ok(pixels),
        _ => Err(format!("expected WIDTHxHEIGHT or one number for both, each from 1 to {SIZE_LIMIT} pixels")),
    };
    Ok([side(width)?, side(height)?])
}

/// A count with thin separators: `12 345 678`.
pub(crate) fn grouped(count: u64) -> String {
    let digits = count.to_string();
    let groups = digits.as_bytes().rchunks(3).rev().map(|group| String::from_utf8_lossy(group).into_owned());
    groups.collect::<Vec<_>>().join(" ")
}

/// Bytes in the unit that suits them: `1.5 GB`.
pub(crate) fn bytes(count: u64) -> String {
    const UNITS: [&str; 5] = ["B", "kB", "MB", "GB", "TB"];
    let mut size = count as f64;
    let mut unit = 0;
    while size >= 999.5 && unit + 1 < UNITS.len() {
        size /= 1000.0;
        unit += 1;
    }
    if unit > 0 && size < 9.95 { format!("{size:.1} {}", UNITS[unit]) } else { format!("{size:.0} {}", UNITS[unit]) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_ranges_and_colors() {
        assert_eq!(list::<3>("1,-2.5, 3e2"), Ok([1.0, -2.5, 300.0]));
        assert!(list::<3>("1,2").unwrap_err().contains("found 2"));
        assert!(list::<3>("1,2,nan").unwrap_err().contains("not a finite number"));
        assert_eq!(range("-1,1"), Ok([-1.0, 1.0]));
        assert!(range("1,1").is_err());
        assert_eq!(color("0,0.5,1"), Ok([0.0, 0.5, 1.0, 1.0]));
        assert_eq!(color("0,0,0,0"), Ok([0.0; 4]));
        assert!(color("0,0,2").is_err() && color("0,0").is_err());
        assert_eq!(positive("0.5"), Ok(0.5));
        assert!(positive("0").is_err());
        assert_eq!((angle("179.9"), samples_per_cell("1000")), (Ok(179.9), Ok(1000.0)));
        assert!(angle("0").is_err() && angle("180").is_err());
        assert!(samples_per_cell("0.009").is_err() && samples_per_cell("1e17").is_err());
    }

    #[test]
    fn sizes() {
        assert_eq!(size("640x480"), Ok([640, 480]));
        assert_eq!(size("512"), Ok([512, 512]));
        for wrong in ["0x1", "10x", "axb", "100000", "-1"] {
            assert!(size(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn counts_and_bytes() {
        assert_eq!(["512M", "1.5G", "7"].map(byte_count), [Ok(512_000_000), Ok(1_500_000_000), Ok(7)]);
        assert!(["", "G", "-1M", "1MM", "1m"].iter().all(|text| byte_count(text).is_err()));
        assert_eq!(grouped(12_345_678), "12 345 678");
        assert_eq!(grouped(7), "7");
        assert_eq!(
            [0, 999, 1500, 151_000_000, 4_000_000_000].map(bytes),
            ["0 B", "999 B", "1.5 kB", "151 MB", "4.0 GB"]
        );
    }
}
