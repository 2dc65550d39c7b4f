//! A bounding-volume hierarchy over the prisms of a primitive, for rays that enter the shell from anywhere: the boxes in
//! depth-first order, each with the one to go on with where a ray misses it. A fragment needs no stack for it.

use glam::DVec3;

/// No prism: the boxes that follow divide this one. `NO_PRISM` of `shaders/shell/prism_bits.glsl`.
pub const NO_PRISM: u32 = u32::MAX;

/// One box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Node {
    /// Least and greatest corner.
    pub bounds: [DVec3; 2],
    /// Index of the box after all that divide this one.
    pub next: u32,
    /// The prism in it, or [`NO_PRISM`].
    pub prism: u32,
}

/// The boxes over `bounds`, the least and greatest corner of each prism: 2 n - 1 of them.
pub fn build(bounds: &[[DVec3; 2]]) -> Vec<Node> {
    let mut order: Vec<u32> = (0..bounds.len() as u32).collect();
    let mut nodes = Vec::with_capacity((2 * bounds.len()).saturating_sub(1));
    if !order.is_empty() {
        divide(bounds, &mut order, &mut nodes);
    }
    nodes
}

/// Adds the box over `prisms` and those that divide it, at the median of its longest axis.
fn divide(bounds: &[[DVec3; 2]], prisms: &mut [u32], nodes: &mut Vec<Node>) {
    let of = |prism: u32| bounds[prism as usize];
    let whole = prisms.iter().fold([DVec3::INFINITY, DVec3::NEG_INFINITY], |[low, high], prism| {
        let [least, greatest] = of(*prism);
        [low.min(least), high.max(greatest)]
    });
    let at = nodes.len();
    nodes.push(Node { bounds: whole, next: 0, prism: NO_PRISM });
    if let [prism] = prisms {
        nodes[at].prism = *prism;
    } else {
        let axis = (whole[1] - whole[0]).max_position();
        let middle = |prism: &u32| of(*prism)[0][axis] + of(*prism)[1][axis];
        let half = prisms.len() / 2;
        prisms.select_nth_unstable_by(half, |a, b| middle(a).total_cmp(&middle(b)));
        let (left, right) = prisms.split_at_mut(half);
        divide(bounds, left, nodes);
        divide(bounds, right, nodes);
    }
    nodes[at].next = nodes.len() as u32;
}

/// The boxes' indices by how many boxes lie between them and their deepest prism: those that divide a box come in a
/// list before its own.
pub fn ranks(nodes: &[Node]) -> Vec<Vec<u32>> {
    let mut ranks: Vec<Vec<u32>> = Vec::new();
    let mut rank_of = vec![0; nodes.len()];
    for (i, node) in nodes.iter().enumerate().rev() {
        if node.prism == NO_PRISM {
            rank_of[i] = 1 + rank_of[i + 1].max(rank_of[nodes[i + 1].next as usize]);
        }
        if ranks.len() <= rank_of[i] {
            ranks.resize(rank_of[i] + 1, Vec::new());
        }
        ranks[rank_of[i]].push(i as u32);
    }
    ranks
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Boxes along a spiral.
    fn boxes(count: u32) -> Vec<[DVec3; 2]> {
        let corner = |i: u32| {
            let angle = f64::from(i) * 0.7;
            DVec3::new(angle.cos() * angle, angle.sin() * angle, 0.1 * angle)
        };
        (0..count).map(|i| [corner(i), corner(i) + DVec3::new(0.3, 0.2, 0.1)]).collect()
    }

    #[test]
    fn every_prism_is_once_in_a_box_that_holds_it() {
        for count in [0, 1, 2, 3, 100] {
            let boxes = boxes(count);
            let nodes = build(&boxes);
            assert_eq!(nodes.len(), (2 * boxes.len()).saturating_sub(1));
            let mut prisms: Vec<u32> = nodes.iter().map(|n| n.prism).filter(|p| *p != NO_PRISM).collect();
            prisms.sort_unstable();
            assert!(prisms.into_iter().eq(0..count));
            for node in nodes.iter().filter(|n| n.prism != NO_PRISM) {
                assert_eq!(node.bounds, boxes[node.prism as usize]);
            }
        }
    }

    #[test]
    fn what_divides_a_box_ranks_before_it() {
        for count in [0, 1, 2, 3, 100] {
            let nodes = build(&boxes(count));
            let mut known = vec![false; nodes.len()];
            for rank in ranks(&nodes) {
                for i in rank.iter().map(|i| *i as usize) {
                    let divided = nodes[i].prism == NO_PRISM;
                    assert!(!known[i] && (!divided || (known[i + 1] && known[nodes[i + 1].next as usize])));
                }
                rank.iter().for_each(|i| known[*i as usize] = true);
            }
            assert!(known.into_iter().all(|known| known));
        }
    }

    #[test]
    fn missing_a_box_skips_what_it_holds_and_no_more() {
        let nodes = build(&boxes(100));
        assert_eq!(nodes[0].next as usize, nodes.len());
        for (i, node) in nodes.iter().enumerate() {
            let [low, high] = node.bounds;
            for inner in &nodes[i + 1..node.next as usize] {
                assert!(low.cmple(inner.bounds[0]).all() && inner.bounds[1].cmple(high).all());
            }
            let leaves = nodes[i..node.next as usize].iter().filter(|n| n.prism != NO_PRISM).count();
            assert_eq!(node.next as usize - i, 2 * leaves - 1);
        }
    }
}
