//! Pictures of 8 bits a channel, and drawing on them.

/// A picture with straight (not premultiplied) alpha, row by row from the top.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Picture {
    width: usize,
    height: usize,
    pixels: Vec<[u8; 4]>,
}

/// A rectangle of pixels; may reach outside of the picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rectangle {
    /// The leftmost column.
    pub left: usize,
    /// The topmost row.
    pub top: usize,
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
}

impl Picture {
    /// A picture of one colour (red, green, blue, alpha).
    pub fn new(width: usize, height: usize, color: [u8; 4]) -> Self {
        Self { width, height, pixels: vec![color; width * height] }
    }

    /// A picture of given pixels, row by row from the top; `None` where they are not `width * height`.
    pub fn from_pixels(width: usize, height: usize, pixels: Vec<[u8; 4]>) -> Option<Self> {
        (width.checked_mul(height) == Some(pixels.len())).then_some(Self { width, height, pixels })
    }

    /// Columns.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Rows.
    pub fn height(&self) -> usize {
        self.height
    }

    /// The pixels, row by row from the top.
    pub fn pixels(&self) -> &[[u8; 4]] {
        &self.pixels
    }

    /// Lays `color` over the part of `rectangle` that is inside.
    pub fn fill(&mut self, rectangle: Rectangle, color: [u8; 4]) {
        let Rectangle { left, top, width, height } = rectangle;
        for y in top..top.saturating_add(height).min(self.height) {
            for x in left..left.saturating_add(width).min(self.width) {
                self.blend(x, y, color, 1.0);
            }
        }
    }

    /// Lays `color` over a pixel, as much as `coverage` (0 to 1) says; does nothing outside.
    pub fn blend(&mut self, x: usize, y: usize, color: [u8; 4], coverage: f32) {
        if x >= self.width || y >= self.height {
            return;
        }
        let pixel = &mut self.pixels[y * self.width + x];
        let over = f32::from(color[3]) / 255.0 * coverage;
        let under = f32::from(pixel[3]) / 255.0 * (1.0 - over);
        let alpha = over + under;
        if alpha > 0.0 {
            for channel in 0..3 {
                let mixed = f32::from(color[channel]) * over + f32::from(pixel[channel]) * under;
                pixel[channel] = (mixed / alpha).round() as u8;
            }
            pixel[3] = (alpha * 255.0).round() as u8;
        }
    }

    /// Draws a straight line between two places, in pixels from the top left corner, `width` pixels wide and smooth at its
    /// edges; what is outside of the picture is lost.
    pub fn line(&mut self, [from, to]: [[f64; 2]; 2], width: f64, color: [u8; 4]) {
        let along = [to[0] - from[0], to[1] - from[1]];
        let square = along[0] * along[0] + along[1] * along[1];
        let ends = |axis: usize, most: usize| {
            let reach = width / 2.0 + 1.0;
            let inside = |place: f64| place.clamp(0.0, most as f64) as usize;
            inside((from[axis].min(to[axis]) - reach).floor())..inside((from[axis].max(to[axis]) + reach).ceil())
        };
        for y in ends(1, self.height) {
            for x in ends(0, self.width) {
                let [dx, dy] = [x as f64 + 0.5 - from[0], y as f64 + 0.5 - from[1]];
                let share = ((dx * along[0] + dy * along[1]) / square.max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
                let distance = (dx - share * along[0]).hypot(dy - share * along[1]);
                let coverage = (width / 2.0 + 0.5 - distance).clamp(0.0, 1.0);
                if coverage > 0.0 {
                    self.blend(x, y, color, coverage as f32);
                }
            }
        }
    }

    /// This picture with another one to its right, top to top; `background` where one is less high.
    pub fn beside(&self, right: &Self, background: [u8; 4]) -> Self {
        let mut joined = Self::new(self.width + right.width, self.height.max(right.height), background);
        for (part, left) in [(self, 0), (right, self.width)] {
            if part.width == 0 {
                continue;
            }
            for (row, pixels) in part.pixels.chunks_exact(part.width).enumerate() {
                let start = row * joined.width + left;
                joined.pixels[start..start + part.width].copy_from_slice(pixels);
            }
        }
        joined
    }
}

/// Black or white, whichever is easier to read on `background`.
pub(crate) fn ink_on([red, green, blue, _]: [u8; 4]) -> [u8; 4] {
    let luma = 0.299 * f32::from(red) + 0.587 * f32::from(green) + 0.114 * f32::from(blue);
    if luma > 127.5 { [0, 0, 0, 255] } else { [255; 4] }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RED: [u8; 4] = [255, 0, 0, 255];
    const CLEAR: [u8; 4] = [0; 4];

    #[test]
    fn fills_are_clipped() {
        let mut picture = Picture::new(3, 2, CLEAR);
        picture.fill(Rectangle { left: 1, top: 1, width: usize::MAX, height: 9 }, RED);
        assert_eq!(picture.pixels(), [CLEAR, CLEAR, CLEAR, CLEAR, RED, RED]);
        picture.fill(Rectangle { left: 7, top: 0, width: 1, height: 1 }, RED);
        assert_eq!(picture.pixels()[..3], [CLEAR; 3]);
    }

    #[test]
    fn blending_keeps_alpha_straight() {
        let mut picture = Picture::new(3, 1, CLEAR);
        picture.fill(Rectangle { left: 1, top: 0, width: 1, height: 1 }, [0, 0, 255, 255]);
        for x in 0..9 {
            picture.blend(x, 0, RED, 0.5);
        }
        assert_eq!(picture.pixels(), [[255, 0, 0, 128], [128, 0, 128, 255], [255, 0, 0, 128]]);
        picture.blend(0, 0, CLEAR, 1.0);
        assert_eq!(picture.pixels()[0], [255, 0, 0, 128]);
    }

    #[test]
    fn lines_go_from_end_to_end() {
        let white = [255; 4];
        let mut picture = Picture::new(8, 4, [0, 0, 0, 255]);
        picture.line([[1.0, 1.5], [20.0, 1.5]], 1.0, white);
        picture.line([[-5.0, -9.0], [-7.0, f64::NAN]], 1.0, white);
        let row = |y: usize| &picture.pixels()[8 * y..8 * y + 8];
        assert!(row(1)[1..].iter().all(|pixel| *pixel == white));
        assert!(row(0).iter().chain(row(2)).chain(row(3)).all(|pixel| pixel[0] < 8), "{picture:?}");
    }

    #[test]
    fn pictures_stand_side_by_side() {
        let blue = [0, 0, 255, 255];
        let joined = Picture::new(2, 1, RED).beside(&Picture::new(1, 2, blue), CLEAR);
        assert_eq!((joined.width(), joined.height()), (3, 2));
        assert_eq!(joined.pixels(), [RED, RED, blue, CLEAR, CLEAR, blue]);
        assert_eq!(Picture::new(0, 5, RED).beside(&Picture::new(1, 1, blue), CLEAR).width(), 1);
        assert_eq!(Picture::from_pixels(2, 2, vec![RED; 3]), None);
    }

    #[test]
    fn ink_can_be_read() {
        let [black, white] = [[0, 0, 0, 255], [255; 4]];
        assert_eq!([[255, 255, 0, 255], [0, 0, 255, 255], CLEAR].map(ink_on), [black, white, white]);
    }
}
