//! Measures a part: every variant's errors once, then the times of all of them in turns.

use std::{
    collections::HashMap,
    time::{Duration, Instant},
};

use prism_engine::{
    aov::Aov,
    error::Result,
    gpu::Feature,
    measure::{
        Metrics,
        flicker::{Flicker, Moment},
    },
    render,
    scene::Scene,
    settings::{SelfShadow, Settings, Shell},
    shell::reference::{Reference, Shadows},
};

use super::{
    contest, flip,
    parts::{self, Part, Stand},
    scenes,
    table::short,
    variants::Variant,
};
use crate::{
    app::{clay, heat, picture::Picture},
    bench::contest::Judge,
    timing::{Device, Drawn, Rounds, Timing, View, grown, mib},
};

/// A variant under one condition, measured.
#[derive(Clone, Debug)]
pub struct Point {
    /// [`Part::id`].
    pub part: &'static str,
    /// [`Stand::scene`].
    pub scene: String,
    /// [`Stand::condition`].
    pub condition: String,
    /// [`Stand::x`].
    pub x: Option<f64>,
    /// Of the picture, in pixels.
    pub size: [u32; 2],
    /// The way to draw.
    pub variant: Variant,
    /// Against the reference.
    pub metrics: Metrics,
    /// Mean FLIP of the picture against the one that stands for the truth, where that is drawn.
    pub flip: Option<f64>,
    /// Reads of height maps by fragments, and of bounds and cones over them, for each pixel that the reference covers;
    /// none of baselines, which read them elsewhere.
    pub reads: Option<f64>,
    /// [`Flicker::depth_p99`], where the camera moves.
    pub flicker: Option<f64>,
    /// Its times.
    pub timing: Timing,
    /// MiB of what it keeps on the device beside the colour textures.
    pub memory: f64,
}

impl Point {
    /// Depth error and median time: its place in the plot.
    pub fn place(&self) -> [f64; 2] {
        [self.timing.spread().map_or(f64::NAN, |spread| spread.median), self.metrics.depth_p99]
    }
}

/// Pictures of one way to draw, or of the truth.
#[derive(Clone)]
pub struct Shown {
    /// What it is.
    pub name: String,
    /// One line of figures.
    pub figures: String,
    /// The frame, and maps of its errors; each with a word.
    pub pictures: Vec<(&'static str, Picture)>,
}

/// All of a part.
pub struct Measured {
    /// A point a variant and stand, in their order.
    pub points: Vec<Point>,
    /// Pictures to show.
    pub shown: Vec<Shown>,
    /// Techniques that the device lacks the stages for.
    pub left_out: Vec<String>,
    /// What it took.
    pub took: Duration,
}

/// A stand's scene as it should be drawn.
struct Truth {
    scene: Scene,
    view: View,
    surface: Aov,
    /// By shadow and number of samples.
    pictures: HashMap<(SelfShadow, u32), Picture>,
}

impl Truth {
    fn new(stand: &Stand, turned: Option<f64>) -> Result<Truth> {
        let [width, height] = stand.size;
        let aspect = f64::from(width) / f64::from(height);
        let file = scenes::load(&stand.scene, aspect)?;
        let place = turned.map_or(stand.place, scenes::Place::Turned);
        let camera = place.camera(&file, aspect)?;
        let scene = stand.change.make(&file)?;
        let shadows = if stand.shadows { Shadows::TraceOwn } else { Shadows::Skip };
        let surface = Reference::new(&scene).render(&camera, width, height, shadows);
        Ok(Truth { scene, view: View { camera, size: stand.size }, surface, pictures: HashMap::new() })
    }

