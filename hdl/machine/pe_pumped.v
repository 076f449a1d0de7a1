// The operand memory of a processing element as in the thesis (section 1.2):
// one memory with two ports, used several times per cycle. The first clock of
// a cycle reads the left operand through port A and the right one through
// port B; each further clock writes two words. With two write ports a cycle
// has two clocks: the memory runs at twice the rate of the element.
//
// There is one clock and no other: the element's registers have an enable,
// `advance`, that is high in the last clock of a cycle. A clock divided by a
// register, which is also a data signal of the fast domain, is what held the
// thesis' design at a fifth of what its memories allow.
//
// An element of fused operations reads three words. The third comes from a
// second memory that is written alike and shows the addend on its port A.
//
// Parameters
//   WIDTH, ADDRESS, INITIAL, IMAGE   as true_dual_port_memory
//   WRITES       write ports
//   PHASES       clocks of a cycle, 1 + ceil(WRITES / 2)
//   PHASE_BITS   bits that count them
//   FUSED        1: there is an addend
//
// Ports
//   advance, phase                 as sequencer
//   left_address, right_address, addend_address   the operands' words
//   write, write_address, write_data   write ports, port 0 lowest
//   host_write       the host writes the word on port 0 of `write_data`
//   host_address     what the host reads or writes; 0 in all other clocks
//   host_word        the word the host has read, one clock later
//   left, right, addend            the operands, in the next cycle
module pe_pumped #(
    parameter WIDTH = 32,
    parameter ADDRESS = 11,
    parameter WRITES = 2,
    parameter PHASES = 2,
    parameter PHASE_BITS = 1,
    parameter FUSED = 0,
    parameter INITIAL = 0,
    parameter IMAGE = "image"
) (
    input                       clock,
    input                       advance,
    input  [PHASE_BITS-1:0]     phase,
    input  [ADDRESS-1:0]        left_address,
    input  [ADDRESS-1:0]        right_address,
    input  [ADDRESS-1:0]        addend_address,
    input  [WRITES-1:0]         write,
    input  [WRITES*ADDRESS-1:0] write_address,
    input  [WRITES*WIDTH-1:0]   write_data,
    input                       host_write,
    input  [ADDRESS-1:0]        host_address,
    output [WIDTH-1:0]          host_word,
    output [WIDTH-1:0]          left,
    output [WIDTH-1:0]          right,
    output [WIDTH-1:0]          addend
);

    // The write ports in pairs, one pair per clock after the first; a port
    // without a partner has one that never writes.
    localparam PAIRS = PHASES - 1;
    localparam MISSING = 2 * PAIRS - WRITES;
    wire [2*PAIRS-1:0]         paired_write = {{MISSING{1'b0}}, write};
    wire [2*PAIRS*ADDRESS-1:0] paired_address = {{(MISSING * ADDRESS) {1'b0}}, write_address};
    wire [2*PAIRS*WIDTH-1:0]   paired_data = {{(MISSING * WIDTH) {1'b0}}, write_data};

    wire reading = phase == 0;
    wire [PHASE_BITS-1:0] pair = (reading | host_write) ? {PHASE_BITS{1'b0}} : phase - 1'b1;

    wire               a_write = (~reading & paired_write[2*pair]) | host_write;
    wire               b_write = ~reading & paired_write[2*pair+1];
    wire [ADDRESS-1:0] a_written = paired_address[2*pair*ADDRESS +: ADDRESS];
    wire [ADDRESS-1:0] b_written = paired_address[(2*pair+1)*ADDRESS +: ADDRESS];
    wire [WIDTH-1:0]   a_data = paired_data[2*pair*WIDTH +: WIDTH];
    wire [WIDTH-1:0]   b_data = paired_data[(2*pair+1)*WIDTH +: WIDTH];

    // A program's fields are zero while the host is at work, and the host's
    // address is zero while a program runs: an OR tells them apart.
    wire [ADDRESS-1:0] a_address = (reading ? left_address : a_written) | host_address;
    wire [ADDRESS-1:0] b_address = reading ? right_address : b_written;

    wire [WIDTH-1:0] right_word;

    true_dual_port_memory #(
        .WIDTH(WIDTH),
        .ADDRESS(ADDRESS),
        .INITIAL(INITIAL),
        .IMAGE(IMAGE)
    ) words (
        .clock(clock),
        .a_write(a_write),
        .a_address(a_address),
        .a_data(a_data),
        .a_word(host_word),
        .b_write(b_write),
        .b_address(b_address),
        .b_data(b_data),
        .b_word(right_word)
    );

    pumped_operand #(.WIDTH(WIDTH), .PHASES(PHASES), .PHASE_BITS(PHASE_BITS)) left_operand (
        .clock(clock), .advance(advance), .phase(phase), .word(host_word), .operand(left));

    pumped_operand #(.WIDTH(WIDTH), .PHASES(PHASES), .PHASE_BITS(PHASE_BITS)) right_operand (
        .clock(clock), .advance(advance), .phase(phase), .word(right_word), .operand(right));

    generate
        if (FUSED != 0) begin : fused
            wire [WIDTH-1:0] addend_word;
            wire [WIDTH-1:0] unused_word;

            true_dual_port_memory #(
                .WIDTH(WIDTH),
                .ADDRESS(ADDRESS),
                .INITIAL(INITIAL),
                .IMAGE(IMAGE)
            ) copy (
                .clock(clock),
                .a_write(a_write),
                .a_address((reading ? addend_address : a_written) | host_address),
                .a_data(a_data),
                .a_word(addend_word),
                .b_write(b_write),
                .b_address(b_written),
                .b_data(b_data),
                .b_word(unused_word)
            );

            pumped_operand #(.WIDTH(WIDTH), .PHASES(PHASES), .PHASE_BITS(PHASE_BITS))
            addend_operand (
                .clock(clock), .advance(advance), .phase(phase), .word(addend_word),
                .operand(addend));
        end else begin : plain
            assign addend = {WIDTH{1'b0}};
            wire unused = &{1'b0, addend_address};
        end
    endgenerate

endmodule
