//! The texture-space map: the height field from above, and the ray's path over it.

use base64::{Engine, prelude::BASE64_STANDARD};
use glam::DVec2;
use image::{GrayImage, codecs::png::PngEncoder};
use prism_engine::shell::reference::Stretch;
use svg::node::element::{Circle, Definitions, Group, Image, path::Data};

use super::{
    chart::{Axis, Chart, stroke},
    figure::{RAY, TANGENT, View, mark, part_within, truth},
};

/// Pixels a side of the picture of the heights.
const PICTURE: u32 = 256;
/// Points that a stretch's path is drawn with.
const POINTS: usize = 48;

/// A stretch on the map, moved by whole periods so that it follows the one before.
struct Laid<'a> {
    index: usize,
    stretch: &'a Stretch<'a>,
    part: [f64; 2],
    shift: DVec2,
}

impl Laid<'_> {
    fn at(&self, x: f64) -> DVec2 {
        self.stretch.at(x).uv - self.shift
    }

    /// The path between two parameters.
    fn path(&self, [from, to]: [f64; 2]) -> impl Iterator<Item = [f64; 2]> {
        (0..=POINTS).map(move |i| self.at(from + (to - from) * i as f64 / POINTS as f64).to_array())
    }
}

/// The base surface's point in the pixel: the stretch that passes it.
pub fn base<'a>(view: &View<'a>) -> Option<(usize, &'a Stretch<'a>)> {
    let through = |t: [f64; 2]| t[0] >= 0.0 && t[1] < 0.0;
    let stretches = view.probe.way.stretches.iter().enumerate();
    stretches.into_iter().find(|(_, stretch)| through(stretch.t))
}

/// The stretches that lie beside the hit's on one piece of the texture: those across a seam are elsewhere on it.
fn laid<'a>(view: &View<'a>) -> Vec<Laid<'a>> {
    let mut shown: Vec<(usize, &Stretch<'_>, [f64; 2])> = view.stretches().collect();
    // On to the base surface, which may lie behind what is shown: the straight ray is that of its triangle.
    let last = shown.last().map_or(0, |(i, ..)| *i);
    let beyond = base(view).map_or(last, |(i, _)| i);
    let way = &view.probe.way.stretches;
    shown.extend((last + 1..=beyond).map(|i| (i, &way[i], [0.0, 0.0])));
    let Some(at_hit) = shown.iter().position(|(i, ..)| *i == view.at_hit) else { return Vec::new() };
    // By how much the second is moved where it follows the first on one piece.
    let follows = |a: &Stretch<'_>, b: &Stretch<'_>| {
        let gap = b.at(0.0).uv - a.at(1.0).uv;
        let one = a.map_size() == b.map_size() && a.scale() == b.scale();
        (one && ((gap - gap.round()) * a.map_size().max(DVec2::splat(64.0))).length() < 0.25).then(|| gap.round())
    };
    let lay = |k: usize, shift: DVec2| Laid { index: shown[k].0, stretch: shown[k].1, part: shown[k].2, shift };
    let mut all = vec![lay(at_hit, DVec2::ZERO)];
    let mut shift = DVec2::ZERO;
    for k in (0..at_hit).rev() {
        let Some(gap) = follows(shown[k].1, shown[k + 1].1) else { break };
        shift -= gap;
        all.insert(0, lay(k, shift));
    }
    shift = DVec2::ZERO;
    for k in at_hit + 1..shown.len() {
        let Some(gap) = follows(shown[k - 1].1, shown[k].1) else { break };
        shift += gap;
        all.push(lay(k, shift));
    }
    all
}