    /// The picture that stands for the truth: of the walk with the exact march, whose own error stands in the table. Of
    /// several samples a pixel, 4×4 of them.
    fn picture(&mut self, device: &mut Device, settings: &Settings) -> Result<&Picture> {
        let key = (settings.self_shadow, settings.msaa);
        if !self.pictures.contains_key(&key) {
            // As a measured variant is drawn: lavapipe takes long to compile another one.
            let self_shadow = settings.self_shadow;
            let exact = counting(device, &Settings { shell: Shell::Walk, self_shadow, ..Settings::default() });
            let picture = if settings.msaa > 1 {
                let fine = View { size: self.view.size.map(|side| side * FINE), ..self.view };
                averaged(&device.shot(&self.scene, &exact, &fine)?.picture)
            } else {
                device.shot(&self.scene, &exact, &self.view)?.picture
            };
            self.pictures.insert(key, picture);
        }
        Ok(&self.pictures[&key])
    }
}

/// Samples a side of a pixel, for the truth of several samples.
const FINE: u32 = 4;

/// The means of blocks of pixels, of light rather than of its sRGB code.
fn averaged(fine: &Picture) -> Picture {
    let [width, height] = fine.size.map(|side| side / FINE);
    let light = |code: u8| (f64::from(code) / 255.0).powf(2.2);
    Picture::of([width, height], |i| {
        let (x, y) = (i as u32 % width * FINE, i as u32 / width * FINE);
        std::array::from_fn(|k| {
            let row = |dy: u32| {
                let at = |dx: u32| ((y + dy) * fine.size[0] + x + dx) as usize;
                (0..FINE).map(|dx| light(fine.pixels[at(dx)][k])).sum::<f64>()
            };
            let mean = (0..FINE).map(row).sum::<f64>() / f64::from(FINE * FINE);
            (255.0 * mean.powf(1.0 / 2.2)).round() as u8
        })
    })
}

/// How often a part is timed.
#[derive(Clone, Copy, Debug)]
pub struct Pace {
    /// Rounds at most.
    pub rounds: u32,
    /// No round begins later, but for the first.
    pub end: Instant,
    /// Frames as they are measured are timed, for a quick look: half as many shaders are compiled.
    pub as_measured: bool,
}

impl Pace {
    /// Turns at this pace.
    pub fn turns(&self) -> Rounds {
        if self.as_measured { Rounds::writing_surface() } else { Rounds::default() }
    }

