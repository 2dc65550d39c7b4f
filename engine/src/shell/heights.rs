//! A displacement's heights on the CPU, point by point.

use glam::DVec2;

use crate::scene::{Displacement, HeightMap, HeightSource, Procedure, Scene, Wrap};

/// What a displacement reads its heights from.
pub struct Heights(Source);

enum Source {
    Map(MapHeights),
    Procedure(Procedure),
}

impl Heights {
    /// Of a displacement of `scene`.
    pub fn new(scene: &Scene, displacement: &Displacement) -> Self {
        Heights(match displacement.source {
            HeightSource::Map(map) => Source::Map(MapHeights::new(&scene.height_maps[map], displacement.wrap)),
            HeightSource::Procedure(procedure) => Source::Procedure(procedure),
        })
    }

    /// Texels of a map; none of a function.
    pub fn texels(&self) -> Option<DVec2> {
        match &self.0 {
            Source::Map(map) => Some(map.size()),
            Source::Procedure(_) => None,
        }
    }

    /// The greatest derivatives along u and v over a box of UV, without sign; none of a function, or of a box so large
    /// that it is not worth the time.
    pub fn steepest(&self, low: DVec2, high: DVec2) -> Option<DVec2> {
        match &self.0 {
            Source::Map(map) => map.steepest(low, high),
            Source::Procedure(_) => None,
        }
    }

    /// The height at `uv`, and its derivatives.
    pub fn at(&self, uv: DVec2) -> (f64, DVec2) {
        match &self.0 {
            Source::Map(map) => map.at(uv),
            Source::Procedure(procedure) => (procedure.height(uv), procedure.gradient(uv)),
        }
    }
}

/// Texels over which [`Heights::steepest`] looks.
const MOST_TEXELS: f64 = 1e6;

/// A height map in f32, at mip 0 and bilinear, as the shaders read it.
struct MapHeights {
    size: [i64; 2],
    texels: Vec<f32>,
    wrap: [Wrap; 2],
}

impl MapHeights {
    fn new(map: &HeightMap, wrap: [Wrap; 2]) -> Self {
        let rows = 0..map.height;
        let texels = rows.flat_map(|y| (0..map.width).map(move |x| map.height(x, y) as f32)).collect();
        MapHeights { size: [map.width, map.height].map(i64::from), texels, wrap }
    }

    fn texel(&self, at: [i64; 2]) -> f64 {
        let wrapped = |axis: usize| self.wrap[axis].index(at[axis], self.size[axis]);
        f64::from(self.texels[(wrapped(1) * self.size[0] + wrapped(0)) as usize])
    }

    fn size(&self) -> DVec2 {
        DVec2::new(self.size[0] as f64, self.size[1] as f64)
    }

    /// See [`Heights::steepest`].
    fn steepest(&self, low: DVec2, high: DVec2) -> Option<DVec2> {
        let [low, high] = [low, high].map(|uv| (uv * self.size() - 0.5).floor());
        let across = high - low + 1.0;
        if across.x * across.y > MOST_TEXELS {
            return None;
        }
        let mut most = DVec2::ZERO;
        // A side of a cell is that of its neighbour too.
        for y in low.y as i64..=high.y as i64 + 1 {
            for x in low.x as i64..=high.x as i64 + 1 {
                let here = self.texel([x, y]);
                let step = DVec2::new(self.texel([x + 1, y]) - here, self.texel([x, y + 1]) - here);
                most = most.max(step.abs());
            }
        }
        Some(most * self.size())
    }

    /// The height at `uv`, and its derivatives.
    fn at(&self, uv: DVec2) -> (f64, DVec2) {
        let size = self.size();
        let place = uv * size - 0.5;
        let (low, between) = (place.floor(), place - place.floor());
        let (x, y) = (low.x as i64, low.y as i64);
        let [a, b] = [self.texel([x, y]), self.texel([x + 1, y])];
        let [c, d] = [self.texel([x, y + 1]), self.texel([x + 1, y + 1])];
        let lerp = |a: f64, b: f64, s: f64| a + (b - a) * s;
        let height = lerp(lerp(a, b, between.x), lerp(c, d, between.x), between.y);
        let slope = DVec2::new(lerp(b - a, d - c, between.y), lerp(c - a, d - b, between.x));
        (height, slope * size)
    }
}
