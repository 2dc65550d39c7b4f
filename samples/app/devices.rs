//! `prism list` and `prism devices`: what there is to run, and on what.

use prism_engine::{
    error::Result,
    gpu::{self, DeviceReport, Feature},
    settings::Validation,
};

use super::{console, sample::Sample};

/// One line per sample.
pub fn list_samples(samples: &[&dyn Sample]) -> Result<()> {
    let width = samples.iter().map(|sample| sample.id().len()).max().unwrap_or(0);
    let lines: String =
        samples.iter().map(|sample| format!("{:width$}  {}\n", sample.id(), sample.summary())).collect();
    console::data(&lines)
}

/// Every Vulkan device, and why one is refused.
pub fn list() -> Result<()> {
    // Without the validation layer: what is installed for developers says nothing about a device.
    let reports = gpu::list_devices(Validation::Off, &[])?;
    console::data(&reports.iter().map(describe).collect::<String>())
}

fn describe(report: &DeviceReport) -> String {
    let DeviceReport { index, name, kind, api_version, driver, .. } = report;
    let verdict = match &report.rejected {
        Some(reason) => format!("refused: {reason}"),
        None => "usable".to_owned(),
    };
    let named = |present: bool| {
        let names: Vec<&str> =
            report.features.iter().filter(|(_, has)| *has == present).map(|(feature, _)| feature.name()).collect();
        if names.is_empty() { "none".to_owned() } else { names.join(", ") }
    };
    let mut text = format!("{index}  {name}\n   {kind}, Vulkan {api_version}, {}\n   {verdict}\n", driver.trim());
    if report.rejected.is_none() {
        text += &format!("   has: {}\n   lacks: {}\n", named(true), named(false));
        let stage =
            |(feature, has): &(Feature, bool)| *has && matches!(feature, Feature::MeshShader | Feature::GeometryShader);
        if !report.features.iter().any(stage) {
            text += "   neither mesh nor geometry stage: only --shell off can be drawn\n";
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    fn report(rejected: Option<&str>, mesh: bool) -> DeviceReport {
        DeviceReport {
            index: 1,
            name: "Some GPU".into(),
            kind: "discrete",
            api_version: "1.3.0".into(),
            driver: "driver 1".into(),
            rejected: rejected.map(Into::into),
            features: vec![(Feature::MeshShader, mesh), (Feature::GeometryShader, false)],
        }
    }

    #[test]
    fn a_refused_device_says_why() {
        let text = describe(&report(Some("Vulkan 1.2.0, 1.3 is needed"), false));
        assert!(text.contains("1  Some GPU") && text.contains("refused: Vulkan 1.2.0"), "{text}");
    }

    #[test]
    fn a_usable_device_says_what_it_lacks() {
        let text = describe(&report(None, true));
        assert!(text.contains("has: mesh\n") && text.contains("lacks: geometry\n"), "{text}");
        assert!(!text.contains("only --shell off"));
        assert!(describe(&report(None, false)).contains("only --shell off"));
    }
}
