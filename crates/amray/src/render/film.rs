//! The film: linear float RGBA, premultiplied, as composited.

/// A picture in linear float RGBA, colours premultiplied by alpha. Row 0 is on top.
#[derive(Clone, Debug, PartialEq)]
pub struct Film {
    size: [usize; 2],
    pixels: Vec<[f32; 4]>,
}

impl Film {
    /// A transparent film of `size` pixels (width, height).
    pub fn new(size: [usize; 2]) -> Self {
        Self { size, pixels: vec![[0.0; 4]; size[0] * size[1]] }
    }

    /// Width and height in pixels.
    pub fn size(&self) -> [usize; 2] {
        self.size
    }

    /// The pixels, row by row.
    pub fn pixels(&self) -> &[[f32; 4]] {
        &self.pixels
    }

    /// This film and, beside it on the right, another one as high; rows that only one has are transparent in the other.
    pub fn beside(&self, right: &Self) -> Self {
        let ([left_width, left_height], [right_width, right_height]) = (self.size, right.size);
        let mut both = Self::new([left_width + right_width, left_height.max(right_height)]);
        for (film, left) in [(self, 0), (right, left_width)] {
            if film.size[0] > 0 {
                both.put_tile([left, 0], film.size[0], &film.pixels);
            }
        }
        both
    }

    /// Puts rows of `width` pixels where their top left one is at `corner`.
    pub(super) fn put_tile(&mut self, corner: [usize; 2], width: usize, pixels: &[[f32; 4]]) {
        for (row, line) in pixels.chunks_exact(width).enumerate() {
            let start = (corner[1] + row) * self.size[0] + corner[0];
            self.pixels[start..start + width].copy_from_slice(line);
        }
    }

    /// The film over a background of straight (not premultiplied) RGBA, as straight 8-bit RGBA: values times 255, no
    /// gamma, for colours are display colours.
    pub fn over(&self, background: [f32; 4]) -> Vec<[u8; 4]> {
        let [red, green, blue, behind] = background;
        let byte = |value: f32| (value * 255.0).round().clamp(0.0, 255.0) as u8;
        let over = |&[r, g, b, alpha]: &[f32; 4]| {
            let left = (1.0 - alpha) * behind;
            let total = alpha + left;
            let straight = |own: f32, other: f32| if total > 0.0 { (own + left * other) / total } else { 0.0 };
            [byte(straight(r, red)), byte(straight(g, green)), byte(straight(b, blue)), byte(total)]
        };
        self.pixels.iter().map(over).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn films_stand_side_by_side() {
        let (mut left, mut right) = (Film::new([1, 2]), Film::new([2, 1]));
        left.put_tile([0, 0], 1, &[[1.0; 4], [2.0; 4]]);
        right.put_tile([0, 0], 2, &[[3.0; 4], [4.0; 4]]);
        let both = left.beside(&right);
        let reds: Vec<f32> = both.pixels().iter().map(|pixel| pixel[0]).collect();
        assert_eq!((both.size(), reds), ([3, 2], vec![1.0, 3.0, 4.0, 2.0, 0.0, 0.0]));
    }

    #[test]
    fn composites_over_the_background() {
        let mut film = Film::new([2, 1]);
        film.put_tile([0, 0], 2, &[[0.5, 0.0, 0.0, 0.5], [0.0; 4]]);
        assert_eq!(film.over([0.0, 0.0, 1.0, 1.0]), [[128, 0, 128, 255], [0, 0, 255, 255]]);
        assert_eq!(film.over([0.0; 4]), [[255, 0, 0, 128], [0; 4]]);
    }
}
