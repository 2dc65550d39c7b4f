//! `prism probe`: what one pixel's ray does in the shell, drawn and in figures.

mod chart;
mod figure;
mod map;
mod profile;
mod record;
#[cfg(feature = "window")]
pub mod sketch;

use std::{io::Write, path::Path};

use prism_engine::{
    error::{Error, Result},
    render::plan,
    scene::{Camera, Scene},
    settings::{March, Settings},
    shell::{
        follow::{Followed, Marches},
        reference::{Hit, Reference, Way},
    },
};

use super::{
    choices,
    classic::ClassicArgs,
    cli::{LookArgs, ProbeArgs, StepArgs},
    console, files,
    load::{self, Loaded},
};

/// What the output is, in messages.
const OBJECT: &str = "drawing";

/// One pixel of a picture.
#[derive(Clone, Copy, Debug)]
pub struct Pixel {
    /// Column and row, row 0 on top.
    pub at: [u32; 2],
    /// Of the picture.
    pub size: [u32; 2],
}

/// What was found along a pixel's ray.
pub struct Probe<'a> {
    /// What the scene is called.
    pub name: &'a str,
    /// Which pixel.
    pub pixel: Pixel,
    /// Seen from here.
    pub camera: &'a Camera,
    /// The ray.
    pub way: &'a Way<'a>,
    /// Where it hits the surface.
    pub hit: Hit,
    /// The marches that were asked for.
    pub followed: Vec<Followed>,
}

/// Probes and writes what `args` ask for.
pub fn run(args: &ProbeArgs) -> Result<()> {
    let extension = args.out.extension().map(|e| e.to_string_lossy().to_lowercase());
    if extension.as_deref() != Some("svg") {
        return Err(Error::Usage(format!("--out {}: only .svg is drawn; name it so", args.out.display())));
    }
    files::check_target(&args.out, OBJECT)?;
    if args.surface.light.given() {
        return Err(Error::Usage("--sun, --light-intensity: no light is in the drawing; drop them".into()));
    }
    let size = [args.size.width, args.size.height];
    let pixel = Pixel { at: args.pixel, size };
    pixel.check()?;
    let Loaded { name, scene, start } = load::still(&args.scene, size, &args.surface, &args.camera)?;
    let settings = marches(args, &scene)?;
    let reference = Reference::new(&scene);
    let way = reference.way(&start.camera, size, pixel.at);
    let probe = probe(&name, &scene, &start.camera, pixel, &way, &settings)?;
    write(&args.out, &probe)?;
    if args.json {
        console::data(&record::json(&probe))?;
    }
    Ok(())
}

/// Writes the drawing.
fn write(path: &Path, probe: &Probe<'_>) -> Result<()> {
    write_drawing(path, &figure::draw(probe).to_string())
}

/// Writes a drawing that is made.
pub fn write_drawing(path: &Path, drawing: &str) -> Result<()> {
    files::replace(path, OBJECT, |file| Ok(file.write_all(drawing.as_bytes())?))?;
    console::notice(format_args!("wrote {}", path.display()));
    Ok(())
}

/// Follows each march of `settings` along the pixel's `way`.
///
/// # Errors
/// `Usage` where the pixel shows nothing, or nothing displaced.
pub fn probe<'a>(
    name: &'a str,
    scene: &Scene,
    camera: &'a Camera,
    pixel: Pixel,
    way: &'a Way<'a>,
    settings: &[Settings],
) -> Result<Probe<'a>> {
    let [x, y] = pixel.at;
    let Some(hit) = way.hit else {
        return Err(Error::Usage(format!(
            "--pixel {x},{y}: its ray hits nothing; choose one where `prism render` with the same flags shows a surface"
        )));
    };
    // Prisms beyond the hit are none of the pixel's.
    if way.stretches.iter().all(|stretch| stretch.at(0.0).distance > hit.distance) {
        let mesh = &scene.meshes[scene.instances[hit.instance].mesh];
        let material = &scene.materials[mesh.primitives[hit.primitive].material].name;
        return Err(Error::Usage(format!(
            "--pixel {x},{y}: its ray hits a plain surface (material '{material}') and no prism before it, so there is \
             nothing to march through; choose one on a displaced surface"
        )));
    }
    let mut marches = Marches::new(scene);
    let followed = settings.iter().map(|settings| marches.follow(way, settings)).collect();
    Ok(Probe { name, pixel, camera, way, hit, followed })
}

