//! The result: one row a fact, as Markdown and as CSV.

use std::{fmt::Write as _, path::Path};

use prism_engine::{error::Result, measure::Metrics};

use crate::{app::files, timing::Spread};

/// What a value must be.
#[derive(Clone, Copy, Debug)]
pub enum Target {
    /// This or more.
    AtLeast(f64),
    /// This or less.
    AtMost(f64),
}

/// One row.
#[derive(Clone, Debug, Default)]
pub struct Row {
    /// What it tells.
    pub name: String,
    /// Of which setting or pair of settings.
    pub setting: String,
    /// Error of the setting.
    pub metrics: Option<Metrics>,
    /// The value; none where it could not be measured.
    pub value: Option<Spread>,
    /// Its unit.
    pub unit: &'static str,
    /// What it must be, if anything.
    pub target: Option<Target>,
}

impl Row {
    fn verdict(&self) -> &'static str {
        let (Some(target), Some(value)) = (self.target, self.value) else {
            return if self.value.is_none() { "not measured" } else { "" };
        };
        let met = match target {
            Target::AtLeast(least) => value.median >= least,
            Target::AtMost(most) => value.median <= most,
        };
        if met { "met" } else { "MISSED" }
    }

    fn cells(&self) -> [String; 9] {
        let number = |value: f64| {
            let decimals = if value >= 100.0 {
                0
            } else if value >= 10.0 {
                1
            } else {
                3
            };
            format!("{value:.decimals$}")
        };
        let of = |f: fn(&Metrics) -> f64| self.metrics.as_ref().map(f).map_or(String::new(), |v| format!("{v:.1e}"));
        let quartiles = self.value.filter(|v| v.low < v.high);
        [
            self.name.clone(),
            self.setting.clone(),
            of(|m| m.depth_p99),
            of(|m| m.coverage_differs),
            self.value.map_or(String::new(), |v| number(v.median)),
            quartiles.map_or(String::new(), |v| format!("{} to {}", number(v.low), number(v.high))),
            self.unit.to_owned(),
            match self.target {
                Some(Target::AtLeast(least)) => format!("≥ {least}"),
                Some(Target::AtMost(most)) => format!("≤ {most}"),
                None => String::new(),
            },
            self.verdict().to_owned(),
        ]
    }
}

const HEADER: [&str; 9] =
    ["row", "setting", "depth p99, footprints", "coverage differs", "median", "quartiles", "unit", "target", "verdict"];

/// The rows as a Markdown table.
pub fn markdown(rows: &[Row]) -> String {
    let mut text = format!("| {} |\n|{}\n", HEADER.join(" | "), "---|".repeat(HEADER.len()));
    for row in rows {
        // Writing to a String cannot fail.
        let _ = writeln!(text, "| {} |", row.cells().join(" | "));
    }
    text
}

/// The same with all digits, for programs.
pub fn write_csv(path: &Path, rows: &[Row]) -> Result<()> {
    files::replace(path, "table", |file| {
        use std::io::Write as _;
        writeln!(file, "row,setting,depth_p99,coverage_differs,low,median,high,unit,target,verdict")?;
        for row in rows {
            let quoted = |text: &str| format!("\"{}\"", text.replace('"', "\"\""));
            let shown = |value: Option<f64>| value.map_or(String::new(), |v| v.to_string());
            let fields = [
                quoted(&row.name),
                quoted(&row.setting),
                shown(row.metrics.map(|m| m.depth_p99)),
                shown(row.metrics.map(|m| m.coverage_differs)),
                shown(row.value.map(|v| v.low)),
                shown(row.value.map(|v| v.median)),
                shown(row.value.map(|v| v.high)),
                row.unit.to_owned(),
                row.cells()[7].clone(),
                row.verdict().to_owned(),
            ];
            writeln!(file, "{}", fields.join(","))?;
        }
        Ok(())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_missed_target_says_so() {
        let value = Some(Spread { low: 1.5, median: 1.9, high: 2.5 });
        let row = |target, value| Row { target, value, ..Row::default() };
        assert_eq!(row(Some(Target::AtLeast(2.0)), value).verdict(), "MISSED");
        assert_eq!(row(Some(Target::AtMost(2.0)), value).verdict(), "met");
        assert_eq!(row(Some(Target::AtMost(2.0)), None).verdict(), "not measured");
        assert_eq!(row(None, value).verdict(), "");
        let text = markdown(&[row(Some(Target::AtLeast(2.0)), value)]);
        assert!(text.contains("| 1.900 | 1.500 to 2.500 |  | ≥ 2 | MISSED |"), "{text}");
    }
}
