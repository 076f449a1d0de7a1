//! The limits of the numbers of a machine file.

use robovec_num::limited_fields;

limited_fields! {
    /// Clock of the processing elements, in MHz.
    clock_mhz ("clock_mhz", "as estimated") = NumberLimit::real(
        1e-3, 1e6, "no circuit has a slower or faster clock, and times in microseconds would lose digits");
    /// Elements of a kind.
    count ("element.count", "") = NumberLimit::whole(
        1, 4096, "images, crossbar and placement grow with the number of elements");
    /// Pipeline stages.
    stages ("element.stages", "") = NumberLimit::whole(
        1, 4096, "the length of a program is its longest chain multiplied by the stages");
    /// Cycles to fetch and to write back.
    transfer ("element.transfer", "") = NumberLimit::whole(
        2, 2, "the sequencer fetches in one cycle and writes back in another");
    /// Words of an operand memory.
    memory_words ("memory.words", "unlimited") = NumberLimit::whole(
        1, 1 << 24, "images have a line for every word, and the simulator loads 2^24 words");
    /// Words written into a memory in a cycle.
    writes ("memory.writes", "unlimited") = NumberLimit::whole(
        1, 64, "every instruction has fields for every write port of every memory");
    /// Words of a buffer.
    buffer_words ("buffer.words", "unlimited") = NumberLimit::whole(
        1, 1 << 24, "the simulator holds 2^24 words; a machine without buffers has no [buffer]");
    /// Words read from a buffer in a cycle.
    reads ("buffer.reads", "unlimited") = NumberLimit::whole(
        1, 64, "every instruction has fields for every read port of every buffer");
    /// Words of an instruction memory.
    instruction_words ("instructions.words", "as needed") = NumberLimit::whole(
        1, 1 << 24, "images have a line for every word, and the simulator loads 2^24 words");
    /// Cycles for a hop in a network.
    hop ("interconnect.hop", "1") = NumberLimit::whole(
        0, 64, "every hop of every word adds its cycles to the program");
    /// Words that a link carries in a cycle.
    link_words ("interconnect.words", "1") = NumberLimit::whole(
        1, 256, "links are reserved word by word in every cycle");
    /// Routers in a row.
    columns ("interconnect.columns", "square") = NumberLimit::whole(
        1, 4096, "there are at most as many routers in a row as elements");
    /// Logic cells.
    logic ("resources.logic", "0") = NumberLimit::whole(
        0, 1_000_000_000, "no device has more");
    /// Memory blocks.
    memory_blocks ("resources.memory_blocks", "0") = NumberLimit::whole(
        0, 1_000_000_000, "no device has more");
    /// Multiplier blocks.
    multipliers ("resources.multipliers", "0") = NumberLimit::whole(
        0, 1_000_000_000, "no device has more");
}
