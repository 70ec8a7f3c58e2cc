//! The colour bar: what the colours of a picture mean.

use super::picture::ink_on;
use super::ticks::{Tick, ticks};
use super::{Picture, Rectangle, TextSize, TransferFunction};

/// Lines of text per labelled tick.
const LINES_PER_TICK: usize = 3;
/// Labelled ticks at most.
const MOST_TICKS: usize = 11;
/// The title is cut where the bar would be wider than this share of its height.
const WIDEST: f64 = 0.5;

/// A vertical colour bar on `background`, `height` pixels high, with `title` (the field's name) above it; text and
/// frame are black or white. Put it to the right of a picture with [`Picture::beside`].
///
/// A function whose points all have one value gets a bar of its one colour.
pub fn color_bar(function: &TransferFunction, title: &str, height: usize, background: [u8; 4]) -> Picture {
    let layout = Layout::new(function, title, height);
    let ink = ink_on(background);
    let mut picture = Picture::new(layout.width, height, background);
    picture.text(layout.margin, layout.margin, layout.text, &layout.title, ink);

    let Rectangle { left, top, width, height } = layout.bar;
    picture.fill(layout.bar.grown(layout.line), ink);
    let (scale, range) = (function.scale(), function.range());
    let prepared = function.prepared(1.0);
    for row in 0..height {
        let value = scale.at_fraction(range, 1.0 - (row as f64 + 0.5) / height as f64);
        let [red, green, blue] = prepared.sample(value).color.map(|channel| (channel * 255.0).round() as u8);
        picture.fill(Rectangle { left, top: top + row, width, height: 1 }, [red, green, blue, 255]);
    }
    for Tick { value, label } in &layout.ticks {
        let fraction = scale.fraction(range, *value);
        let middle = top as f64 + (1.0 - fraction) * height as f64;
        let mark_top = (middle - layout.line as f64 / 2.0).round().max(0.0) as usize;
        let start = left + width + layout.line;
        picture.fill(Rectangle { left: start, top: mark_top, width: layout.mark, height: layout.line }, ink);
        let label_top = (middle - layout.text.height() as f64 / 2.0).round().max(0.0) as usize;
        picture.text(start + layout.mark + layout.text.character_width() / 2, label_top, layout.text, label, ink);
    }
    picture
}

/// Where the parts of a colour bar lie.
struct Layout {
    text: TextSize,
    title: String,
    ticks: Vec<Tick>,
    bar: Rectangle,
    width: usize,
    margin: usize,
    /// The width of lines.
    line: usize,
    /// The length of a tick's mark.
    mark: usize,
}

impl Layout {
    fn new(function: &TransferFunction, title: &str, height: usize) -> Self {
        let text = TextSize::of_picture(height);
        let margin = text.height() / 2;
        let top = margin + 2 * text.height();
        // Half a line for the lowest label.
        let bottom = margin + text.height() / 2;
        let line = (text.height() / 16).max(1);
        let mark = text.height() / 4;
        let bar =
            Rectangle { left: margin + line, top, width: text.height(), height: height.saturating_sub(top + bottom) };
        let most = (bar.height / (LINES_PER_TICK * text.height())).min(MOST_TICKS);
        let range = function.range();
        let ticks = if range[0] < range[1] { ticks(function.scale(), range, most) } else { Tick::single(range[0]) };
        let label_width = ticks.iter().map(|tick| text.width(&tick.label)).max().unwrap_or(0);
        let body = bar.width + 2 * line + mark + text.character_width() / 2 + label_width;
        let title_limit = body.max((WIDEST * height as f64) as usize) / text.character_width();
        let title = shortened(title, title_limit);
        let width = body.max(text.width(&title)) + 2 * margin;
        Self { text, title, ticks, bar, width, margin, line, mark }
    }
}

impl Rectangle {
    fn grown(self, by: usize) -> Self {
        let [left, top] = [self.left, self.top].map(|edge| edge.saturating_sub(by));
        Self { left, top, width: self.width + 2 * by, height: self.height + 2 * by }
    }
}

/// `text` in at most `limit` characters.
fn shortened(text: &str, limit: usize) -> String {
    if text.chars().count() <= limit {
        return text.into();
    }
    let kept = text.chars().take(limit.saturating_sub(2));
    kept.chain("..".chars()).collect()
}

#[cfg(test)]
mod tests {
    use super::super::{ColorMap, ColorPoint, Opacity, OpacityPoint, Scale};
    use super::*;

    const BLACK: [u8; 4] = [0, 0, 0, 255];
    const WHITE: [u8; 4] = [255; 4];

    fn function(map: ColorMap, range: [f64; 2], scale: Scale) -> TransferFunction {
        let opacity = Opacity::Extinction(vec![OpacityPoint { value: range[0], opacity: 1.0 }]);
        TransferFunction::from_color_map(map, range, scale, opacity).unwrap()
    }

    #[test]
    fn colours_run_from_the_low_end_up() {
        for scale in [Scale::Linear, Scale::Log10] {
            let function = function(ColorMap::Gray, [1.0, 1e3], scale);
            let layout = Layout::new(&function, "density", 1024);
            let picture = color_bar(&function, "density", 1024, BLACK);
            assert_eq!((picture.width(), picture.height()), (layout.width, 1024));
            let column = layout.bar.left + layout.bar.width / 2;
            let at = |share: f64| {
                let row = layout.bar.top + (share * (layout.bar.height - 1) as f64) as usize;
                picture.pixels()[row * picture.width() + column]
            };
            assert_eq!([at(0.0), at(0.5), at(1.0)], [WHITE, [128, 128, 128, 255], BLACK]);
        }
    }

    #[test]
    fn ink_is_seen_and_stays_inside() {
        for height in [0, 10, 64, 256, 1024, 3000] {
            for (background, ink) in [(BLACK, WHITE), (WHITE, BLACK)] {
                let function = function(ColorMap::Viridis, [-1e-30, 1e-30], Scale::Linear);
                let picture = color_bar(&function, "x-momentum", height, background);
                assert_eq!(picture.height(), height);
                let right = picture.pixels().chunks_exact(picture.width()).map(|row| row[picture.width() - 1]);
                assert!(right.clone().all(|pixel| pixel == background), "height {height}");
                assert!(height < 64 || picture.pixels().contains(&ink));
            }
        }
    }

    #[test]
    fn long_titles_are_cut() {
        let bar = |title: &str| Layout::new(&function(ColorMap::Gray, [0.0, 1.0], Scale::Linear), title, 256);
        assert_eq!(bar("energy-density").title, "energy-density");
        assert_eq!(bar("a_very_long_name_of_a_field").title, "a_very_long_name..");
        assert!(bar(&"w".repeat(10_000)).width < 150);
    }

    #[test]
    fn a_single_value_has_a_single_tick() {
        let colors = vec![ColorPoint { value: 1.0 / 3.0, color: [1.0, 0.0, 0.0] }];
        let opacity = Opacity::PerUnitDistance(vec![OpacityPoint { value: 1.0 / 3.0, opacity: 0.5 }]);
        let function = TransferFunction::new(Scale::Linear, colors, opacity).unwrap();
        assert_eq!(Layout::new(&function, "", 256).ticks[0].label, "0.333333");
        assert!(color_bar(&function, "", 256, BLACK).pixels().contains(&[255, 0, 0, 255]));
    }
}
