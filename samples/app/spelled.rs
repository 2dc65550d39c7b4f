//! What is on screen as words of the command line: the exact `prism` call that shows it again, and the same words kept
//! in a file. There is one grammar and one set of rules, those of [`super::cli`] and [`super::choices`].

use std::path::Path;

use clap::Parser;
use glam::DVec3;
use prism_engine::{
    error::{Error, Result},
    scene::{Camera, Projection},
    settings::Settings,
};
use serde_json::{Value, json};

use super::{
    choices,
    cli::{Cli, Command, CommonArgs},
    files,
    sample::Pose,
    surface::SurfaceArgs,
};

/// What the file is, in messages.
const OBJECT: &str = "view";

/// A setting's flag and its word; none where the flag has no word for it.
type Spelling = (&'static str, fn(&Settings) -> Option<String>);

/// In an order in which each is understood: what others depend on comes first.
const SPELLINGS: &[Spelling] = &[
    ("--shell", |s| Some(s.shell.to_string())),
    ("--march", |s| Some(s.march.to_string())),
    ("--self-shadow", |s| Some(s.self_shadow.to_string())),
    ("--shadow-softness", |s| Some(s.shadow_softness.to_string())),
    ("--shadow-steps", |s| s.shadow_steps.map(|steps| steps.to_string())),
    ("--shadow-map", |s| Some(on_off(s.shadow_map))),
    ("--silhouette", |s| Some(s.silhouette.to_string())),
    ("--stage", |s| Some(s.stage.to_string())),
    ("--min-steps", |s| Some(s.min_steps.to_string())),
    ("--max-steps", |s| Some(s.max_steps.to_string())),
    ("--refine-steps", |s| Some(s.refine_steps.to_string())),
    ("--tolerance", |s| Some(s.tolerance.to_string())),
    ("--dither", |s| Some(on_off(s.dither))),
    ("--slope-limit", |s| Some(s.slope_limit.to_string())),
    ("--normals", |s| Some(s.normals.to_string())),
    ("--depth-offset", |s| Some(on_off(s.depth_offset))),
    ("--lod-fade", |s| s.lod_fade.map(|start| start.to_string())),
    ("--horizon-strength", |s| Some(s.horizon.strength.to_string())),
    ("--horizon-bias", |s| Some(s.horizon.bias.to_string())),
    ("--horizon-threshold", |s| Some(s.horizon.safe_threshold.to_string())),
    ("--horizon-falloff", |s| Some(s.horizon.falloff.to_string())),
    ("--uv-min", |s| s.uv_min.map(|p| list(&p))),
    ("--uv-max", |s| s.uv_max.map(|p| list(&p))),
    ("--tangents", |s| Some(s.tangents.to_string())),
    ("--occlusion-light", |s| Some(s.occlusion_light.to_string())),
    ("--ambient-occlusion", |s| Some(on_off(s.ambient_occlusion))),
    ("--shadow-map-size", |s| Some(s.shadow_map_size.to_string())),
    ("--cascades", |s| Some(s.cascades.to_string())),
    ("--depth-prepass", |s| Some(s.depth_prepass.to_string())),
    ("--visibility-buffer", |s| Some(s.visibility_buffer.to_string())),
    ("--prism-culling", |s| Some(s.prism_culling.to_string())),
    ("--msaa", |s| Some(s.msaa.to_string())),
    ("--view", |s| Some(s.view.to_string())),
];

fn on_off(on: bool) -> String {
    if on { "on".into() } else { "off".into() }
}

fn list<T: ToString>(numbers: &[T]) -> String {
    numbers.iter().map(ToString::to_string).collect::<Vec<_>>().join(",")
}

/// The flags that make `wanted` of a sample's own settings, `base`: no more than are needed, and none that the others
/// would refuse.
pub fn settings(wanted: &Settings, base: &Settings) -> Vec<String> {
    let mut words = Vec::new();
    for (flag, word) in SPELLINGS {
        let Ok(now) = read(&words).and_then(|args| choices::settings(&args.look, &args.classic, base)) else { break };
        let Some(value) = word(wanted).filter(|value| word(&now).as_ref() != Some(value)) else { continue };
        let longer: Vec<String> = words.iter().cloned().chain([(*flag).to_owned(), value]).collect();
        // What is refused changes nothing in what is drawn: another setting leaves it without a meaning.
        if read(&longer).and_then(|args| choices::settings(&args.look, &args.classic, base)).is_ok() {
            words = longer;
        }
    }
    words
}

/// The flags of the displaced materials.
pub fn surface(args: &SurfaceArgs) -> Vec<String> {
    let flags = [
        ("--uv-scale", args.uv_scale.map(|p| list(&p))),
        ("--uv-offset", args.uv_offset.map(|p| list(&p))),
        ("--height-flip", args.height_flip.map(on_off)),
        ("--height-scale", args.height_scale.map(|scale| scale.to_string())),
        ("--relative", args.relative.map(on_off)),
        ("--midlevel", args.midlevel.map(|level| level.to_string())),
        ("--wrap", args.wrap.map(|wrap| wrap.name().to_owned())),
        ("--height-lod", args.height_lod.map(|lod| lod.to_string())),
        ("--height-format", args.height_format.map(|format| format.name().to_owned())),
        ("--roughness-channel", args.roughness_channel.map(|channel| channel.name().to_owned())),
        ("--metallic-channel", args.metallic_channel.map(|channel| channel.name().to_owned())),
        ("--specular", args.specular.map(|share| share.to_string())),
        ("--sun", args.light.sun.map(|degrees| list(&degrees))),
        ("--light-intensity", args.light.light_intensity.map(|factor| factor.to_string())),
    ];
    flags.into_iter().filter_map(|(flag, word)| Some([flag.to_owned(), word?])).flatten().collect()
}

/// A camera as its flags have it.
#[cfg(feature = "window")]
pub fn camera_args(pose: &Pose) -> super::cli::CameraArgs {
    let eye = pose.camera.transform.translation;
    let fov_y = field_of_view(&pose.camera).map(f64::to_degrees);
    super::cli::CameraArgs { eye: Some(eye.to_array()), target: Some(looked_at(pose).to_array()), fov_y }
}

/// The point before the camera that is as far away as its pivot.
fn looked_at(pose: &Pose) -> DVec3 {
    let eye = pose.camera.transform.translation;
    eye + pose.camera.transform.matrix3 * DVec3::NEG_Z * eye.distance(pose.pivot).max(1e-3)
}

/// The flags of a camera that looks at its pivot; none where it is where it started.
pub fn camera(pose: &Pose, start: &Pose) -> Vec<String> {
    let mut words = Vec::new();
    if pose.camera.transform != start.camera.transform {
        let eye = pose.camera.transform.translation;
        let target = looked_at(pose);
        words.extend(["--eye".into(), list(&eye.to_array()), "--target".into(), list(&target.to_array())]);
    }
    if let (Some(now), Some(before)) = (field_of_view(&pose.camera), field_of_view(&start.camera))
        && now != before
    {
        words.extend(["--fov-y".into(), now.to_degrees().to_string()]);
    }
    words
}

fn field_of_view(camera: &Camera) -> Option<f64> {
    match camera.projection {
        Projection::Perspective { fov_y, .. } => Some(fov_y),
        Projection::Orthographic { .. } => None,
    }
}

/// The flags that every command that draws has, read from words.
pub fn read(words: &[String]) -> Result<CommonArgs> {
    let line = ["prism", "render", "-"].into_iter().map(str::to_owned).chain(words.iter().cloned());
    match Cli::try_parse_from(line).map_err(|e| Error::Usage(e.to_string().trim().to_owned()))?.command {
        Command::Render(args) => Ok(args.common),
        _ => Err(Error::Usage("not the words of a view".into())),
    }
}

/// A line that a POSIX shell takes apart into these words.
pub fn line(words: &[String]) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_.,:/=+@%".contains(c);
    let quoted = |word: &String| match word.is_empty() || !word.chars().all(plain) {
        true => format!("'{}'", word.replace('\'', r"'\''")),
        false => word.clone(),
    };
    words.iter().map(quoted).collect::<Vec<_>>().join(" ")
}

