//! Numbers that look random and are the same each time (splitmix64: Steele, Lea, Flood 2014).

use glam::DVec3;

pub struct Random(pub u64);

impl Random {
    /// In [0, 1).
    pub fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    /// A point in the unit ball.
    pub fn in_ball(&mut self) -> DVec3 {
        loop {
            let point = DVec3::from_array(std::array::from_fn(|_| 2.0 * self.next() - 1.0));
            if point.length() <= 1.0 {
                return point;
            }
        }
    }
}
