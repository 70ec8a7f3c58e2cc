//! Named colour maps.

use std::fmt;
use std::str::FromStr;

use colorous::Gradient;
use thiserror::Error;

use super::color_space::ColorSpace;

/// A named colour map. The perceptually uniform ones stand in front: with them, equal steps of the value look equal.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum ColorMap {
    /// Matplotlib's default: dark violet, green, yellow.
    #[default]
    Viridis,
    /// Matplotlib's: blue, magenta, yellow.
    Plasma,
    /// Matplotlib's: black, red, pale yellow.
    Inferno,
    /// Matplotlib's: black, magenta, pale pink.
    Magma,
    /// Nuñez, Anderton, Renslow (2018): blue to yellow, the same for colour-blind eyes.
    Cividis,
    /// Green (2011): black to white in a helix through the colours.
    Cubehelix,
    /// Black to white.
    Gray,
    /// ParaView's "Black-Body Radiation": black, red, yellow, white.
    BlackBody,
    /// Google's rainbow (Mikhailov 2019).
    Turbo,
    /// Moreland's (2009) diverging map, ParaView's default: blue, white, red.
    CoolToWarm,
    /// ColorBrewer's RdBu, diverging.
    RedBlue,
    /// ColorBrewer's RdYlBu, diverging.
    RedYellowBlue,
    /// ColorBrewer's PuOr, diverging.
    PurpleOrange,
    /// ColorBrewer's BrBG, diverging.
    BrownGreen,
    /// ColorBrewer's Spectral: red, yellow, violet.
    Spectral,
}

/// A name that no colour map has.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("no colour map {0:?}; the colour maps are {names}", names = ColorMap::ALL.map(ColorMap::name).join(", "))]
pub struct UnknownColorMap(
    /// The name asked for.
    pub String,
);

/// Colours of the tables behind the maps that matplotlib made; between them colours are mixed.
const TABLE: usize = 256;
/// Colours of a ColorBrewer map; mixing between these eleven, and no spline, is what matplotlib and ParaView do.
const BREWER: usize = 11;

/// Every 7.7th colour of the published table of 256.
#[rustfmt::skip]
const CIVIDIS: [u32; 34] = [
    0x00224e, 0x00285b, 0x002d69, 0x023271, 0x18376f, 0x253d6e, 0x30426d, 0x39486c, 0x414d6c, 0x49526c, 0x50586c,
    0x575d6d, 0x5e626e, 0x656870, 0x6c6d72, 0x727374, 0x797977, 0x807e78, 0x878478, 0x8e8a78, 0x969077, 0x9e9676,
    0xa59c74, 0xada272, 0xb5a86f, 0xbdaf6c, 0xc5b568, 0xcdbc63, 0xd6c35e, 0xdec957, 0xe7d050, 0xefd847, 0xf8df3b,
    0xfee838,
];

/// Every 7.7th colour of the published table of 256.
#[rustfmt::skip]
const TURBO: [u32; 34] = [
    0x30123b, 0x392971, 0x403f9f, 0x4454c4, 0x4669e0, 0x467cf4, 0x4390fe, 0x3aa3fc, 0x2cb6f0, 0x20c8de, 0x18d8c9,
    0x1ae4b6, 0x29eea2, 0x41f689, 0x5efc6f, 0x7cff56, 0x98fe43, 0xadfa38, 0xc1f234, 0xd4e735, 0xe4da38, 0xf1cb3a,
    0xfaba39, 0xfea732, 0xfe9129, 0xfa7a1f, 0xf36315, 0xea4f0d, 0xde3e08, 0xd02f05, 0xbf2202, 0xab1601, 0x940c01,
    0x7a0403,
];

const BLACK_BODY: [u32; 6] = [0x000000, 0x730000, 0xe60000, 0xe67300, 0xe6e600, 0xffffff];

/// The ends of Moreland's cool to warm.
const COOL: [f64; 3] = [59.0 / 255.0, 76.0 / 255.0, 192.0 / 255.0];
const WARM: [f64; 3] = [180.0 / 255.0, 4.0 / 255.0, 38.0 / 255.0];

impl ColorMap {
    /// All colour maps.
    pub const ALL: [Self; 15] = [
        Self::Viridis,
        Self::Plasma,
        Self::Inferno,
        Self::Magma,
        Self::Cividis,
        Self::Cubehelix,
        Self::Gray,
        Self::BlackBody,
        Self::Turbo,
        Self::CoolToWarm,
        Self::RedBlue,
        Self::RedYellowBlue,
        Self::PurpleOrange,
        Self::BrownGreen,
        Self::Spectral,
    ];

