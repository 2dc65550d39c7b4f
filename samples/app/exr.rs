//! The surface data of a frame: a 32-bit float OpenEXR, as DESIGN section 3 names its channels.

use std::path::Path;

use exr::{
    compression::Compression,
    image::{AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer, write::WritableImage},
    meta::{attribute::Text, header::LayerAttributes},
};
use prism_engine::{aov::Aov, error::Result};

use super::files;

/// Writes every channel of `aov`, lossless, row 0 on top, in one part.
pub fn write(path: &Path, aov: &Aov) -> Result<()> {
    let mut list: Vec<AnyChannel<FlatSamples>> = Vec::new();
    let mut add = |name: &str, samples: Vec<f32>| {
        list.push(AnyChannel::new(Text::from(name), FlatSamples::F32(samples)));
    };
    add("depth.Z", aov.depth.clone());
    add("height.H", aov.height_at_hit.clone());
    add("shadow.S", aov.shadow.clone());
    for (name, axis) in [("R", 0), ("G", 1), ("B", 2)] {
        add(name, aov.color.iter().map(|color| color[axis]).collect());
    }
    for (name, axis) in [("X", 0), ("Y", 1), ("Z", 2)] {
        add(&format!("position.{name}"), aov.position.iter().map(|point| point[axis]).collect());
        add(&format!("normal.{name}"), aov.normal.iter().map(|normal| normal[axis]).collect());
    }
    for (name, axis) in [("U", 0), ("V", 1)] {
        add(&format!("uv.{name}"), aov.uv.iter().map(|uv| uv[axis]).collect());
    }

    // ZIP is lossless for floats and every reader has it.
    let encoding = Encoding { compression: Compression::ZIP16, ..Encoding::default() };
    let size = (aov.width as usize, aov.height as usize);
    // The format wants the names in alphabetical order.
    let channels = AnyChannels::sort(list.into());
    let image = Image::from_layer(Layer::new(size, LayerAttributes::default(), encoding, channels));
    files::replace(path, "surface data", |file| Ok(image.write().to_buffered(file)?))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;

    fn read(path: &Path) -> (usize, usize, BTreeMap<String, Vec<f32>>) {
        use exr::prelude::*;
        let image = read_all_flat_layers_from_file(path).unwrap();
        assert_eq!(image.layer_data.len(), 1, "one part");
        let layer = &image.layer_data[0];
        let channels = layer.channel_data.list.iter().map(|channel| {
            let FlatSamples::F32(samples) = &channel.sample_data else { panic!("{}: not f32", channel.name) };
            (channel.name.to_string(), samples.clone())
        });
        (layer.size.0, layer.size.1, channels.collect())
    }

    #[test]
    fn reads_back_to_the_bit() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("frame.exr");
        // Taller than one compressed block of 16 rows, so that the rows' order shows.
        let mut aov = Aov::missed(3, 40);
        for row in 0..40 {
            let i = row * 3 + 1;
            let value = row as f32 + 0.1;
            aov.depth[i] = value;
            aov.position[i] = [value, -value, 1e-30];
            aov.normal[i] = [0.0, 0.6, 0.8];
            aov.uv[i] = [value * 7.0, -value];
            aov.height_at_hit[i] = 1.0 / 3.0;
            aov.shadow[i] = 0.0;
            aov.color[i] = [value, 1e6, 0.5];
        }
        write(&path, &aov).unwrap();

        let (width, height, channels) = read(&path);
        assert_eq!((width, height), (3, 40));
        let names: Vec<&str> = channels.keys().map(String::as_str).collect();
        let mut expected = [
            "R",
            "G",
            "B",
            "depth.Z",
            "position.X",
            "position.Y",
            "position.Z",
            "normal.X",
            "normal.Y",
            "normal.Z",
            "uv.U",
            "uv.V",
            "height.H",
            "shadow.S",
        ];
        expected.sort();
        assert_eq!(names, expected);

        let axis = |data: &[[f32; 3]], axis: usize| data.iter().map(|v| v[axis]).collect::<Vec<_>>();
        assert_eq!(channels["depth.Z"], aov.depth);
        assert_eq!(channels["depth.Z"][0], f32::INFINITY);
        assert_eq!(channels["height.H"], aov.height_at_hit);
        assert_eq!(channels["shadow.S"], aov.shadow);
        for (i, [position, normal, color]) in
            [["position.X", "normal.X", "R"], ["position.Y", "normal.Y", "G"], ["position.Z", "normal.Z", "B"]]
                .into_iter()
                .enumerate()
        {
            assert_eq!(channels[position], axis(&aov.position, i));
            assert_eq!(channels[normal], axis(&aov.normal, i));
            assert_eq!(channels[color], axis(&aov.color, i));
        }
        assert_eq!(channels["uv.U"], aov.uv.iter().map(|uv| uv[0]).collect::<Vec<_>>());
        assert_eq!(channels["uv.V"], aov.uv.iter().map(|uv| uv[1]).collect::<Vec<_>>());
    }
}
