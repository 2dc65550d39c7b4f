//! A probe in figures: JSON for stdout.

use prism_engine::shell::follow::{Followed, Place};
use serde_json::{Value, json};

use super::Probe;

/// The probe as JSON, a line of it ended.
pub fn json(probe: &Probe<'_>) -> String {
    let hit = &probe.hit;
    let prisms: Vec<Value> = (probe.way.stretches.iter())
        .map(|stretch| {
            json!({
                "instance": stretch.instance,
                "primitive": stretch.primitive,
                "triangle": stretch.triangle,
                "depth": [stretch.at(0.0).distance, stretch.at(1.0).distance],
                "t": stretch.t,
            })
        })
        .collect();
    let marches: Vec<Value> = probe.followed.iter().map(|followed| march(probe, followed)).collect();
    let record = json!({
        "scene": probe.name,
        "size": probe.pixel.size,
        "pixel": probe.pixel.at,
        "hit": {
            "depth": hit.distance,
            "position": hit.position.to_array(),
            "normal": hit.normal.to_array(),
            "uv": hit.uv.to_array(),
            "height": hit.height,
            "wall": hit.on_wall,
        },
        "prisms": prisms,
        "marches": marches,
    });
    format!("{record:#}\n")
}

fn march(probe: &Probe<'_>, followed: &Followed) -> Value {
    let place = |place: &Place| {
        let stretch = &probe.way.stretches[place.stretch];
        let (station, [scale, midlevel]) = (stretch.at(place.x), stretch.scale());
        json!({
            "prism": place.stretch,
            "depth": station.distance,
            "uv": station.uv.to_array(),
            "height": station.t / scale + midlevel,
            "surface": station.surface / scale + midlevel,
        })
    };
    json!({
        "march": followed.march.name(),
        "depth": followed.distance,
        "error_pixels": probe.error(followed),
        "hit": followed.place.as_ref().map(place),
        "samples": followed.samples.iter().map(place).collect::<Vec<_>>(),
    })
}
