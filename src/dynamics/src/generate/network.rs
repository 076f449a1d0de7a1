//! Networks that combine values along all paths of a tree.
//!
//! A recursion from joint to joint is as deep as the tree. When a step is
//! associative, the values of a path can be combined in another order: in depth
//! `log2 n` (Sklansky) with some `n/2 log2 n` combinations, in `2 log2 n`
//! (Brent and Kung) with at most `2 n`, or one after another with `n`. The
//! combined blocks of a path begin at multiples of a power of two, counted from
//! the root. They depend on ancestors alone, so branches share them.

/// In which order values along a path are combined.
#[derive(Clone, Copy, PartialEq, Eq, Default, Debug)]
pub enum PrefixNetwork {
    /// One after another: the fewest operations.
    Serial,
    /// In twice logarithmic depth with at most twice the operations.
    BrentKung,
    /// In logarithmic depth: the shortest path.
    #[default]
    Sklansky,
}

impl PrefixNetwork {
    /// All networks.
    pub const ALL: [PrefixNetwork; 3] = [
        PrefixNetwork::Serial,
        PrefixNetwork::BrentKung,
        PrefixNetwork::Sklansky,
    ];
}

/// Place of a combination: the block of a joint's path from a depth, from 0.
#[derive(Clone, Copy)]
pub(super) struct PathBlock {
    pub(super) joint: usize,
    pub(super) start: usize,
}

/// Combines the values of every path. `parents` has parents before children;
/// `combine` gets the block it makes, the value of the part towards the root
/// and the value of the part that ends at the joint.
pub(super) fn paths<T: Copy>(
    network: PrefixNetwork,
    parents: &[Option<usize>],
    values: &[T],
    combine: impl FnMut(PathBlock, T, T) -> T,
) -> Vec<T> {
    assert_eq!(values.len(), parents.len(), "one value per joint");
    let mut depths: Vec<usize> = Vec::with_capacity(parents.len());
    for parent in parents {
        depths.push(parent.map_or(0, |parent| depths[parent] + 1));
    }
    let paths = JointPaths { parents, depths };
    match network {
        PrefixNetwork::Serial => paths.serial(values, combine),
        PrefixNetwork::BrentKung => paths.brent_kung(values, combine),
        PrefixNetwork::Sklansky => paths.sklansky(values, combine),
    }
}

struct JointPaths<'a> {
    parents: &'a [Option<usize>],
    depths: Vec<usize>,
}

impl JointPaths<'_> {
    fn at(&self, mut joint: usize, depth: usize) -> usize {
        while self.depths[joint] > depth {
            match self.parents[joint] {
                Some(parent) => joint = parent,
                None => break,
            }
        }
        joint
    }

    fn serial<T: Copy>(
        &self,
        values: &[T],
        mut combine: impl FnMut(PathBlock, T, T) -> T,
    ) -> Vec<T> {
        let mut combined: Vec<T> = Vec::with_capacity(values.len());
        for (joint, &value) in values.iter().enumerate() {
            let block = PathBlock { joint, start: 0 };
            combined.push(match self.parents[joint] {
                Some(parent) => combine(block, combined[parent], value),
                None => value,
            });
        }
        combined
    }

    /// In step k, blocks of `2^k` are joined in pairs: every joint of a second
    /// block takes the whole first one.
    fn sklansky<T: Copy>(
        &self,
        values: &[T],
        mut combine: impl FnMut(PathBlock, T, T) -> T,
    ) -> Vec<T> {
        let mut combined = values.to_vec();
        let deepest = self.depths.iter().copied().fold(0, usize::max);
        let mut size = 1;
        while size <= deepest {
            let before = combined.clone();
            for (joint, &depth) in self.depths.iter().enumerate() {
                if depth & size != 0 {
                    let middle = depth / size * size;
                    let other = self.at(joint, middle - 1);
                    let block = PathBlock {
                        joint,
                        start: middle - size,
                    };
                    combined[joint] = combine(block, before[other], before[joint]);
                }
            }
            size *= 2;
        }
        combined
    }

    /// The joint at place p (from 1) first combines a block whose length is the
    /// largest power of two that divides p, then all blocks before it.
    fn brent_kung<T: Copy>(
        &self,
        values: &[T],
        mut combine: impl FnMut(PathBlock, T, T) -> T,
    ) -> Vec<T> {
        let mut blocks = values.to_vec();
        let mut combined = values.to_vec();
        for (joint, &depth) in self.depths.iter().enumerate() {
            let place = depth + 1;
            let largest = place & place.wrapping_neg();
            let mut size = 1;
            while size < largest {
                let other = self.at(joint, depth - size);
                let block = PathBlock {
                    joint,
                    start: place - 2 * size,
                };
                blocks[joint] = combine(block, blocks[other], blocks[joint]);
                size *= 2;
            }
            combined[joint] = if place == largest {
                blocks[joint]
            } else {
                let other = self.at(joint, depth - largest);
                combine(
                    PathBlock { joint, start: 0 },
                    combined[other],
                    blocks[joint],
                )
            };
        }
        combined
    }
}

