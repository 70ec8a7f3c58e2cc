//! Text in pictures: Noto Sans Mono, drawn beforehand in four sizes and enlarged beyond.

use noto_sans_mono_bitmap::{FontWeight, RasterHeight, RasterizedChar, get_raster, get_raster_width};

use super::Picture;

/// Characters of a fixed width and height in pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TextSize {
    raster: RasterHeight,
    /// Pixels a side per pixel of the raster.
    enlargement: usize,
}

/// Lines of text that a picture is high, as far as the smallest legible size allows.
const LINES: usize = 40;

impl TextSize {
    /// The size that goes with a picture of `height` pixels.
    pub fn of_picture(height: usize) -> Self {
        let line = height / LINES;
        let rasters = [RasterHeight::Size16, RasterHeight::Size20, RasterHeight::Size24, RasterHeight::Size32];
        let raster =
            rasters.into_iter().min_by_key(|raster| raster.val().abs_diff(line)).unwrap_or(RasterHeight::Size16);
        Self { raster, enlargement: ((line + raster.val() / 2) / raster.val()).max(1) }
    }

    /// The height of a line.
    pub fn height(&self) -> usize {
        self.raster.val() * self.enlargement
    }

    /// The width of one character.
    pub fn character_width(&self) -> usize {
        get_raster_width(FontWeight::Regular, self.raster) * self.enlargement
    }

    /// The width of a line of text.
    pub fn width(&self, text: &str) -> usize {
        text.chars().count() * self.character_width()
    }
}

impl Picture {
    /// Writes one line of text, its upper left corner at (`left`, `top`); what is outside of the picture is lost.
    /// Characters other than ASCII's become question marks.
    pub fn text(&mut self, left: usize, top: usize, size: TextSize, text: &str, color: [u8; 4]) {
        for (index, character) in text.chars().enumerate() {
            let start = left + index * size.character_width();
            let raster = |character| get_raster(character, FontWeight::Regular, size.raster);
            let Some(glyph) = raster(character).or_else(|| raster('?')) else { continue };
            for y in 0..size.height() {
                for x in 0..size.character_width() {
                    let [x_in_glyph, y_in_glyph] =
                        [x, y].map(|pixel| (pixel as f32 + 0.5) / size.enlargement as f32 - 0.5);
                    let coverage = coverage(&glyph, x_in_glyph, y_in_glyph);
                    if coverage > 0.0 {
                        self.blend(start + x, top + y, color, coverage);
                    }
                }
            }
        }
    }
}

/// How much ink there is at a place in pixels of the glyph: 0 to 1, linear between the pixels' centres.
fn coverage(glyph: &RasterizedChar, x: f32, y: f32) -> f32 {
    let [left, top] = [x.floor(), y.floor()];
    let [right_share, lower_share] = [x - left, y - top];
    let ink = |dx: f32, dy: f32| {
        let [column, row] = [left + dx, top + dy];
        if column < 0.0 || row < 0.0 {
            return 0.0;
        }
        f32::from(glyph.pixel(column as usize, row as usize).unwrap_or(0)) / 255.0
    };
    let row = |dy| ink(0.0, dy) * (1.0 - right_share) + ink(1.0, dy) * right_share;
    row(0.0) * (1.0 - lower_share) + row(1.0) * lower_share
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_grow_with_the_picture() {
        let sizes = [1, 256, 640, 800, 1024, 1280, 2160, 4320].map(|height| TextSize::of_picture(height).height());
        assert_eq!(sizes, [16, 16, 16, 20, 24, 32, 64, 96]);
        let size = TextSize::of_picture(256);
        assert_eq!((size.character_width(), size.width("1e-5")), (7, 28));
    }

    #[test]
    fn glyphs_are_drawn_as_rasterised() {
        let size = TextSize::of_picture(256);
        let mut picture = Picture::new(14, 16, [0, 0, 0, 255]);
        picture.text(7, 0, size, "A", [255; 4]);
        let glyph = get_raster('A', FontWeight::Regular, RasterHeight::Size16).unwrap();
        for y in 0..16 {
            for x in 0..7 {
                assert_eq!(picture.pixels()[y * 14 + x], [0, 0, 0, 255]);
                assert_eq!(Some(picture.pixels()[y * 14 + 7 + x][0]), glyph.pixel(x, y));
            }
        }
    }

    #[test]
    fn enlarged_glyphs_have_the_same_ink() {
        let ink = |height: usize| {
            let size = TextSize::of_picture(height);
            let mut picture = Picture::new(size.character_width(), size.height(), [0, 0, 0, 255]);
            picture.text(0, 0, size, "8", [255; 4]);
            let ink: f64 = picture.pixels().iter().map(|pixel| f64::from(pixel[0])).sum();
            ink / (picture.width() * picture.height()) as f64
        };
        assert!((ink(2560) / ink(1280) - 1.0).abs() < 0.02);
    }

    #[test]
    fn unknown_characters_and_long_lines_do_no_harm() {
        let size = TextSize::of_picture(256);
        let [mut unknown, mut question] = [0; 2].map(|_| Picture::new(10, 16, [0; 4]));
        unknown.text(0, 0, size, "\u{3c1}\n", [255; 4]);
        question.text(0, 0, size, "??", [255; 4]);
        assert_eq!(unknown, question);
        unknown.text(9, 15, size, &"x".repeat(100), [255; 4]);
    }
}
