//! What is measured, as data: each part varies one thing.

use prism_engine::settings::{Dicer, March, Shell};

use super::{
    scenes::{Change, NAMED, Place},
    variants::{self, Rival, Variant},
};

/// A part of the report: all its points take turns.
#[derive(Clone, Debug)]
pub struct Part {
    /// A word for the command line and the CSV.
    pub id: &'static str,
    /// Above its figures.
    pub title: String,
    /// What it shows.
    pub text: &'static str,
    /// What its stands vary, if that is a number; a unit in brackets.
    pub varies: Option<&'static str>,
    /// What is drawn.
    pub stands: Vec<Stand>,
}

/// A scene under one condition, and how it is drawn.
#[derive(Clone, Debug)]
pub struct Stand {
    /// A word of [`NAMED`], or a file.
    pub scene: String,
    /// What it has otherwise.
    pub change: Change,
    /// From where.
    pub place: Place,
    /// Of the picture, in pixels.
    pub size: [u32; 2],
    /// What sets it apart in its part, for people.
    pub condition: String,
    /// The same as a number.
    pub x: Option<f64>,
    /// The ways to draw.
    pub variants: Vec<Variant>,
    /// The coarsest of these whose p99 is within [`MATCHED`] take part too.
    pub matched: Vec<Rival>,
    /// Whether shadows are judged.
    pub shadows: bool,
    /// Degrees by which the camera turns for a second frame, to see what changes.
    pub moves: Option<f64>,
}

/// How much is measured.
#[derive(Clone, Copy, Debug)]
pub struct Extent {
    /// Little, for a look.
    pub quick: bool,
    /// Of the pictures.
    pub size: [u32; 2],
    /// Of fronts only what competes at equal error: our shells.
    pub ours: bool,
}

/// Words of all parts.
pub const IDS: &[&str] = &[
    "front",
    "stage",
    "shadow",
    "samples",
    "distance",
    "stiffness",
    "angle",
    "scale",
    "map",
    "triangles",
    "resolution",
    "moving",
];

/// Base triangles from which on mesh shaders dice none.
const MOST_DICED_BY_MESH: u32 = 500_000;

/// The depth error at which baselines are matched where sizes are swept.
pub const MATCHED: f64 = 0.5;

impl Extent {
    /// All parts. `scenes`: whose fronts; the first one is drawn in every way. Sweeps are of the scene that they need.
    pub fn parts(&self, scenes: &[String]) -> Vec<Part> {
        let mut parts: Vec<Part> = scenes.iter().enumerate().map(|(i, scene)| self.front(scene, i == 0)).collect();
        // A file of one's own has its front; what is varied about a scene is varied about ours.
        if scenes.iter().any(|scene| NAMED.iter().any(|(word, _)| word == scene)) {
            parts.extend([
                self.stage(),
                self.shadow(),
                self.samples(),
                self.distance(),
                self.stiffness(),
                self.angle(),
            ]);
            parts.extend([self.scale(), self.map(), self.triangles(), self.resolution(), self.moving()]);
        }
        parts
    }

    fn stand(&self, scene: &str, condition: String, x: Option<f64>, variants: Vec<Variant>) -> Stand {
        Stand {
            scene: scene.to_owned(),
            change: Change::None,
            place: Place::Own,
            size: self.size,
            condition,
            x,
            variants,
            matched: Vec::new(),
            shadows: false,
            moves: None,
        }
    }

    /// A choice: short or long.
    fn pick<'a, T>(&self, quick: &'a [T], full: &'a [T]) -> &'a [T] {
        if self.quick { quick } else { full }
    }

    fn front(&self, scene: &str, first: bool) -> Part {
        let mut variants = match (self.quick, first && !self.ours) {
            (true, _) => variants::few(),
            (false, true) => variants::all(),
            (false, false) => variants::some(),
        };
        variants.retain(|variant| !self.ours || variant.is_ours());
        Part {
            id: "front",
            title: format!("Error against time: {scene}"),
            text: "Every technique is a curve, every setting of it a point; lower left is better. The dashed line is the \
                   Pareto front: nothing measured is both faster and more exact than what lies on it.",
            varies: None,
            stands: vec![self.stand(scene, "its own camera".into(), None, variants)],
        }
    }