/// Sums of values over the joints beyond every joint, itself included. The tree
/// is cut into chains, each as long as it can be; along a chain the network
/// adds, and where a chain ends on another its whole sum is added to the value
/// there. There are no subtractions. `add` gets the joint of the sum (or part:
/// a block of `start` places towards the leaf), and the terms to be added.
pub(super) fn subtrees<T: Copy>(
    network: PrefixNetwork,
    parents: &[Option<usize>],
    values: &[T],
    mut add: impl FnMut(PathBlock, &[T]) -> T,
) -> Vec<T> {
    assert_eq!(values.len(), parents.len(), "one value per joint");
    assert!(
        (0..)
            .zip(parents)
            .all(|(joint, parent)| parent.is_none_or(|parent| parent < joint)),
        "parents come before children"
    );
    let chains = chains(parents);
    let mut sums = values.to_vec();
    let mut pending: Vec<Vec<usize>> = vec![Vec::new(); parents.len()];
    // A chain that ends on another begins behind it.
    for chain in chains.iter().rev() {
        let mut own: Vec<T> = Vec::with_capacity(chain.len());
        for &joint in chain.iter().rev() {
            let mut parts = vec![values[joint]];
            parts.extend(pending[joint].iter().map(|&child| sums[child]));
            own.push(match parts.as_slice() {
                [value] => *value,
                parts => add(
                    PathBlock {
                        joint,
                        start: chain.len(),
                    },
                    parts,
                ),
            });
        }
        let order: Vec<Option<usize>> =
            (0..chain.len()).map(|place| place.checked_sub(1)).collect();
        let last = chain.len() - 1;
        let combined = paths(network, &order, &own, |block, before, after| {
            let joint = chain[last - block.joint];
            let start = block.start;
            add(PathBlock { joint, start }, &[after, before])
        });
        for (place, sum) in combined.into_iter().enumerate() {
            sums[chain[last - place]] = sum;
        }
        if let Some(parent) = parents[chain[0]] {
            pending[parent].push(chain[0]);
        }
    }
    sums
}

/// Chains from root to leaves that cover the tree, in the order of their first
/// joints. Each continues with the child of the longest path.
fn chains(parents: &[Option<usize>]) -> Vec<Vec<usize>> {
    let mut heights = vec![1; parents.len()];
    let mut next: Vec<Option<usize>> = vec![None; parents.len()];
    for joint in (0..parents.len()).rev() {
        if let Some(parent) = parents[joint]
            && heights[joint] + 1 > heights[parent]
        {
            heights[parent] = heights[joint] + 1;
            next[parent] = Some(joint);
        }
    }
    let heads = (0..parents.len())
        .filter(|&joint| parents[joint].is_none_or(|parent| next[parent] != Some(joint)));
    heads
        .map(|head| std::iter::successors(Some(head), |&joint| next[joint]).collect())
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every network gives the joints of each path in order, and each joint of a
    /// subtree once.
    #[test]
    fn networks_combine_paths_and_subtrees() {
        let parents: Vec<Option<usize>> = (0..60usize)
            .map(|joint| match joint {
                0 | 7 => None,
                _ if joint % 5 == 0 => Some(joint / 2),
                _ => Some(joint - 1),
            })
            .collect();
        let lists: Vec<Vec<usize>> = (0..60).map(|joint| vec![joint]).collect();
        let values: Vec<usize> = (0..60).collect();
        for network in PrefixNetwork::ALL {
            let mut store = lists.clone();
            let down = paths(network, &parents, &values, |_, before, after| {
                let joined = [store[before].clone(), store[after].clone()].concat();
                store.push(joined);
                store.len() - 1
            });
            for joint in 0..60 {
                let mut path: Vec<usize> =
                    std::iter::successors(Some(joint), |&joint| parents[joint]).collect();
                path.reverse();
                assert_eq!(store[down[joint]], path);
            }
            let up = subtrees(network, &parents, &values, |_, parts| {
                let joined = parts.iter().flat_map(|&part| store[part].clone()).collect();
                store.push(joined);
                store.len() - 1
            });
            for root in 0..60 {
                let behind = |joint| {
                    std::iter::successors(Some(joint), |&joint| parents[joint])
                        .any(|joint| joint == root)
                };
                let mut found = store[up[root]].clone();
                found.sort_unstable();
                assert_eq!(found, (0..60).filter(|&j| behind(j)).collect::<Vec<_>>());
            }
        }
    }
}