    /// The name, as [`FromStr`] reads it.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Viridis => "viridis",
            Self::Plasma => "plasma",
            Self::Inferno => "inferno",
            Self::Magma => "magma",
            Self::Cividis => "cividis",
            Self::Cubehelix => "cubehelix",
            Self::Gray => "gray",
            Self::BlackBody => "black-body",
            Self::Turbo => "turbo",
            Self::CoolToWarm => "cool-to-warm",
            Self::RedBlue => "red-blue",
            Self::RedYellowBlue => "red-yellow-blue",
            Self::PurpleOrange => "purple-orange",
            Self::BrownGreen => "brown-green",
            Self::Spectral => "spectral",
        }
    }

    /// The display colour at `t`, which counts as 0 below 0 (and where it is NaN) and as 1 above 1.
    pub fn color(self, t: f32) -> [f32; 3] {
        let t = if t > 0.0 { t.min(1.0) } else { 0.0 };
        match self {
            Self::Viridis => sampled(colorous::VIRIDIS, TABLE, t),
            Self::Plasma => sampled(colorous::PLASMA, TABLE, t),
            Self::Inferno => sampled(colorous::INFERNO, TABLE, t),
            Self::Magma => sampled(colorous::MAGMA, TABLE, t),
            Self::Cividis => mixed(CIVIDIS.len(), t, |index| hex(CIVIDIS[index])),
            Self::Cubehelix => sampled(colorous::CUBEHELIX, TABLE, t),
            Self::Gray => [t; 3],
            Self::BlackBody => mixed(BLACK_BODY.len(), t, |index| hex(BLACK_BODY[index])),
            Self::Turbo => mixed(TURBO.len(), t, |index| hex(TURBO[index])),
            Self::CoolToWarm => ColorSpace::Diverging.mix(COOL, WARM, t.into()).map(|value| value as f32),
            Self::RedBlue => sampled(colorous::RED_BLUE, BREWER, t),
            Self::RedYellowBlue => sampled(colorous::RED_YELLOW_BLUE, BREWER, t),
            Self::PurpleOrange => sampled(colorous::PURPLE_ORANGE, BREWER, t),
            Self::BrownGreen => sampled(colorous::BROWN_GREEN, BREWER, t),
            Self::Spectral => sampled(colorous::SPECTRAL, BREWER, t),
        }
    }
}

fn sampled(gradient: Gradient, count: usize, t: f32) -> [f32; 3] {
    mixed(count, t, |index| gradient.eval_rational(index, count).as_array())
}

/// The mix of the two of `count` evenly spaced colours that are nearest to `t`, which lies within 0 and 1.
fn mixed(count: usize, t: f32, color: impl Fn(usize) -> [u8; 3]) -> [f32; 3] {
    let place = t * (count - 1) as f32;
    let index = (place as usize).min(count - 2);
    let share = place - index as f32;
    let [low, high] = [color(index), color(index + 1)].map(|rgb| rgb.map(|value| f32::from(value) / 255.0));
    std::array::from_fn(|channel| low[channel] * (1.0 - share) + high[channel] * share)
}

fn hex(color: u32) -> [u8; 3] {
    let [_, rgb @ ..] = color.to_be_bytes();
    rgb
}

impl fmt::Display for ColorMap {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl FromStr for ColorMap {
    type Err = UnknownColorMap;

    fn from_str(name: &str) -> Result<Self, Self::Err> {
        let known = Self::ALL.into_iter().find(|map| map.name().eq_ignore_ascii_case(name));
        known.ok_or_else(|| UnknownColorMap(name.into()))
    }
}

#[cfg(test)]
mod tests {
    use super::super::color_space::rgb_to_lab;
    use super::*;

    fn bytes(map: ColorMap, t: f32) -> u32 {
        let [r, g, b] = map.color(t).map(|value| (value * 255.0).round() as u8);
        u32::from_be_bytes([0, r, g, b])
    }