impl Pixel {
    /// Refuses one outside the picture.
    fn check(self) -> Result<()> {
        let ([x, y], [width, height]) = (self.at, self.size);
        if x < width && y < height {
            return Ok(());
        }
        Err(Error::Usage(format!(
            "--pixel {x},{y}: the picture of {width}x{height} ends at {},{}; choose one in it, or another --size",
            width - 1,
            height - 1
        )))
    }
}

/// What the window's click shows: every march that the scene allows and the steps of `settings`.
///
/// # Errors
/// As [`probe`].
#[cfg(feature = "window")]
pub fn sketch(name: &str, scene: &Scene, camera: &Camera, pixel: Pixel, settings: &Settings) -> Result<sketch::Sketch> {
    let reference = Reference::new(scene);
    let way = reference.way(camera, pixel.size, pixel.at);
    let marches = March::ALL.iter().copied().filter(|march| march.steps() || march.reads_cones());
    let of = |march: March| Settings {
        march,
        shell: prism_engine::settings::Shell::Auto,
        refine_steps: march.usual_refine_steps(),
        ..settings.clone()
    };
    let all: Vec<Settings> = marches.filter(|march| plan::allows(scene, *march)).map(of).collect();
    Ok(sketch::Sketch::new(&probe(name, scene, camera, pixel, &way, &all)?))
}

/// The settings of each march that is drawn, as the command line would have them in a shell.
fn marches(args: &ProbeArgs, scene: &Scene) -> Result<Vec<Settings>> {
    let chosen: Vec<March> = match &args.march[..] {
        [] => March::ALL.iter().copied().filter(|march| march.traces() && plan::allows(scene, *march)).collect(),
        some => some.to_vec(),
    };
    let takes = |flag: &str, given: bool, takes: fn(March) -> bool| match given && !chosen.iter().any(|m| takes(*m)) {
        true => Err(Error::Usage(format!("{flag}: no march of --march takes it; add one that does, or drop it"))),
        false => Ok(()),
    };
    let StepArgs { min_steps, max_steps, refine_steps, tolerance } = args.steps;
    takes("--min-steps", min_steps.is_some(), March::steps)?;
    takes("--max-steps", max_steps.is_some(), |march| march != March::Exact)?;
    takes("--refine-steps", refine_steps.is_some(), March::refines)?;
    takes("--tolerance", tolerance.is_some(), |march| march == March::Secant)?;
    let mut all = Vec::new();
    for march in chosen {
        if !plan::allows(scene, march) {
            return Err(Error::Usage(format!(
                "--march {march}: cones are of height maps, and this scene's is a function"
            )));
        }
        let steps = StepArgs {
            min_steps: min_steps.filter(|_| march.steps()),
            max_steps: max_steps.filter(|_| march != March::Exact),
            refine_steps: refine_steps.filter(|_| march.refines()),
            tolerance: tolerance.filter(|_| march == March::Secant),
        };
        let look = LookArgs { march: Some(march), steps, ..LookArgs::default() };
        let settings = choices::settings(&look, &ClassicArgs::default(), &Settings::default())?;
        // What is exact is the reference's own hit, and always drawn.
        if march != March::Exact {
            all.push(settings);
        }
    }
    Ok(all)
}

impl Probe<'_> {
    /// How far a march ended behind the true hit, in pixel footprints; before it where negative, none where it missed.
    pub fn error(&self, followed: &Followed) -> Option<f64> {
        let height = self.pixel.size[1];
        let footprint = prism_engine::measure::footprint(self.camera, height, self.hit.distance);
        Some((followed.distance? - self.hit.distance) / footprint)
    }
}
