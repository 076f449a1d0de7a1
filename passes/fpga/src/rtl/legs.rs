//! The legs of a crossbar: which source reaches which write port.

use super::error::RtlError;
use crate::layout::Sizes;
use crate::traffic::Traffic;
use robovec_ir::placement::Bank;
use std::collections::BTreeSet;

/// For every write port the codes of the sources it selects, ascending.
/// Ports are counted element by element, within an element memory by memory.
pub(super) fn used(traffic: &Traffic<'_>, sizes: &Sizes) -> Vec<Vec<u32>> {
    let ports = (sizes.elements * sizes.memories * sizes.write_ports) as usize;
    let mut legs = vec![BTreeSet::new(); ports];
    let writes = &traffic.placement.writes;
    for element in traffic.elements() {
        for group in traffic.write_groups(element) {
            for (port, &index) in (0u32..).zip(group) {
                let write = writes[index as usize];
                let memory = u32::from(write.word.bank == Bank::Right);
                let place = (element.number() * sizes.memories + memory) * sizes.write_ports + port;
                let value = traffic.owners[index as usize];
                legs[place as usize].insert(traffic.select(value, write.cycle));
            }
        }
    }
    legs.into_iter()
        .map(|set| set.into_iter().collect())
        .collect()
}

/// A list per port, of sources that exist, in order.
pub(super) fn validate(legs: &[Vec<u32>], sizes: &Sizes) -> Result<(), RtlError> {
    let ports = sizes.elements * sizes.memories * sizes.write_ports;
    let sound = |codes: &Vec<u32>| {
        codes.windows(2).all(|pair| pair[0] < pair[1])
            && codes.last().is_none_or(|&last| last < sizes.sources())
    };
    if legs.len() as u64 != u64::from(ports) || !legs.iter().all(sound) {
        let message = "its crossbar does not match its elements".to_owned();
        return Err(RtlError::Description(message));
    }
    Ok(())
}

/// The source through which the host's words reach a memory: for every memory,
/// a code among the legs of its first write port, or none where no instruction
/// selects a source.
///
/// While the host writes, every select is 0, so a port that has the source 0
/// takes that one; the others take as few sources as a greedy choice finds,
/// since each of them costs its own multiplexer.
pub(super) fn host_legs(legs: &[Vec<u32>], write_ports: u32) -> Vec<Option<u32>> {
    let first: Vec<&Vec<u32>> = legs.iter().step_by(write_ports as usize).collect();
    let mut chosen: Vec<Option<u32>> = first
        .iter()
        .map(|codes| codes.first().copied().filter(|&code| code == 0))
        .collect();
    loop {
        let mut counts = std::collections::BTreeMap::new();
        let open = first
            .iter()
            .zip(&chosen)
            .filter(|(_, chosen)| chosen.is_none());
        for &code in open.flat_map(|(codes, _)| codes.iter()) {
            *counts.entry(code).or_insert(0u32) += 1;
        }
        // The most frequent one, the lowest of several.
        let best = counts
            .iter()
            .max_by_key(|&(&code, &count)| (count, u32::MAX - code));
        let Some((&best, _)) = best else {
            return chosen;
        };
        for (codes, chosen) in first.iter().zip(&mut chosen) {
            if chosen.is_none() && codes.contains(&best) {
                *chosen = Some(best);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn few_sources_carry_the_host_s_words_everywhere() {
        let legs = vec![vec![0, 3], vec![1, 2], vec![2, 5], vec![], vec![4, 6]];
        assert_eq!(
            host_legs(&legs, 1),
            [Some(0), Some(2), Some(2), None, Some(4)]
        );
        let second_ports_do_not_count = vec![vec![3], vec![0], vec![3], vec![]];
        assert_eq!(host_legs(&second_ports_do_not_count, 2), [Some(3), Some(3)]);
    }
}