    #[test]
    fn the_ends_are_the_published_colours() {
        let ends = [
            (ColorMap::Viridis, 0x440154, 0xfde725),
            (ColorMap::Plasma, 0x0d0887, 0xf0f921),
            (ColorMap::Inferno, 0x000004, 0xfcffa4),
            (ColorMap::Magma, 0x000004, 0xfcfdbf),
            (ColorMap::Cividis, 0x00224e, 0xfee838),
            (ColorMap::Cubehelix, 0x000000, 0xffffff),
            (ColorMap::Gray, 0x000000, 0xffffff),
            (ColorMap::BlackBody, 0x000000, 0xffffff),
            (ColorMap::Turbo, 0x30123b, 0x7a0403),
            (ColorMap::CoolToWarm, 0x3b4cc0, 0xb40426),
            (ColorMap::RedBlue, 0x67001f, 0x053061),
            (ColorMap::RedYellowBlue, 0xa50026, 0x313695),
            (ColorMap::PurpleOrange, 0x2d004b, 0x7f3b08),
            (ColorMap::BrownGreen, 0x543005, 0x003c30),
            (ColorMap::Spectral, 0x9e0142, 0x5e4fa2),
        ];
        assert_eq!(ends.map(|(map, ..)| map), ColorMap::ALL);
        for (map, low, high) in ends {
            assert_eq!([bytes(map, 0.0), bytes(map, 1.0)], [low, high], "{map}: {:06x?}", map.color(0.0));
            assert_eq!([map.color(f32::NAN), map.color(-9.0)], [map.color(0.0); 2]);
            assert_eq!(map.color(f32::INFINITY), map.color(1.0));
        }
    }

    #[test]
    fn the_middles_are_the_published_colours() {
        // Matplotlib's colours number 51 (t = 0.2) and 204 (t = 0.8) of 256; colorous may be off by one.
        let published = [
            (ColorMap::Viridis, 0x414487, 0x7ad151),
            (ColorMap::Plasma, 0x6a00a8, 0xfca636),
            (ColorMap::Inferno, 0x420a68, 0xfca50a),
            (ColorMap::Magma, 0x3b0f70, 0xfe9f6d),
            (ColorMap::Cividis, 0x35456c, 0xc8b866),
            (ColorMap::Turbo, 0x3e9bfe, 0xf05b12),
            (ColorMap::Spectral, 0xf46d43, 0x66c2a5),
            (ColorMap::Cubehelix, 0x163d4e, 0xc1caf3),
        ];
        for (map, low, high) in published {
            for (t, expected) in [(0.2, low), (0.8, high)] {
                let found = bytes(map, t);
                let off = hex(found).into_iter().zip(hex(expected)).map(|(a, b)| a.abs_diff(b)).max();
                assert!(off <= Some(1), "{map} at {t}: {found:06x}, expected {expected:06x}");
            }
        }
        assert_eq!(bytes(ColorMap::RedBlue, 0.5), 0xf7f7f7);
        assert_eq!(bytes(ColorMap::BlackBody, 0.4), 0xe60000);
    }

    #[test]
    fn sequential_maps_grow_lighter() {
        for map in &ColorMap::ALL[..8] {
            let lightness: Vec<f64> =
                (0..=32).map(|i| rgb_to_lab(map.color(i as f32 / 32.0).map(f64::from))[0]).collect();
            assert!(lightness.is_sorted_by(|a, b| a < b), "{map}: {lightness:?}");
        }
    }

    #[test]
    fn colours_are_continuous_and_within_range() {
        for map in ColorMap::ALL {
            let colors: Vec<_> = (0..=4096).map(|i| map.color(i as f32 / 4096.0)).collect();
            assert!(colors.iter().flatten().all(|value| (0.0..=1.0).contains(value)), "{map}");
            let jump = colors.windows(2).flat_map(|pair| (0..3).map(|c| (pair[0][c] - pair[1][c]).abs()));
            assert!(jump.fold(0.0, f32::max) < 0.006, "{map}");
        }
    }

    #[test]
    fn names_go_there_and_back() {
        for map in ColorMap::ALL {
            assert_eq!(map.to_string().parse(), Ok(map));
        }
        assert_eq!("Viridis".parse(), Ok(ColorMap::Viridis));
        assert_eq!(
            "jet".parse::<ColorMap>().unwrap_err().to_string(),
            "no colour map \"jet\"; the colour maps are viridis, plasma, inferno, magma, cividis, cubehelix, gray, \
             black-body, turbo, cool-to-warm, red-blue, red-yellow-blue, purple-orange, brown-green, spectral"
        );
    }
}
