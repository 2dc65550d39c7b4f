//! The whole drawing: the map on the left, the profile with a lane for each march and a close-up on the right.

use prism_engine::{
    settings::March,
    shell::{follow::Followed, reference::Stretch},
};
use svg::{
    Document,
    node::element::{Circle, Group, Path, Rectangle, path::Data},
};

use super::{
    Probe,
    chart::{Axis, Chart, INK, stroke, words},
    map, profile,
};

/// The ray.
pub const RAY: &str = "#d7263d";
/// What classic parallax takes for it.
pub const TANGENT: &str = "#0f8b8d";
/// The field.
pub const FIELD: &str = "#c8b6a6";
/// Its outline.
pub const SURFACE: &str = "#7f5539";

const SIZE: [f64; 2] = [1240.0, 760.0];
/// Rows of the lanes.
const LANE: f64 = 19.0;

/// What of the ray is shown, and how distances along it are told.
pub struct View<'a> {
    pub probe: &'a Probe<'a>,
    /// Distances, in units of the ray's direction.
    pub window: [f64; 2],
    /// World units of one of these.
    pub unit: f64,
    /// The stretch with the hit, or the last before it.
    pub at_hit: usize,
}

impl<'a> View<'a> {
    /// All of the ray up to the last hit, and a little more.
    pub fn new(probe: &'a Probe<'a>) -> Self {
        let way = probe.way;
        let samples = probe.followed.iter().flat_map(|followed| &followed.samples);
        let starts = samples.map(|place| way.stretches[place.stretch].at(place.x).distance);
        let first = starts.fold(probe.hit.distance, f64::min).min(way.stretches[0].at(0.0).distance.max(0.0));
        let hits = probe.followed.iter().filter_map(|followed| followed.distance);
        let last = hits.fold(probe.hit.distance, f64::max);
        let at_hit = way.stretches.iter().rposition(|s| s.at(0.0).distance <= probe.hit.distance).unwrap_or(0);
        let window = [first, last + 0.12 * (last - first)];
        View { probe, window, unit: way.direction.length(), at_hit }
    }

    /// A distance as it is told: world units from the window's beginning.
    pub fn along(&self, distance: f64) -> f64 {
        (distance - self.window[0]) * self.unit
    }

    /// The stretches that the window shows, and the part of each.
    pub fn stretches(&self) -> impl Iterator<Item = (usize, &'a Stretch<'a>, [f64; 2])> {
        let window = self.window;
        let shown = move |(i, stretch): (usize, &'a Stretch<'a>)| {
            let part = part_within(stretch, window)?;
            Some((i, stretch, part))
        };
        self.probe.way.stretches.iter().enumerate().filter_map(shown)
    }
}

/// Parameters of a stretch between two distances.
pub fn part_within(stretch: &Stretch<'_>, [near, far]: [f64; 2]) -> Option<[f64; 2]> {
    // Distances grow with the parameter: the ray goes one way.
    let find = |distance: f64| {
        let (mut a, mut b) = (0.0, 1.0);
        for _ in 0..50 {
            let middle = 0.5 * (a + b);
            if stretch.at(middle).distance < distance { a = middle } else { b = middle }
        }
        0.5 * (a + b)
    };
    let (start, end) = (stretch.at(0.0).distance, stretch.at(1.0).distance);
    let from = if start >= near { 0.0 } else { find(near) };
    let to = if end <= far { 1.0 } else { find(far) };
    (start < far && end > near && from < to).then_some([from, to])
}

/// The colour of a march.
pub fn colour(march: March) -> &'static str {
    match march {
        March::Steep => "#e07a00",
        March::Pom => "#2f80c2",
        March::Relief => "#009e73",
        March::Secant => "#c0529b",
        March::Contact => "#6a4cbe",
        March::Cone => "#004d80",
        March::RelaxedCone => "#8a6d00",
        _ => INK,
    }
}

/// The mark of a march's hit: no two alike, so that colours are not all there is to tell them by.
pub fn mark(march: March, [x, y]: [f64; 2], size: f64) -> Path {
    let d = size;
    let data = Data::new();
    let data = match march {
        March::Steep => data.move_to((x - d, y - d)).line_by((2.0 * d, 0)).line_by((0, 2.0 * d)).line_by((-2.0 * d, 0)),
        March::Pom => data
            .move_to((x, y - 1.3 * d))
            .line_by((1.3 * d, 1.3 * d))
            .line_by((-1.3 * d, 1.3 * d))
            .line_by((-1.3 * d, -1.3 * d)),
        March::Relief => data.move_to((x, y - 1.3 * d)).line_by((1.3 * d, 2.2 * d)).line_by((-2.6 * d, 0)),
        March::Secant => data.move_to((x, y + 1.3 * d)).line_by((1.3 * d, -2.2 * d)).line_by((-2.6 * d, 0)),
        March::Contact => data.move_to((x - 1.3 * d, y)).line_by((2.2 * d, -1.3 * d)).line_by((0, 2.6 * d)),
        March::Cone => data.move_to((x + 1.3 * d, y)).line_by((-2.2 * d, -1.3 * d)).line_by((0, 2.6 * d)),
        _ => data
            .move_to((x - d, y - 0.5 * d))
            .line_by((d, -d))
            .line_by((d, d))
            .line_by((0, d))
            .line_by((-d, d))
            .line_by((-d, -d)),
    };
    Path::new().set("d", data.close()).set("fill", colour(march)).set("stroke", "white").set("stroke-width", 1)
}

