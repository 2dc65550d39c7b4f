//! A bounding-volume hierarchy over boxes, split at the median of the longest axis.

use glam::DVec3;

/// An axis-aligned box.
#[derive(Clone, Copy, Debug)]
pub(super) struct Aabb {
    pub(super) min: DVec3,
    pub(super) max: DVec3,
}

impl Aabb {
    /// The box around `points`, grown by `pad` on every side.
    pub(super) fn around(points: impl IntoIterator<Item = DVec3>, pad: f64) -> Self {
        let empty = Aabb { min: DVec3::INFINITY, max: DVec3::NEG_INFINITY };
        let tight = points.into_iter().fold(empty, |b, p| Aabb { min: b.min.min(p), max: b.max.max(p) });
        Aabb { min: tight.min - pad, max: tight.max + pad }
    }

    fn union(self, other: Aabb) -> Aabb {
        Aabb { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// Where the line enters the box, if it meets it within `range` (slabs; NaN from 0 · ∞ is ignored by min and max).
    fn entry(&self, origin: DVec3, inverse: DVec3, range: [f64; 2]) -> Option<f64> {
        let (a, b) = ((self.min - origin) * inverse, (self.max - origin) * inverse);
        let [mut near, mut far] = range;
        for k in 0..3 {
            near = near.max(a[k].min(b[k]));
            far = far.min(a[k].max(b[k]));
        }
        (near <= far).then_some(near)
    }
}

#[derive(Clone, Copy, Debug)]
enum Node {
    /// Items `order[first..first + count]`.
    Leaf { first: u32, count: u32 },
    /// The left child follows its parent; this is the right one.
    Inner { right: u32 },
}

/// The hierarchy; items are indices into the boxes it was built from.
#[derive(Clone, Debug)]
pub(super) struct Bvh {
    nodes: Vec<(Aabb, Node)>,
    order: Vec<u32>,
}

const LEAF: usize = 2;

impl Bvh {
    pub(super) fn new(boxes: &[Aabb]) -> Self {
        let mut bvh = Bvh { nodes: Vec::new(), order: (0..boxes.len() as u32).collect() };
        if !boxes.is_empty() {
            bvh.build(boxes, 0, boxes.len());
        }
        bvh
    }

    fn build(&mut self, boxes: &[Aabb], first: usize, last: usize) {
        let items = &mut self.order[first..last];
        let bounds = items.iter().map(|i| boxes[*i as usize]).reduce(Aabb::union).expect("a node has items");
        let at = self.nodes.len();
        self.nodes.push((bounds, Node::Leaf { first: first as u32, count: (last - first) as u32 }));
        if last - first <= LEAF {
            return;
        }
        let centre = |i: u32| boxes[i as usize].min + boxes[i as usize].max;
        let centres = Aabb::around(items.iter().map(|i| centre(*i)), 0.0);
        let axis = (centres.max - centres.min).max_position();
        let middle = items.len() / 2;
        items.select_nth_unstable_by(middle, |a, b| centre(*a)[axis].total_cmp(&centre(*b)[axis]));
        self.build(boxes, first, first + middle);
        self.nodes[at].1 = Node::Inner { right: self.nodes.len() as u32 };
        self.build(boxes, first + middle, last);
    }

    /// Calls `visit(item, far)` for every item whose box the ray meets between `near` and `far`, near boxes first.
    /// `visit` returns the new far end: the hit it found, or what it was given.
    pub(super) fn traverse(
        &self,
        origin: DVec3,
        direction: DVec3,
        [near, mut far]: [f64; 2],
        mut visit: impl FnMut(usize, f64) -> f64,
    ) {
        let inverse = direction.recip();
        let entry = |node: u32, far: f64| self.nodes[node as usize].0.entry(origin, inverse, [near, far]);
        let mut stack = Vec::with_capacity(64);
        if let Some(enters) = (!self.nodes.is_empty()).then(|| entry(0, far)).flatten() {
            stack.push((0, enters));
        }
        while let Some((node, enters)) = stack.pop() {
            if enters > far {
                continue;
            }
            match self.nodes[node as usize].1 {
                Node::Leaf { first, count } => {
                    for item in &self.order[first as usize..(first + count) as usize] {
                        far = visit(*item as usize, far);
                    }
                }
                Node::Inner { right } => {
                    let mut children = [node + 1, right].map(|child| entry(child, far).map(|enters| (child, enters)));
                    if let [Some(a), Some(b)] = children
                        && a.1 < b.1
                    {
                        children.swap(0, 1);
                    }
                    stack.extend(children.into_iter().flatten());
                }
            }
        }
    }
}
