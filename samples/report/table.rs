//! The points as rows: for programs a CSV with all digits, for people cells.

use std::path::Path;

use prism_engine::{error::Result, settings::Baseline};

use super::measure::Point;
use crate::app::files;

/// Columns of the CSV.
const COLUMNS: &[&str] = &[
    "part",
    "scene",
    "condition",
    "x",
    "width",
    "height",
    "technique",
    "setting",
    "shell",
    "stage",
    "march",
    "steps",
    "refine_steps",
    "density",
    "self_shadow",
    "msaa",
    "covered",
    "depth_p50",
    "depth_p99",
    "depth_above_1",
    "silhouette",
    "normal_p50",
    "normal_p99",
    "shadow_wrong",
    "flip",
    "flicker_p99",
    "ms_least",
    "ms_low",
    "ms_median",
    "ms_high",
    "ms_most",
    "outliers",
    "rounds",
    "fragments",
    "height_reads",
    "memory_mib",
];

fn fields(point: &Point) -> Vec<String> {
    let Point { variant, metrics: m, timing, .. } = point;
    let s = &variant.settings;
    let number = |value: f64| value.to_string();
    let maybe = |value: Option<f64>| value.map_or(String::new(), number);
    let spread = timing.spread();
    let drawn = s.baseline.is_none();
    let ours = |text: String| if drawn { text } else { String::new() };
    let density = if let Some(Baseline::MicroMesh { density, .. }) = s.baseline { Some(density) } else { None };
    vec![
        point.part.to_owned(),
        point.scene.clone(),
        point.condition.clone(),
        maybe(point.x),
        point.size[0].to_string(),
        point.size[1].to_string(),
        variant.technique.clone(),
        variant.setting.clone(),
        ours(s.shell.to_string()),
        ours(s.stage.to_string()),
        ours(s.march.to_string()),
        if drawn && (s.march.steps() || s.march.reads_cones()) { s.max_steps.to_string() } else { String::new() },
        if drawn && s.march.refines() { s.refine_steps.to_string() } else { String::new() },
        density.map_or(String::new(), |n| n.to_string()),
        s.self_shadow.to_string(),
        s.msaa.to_string(),
        m.covered.to_string(),
        number(m.depth_p50),
        number(m.depth_p99),
        number(m.depth_above_1),
        number(m.coverage_differs),
        number(m.normal_p50),
        number(m.normal_p99),
        number(m.shadow_wrong),
        maybe(point.flip),
        maybe(point.flicker),
        number(timing.least()),
        maybe(spread.map(|s| s.low)),
        maybe(spread.map(|s| s.median)),
        maybe(spread.map(|s| s.high)),
        maybe(timing.times.iter().copied().reduce(f64::max)),
        timing.outliers().len().to_string(),
        timing.times.len().to_string(),
        timing.fragments.map_or(String::new(), |n| n.to_string()),
        maybe(point.reads),
        number(point.memory),
    ]
}

/// Writes a row a point.
pub fn write_csv(path: &Path, points: &[Point]) -> Result<()> {
    files::replace(path, "table", |file| {
        let mut csv = csv::Writer::from_writer(file);
        csv.write_record(COLUMNS)?;
        for point in points {
            csv.write_record(fields(point))?;
        }
        Ok(csv.flush()?)
    })
}

/// A column for people: its head, what it means, and a point's cell; none where it says nothing.
pub struct Column {
    /// Above the cells.
    pub head: &'static str,
    /// In words.
    pub meaning: &'static str,
    /// The cell.
    pub cell: fn(&Point) -> Option<String>,
}

/// Three digits that count.
pub fn short(value: f64) -> String {
    match value.abs() {
        0.0 => "0".into(),
        v if !(1e-3..1e5).contains(&v) => format!("{value:.1e}"),
        v => {
            let decimals = (2 - v.log10().floor() as i32).clamp(0, 5) as usize;
            format!("{value:.decimals$}")
        }
    }
}

fn percent(share: f64) -> String {
    format!("{} %", short(100.0 * share))
}

/// The columns that people see.
pub const FOR_PEOPLE: &[Column] = &[
    Column { head: "technique", meaning: "place and march, or baseline", cell: |p| Some(p.variant.technique.clone()) },
    Column { head: "setting", meaning: "its place on the curve", cell: |p| Some(p.variant.setting.clone()) },
    Column {
        head: "time, ms",
        meaning: "GPU time of a frame, median of the rounds, milliseconds",
        cell: |p| p.timing.spread().map(|s| short(s.median)),
    },
    Column {
        head: "quartiles",
        meaning: "a quarter of the times lies below the one, a quarter above the other",
        cell: |p| p.timing.spread().map(|s| format!("{} to {}", short(s.low), short(s.high))),
    },
    Column {
        head: "outliers",
        meaning: "times further from the quartiles than 1.5 times their distance",
        cell: |p| Some(p.timing.outliers().iter().map(|ms| short(*ms)).collect::<Vec<_>>().join(", ")),
    },
    Column {
        head: "fragments",
        meaning: "fragment shader invocations of a frame",
        cell: |p| p.timing.fragments.map(|n| n.to_string()),
    },
    Column {
        head: "reads",
        meaning: "reads of the height map, its bounds or cones by fragments, for each covered pixel",
        cell: |p| p.reads.map(short),
    },
    Column { head: "MiB", meaning: "kept on the device, colour textures not counted", cell: |p| Some(short(p.memory)) },
    Column {
        head: "depth p50",
        meaning: "median depth error, pixel footprints",
        cell: |p| Some(short(p.metrics.depth_p50)),
    },
    Column {
        head: "depth p99",
        meaning: "99 % of the pixels have a smaller depth error, pixel footprints",
        cell: |p| Some(short(p.metrics.depth_p99)),
    },
    Column {
        head: "depth above 1",
        meaning: "pixels whose depth is off by more than a footprint",
        cell: |p| Some(percent(p.metrics.depth_above_1)),
    },
    Column {
        head: "silhouette",
        meaning: "pixels that only one of frame and reference covers, per covered pixel",
        cell: |p| Some(percent(p.metrics.coverage_differs)),
    },
    Column {
        head: "normal, °",
        meaning: "99th percentile of the angle between the normals, degrees",
        cell: |p| Some(short(p.metrics.normal_p99)),
    },
    Column {
        head: "shadow",
        meaning: "pixels lit in one and dark in the other",
        cell: |p| (p.part == "shadow").then(|| percent(p.metrics.shadow_wrong)),
    },
    Column { head: "FLIP", meaning: "mean FLIP of the shaded picture, 0 to 1", cell: |p| p.flip.map(short) },
    Column {
        head: "flicker",
        meaning: "99th percentile of what the depth error of a point changes by, footprints",
        cell: |p| p.flicker.map(short),
    },
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn three_digits_count() {
        for (value, text) in [
            (0.0, "0"),
            (0.0123456, "0.0123"),
            (0.5, "0.500"),
            (12.345, "12.3"),
            (99999.4, "99999"),
            (1e-4, "1.0e-4"),
            (3e7, "3.0e7"),
        ] {
            assert_eq!(short(value), text);
        }
    }

    #[test]
    fn no_column_is_named_twice() {
        for (i, name) in COLUMNS.iter().enumerate() {
            assert!(!COLUMNS[..i].contains(name), "{name}");
        }
    }
}
