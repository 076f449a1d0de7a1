//! Words that meet on the links of a network.

use super::{parsed, view};
use crate::Machine;
use crate::machine::interconnect::{Interconnect, LinkNetwork, Topology};
use crate::verify::verify_placement;

/// One ring of add0, multi0, add1, multi1: the sum has two hops to go in
/// either direction, the product one.
const RING: &str = "function f placed {
      in a
      out M[1..2]
      schedule \"torus\" add*2 multi*2 cycles 14 bound 1
      preload add0[0] = a
      preload multi0[0] = a
      %s = a + a on add0 at 0 read 0 0 write add1[0] at 13
      %p = a*a on multi0 at 6 read 0 0 write add1[1] at 13
      M[1] = %s in add1[0]
      M[2] = %p in add1[1]
    }";

/// Two sums of one element that leave its buffer in one cycle, for add1.
const BUFFERED: &str = "function f placed {
      in a
      out M[1..2]
      schedule \"torus\" add*2 multi*2 cycles 16 bound 1
      preload add0[0] = a
      %s = a + a on add0 at 0 read 0 0 buffer 0 write add1[0] at 15
      %d = a - a on add0 at 1 read 0 0 buffer 1 write add1[1] at 15
      M[1] = %s in add1[0]
      M[2] = %d in add1[1]
    }";

fn messages(text: &str, words: u32, reads: u32) -> Vec<String> {
    let module = parsed(text);
    let mut machine = Machine::built_in("torus").expect("it ships");
    machine.interconnect = Interconnect::Network(LinkNetwork {
        topology: Topology::Torus,
        hop: 1,
        words,
        columns: Some(4),
    });
    let buffer = machine.buffer.as_mut().expect("it has buffers");
    buffer.reads = Some(reads);
    let violations = verify_placement(view(&module), &machine).into_iter();
    violations.map(|violation| violation.message).collect()
}

#[test]
fn a_link_carries_no_more_words_than_it_can() {
    assert_eq!(messages(RING, 2, 1), [""; 0]);
    // Both ways round are as long for the sum; it goes upwards, by multi0,
    // and takes the link to add1 in the cycle in which the product does.
    assert_eq!(
        messages(RING, 1, 1),
        ["%p is one of 2 words on one link of the torus at cycle 12, which carries 1"]
    );
}

#[test]
fn a_buffer_hands_out_no_more_words_than_it_can() {
    assert_eq!(messages(BUFFERED, 2, 2), [""; 0]);
    assert_eq!(
        messages(BUFFERED, 2, 1),
        ["more words of the buffer of add0 are read at cycle 13 than the 1 it hands out"]
    );
}
