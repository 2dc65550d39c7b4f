//! `prism bake`: a height map in, a cone map or a min-max pyramid out.

use std::{path::Path, time::Instant};

use exr::{
    compression::Compression,
    image::{AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer, write::WritableImage},
    math::Vec2,
    meta::{
        attribute::{IntegerBounds, Text},
        header::{ImageAttributes, LayerAttributes},
    },
};
use image::{ImageBuffer, Rgb, codecs::png::PngEncoder};
use indicatif::{ProgressBar, ProgressStyle};
use prism_engine::{
    error::{Error, Result},
    gpu::{Context, ContextDesc},
    render::{self, bake},
    scene::HeightMap,
    shell::cones::ConeKind,
};

use super::{
    cli::{BakeArgs, BakeKind},
    console, files,
};

/// Steps of the bar.
const STEPS: f64 = 1000.0;

/// What the output is, in messages.
const OBJECT: &str = "baked map";

/// Bakes what `args` ask for.
pub fn run(args: &BakeArgs) -> Result<()> {
    let png = is_png(args)?;
    files::check_target(&args.out, OBJECT)?;
    let map = HeightMap::read(&args.input)?;
    let desc = ContextDesc {
        app: "prism bake",
        validation: args.device.validation,
        selector: args.device.gpu.as_deref(),
        ..ContextDesc::default()
    };
    let ctx = Context::new(&desc)?;
    let compiler = render::shader_compiler(args.device.shader_dir.as_deref())?;
    let wrap = [args.wrap; 2];
    let begin = Instant::now();
    let cone = |kind| {
        // Drawn on stderr where that is a terminal.
        let style = ProgressStyle::with_template("{bar:40} {percent} %, {eta} left");
        let bar = ProgressBar::new(STEPS as u64).with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
        let told = |done| bar.set_position((done * STEPS) as u64);
        let roots = bake::cone_map(&ctx, &compiler, &args.input, &map, wrap, kind, told);
        bar.finish_and_clear();
        roots
    };
    match args.kind {
        BakeKind::MinMax => write_levels(&args.out, &bake::min_max(&ctx, &compiler, &args.input, &map, wrap)?)?,
        BakeKind::Cone if png => write_png(&args.out, &map, &cone(ConeKind::Plain)?)?,
        BakeKind::Cone => write_exr(&args.out, &map, &cone(ConeKind::Plain)?)?,
        BakeKind::RelaxedCone if png => write_png(&args.out, &map, &cone(ConeKind::Relaxed)?)?,
        BakeKind::RelaxedCone => write_exr(&args.out, &map, &cone(ConeKind::Relaxed)?)?,
    }
    ctx.check_validation()?;
    console::notice(format_args!(
        "wrote {}: {} of {} x {} texels in {:.1} s",
        args.out.display(),
        args.kind.name(),
        map.width,
        map.height,
        begin.elapsed().as_secs_f64()
    ));
    Ok(())
}

/// Whether the output is a PNG; else it is an OpenEXR.
fn is_png(args: &BakeArgs) -> Result<bool> {
    let extension = args.out.extension().map(|e| e.to_string_lossy().to_lowercase());
    match (extension.as_deref(), args.kind) {
        (Some("png"), BakeKind::Cone | BakeKind::RelaxedCone) => Ok(true),
        (Some("exr"), _) => Ok(false),
        (_, BakeKind::MinMax) => {
            Err(Error::Usage(format!("{}: a min-max pyramid is written as .exr", args.out.display())))
        }
        _ => Err(Error::Usage(format!("{}: a cone map is written as .png or .exr", args.out.display()))),
    }
}

/// The heights in file order.
fn heights(map: &HeightMap) -> impl Iterator<Item = f64> {
    (0..map.height).flat_map(move |y| (0..map.width).map(move |x| map.height(x, y)))
}

fn write_png(path: &Path, map: &HeightMap, roots: &[u16]) -> Result<()> {
    let height = |h: f64| (h * 65535.0).round() as u16;
    let texels: Vec<u16> = heights(map).zip(roots).flat_map(|(h, root)| [height(h), *root, 0]).collect();
    files::replace(path, OBJECT, |file| {
        let image =
            ImageBuffer::<Rgb<u16>, _>::from_raw(map.width, map.height, texels).ok_or("fewer texels than size")?;
        Ok(image.write_with_encoder(PngEncoder::new(file))?)
    })
}

/// ZIP is lossless for floats and every reader has it.
fn encoding() -> Encoding {
    Encoding { compression: Compression::ZIP16, ..Encoding::default() }
}

fn channels(channels: [(&str, Vec<f32>); 2]) -> AnyChannels<FlatSamples> {
    let channels = channels.map(|(name, samples)| AnyChannel::new(Text::from(name), FlatSamples::F32(samples)));
    AnyChannels::sort(channels.into_iter().collect())
}

fn write_exr(path: &Path, map: &HeightMap, roots: &[u16]) -> Result<()> {
    // f32 rounds by less than the 16 bits have rounded down, or not at all.
    let ratios = roots.iter().map(|root| (f64::from(*root) / 65535.0).powi(2) as f32).collect();
    let channels = channels([("height.H", heights(map).map(|h| h as f32).collect()), ("cone.R", ratios)]);
    let size = (map.width as usize, map.height as usize);
    let image = Image::from_layer(Layer::new(size, LayerAttributes::default(), encoding(), channels));
    files::replace(path, OBJECT, |file| Ok(image.write().to_buffered(file)?))
}

fn write_levels(path: &Path, levels: &[bake::Level]) -> Result<()> {
    let part = |(number, level): (usize, &bake::Level)| {
        let side = |side: usize| level.bounds.iter().map(|bounds| f32::from(bounds[side]) / 65535.0).collect();
        let size = (level.size[0] as usize, level.size[1] as usize);
        let name = LayerAttributes::named(format!("level {number}").as_str());
        Layer::new(size, name, encoding(), channels([("min", side(0)), ("max", side(1))]))
    };
    let whole = IntegerBounds::from_dimensions(Vec2(levels[0].size[0] as usize, levels[0].size[1] as usize));
    let parts: exr::image::Layers<_> = levels.iter().enumerate().map(part).collect();
    let image = Image::from_layers(ImageAttributes::new(whole), parts);
    files::replace(path, OBJECT, |file| Ok(image.write().to_buffered(file)?))
}