    /// What a variant is timed with.
    pub fn timed(&self, device: &Device, settings: &Settings) -> Settings {
        if self.as_measured { counting(device, settings) } else { settings.clone() }
    }
}

/// The settings that a variant is measured with: what fragments read is counted, where they can.
fn counting(device: &Device, settings: &Settings) -> Settings {
    Settings { count_reads: device.ctx.has(Feature::FragmentStoresAndAtomics), ..settings.clone() }
}

/// Measures a part. `tick` is called after every frame.
pub fn part(part: &Part, device: &mut Device, pace: Pace, tick: &dyn Fn()) -> Result<Measured> {
    let began = Instant::now();
    let mut measured = Measured { points: Vec::new(), shown: Vec::new(), left_out: Vec::new(), took: Duration::ZERO };
    let mut turns = pace.turns();
    for stand in &part.stands {
        let mut truth = Truth::new(stand, None)?;
        let mut before = stand.moves.map(|degrees| Truth::new(stand, Some(-degrees))).transpose()?;
        if stand.variants.iter().any(|variant| variant.shown) {
            measured.shown.push(reference(stand, &truth));
        }
        let (able, unable) = variants_of(stand, &truth, device)?;
        measured.left_out.extend(unable);
        for variant in able {
            let ours = variant.settings.baseline.is_none();
            let (name, colours) = (format!("{}, {}", stand.condition, variant.name()), colours(&truth.scene));
            let before_it = device.memory();
            let mut renderer = device.measuring(&truth.scene, &counting(device, &variant.settings))?;
            let measures = device.memory();
            let drawn = device.shot_by(&mut renderer, &truth.view)?;
            let metrics = Metrics::between(&drawn.surface, &truth.surface, &truth.view.camera);
            let settings = compared(part, &variant.settings);
            // A walk that casts shadows takes lavapipe half a minute to compile: too long for a look.
            let judges_picture = !pace.as_measured || settings.self_shadow == SelfShadow::Off;
            let seen = if judges_picture {
                Some(flip::between(&drawn.picture, truth.picture(device, &settings)?))
            } else {
                None
            };
            let flicker = match &mut before {
                Some(before) => Some(flicker(device, &variant, [&*before, &truth], &drawn)?),
                None => None,
            };
            let reads = drawn.height_reads.filter(|_| ours && variant.settings.msaa == 1);
            let reads = reads.map(|n| f64::from(n) / metrics.covered.max(1) as f64);
            tick();
            if variant.shown {
                measured.shown.push(shown(&variant, &truth, &drawn, &metrics, seen.as_ref()));
            }
            let memory = if pace.as_measured {
                let place = turns.enter(&name, renderer, &truth.view);
                held(&before_it, &measures, turns.host_bytes(place), &colours)
            } else {
                drop(renderer);
                let before_it = device.memory();
                let place = turns.add(device, &name, &truth.scene, &variant.settings, &truth.view)?;
                held(&before_it, &device.memory(), turns.host_bytes(place), &colours)
            };
            measured.points.push(Point {
                part: part.id,
                scene: stand.scene.clone(),
                condition: stand.condition.clone(),
                x: stand.x,
                size: stand.size,
                variant,
                metrics,
                flip: seen.map(|seen| seen.mean),
                reads,
                flicker,
                timing: Timing::default(),
                memory,
            });
        }
    }
    turns.run_until(device, pace.rounds, Some(pace.end), |_| tick())?;
    for (place, point) in measured.points.iter_mut().enumerate() {
        point.timing = turns.timing(place).clone();
    }
    measured.took = began.elapsed();
    Ok(measured)
}

/// The settings whose exact picture a variant's is compared with. Where the number of samples varies, the smooth one is
/// right for all.
fn compared(part: &Part, settings: &Settings) -> Settings {
    if part.id == "samples" { Settings { msaa: 4, ..settings.clone() } } else { settings.clone() }
}

/// A stand's variants that the device can draw, with the matched baselines if there are any, and the techniques of the
/// others.
fn variants_of(stand: &Stand, truth: &Truth, device: &mut Device) -> Result<(Vec<Variant>, Vec<String>)> {
    let can_draw = |variant: &Variant| {
        let features = render::features(&truth.scene, &variant.settings, false);
        features.required.iter().all(|feature| device.ctx.has(*feature))
    };
    let (mut able, unable): (Vec<_>, Vec<_>) = stand.variants.iter().cloned().partition(can_draw);
    if !stand.matched.is_empty() {
        let mut judge = Judge::knowing(&truth.scene, truth.view, truth.surface.clone());
        for rival in &stand.matched {
            able.extend(contest::coarsest(*rival, &mut judge, device, parts::MATCHED)?.map(Variant::matched));
        }
    }
    Ok((able, unable.into_iter().map(|variant| variant.technique).collect()))
}

fn flicker(device: &mut Device, variant: &Variant, [first, second]: [&Truth; 2], drawn: &Drawn) -> Result<f64> {
    let earlier = device.surface(&first.scene, &variant.settings, &first.view)?;
    Ok(Flicker::between(
        &Moment { test: &earlier, reference: &first.surface, camera: &first.view.camera },
        &Moment { test: &drawn.surface, reference: &second.surface, camera: &second.view.camera },
    )
    .depth_p99)
}

/// Names of the colour textures, which every way to draw has.
pub fn colours(scene: &Scene) -> Vec<String> {
    scene.images.iter().map(|image| image.name.clone()).collect()
}

/// MiB that came to be between two reports, and on the CPU.
pub fn held(before: &HashMap<String, u64>, after: &HashMap<String, u64>, host: u64, colours: &[String]) -> f64 {
    let counted = grown(before, after).filter(|(name, _)| !colours.iter().any(|colour| colour == name));
    mib(counted.map(|(_, bytes)| bytes).sum::<u64>() + host)
}

/// The reference in clay.
fn reference(stand: &Stand, truth: &Truth) -> Shown {
    let [width, height] = stand.size;
    Shown {
        name: "reference (f64)".into(),
        figures: format!("{}, {width}×{height} pixels", stand.condition),
        pictures: vec![("surface", clay::of(&truth.surface, &truth.view.camera))],
    }
}

fn shown(variant: &Variant, truth: &Truth, drawn: &Drawn, m: &Metrics, seen: Option<&flip::Difference>) -> Shown {
    let (depth, outline) = (short(m.depth_p99), short(100.0 * m.coverage_differs));
    let mut figures = format!("depth p99 {depth} footprints, outline {outline} %");
    let mut pictures = vec![
        ("frame", drawn.picture.clone()),
        ("depth error", heat::map(&drawn.surface, &truth.surface, &truth.view.camera)),
    ];
    if let Some(seen) = seen {
        figures += &format!(", FLIP {}", short(seen.mean));
        pictures.push(("FLIP", seen.map.clone()));
    }
    Shown { name: variant.name(), figures, pictures }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn light_is_averaged_not_its_code() {
        let half = Picture::of([4, 4], |i| if i < 8 { [255; 3] } else { [0; 3] });
        let mean = averaged(&half);
        assert_eq!(mean.size, [1, 1]);
        assert!((i32::from(mean.pixels[0][0]) - 186).abs() <= 1, "{:?}", mean.pixels[0]);
    }

    #[test]
    fn memory_is_what_came_and_is_no_colour() {
        let mib = |pairs: &[(&str, u64)]| pairs.iter().map(|(name, n)| ((*name).to_owned(), n << 20)).collect();
        let before: HashMap<String, u64> = mib(&[("prisms", 1), ("albedo", 1)]);
        let after = mib(&[("prisms", 3), ("albedo", 5), ("heights", 4)]);
        assert_eq!(held(&before, &after, 1 << 20, &["albedo".to_owned()]), 7.0);
    }
}