/// Keeps words in a small JSON file.
pub fn write(path: &Path, words: &[String]) -> Result<()> {
    let text = format!("{:#}\n", json!({ "prism view": words }));
    files::replace(path, OBJECT, |file| Ok(std::io::Write::write_all(file, text.as_bytes())?))
}

/// The flags that a file keeps.
pub fn load(path: &Path) -> Result<CommonArgs> {
    let wrong = |problem: String| Error::input(path, OBJECT, problem, "save it again from the window's panel");
    let text = std::fs::read_to_string(path).map_err(|e| wrong(format!("cannot be read: {e}")))?;
    let value: Value = serde_json::from_str(&text).map_err(|e| wrong(format!("is no JSON: {e}")))?;
    let words = value["prism view"].as_array().ok_or_else(|| wrong("has no list 'prism view'".into()))?;
    let words: Option<Vec<String>> = words.iter().map(|word| word.as_str().map(str::to_owned)).collect();
    read(&words.ok_or_else(|| wrong("'prism view' holds more than words".into()))?).map_err(|e| wrong(e.to_string()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::{camera as start, light::LightArgs, surface::HeightLod, testing::empty_scene};
    use prism_engine::settings::{
        DepthPrepass, Horizon, March, Normals, SelfShadow, Shell, Silhouette, Stage, View, VisibilityBuffer,
    };

    fn again(words: &[String], base: &Settings) -> Settings {
        let args = read(words).unwrap_or_else(|e| panic!("{words:?}: {e}"));
        choices::settings(&args.look, &args.classic, base).unwrap_or_else(|e| panic!("{words:?}: {e}"))
    }

    #[test]
    fn what_is_on_screen_comes_back_from_its_words() {
        let off = Settings { shell: Shell::Off, march: March::Pom, ..Settings::default() };
        let wanted = [
            Settings::default(),
            off.clone(),
            Settings {
                shell: Shell::Prism,
                stage: Stage::Geometry,
                march: March::Relief,
                max_steps: 12,
                ..Settings::default()
            },
            Settings {
                march: March::Secant,
                refine_steps: 3,
                tolerance: 0.25,
                dither: true,
                msaa: 4,
                ..Settings::default()
            },
            Settings {
                silhouette: Silhouette::Horizon,
                horizon: Horizon { strength: 2.0, bias: 0.125, safe_threshold: 0.25, falloff: 3.0 },
                depth_offset: false,
                normals: Normals::Sobel,
                self_shadow: SelfShadow::Hard,
                ..off.clone()
            },
            Settings {
                self_shadow: SelfShadow::Soft,
                shadow_softness: 0.125,
                shadow_steps: Some(8),
                silhouette: Silhouette::UvBounds,
                uv_min: Some([-0.5, 0.0]),
                uv_max: Some([2.0, 1.5]),
                ..off.clone()
            },
            Settings { lod_fade: Some(-0.5), slope_limit: 4.0, min_steps: 100, max_steps: 200, ..off.clone() },
            Settings {
                shadow_map: true,
                shadow_map_size: 512,
                cascades: 2,
                ambient_occlusion: true,
                depth_prepass: DepthPrepass::On,
                view: View::Walk,
                ..Settings::default()
            },
            Settings { visibility_buffer: VisibilityBuffer::Off, ..Settings::default() },
        ];
        let bases = [Settings::default(), off, Settings { shadow_map: true, ..Settings::default() }];
        for base in &bases {
            for wanted in &wanted {
                let words = settings(wanted, base);
                assert_eq!(again(&words, base), *wanted, "{words:?}");
            }
            assert!(settings(base, base).is_empty());
        }
    }

    #[test]
    fn a_setting_without_a_meaning_needs_no_words() {
        // Left over from a march that takes steps.
        let exact = Settings { max_steps: 12, tolerance: 0.5, ..Settings::default() };
        assert!(settings(&exact, &Settings::default()).is_empty());
    }

    #[test]
    fn materials_and_cameras_come_back_too_through_a_file() {
        let materials = SurfaceArgs {
            uv_scale: Some([2.0, 3.0]),
            uv_offset: Some([-0.25, 0.5]),
            height_flip: Some(true),
            height_scale: Some(0.1),
            relative: Some(false),
            midlevel: Some(-1.0),
            height_lod: Some(HeightLod::Mip(2)),
            light: LightArgs { sun: Some([-30.5, 20.0]), light_intensity: Some(0.5) },
            ..SurfaceArgs::default()
        };
        let eye = Some(DVec3::new(1.5, 0.1, 4.0));
        let first = start::start(&CommonArgs::default().camera, &empty_scene(), &base()).unwrap();
        let camera_now = base().overridden(eye, Some(DVec3::new(0.3, -0.2, 0.0)), Some(30.0)).unwrap();
        let pose = Pose { camera: camera_now, pivot: DVec3::new(0.3, -0.2, 0.0) };
        let words: Vec<String> = surface(&materials).into_iter().chain(camera(&pose, &first)).collect();

        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("view.json");
        write(&path, &words).unwrap();
        let args = load(&path).unwrap();
        assert_eq!(format!("{:?}", args.surface), format!("{materials:?}"));
        let back = start::start(&args.camera, &empty_scene(), &base()).unwrap();
        assert!(back.camera.transform.abs_diff_eq(camera_now.transform, 1e-9), "{back:?}");
        assert!(camera(&first, &first).is_empty());

        std::fs::write(&path, "{ \"prism view\": [\"--march\", \"sideways\"] }").unwrap();
        let told = load(&path).unwrap_err().to_string();
        assert!(told.contains("view.json") && told.contains("sideways"), "{told}");
    }

    fn base() -> Camera {
        Camera {
            transform: glam::DAffine3::from_translation(DVec3::new(0.0, 0.0, 5.0)),
            projection: Projection::Perspective { fov_y: 1.0, near: 0.1, far: None },
        }
    }

    #[test]
    fn words_are_quoted_for_a_shell() {
        let words = ["--scene", "my models/it's.gltf", ""].map(str::to_owned);
        assert_eq!(line(&words), r"--scene 'my models/it'\''s.gltf' ''");
    }
}
