//! The profile along the ray: its level against the surface's, prism by prism.

use svg::node::element::{Circle, Definitions, Group, Line, Path, Rectangle};

use super::{
    chart::{Axis, Chart, FAINT, stroke, words},
    figure::{FIELD, RAY, SURFACE, View, colour, mark, part_within, truth},
};

/// Points of a curve within a prism.
const POINTS: usize = 160;
/// A prism narrower than this is not named.
const ROOM: f64 = 34.0;

/// The axis of levels that holds ray and surface within a window of distances. `places`: bottom and top.
pub fn levels(view: &View<'_>, window: [f64; 2], places: [f64; 2]) -> Axis {
    let mut range = [f64::MAX, f64::MIN];
    for (_, stretch, _) in view.stretches() {
        let Some([from, to]) = part_within(stretch, window) else { continue };
        for i in 0..=POINTS {
            let station = stretch.at(from + (to - from) * i as f64 / POINTS as f64);
            // A level that leaves the shell says nothing about the hit.
            for t in [station.t, station.surface] {
                range = [range[0].min(t), range[1].max(t)];
            }
        }
    }
    if range[0] >= range[1] {
        range = [range[0].min(0.0) - 1e-6, range[0].max(0.0) + 1e-6];
    }
    let room = 0.08 * (range[1] - range[0]);
    Axis { numbers: [range[0] - room, range[1] + room], places }
}

/// Distances around the true hit that hold those of the marches that came near it.
pub fn close_up(view: &View<'_>) -> [f64; 2] {
    let hit = view.probe.hit.distance;
    let whole = view.window[1] - view.window[0];
    let errors = view.probe.followed.iter().filter_map(|followed| Some((followed.distance? - hit).abs()));
    let near = errors.filter(|error| *error < 0.12 * whole).fold(0.0, f64::max);
    // No nearer than shows a curve that is one.
    let half = (1.6 * near).max(0.012 * whole);
    [hit - half, hit + half]
}

/// Draws a window of distances into a panel.
pub fn draw(view: &View<'_>, chart: &Chart, id: &str, window: [f64; 2], counts: [f64; 2]) -> Group {
    let clip = format!("url(#{id})");
    let mut inside = Group::new().set("clip-path", clip);
    let [bottom, top] = chart.y.places;
    for (i, stretch, _) in view.stretches() {
        let Some([from, to]) = part_within(stretch, window) else { continue };
        let curve = |level: fn(&prism_engine::shell::reference::Station) -> f64| {
            let points = (0..=POINTS).map(|k| stretch.at(from + (to - from) * k as f64 / POINTS as f64));
            points.map(|station| [view.along(station.distance), level(&station)]).collect::<Vec<_>>()
        };
        let surface = curve(|station| station.surface);
        let [x0, x1] = [surface[0][0], surface[POINTS][0]].map(|x| chart.at([x, 0.0])[0]);
        if i % 2 == 1 {
            let band = Rectangle::new().set("x", x0).set("y", top).set("width", x1 - x0).set("height", bottom - top);
            inside = inside.add(band.set("fill", "#f1f3f8"));
        }
        let ground = chart.y.numbers[0];
        let mut outline = surface.clone();
        outline.push([surface[POINTS][0], ground]);
        outline.push([surface[0][0], ground]);
        inside = inside
            .add(Path::new().set("d", chart.line(outline).close()).set("fill", FIELD).set("fill-opacity", 0.75))
            .add(stroke(chart.line(surface), SURFACE, 1.5));
        let wall = Line::new().set("x1", x1).set("x2", x1).set("y1", top).set("y2", bottom);
        inside = inside.add(wall.set("stroke", FAINT).set("stroke-width", 0.8));
        if x1 - x0 > ROOM {
            let name = format!("prism {}", stretch.triangle);
            inside = inside.add(words([0.5 * (x0 + x1), top + 12.0], &name, 9.0, "middle").set("fill", FAINT));
        }
        let hit = view.probe.hit.distance;
        let ray = curve(|station| station.t);
        let (before, behind): (Vec<[f64; 2]>, Vec<[f64; 2]>) = ray.into_iter().partition(|p| p[0] <= view.along(hit));
        inside = inside.add(stroke(chart.line(before), RAY, 2.0));
        inside = inside.add(stroke(chart.line(behind), RAY, 1.3).set("stroke-dasharray", "4 4"));
    }
    inside = marks(view, chart, window, inside);
    Group::new()
        .add(Definitions::new().add(chart.clip(id)))
        .add(inside)
        .add(chart.axes(counts, ["distance along the ray, world units", "level t, mesh units"]))
}

/// Samples, the hits, the true hit.
fn marks(view: &View<'_>, chart: &Chart, window: [f64; 2], mut inside: Group) -> Group {
    let way = view.probe.way;
    let point = |place: &prism_engine::shell::follow::Place| {
        let station = way.stretches[place.stretch].at(place.x);
        let shown = (window[0]..=window[1]).contains(&station.distance);
        shown.then(|| chart.at([view.along(station.distance), station.t]))
    };
    // Those of a later march lie under those of an earlier one: linear searches share theirs.
    for followed in view.probe.followed.iter().rev() {
        for [x, y] in followed.samples.iter().filter_map(point) {
            let dot = Circle::new().set("cx", x).set("cy", y).set("r", 2.0).set("fill", "white");
            inside = inside.add(dot.set("stroke", colour(followed.march)).set("stroke-width", 1.0));
        }
    }
    for followed in &view.probe.followed {
        if let Some(at) = followed.place.as_ref().and_then(point) {
            inside = inside.add(mark(followed.march, at, 4.5));
        }
    }
    let stretch = &way.stretches[view.at_hit];
    if let Some([_, end]) = part_within(stretch, [f64::MIN, view.probe.hit.distance]) {
        inside = inside.add(truth(chart.at([view.along(view.probe.hit.distance), stretch.at(end).t]), 8.0));
    }
    inside
}