/// The mark of the true hit.
pub fn truth([x, y]: [f64; 2], radius: f64) -> Group {
    let ring = |radius: f64, colour: &str, width: f64| {
        let circle = Circle::new().set("cx", x).set("cy", y).set("r", radius).set("fill", "none");
        circle.set("stroke", colour).set("stroke-width", width)
    };
    Group::new().add(ring(radius, "white", 4.0)).add(ring(radius, "black", 2.0))
}

/// Draws a probe.
pub fn draw(probe: &Probe<'_>) -> Document {
    let view = View::new(probe);
    let [x, y] = probe.pixel.at;
    let [width, height] = probe.pixel.size;
    let shown = view.stretches().count();
    let prisms = if shown == 1 { "one prism".to_owned() } else { format!("{shown} prisms") };
    let title = format!("{}: pixel {x},{y} of {width}x{height}", probe.name);
    let what = format!(
        "One pixel's ray through {prisms}, as the marches see it. The ring is the true hit, by the f64 reference."
    );
    let mut document = Document::new()
        .set("viewBox", (0, 0, SIZE[0], SIZE[1]))
        .set("width", SIZE[0])
        .set("height", SIZE[1])
        .set("font-family", "Helvetica, Arial, 'DejaVu Sans', sans-serif")
        .add(Rectangle::new().set("width", "100%").set("height", "100%").set("fill", "white"))
        .add(words([24.0, 34.0], &title, 20.0, "start").set("font-weight", "bold"))
        .add(words([24.0, 54.0], &what, 12.0, "start"));

    document = document.add(map::draw(&view, [74.0, 84.0], 500.0));
    document = document.add(key([74.0, 640.0], &view));

    let along = Axis { numbers: [0.0, view.along(view.window[1])], places: [690.0, 1130.0] };
    let chart = Chart { x: along, y: profile::levels(&view, view.window, [300.0, 84.0]) };
    document = document.add(profile::draw(&view, &chart, "profile", view.window, [8.0, 6.0]));
    document = document.add(lanes(&view, &chart, 352.0));

    let close = profile::close_up(&view);
    let along = Axis { numbers: close.map(|distance| view.along(distance)), places: [690.0, 1130.0] };
    let below = 352.0 + LANE * probe.followed.len().max(1) as f64 + 42.0;
    let chart = Chart { x: along, y: profile::levels(&view, close, [718.0, below]) };
    document = document.add(words([690.0, below - 8.0], "Around the hit", 12.0, "start").set("font-weight", "bold"));
    document.add(profile::draw(&view, &chart, "close", close, [6.0, 4.0]))
}

/// A lane for each march under the profile: where it takes samples, where it ends, how many they are and how far it is off.
fn lanes(view: &View<'_>, chart: &Chart, top: f64) -> Group {
    let mut group = Group::new();
    let way = view.probe.way;
    for (row, followed) in view.probe.followed.iter().enumerate() {
        let y = top + LANE * (row as f64 + 0.5);
        let hue = colour(followed.march);
        let [from, to] = chart.x.places;
        let base = Data::new().move_to((from, y)).line_to((to, y));
        group = group.add(stroke(base, "#e5e7ee", 1.0));
        let mut ticks = Data::new();
        for place in &followed.samples {
            let x = chart.at([view.along(way.stretches[place.stretch].at(place.x).distance), 0.0])[0];
            ticks = ticks.move_to((x, y - 5.0)).line_to((x, y + 5.0));
        }
        group =
            group.add(stroke(ticks, hue, 1.0)).add(words([from - 10.0, y + 4.0], followed.march.name(), 11.0, "end"));
        if let Some(distance) = followed.distance {
            group = group.add(mark(followed.march, [chart.at([view.along(distance), 0.0])[0], y], 4.5));
        }
        group = group.add(words([to + 8.0, y + 4.0], &verdict(view, followed), 10.0, "start"));
    }
    group
}

/// Samples and error of a march.
pub fn verdict(view: &View<'_>, followed: &Followed) -> String {
    let count = followed.samples.len();
    match view.probe.error(followed) {
        None => format!("{count}, no hit"),
        Some(error) if error.abs() < 5e-4 => format!("{count}, off by < 0.001 px"),
        Some(error) => format!("{count}, off by {error:+.3} px"),
    }
}

/// What lines and marks mean.
fn key([x, y]: [f64; 2], view: &View<'_>) -> Group {
    let line = |row: f64, colour: &str, dashes: &str| {
        let data = Data::new().move_to((x, y + 18.0 * row)).line_by((30.0, 0));
        stroke(data, colour, 2.5).set("stroke-dasharray", dashes.to_owned())
    };
    let told = |row: f64, text: &str| words([x + 40.0, y + 18.0 * row + 4.0], text, 11.0, "start");
    let parallax = if map::base(view).is_some() {
        "parallax mapping: the straight ray in the base triangle's plane, and its hit (×)"
    } else {
        "no base surface lies in this pixel: parallax mapping leaves it out"
    };
    Group::new()
        .add(line(0.0, RAY, "none"))
        .add(told(0.0, "the ray's exact path, prism by prism; dashed behind the hit; first march's samples"))
        .add(line(1.0, TANGENT, "5 4"))
        .add(told(1.0, parallax))
        .add(line(2.0, "#1d3557", "none"))
        .add(told(2.0, "base triangles of the prisms it passes, over the height map (light is high)"))
        .add(truth([x + 15.0, y + 54.0], 6.0))
        .add(told(3.0, "the true hit; on the right each march's samples and its error in pixel footprints"))
}