/// The square of texture around the path and the straight ray, with some room.
fn square(laid: &[Laid<'_>], straight: Option<[DVec2; 2]>) -> [DVec2; 2] {
    let path = laid.iter().filter(|laid| laid.part[0] < laid.part[1]).flat_map(|laid| laid.path(laid.part));
    let points = path.map(DVec2::from).chain(straight.into_iter().flatten());
    let (low, high) = points.fold((DVec2::MAX, DVec2::MIN), |(low, high), p| (low.min(p), high.max(p)));
    let texel = laid[0].stretch.map_size().max(DVec2::splat(64.0)).recip();
    let side = (1.3 * (high - low).max_element()).max(10.0 * texel.max_element());
    let middle = 0.5 * (low + high);
    [middle - 0.5 * side, middle + 0.5 * side]
}

/// The heights of the square, as a PNG in a data URI.
fn heights(stretch: &Stretch<'_>, [low, high]: [DVec2; 2]) -> String {
    let side = f64::from(PICTURE);
    let height = |x: u32, y: u32| {
        let at = (DVec2::new(f64::from(x), f64::from(y)) + 0.5) / side;
        stretch.height(low + at * (high - low))
    };
    let all: Vec<f64> = (0..PICTURE).flat_map(|y| (0..PICTURE).map(move |x| height(x, y))).collect();
    let (least, most) = all.iter().fold((f64::MAX, f64::MIN), |(a, b), h| (a.min(*h), b.max(*h)));
    let grey = |h: &f64| (70.0 + 175.0 * (h - least) / (most - least).max(1e-9)).round() as u8;
    let mut png = Vec::new();
    // In memory and of the right length: nothing that could fail.
    let written = GrayImage::from_raw(PICTURE, PICTURE, all.iter().map(grey).collect())
        .map(|image| image.write_with_encoder(PngEncoder::new(&mut png)));
    debug_assert!(matches!(written, Some(Ok(()))));
    format!("data:image/png;base64,{}", BASE64_STANDARD.encode(png))
}

/// Draws the map with its left upper corner at `[x, y]`.
pub fn draw(view: &View<'_>, [x, y]: [f64; 2], side: f64) -> Group {
    let laid = laid(view);
    if laid.is_empty() {
        return Group::new();
    }
    let straight = tangent(view, &laid);
    let square = square(&laid, straight);
    let chart = Chart {
        x: Axis { numbers: [square[0].x, square[1].x], places: [x, x + side] },
        y: Axis { numbers: [square[0].y, square[1].y], places: [y, y + side] },
    };
    let own = laid.iter().find(|laid| laid.index == view.at_hit).unwrap_or(&laid[0]);
    let picture = Image::new().set("x", x).set("y", y).set("width", side).set("height", side);
    let mut inside = Group::new()
        .set("clip-path", "url(#map)")
        .add(picture.set("href", heights(own.stretch, square.map(|p| p + own.shift))));
    for laid in &laid {
        let [a, b, c] = laid.stretch.corners().map(|corner| (corner - laid.shift).to_array());
        inside = inside.add(stroke(chart.line([a, b, c, a]), "#1d3557", 1.2).set("stroke-opacity", 0.75));
    }
    if let Some(ends) = straight {
        let ends = ends.map(|p| p.to_array());
        let [x, y] = chart.at(ends[1]);
        let cross =
            Data::new().move_to((x - 5.0, y - 5.0)).line_by((10, 10)).move_to((x - 5.0, y + 5.0)).line_by((10, -10));
        inside = inside
            .add(stroke(chart.line(ends), "white", 3.5))
            .add(stroke(chart.line(ends), TANGENT, 2.0).set("stroke-dasharray", "5 4"))
            .add(stroke(cross, TANGENT, 2.5));
    }
    let hit = view.probe.hit.distance;
    for laid in &laid {
        let before = part_within(laid.stretch, [view.window[0], hit.min(view.window[1])]);
        let behind = part_within(laid.stretch, [hit.max(view.window[0]), view.window[1]]);
        if let Some(part) = behind {
            inside = inside.add(stroke(chart.line(laid.path(part)), RAY, 1.5).set("stroke-dasharray", "4 4"));
        }
        if let Some(part) = before {
            inside = inside.add(stroke(chart.line(laid.path(part)), "white", 5.0)).add(stroke(
                chart.line(laid.path(part)),
                RAY,
                2.5,
            ));
        }
    }
    for place in view.probe.followed.first().iter().flat_map(|followed| &followed.samples) {
        if let Some(laid) = laid.iter().find(|laid| laid.index == place.stretch) {
            let [cx, cy] = chart.at(laid.at(place.x).to_array());
            let dot = Circle::new().set("cx", cx).set("cy", cy).set("r", 2.6).set("fill", "white");
            inside = inside.add(dot.set("stroke", RAY).set("stroke-width", 1.2));
        }
    }
    for followed in &view.probe.followed {
        if let Some((laid, place)) = followed.place.and_then(|p| Some((laid.iter().find(|l| l.index == p.stretch)?, p)))
        {
            inside = inside.add(mark(followed.march, chart.at(laid.at(place.x).to_array()), 4.5));
        }
    }
    if let Some([_, end]) = part_within(own.stretch, [f64::MIN, hit]) {
        inside = inside.add(truth(chart.at(own.at(end).to_array()), 9.0));
    }
    Group::new()
        .add(Definitions::new().add(chart.clip("map")))
        .add(inside)
        .add(chart.axes([6.0, 6.0], ["u of the height map", "v"]))
}

/// The straight ray that parallax mapping follows, from the highest level to where it hits the heights.
fn tangent(view: &View<'_>, laid: &[Laid<'_>]) -> Option<[DVec2; 2]> {
    let (index, stretch) = base(view)?;
    let laid = laid.iter().find(|laid| laid.index == index)?;
    let [from, slope] = stretch.tangent_line()?;
    let [scale, midlevel] = stretch.scale();
    let [top, bottom] = [(1.0 - midlevel) * scale, -midlevel * scale];
    let at = |t: f64| from + t * slope;
    // To a part of the way that no eye can see.
    let mut levels = (0..=4096).map(|i| top + (bottom - top) * f64::from(i) / 4096.0);
    let hit = levels.find(|t| *t <= (stretch.height(at(*t)) - midlevel) * scale).unwrap_or(bottom);
    Some([top, hit].map(|t| at(t) - laid.shift))
}
