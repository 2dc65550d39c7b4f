//! Procedural heights: the f64 twins of `shaders/shell/procedures/`.
//!
//! A procedure is a height in [0, 1] that is a function of UV, repeats with period 1 along u and v, and is continuous:
//! a cliff is a steep bevel. Its counts per UV unit are powers of two, so that f32 scales UVs without rounding. To add
//! one: its twin here, its GLSL beside the others, a value of [`Procedure`] and a line in
//! `shaders/shell/procedures.glsl`; `tests/procedures.rs` then holds the two to each other and the marches to the
//! reference.

mod bricks;
mod cobbles;
mod waves;

use glam::DVec2;

/// A built-in height function.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Procedure {
    /// Running bond: 4 bricks by 8 courses of slightly tilted bricks with bevelled edges, the joints at height 0. The
    /// joints are even where a UV unit is 3 wide by 2 high.
    Bricks,
    /// 8 by 8 domed stones on a flat bed at height 0.
    Cobbles,
    /// Smooth water: a sum of six sines.
    Waves,
}

impl Procedure {
    /// Every procedure.
    pub const ALL: [Procedure; 3] = [Procedure::Bricks, Procedure::Cobbles, Procedure::Waves];

    /// Its name in a scene file.
    pub fn name(self) -> &'static str {
        match self {
            Procedure::Bricks => "bricks",
            Procedure::Cobbles => "cobbles",
            Procedure::Waves => "waves",
        }
    }

    /// The height at `uv`, in [0, 1].
    pub fn height(self, uv: DVec2) -> f64 {
        match self {
            Procedure::Bricks => bricks::height_and_gradient(uv).0,
            Procedure::Cobbles => cobbles::height_and_gradient(uv).0,
            Procedure::Waves => waves::height_and_gradient(uv).0,
        }
    }

    /// ∂h/∂u and ∂h/∂v at `uv`; at a crease those of one side.
    pub fn gradient(self, uv: DVec2) -> DVec2 {
        match self {
            Procedure::Bricks => bricks::height_and_gradient(uv).1,
            Procedure::Cobbles => cobbles::height_and_gradient(uv).1,
            Procedure::Waves => waves::height_and_gradient(uv).1,
        }
    }

    /// Bounds of the height over the box `low..=high`, which may be a point. They close in on the height at least as
    /// fast as the box shrinks, and leave room for the rounding of f64.
    pub fn bounds(self, low: DVec2, high: DVec2) -> [f64; 2] {
        let [least, greatest] = self.extent();
        // Over a whole period nothing is to be learnt.
        if (high - low).max_element() >= 1.0 {
            return [least, greatest];
        }
        let [a, b] = match self {
            Procedure::Bricks => bricks::bounds(low, high),
            Procedure::Cobbles => cobbles::bounds(low, high),
            Procedure::Waves => waves::bounds(low, high),
        };
        [(a - ROUNDING).max(least), (b + ROUNDING).min(greatest)]
    }

    /// Texels along u and v of a map that would hold its features, as its GLSL has them: what marches count steps by.
    pub fn detail(self) -> [f64; 2] {
        match self {
            Procedure::Bricks => [256.0; 2],
            Procedure::Cobbles => [128.0; 2],
            Procedure::Waves => [64.0; 2],
        }
    }

    /// Bounds of the height everywhere.
    pub fn extent(self) -> [f64; 2] {
        [0.0, 1.0]
    }
}

/// More than the rounding of any height or bound here, for UVs of a few units.
const ROUNDING: f64 = 1e-14;

/// A number without order, the same for the same `n`: the 32-bit finaliser of C. Wellons (hash-prospector,
/// "lowbias32").
fn scrambled(mut n: u32) -> u32 {
    n ^= n >> 16;
    n = n.wrapping_mul(0x7feb_352d);
    n ^= n >> 15;
    n = n.wrapping_mul(0x846c_a68b);
    n ^ n >> 16
}

/// Ten bits of `n` from bit `first`, as a fraction in [0, 1).
fn fraction(n: u32, first: u32) -> f64 {
    f64::from(n >> first & 1023) / 1024.0
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers in [0, 1), the same every time.
    struct Random(u64);

    impl Random {
        fn next(&mut self) -> f64 {
            self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (self.0 >> 11) as f64 / (1u64 << 53) as f64
        }

        fn point(&mut self, from: f64, to: f64) -> DVec2 {
            DVec2::new(from + (to - from) * self.next(), from + (to - from) * self.next())
        }
    }

    #[test]
    fn a_unit_of_uv_is_a_period_and_heights_fill_the_range() {
        let mut random = Random(1);
        for procedure in Procedure::ALL {
            let (mut least, mut greatest) = (f64::INFINITY, f64::NEG_INFINITY);
            for _ in 0..20_000 {
                let at = random.point(0.0, 1.0);
                let h = procedure.height(at);
                for shift in [DVec2::X, DVec2::Y, DVec2::new(-3.0, 2.0)] {
                    assert!((procedure.height(at + shift) - h).abs() < 1e-12, "{procedure:?} at {at}");
                }
                (least, greatest) = (least.min(h), greatest.max(h));
            }
            let [low, high] = procedure.extent();
            assert!(low <= least && greatest <= high, "{procedure:?}: {least}..{greatest}");
            assert!(greatest - least > 0.75 * (high - low), "{procedure:?}: {least}..{greatest}");
        }
    }

    #[test]
    fn gradients_are_the_heights_slopes() {
        const STEP: f64 = 1e-6;
        let mut random = Random(2);
        for procedure in Procedure::ALL {
            let mut creases = 0;
            for _ in 0..20_000 {
                let at = random.point(-1.0, 2.0);
                let slope = |axis: DVec2| {
                    let ends = [1.0, -1.0].map(|side| procedure.height(at + side * STEP * axis));
                    (ends[0] - ends[1]) / (2.0 * STEP)
                };
                let error = procedure.gradient(at) - DVec2::new(slope(DVec2::X), slope(DVec2::Y));
                // Across a crease the difference quotient has neither side's slope.
                creases += u32::from(error.length() > 0.02);
            }
            assert!(creases < 20, "{procedure:?}: {creases} of 20000");
        }
    }

    #[test]
    fn bounds_contain_dense_samples_of_boxes_of_all_sizes_and_close_in_with_them() {
        let mut random = Random(3);
        for procedure in Procedure::ALL {
            for _ in 0..4000 {
                let low = random.point(-2.0, 2.0);
                // Each side from 2^-40 to 2, by itself.
                let extent = random.point(-40.0, 1.0).exp2();
                let [least, greatest] = procedure.bounds(low, low + extent);
                for i in 0..=16 {
                    for j in 0..=16 {
                        let at = low + extent * DVec2::new(f64::from(i), f64::from(j)) / 16.0;
                        let h = procedure.height(at);
                        assert!(least <= h && h <= greatest, "{procedure:?} {low} {extent}: {h}, {least}..{greatest}");
                    }
                }
                // No height has a slope beyond this.
                let width = 300.0 * extent.max_element() + 4.0 * ROUNDING;
                assert!(greatest - least <= width, "{procedure:?} {low} {extent}: {least}..{greatest}");
            }
        }
    }
}
