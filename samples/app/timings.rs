//! What the passes of the frames took: rows for `--csv`, a summary for `--stats`.

use std::{
    fmt::{self, Write as _},
    io::Write as _,
    path::Path,
};

use prism_engine::error::Result;

use super::files;

/// One pass of one frame. A value that the device cannot measure is absent.
#[derive(Clone, Debug, PartialEq)]
pub struct PassRow {
    /// The pass.
    pub pass: String,
    /// Between its timestamps, milliseconds.
    pub gpu_ms: Option<f64>,
    /// Fragment shader invocations.
    pub invocations: Option<u64>,
    /// Primitives that reached clipping.
    pub primitives: Option<u64>,
}

/// One frame.
#[derive(Clone, Debug, PartialEq)]
pub struct FrameRow {
    /// From 0.
    pub frame: u64,
    /// The sample's time, seconds.
    pub time: f64,
    /// Its passes in the order in which they ran.
    pub passes: Vec<PassRow>,
}

#[cfg(feature = "window")]
impl FrameRow {
    /// GPU time of all passes, milliseconds.
    pub fn gpu_ms(&self) -> Option<f64> {
        self.passes.iter().map(|pass| pass.gpu_ms).sum()
    }
}

/// Writes a row per frame and pass.
pub fn write_csv(path: &Path, frames: &[FrameRow]) -> Result<()> {
    files::replace(path, "table", |file| {
        writeln!(file, "frame,time,pass,gpu_ms,invocations,primitives")?;
        for frame in frames {
            for row in &frame.passes {
                let (pass, ms) = (quoted(&row.pass), shown(row.gpu_ms));
                let (invocations, primitives) = (shown(row.invocations), shown(row.primitives));
                writeln!(file, "{},{},{pass},{ms},{invocations},{primitives}", frame.frame, frame.time)?;
            }
        }
        Ok(())
    })
}

/// A field that a comma or a quote in a pass's name cannot break.
fn quoted(text: &str) -> String {
    if text.contains([',', '"', '\n']) { format!("\"{}\"", text.replace('"', "\"\"")) } else { text.to_owned() }
}

fn shown<T: fmt::Display>(value: Option<T>) -> String {
    value.map(|value| value.to_string()).unwrap_or_default()
}

/// The summary of every pass, aligned for reading: `pass NAME: gpu MIN MEDIAN P95 ms (n=N), …`.
///
/// Counts are the last frame's: they say what the picture cost.
pub fn summary(frames: &[FrameRow]) -> String {
    let mut text = String::new();
    for name in pass_names(frames) {
        let rows = || frames.iter().flat_map(|frame| &frame.passes).filter(|row| row.pass == name);
        let mut times: Vec<f64> = rows().filter_map(|row| row.gpu_ms).collect();
        times.sort_by(f64::total_cmp);
        let gpu = match (times.first(), quantile(&times, 0.5), quantile(&times, 0.95)) {
            (Some(min), Some(median), Some(p95)) => {
                format!("{min:.3} ms min, {median:.3} ms median, {p95:.3} ms p95, n={}", times.len())
            }
            _ => "no timestamps on this device".to_owned(),
        };
        let count = |value: Option<u64>| value.map_or_else(|| "unknown".to_owned(), |n| n.to_string());
        let last = rows().next_back();
        let invocations = count(last.and_then(|row| row.invocations));
        let primitives = count(last.and_then(|row| row.primitives));
        // Writing to a String cannot fail.
        let _ = writeln!(text, "pass {name}: gpu {gpu}; invocations {invocations}; primitives {primitives}");
    }
    text
}

/// Names of the passes in the order in which they first ran.
fn pass_names(frames: &[FrameRow]) -> Vec<&str> {
    let mut names: Vec<&str> = Vec::new();
    for row in frames.iter().flat_map(|frame| &frame.passes) {
        if !names.contains(&row.pass.as_str()) {
            names.push(&row.pass);
        }
    }
    names
}

/// The smallest value that at least the share `q` of the sorted values do not exceed (nearest rank).
fn quantile(sorted: &[f64], q: f64) -> Option<f64> {
    let rank = (q * sorted.len() as f64).ceil() as usize;
    sorted.get(rank.max(1) - 1).copied()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame(frame: u64, ms: Option<f64>) -> FrameRow {
        let row =
            |pass: &str| PassRow { pass: pass.into(), gpu_ms: ms, invocations: Some(7 + frame), primitives: None };
        FrameRow { frame, time: frame as f64 * 0.5, passes: vec![row("shell"), row("tone, map")] }
    }

    #[test]
    fn quantiles_by_nearest_rank() {
        let values: Vec<f64> = (1..=20).map(f64::from).collect();
        assert_eq!(quantile(&values, 0.5), Some(10.0));
        assert_eq!(quantile(&values, 0.95), Some(19.0));
        assert_eq!(quantile(&[3.0], 0.95), Some(3.0));
        assert_eq!(quantile(&[], 0.5), None);
    }

    #[test]
    fn the_table_has_a_row_per_frame_and_pass() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("frames.csv");
        write_csv(&path, &[frame(0, Some(1.5)), frame(1, None)]).unwrap();
        let text = std::fs::read_to_string(&path).unwrap();
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines[0], "frame,time,pass,gpu_ms,invocations,primitives");
        assert_eq!(lines[1], "0,0,shell,1.5,7,");
        assert_eq!(lines[2], "0,0,\"tone, map\",1.5,7,");
        assert_eq!(lines[3], "1,0.5,shell,,8,");
        assert_eq!(lines.len(), 5);
    }

    #[test]
    fn the_summary_says_how_many_frames_it_saw() {
        let text = summary(&[frame(0, Some(4.0)), frame(1, Some(2.0)), frame(2, Some(3.0))]);
        let first = text.lines().next().unwrap();
        assert_eq!(
            first,
            "pass shell: gpu 2.000 ms min, 3.000 ms median, 4.000 ms p95, n=3; invocations 9; primitives unknown"
        );
        assert!(summary(&[frame(0, None)]).contains("no timestamps"));
    }
}
