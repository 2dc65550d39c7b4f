//! The files that a run leaves.

use std::{collections::BTreeMap, path::Path};

use exr::prelude::{FlatSamples, read_all_flat_layers_from_file};
use prism_engine::aov::Aov;

/// An OpenEXR file.
#[derive(Clone, Debug)]
pub struct Frame {
    pub width: u32,
    pub height: u32,
    /// Every channel by its name, row 0 on top.
    pub channels: BTreeMap<String, Vec<f32>>,
}

impl Frame {
    /// Reads a file of one layer of 32-bit floats.
    #[track_caller]
    pub fn read(path: &Path) -> Frame {
        let image = read_all_flat_layers_from_file(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        assert_eq!(image.layer_data.len(), 1, "{}: layers", path.display());
        let layer = &image.layer_data[0];
        let channel = |channel: &exr::image::AnyChannel<FlatSamples>| {
            let FlatSamples::F32(samples) = &channel.sample_data else { panic!("{}: not 32-bit float", channel.name) };
            (channel.name.to_string(), samples.clone())
        };
        Frame {
            width: layer.size.0 as u32,
            height: layer.size.1 as u32,
            channels: layer.channel_data.list.iter().map(channel).collect(),
        }
    }

    /// The channels under the contract's names. A NaN anywhere is a failure.
    #[track_caller]
    pub fn aov(&self) -> Aov {
        let pixels = (self.width * self.height) as usize;
        let one = |name: &str| {
            let channel = self.channels.get(name).unwrap_or_else(|| panic!("no channel {name}"));
            assert_eq!(channel.len(), pixels, "{name}");
            assert!(channel.iter().all(|v| !v.is_nan()), "{name} has a NaN");
            channel.clone()
        };
        let three = |names: [&str; 3]| {
            let [a, b, c] = names.map(one);
            (0..pixels).map(|i| [a[i], b[i], c[i]]).collect()
        };
        let (u, v) = (one("uv.U"), one("uv.V"));
        Aov {
            width: self.width,
            height: self.height,
            depth: one("depth.Z"),
            position: three(["position.X", "position.Y", "position.Z"]),
            normal: three(["normal.X", "normal.Y", "normal.Z"]),
            uv: (0..pixels).map(|i| [u[i], v[i]]).collect(),
            height_at_hit: one("height.H"),
            shadow: one("shadow.S"),
            color: three(["R", "G", "B"]),
        }
    }
}

/// A PNG, as 8-bit RGB.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    pub width: u32,
    pub height: u32,
    pub pixels: Vec<[u8; 3]>,
}

impl Picture {
    /// Reads a file.
    #[track_caller]
    pub fn read(path: &Path) -> Picture {
        let image = image::open(path).unwrap_or_else(|error| panic!("{}: {error}", path.display())).to_rgb8();
        let (width, height) = image.dimensions();
        Picture { width, height, pixels: image.pixels().map(|p| p.0).collect() }
    }

    /// Writes a file.
    pub fn write(&self, path: &Path) {
        let bytes = self.pixels.concat();
        image::save_buffer(path, &bytes, self.width, self.height, image::ColorType::Rgb8).expect("the picture");
    }

    /// The largest difference of a channel, pixel by pixel.
    #[track_caller]
    pub fn differences(&self, other: &Picture) -> Vec<u8> {
        assert_eq!((self.width, self.height), (other.width, other.height), "sizes");
        let pixel = |(a, b): (&[u8; 3], &[u8; 3])| (0..3).map(|i| a[i].abs_diff(b[i])).max().unwrap_or(0);
        self.pixels.iter().zip(&other.pixels).map(pixel).collect()
    }

    /// How many colours it has.
    pub fn colours(&self) -> usize {
        self.pixels.iter().collect::<std::collections::HashSet<_>>().len()
    }
}
