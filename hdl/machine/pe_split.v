// The operand memories of a processing element, split by side: the left and
// the right operand have a memory of their own, each with one read and one
// write port. Two words are read and two written per cycle, on one clock; the
// price is that an operand must lie in the memory of its side.
//
// The thesis' true dual-port memory needs twice the clock of the element for
// the same traffic (pe_pumped), which halves what the block memory allows the
// element, and open synthesis has no cell for it.
//
// Ports and parameters: as operand_side, for two sides.
module pe_split #(
    parameter WIDTH = 32,
    parameter ADDRESS = 10,
    parameter WRITES = 1,
    parameter PHASE_BITS = 1,
    parameter INITIAL = 0,
    parameter LEFT_IMAGE = "left",
    parameter RIGHT_IMAGE = "right"
) (
    input                       clock,
    input                       advance,
    input  [PHASE_BITS-1:0]     phase,
    input  [ADDRESS-1:0]        left_address,
    input  [ADDRESS-1:0]        right_address,
    input  [WRITES-1:0]         left_write,
    input  [WRITES*ADDRESS-1:0] left_write_address,
    input  [WRITES*WIDTH-1:0]   left_write_data,
    input  [WRITES-1:0]         right_write,
    input  [WRITES*ADDRESS-1:0] right_write_address,
    input  [WRITES*WIDTH-1:0]   right_write_data,
    input                       host_access,
    input                       host_left_write,
    input                       host_right_write,
    input  [ADDRESS-1:0]        host_address,
    output [WIDTH-1:0]          host_left_word,
    output [WIDTH-1:0]          host_right_word,
    output [WIDTH-1:0]          left,
    output [WIDTH-1:0]          right
);

    operand_side #(
        .WIDTH(WIDTH),
        .ADDRESS(ADDRESS),
        .WRITES(WRITES),
        .PHASE_BITS(PHASE_BITS),
        .INITIAL(INITIAL),
        .IMAGE(LEFT_IMAGE)
    ) left_side (
        .clock(clock),
        .advance(advance),
        .phase(phase),
        .read_address(left_address),
        .write(left_write),
        .write_address(left_write_address),
        .write_data(left_write_data),
        .host_access(host_access),
        .host_write(host_left_write),
        .host_address(host_address),
        .host_word(host_left_word),
        .operand(left)
    );

    operand_side #(
        .WIDTH(WIDTH),
        .ADDRESS(ADDRESS),
        .WRITES(WRITES),
        .PHASE_BITS(PHASE_BITS),
        .INITIAL(INITIAL),
        .IMAGE(RIGHT_IMAGE)
    ) right_side (
        .clock(clock),
        .advance(advance),
        .phase(phase),
        .read_address(right_address),
        .write(right_write),
        .write_address(right_write_address),
        .write_data(right_write_data),
        .host_access(host_access),
        .host_write(host_right_write),
        .host_address(host_address),
        .host_word(host_right_word),
        .operand(right)
    );

endmodule
