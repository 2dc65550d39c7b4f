//! A panel of a drawing: a rectangle with an axis along each side, and the ways to draw in it.

use svg::node::element::{ClipPath, Group, Line, Path, Rectangle, Text, path::Data};

/// Ink of axes and words.
pub const INK: &str = "#2b2d42";
/// Of what is only to be there.
pub const FAINT: &str = "#8d99ae";

/// Where numbers lie along an axis.
#[derive(Clone, Copy, Debug)]
pub struct Axis {
    /// Numbers at both ends.
    pub numbers: [f64; 2],
    /// Places of the drawing there.
    pub places: [f64; 2],
}

impl Axis {
    /// The place of a number.
    pub fn at(&self, number: f64) -> f64 {
        let [a, b] = self.numbers;
        let [from, to] = self.places;
        from + (to - from) * (number - a) / (b - a)
    }

    /// Round numbers along the axis, about `count` of them, and how many decimals they need.
    pub fn ticks(&self, count: f64) -> (Vec<f64>, usize) {
        let [low, high] = [self.numbers[0].min(self.numbers[1]), self.numbers[0].max(self.numbers[1])];
        let raw = (high - low) / count;
        let power = 10f64.powf(raw.log10().floor());
        let step = [1.0, 2.0, 5.0, 10.0].map(|k| k * power).into_iter().find(|step| *step >= raw).unwrap_or(raw);
        let first = (low / step).ceil() as i64;
        let last = (high / step + 1e-9).floor() as i64;
        let decimals = (-step.log10().floor()).max(0.0) as usize;
        ((first..=last).map(|i| i as f64 * step).collect(), decimals)
    }
}

/// A panel.
#[derive(Clone, Copy, Debug)]
pub struct Chart {
    /// Left to right.
    pub x: Axis,
    /// Top to bottom.
    pub y: Axis,
}

/// Two decimals are a hundredth of a pixel.
fn round(place: f64) -> f64 {
    (place * 100.0).round() / 100.0
}

impl Chart {
    /// The place of a point.
    pub fn at(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        [round(self.x.at(x)), round(self.y.at(y))]
    }

    /// A line through points.
    pub fn line(&self, points: impl IntoIterator<Item = [f64; 2]>) -> Data {
        let mut data = Data::new();
        for (i, point) in points.into_iter().enumerate() {
            let [x, y] = self.at(point);
            data = if i == 0 { data.move_to((x, y)) } else { data.line_to((x, y)) };
        }
        data
    }

    /// A clip path of the panel's own area.
    pub fn clip(&self, id: &str) -> ClipPath {
        ClipPath::new().set("id", id).add(self.area())
    }

    /// The panel's own area.
    pub fn area(&self) -> Rectangle {
        let ([x0, x1], [y0, y1]) = (self.x.places, self.y.places);
        let (top, bottom) = (y0.min(y1), y0.max(y1));
        Rectangle::new().set("x", x0).set("y", top).set("width", x1 - x0).set("height", bottom - top)
    }

    /// Frame, ticks and their numbers, and what the axes are of.
    pub fn axes(&self, counts: [f64; 2], titles: [&str; 2]) -> Group {
        let ([x0, x1], [y0, y1]) = (self.x.places, self.y.places);
        let (top, bottom) = (y0.min(y1), y0.max(y1));
        let mut group = Group::new();
        let tick = |a: [f64; 2], b: [f64; 2]| {
            let line = Line::new().set("x1", round(a[0])).set("y1", round(a[1]));
            line.set("x2", round(b[0])).set("y2", round(b[1])).set("stroke", FAINT)
        };
        let (numbers, decimals) = self.x.ticks(counts[0]);
        for number in numbers {
            let x = self.x.at(number);
            group = group.add(tick([x, bottom], [x, bottom + 4.0]));
            group = group.add(words([x, bottom + 15.0], &format!("{number:.decimals$}"), 10.0, "middle"));
        }
        let (numbers, decimals) = self.y.ticks(counts[1]);
        for number in numbers {
            let y = self.y.at(number);
            group = group.add(tick([x0 - 4.0, y], [x0, y]));
            group = group.add(words([x0 - 7.0, y + 3.5], &format!("{number:.decimals$}"), 10.0, "end"));
        }
        let side = x0 - 56.0;
        let upright = format!("rotate(-90 {side} {})", (top + bottom) / 2.0);
        group
            .add(self.area().set("fill", "none").set("stroke", FAINT))
            .add(words([(x0 + x1) / 2.0, bottom + 30.0], titles[0], 11.0, "middle"))
            .add(words([side, (top + bottom) / 2.0], titles[1], 11.0, "middle").set("transform", upright))
    }
}

/// Words at a place; `anchor` is start, middle or end.
pub fn words(at: [f64; 2], text: &str, size: f64, anchor: &str) -> Text {
    let text = Text::new(text).set("x", round(at[0])).set("y", round(at[1])).set("font-size", size);
    text.set("text-anchor", anchor).set("fill", INK)
}

/// A stroke that is not filled.
pub fn stroke(data: Data, colour: &str, width: f64) -> Path {
    let path = Path::new().set("d", data).set("fill", "none").set("stroke", colour).set("stroke-width", width);
    path.set("stroke-linejoin", "round").set("stroke-linecap", "round")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_within_the_axis() {
        let ticks = |numbers: [f64; 2], count: f64| Axis { numbers, places: [0.0, 1.0] }.ticks(count);
        assert_eq!(ticks([0.0, 1.0], 5.0), (vec![0.0, 0.2, 0.4, 0.6000000000000001, 0.8, 1.0], 1));
        assert_eq!(ticks([-3.0, 14.0], 4.0), (vec![0.0, 5.0, 10.0], 0));
        // Either end may be the lower one.
        assert_eq!(ticks([14.0, -3.0], 4.0), (vec![0.0, 5.0, 10.0], 0));
    }
}