    fn sweep<X: Copy + Into<f64>>(
        &self,
        [id, title, text, varies]: [&'static str; 4],
        scene: &str,
        values: &[X],
        vary: impl Fn(&mut Stand, X),
    ) -> Part {
        let stand = |value: &X| {
            let x: f64 = (*value).into();
            let mut stand = self.stand(scene, format!("{x}"), Some(x), variants::followed());
            vary(&mut stand, *value);
            stand
        };
        let stands = values.iter().map(stand).collect();
        Part { id, title: title.to_owned(), text, varies: Some(varies), stands }
    }

    fn stage(&self) -> Part {
        Part {
            id: "stage",
            title: "Mesh and geometry stage: torus".into(),
            text: "Both stages make the same picture; what differs is what they cost.",
            varies: None,
            stands: vec![self.stand("torus", "its own camera".into(), None, variants::stages())],
        }
    }

    fn shadow(&self) -> Part {
        let mut stand = self.stand("torus", "its own camera".into(), None, variants::shadows(self.quick));
        // Half on a side: a ray to the light costs as much as one from the eye, and compiles for half a minute.
        stand.size = self.size.map(|side| (side / 2).max(1));
        stand.shadows = true;
        Part {
            id: "shadow",
            title: "Self-shadow: torus".into(),
            text: "Wrong shadow pixels are those lit here and dark in the reference, or the other way round. The reference's \
                   shadows are hard; a soft one counts as dark where less than half of the light is seen.",
            varies: None,
            stands: vec![stand],
        }
    }

    fn samples(&self) -> Part {
        Part {
            id: "samples",
            title: "Four samples a pixel: torus".into(),
            text: "FLIP is taken here against a picture of 4×4 exact samples a pixel, so that smoother outlines count; \
                   depth is that of the pixel's centre in either.",
            varies: None,
            stands: vec![self.stand("torus", "its own camera".into(), None, variants::samples())],
        }
    }

    fn distance(&self) -> Part {
        let text = "Near, the detail is larger than a pixel; far, many texels fall into one.";
        let words = ["distance", "Near, middle and far: torus", text, "distance (of the scene's own)"];
        self.sweep(words, "torus", self.pick(&[0.6, 4.0], &[0.5, 1.0, 2.0, 4.0]), |stand, factor| {
            stand.place = Place::Distance(factor);
        })
    }

    fn stiffness(&self) -> Part {
        let text = "The same heights, smoother to the left (maps halved) and stiffer to the right (maps repeated). A \
                    matched baseline is the coarsest of its kind that is within half a footprint.";
        let words = ["stiffness", "Smooth to stiff maps: torus", text, "detail (of the map's own)"];
        self.sweep(words, "torus", self.pick(&[-5, 0], &[-6, -4, -2, 0, 2]), |stand, octave: i32| {
            let detail = f64::from(octave).exp2();
            (stand.x, stand.condition) = (Some(detail), format!("{detail}"));
            stand.change =
                if octave < 0 { Change::Halved(octave.unsigned_abs()) } else { Change::Repeated(1 << octave) };
            stand.matched = Rival::ALL.to_vec();
        })
    }

    fn angle(&self) -> Part {
        let text = "A plane of two triangles, from straight above to one degree over the horizon.";
        let words = ["angle", "View angle: plane", text, "angle (degrees from the normal)"];
        self.sweep(words, "plane", self.pick(&[0, 80], &[0, 30, 60, 75, 85, 89]), |stand, degrees: i32| {
            stand.place = Place::Tilted(f64::from(degrees));
            // Two triangles: so many along an edge as the map has texels across the picture.
            for variant in stand.variants.iter_mut().filter(|variant| variant.rival() == Some(Rival::MicroMesh)) {
                *variant = variants::micro_mesh(64, prism_engine::settings::Culling::Triangles);
            }
        })
    }

    fn scale(&self) -> Part {
        let text = "Heights from none to the largest that folds no prism.";
        let words = ["scale", "Height scale: torus", text, "height scale (of the fold limit)"];
        self.sweep(words, "torus", self.pick(&[0.0, 0.5], &[0.0, 0.125, 0.25, 0.5, 0.75, 1.0]), |stand, part| {
            stand.change = Change::OfFoldLimit(part);
        })
    }

    fn map(&self) -> Part {
        let text = "The same detail in maps of more and more texels.";
        let words = ["map", "Map size: torus", text, "map size (texels a side)"];
        let sides: &[u32] = self.pick(&[256, 1024], &[256, 512, 1024, 2048, 4096, 8192]);
        self.sweep(words, "torus", sides, |stand, side| stand.change = Change::MapSide(side))
    }

    fn triangles(&self) -> Part {
        const GRIDS: &[[u32; 2]] = &[[10, 5], [32, 16], [100, 50], [316, 158], [1000, 500]];
        let text = "The torus from a hundred to a million triangles under the same map. A matched baseline is the \
                    coarsest of its kind that is within half a footprint: the larger the base mesh, the less it adds. Mesh \
                    shaders are left out of the largest, where they take longer than all others together.";
        let mut part = Part {
            id: "triangles",
            title: "Base triangles: torus".into(),
            text,
            varies: Some("base triangles"),
            stands: Vec::new(),
        };
        for &[around, along] in self.pick(&GRIDS[..2], GRIDS) {
            let count = 2 * around * along;
            let mut variants = variants::followed();
            variants.retain(|variant| variant.settings.baseline.is_none());
            let mut stand = self.stand("torus", format!("{count}"), Some(f64::from(count)), variants);
            stand.change = Change::Grid([around, along]);
            stand.matched = Rival::ALL.to_vec();
            // A frame takes mesh shaders 13 s there on lavapipe, all of the others together 4.
            stand.matched.retain(|rival| count < MOST_DICED_BY_MESH || *rival != Rival::Diced(Dicer::Mesh));
            part.stands.push(stand);
        }
        part
    }

    fn resolution(&self) -> Part {
        let text = "The same view in more and more pixels; a footprint shrinks with them.";
        let words = ["resolution", "Resolution: torus", text, "pixels"];
        let widths: &[u32] = self.pick(&[80, 160], &[80, 160, 320, 640, 1280]);
        self.sweep(words, "torus", widths, |stand, width| {
            stand.size = [width, width * 9 / 16];
            stand.x = Some(f64::from(stand.size[0] * stand.size[1]));
            stand.condition = format!("{}x{}", stand.size[0], stand.size[1]);
        })
    }

    fn moving(&self) -> Part {
        let mut variants = variants::followed();
        variants.push(variants::march(Shell::Off, March::Pom, 8));
        variants.push(variants::march(Shell::Walk, March::Pom, 2));
        let mut stand = self.stand("torus", "a turn of half a degree".into(), None, variants);
        stand.moves = Some(0.5);
        Part {
            id: "moving",
            title: "A moving camera: torus".into(),
            text: "Two frames, half a degree apart. A point that both frames see has a depth error in each; what the error \
                   changes by, in footprints, is what flickers: the surface stands still.",
            varies: None,
            stands: vec![stand],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points(quick: bool, scenes: &[&str]) -> usize {
        let scenes: Vec<String> = scenes.iter().map(|scene| (*scene).to_owned()).collect();
        let parts = Extent { quick, size: [160, 90], ours: false }.parts(&scenes);
        let of = |stand: &Stand| stand.variants.len() + stand.matched.len();
        parts.iter().flat_map(|part| &part.stands).map(of).sum()
    }

    #[test]
    fn a_full_run_has_600_points_at_most() {
        let all: Vec<&str> = NAMED.iter().map(|(word, _)| *word).collect();
        let count = points(false, &all);
        assert!((300..=600).contains(&count), "{count}");
        assert!(points(true, &["torus"]) < 120);
    }

    #[test]
    fn every_part_has_its_word() {
        let parts = Extent { quick: true, size: [16, 9], ours: false }.parts(&["torus".to_owned()]);
        let ids: Vec<&str> = parts.iter().map(|part| part.id).collect();
        assert_eq!(ids, IDS);
    }

    #[test]
    fn a_part_varies_one_thing() {
        for part in (Extent { quick: false, size: [320, 180], ours: false }).parts(&["torus".to_owned()]) {
            let [first, ..] = &part.stands[..] else { panic!("{} is empty", part.id) };
            let varied = |differs: fn(&Stand, &Stand) -> bool| part.stands.iter().any(|stand| differs(stand, first));
            let varied = [
                varied(|a, b| a.change != b.change),
                varied(|a, b| a.place != b.place),
                varied(|a, b| a.size != b.size),
                varied(|a, b| a.scene != b.scene),
            ];
            let count = varied.iter().filter(|varies| **varies).count();
            assert_eq!(count, usize::from(part.varies.is_some()), "{}: {varied:?}", part.id);
        }
    }
}
