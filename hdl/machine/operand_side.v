// The memory of one operand side of a processing element: one read and
// WRITES writes per cycle.
//
// With one write port a cycle is one clock and the memory is a block memory
// as it is: the read of a cycle sees what was there before the write of the
// same cycle. With more write ports a cycle has as many clocks: the first
// reads and writes through port 0, each further one writes through the next
// port, and the word read waits in a register for the end of the cycle.
//
// Parameters
//   WIDTH, ADDRESS, INITIAL, IMAGE   as simple_dual_port_memory
//   WRITES       write ports, and clocks of a cycle
//   PHASE_BITS   bits that count the clocks of a cycle
//
// Ports
//   advance, phase   as sequencer
//   read_address     the operand's word
//   write, write_address, write_data   write ports, port 0 lowest
//   host_access      the host reads or writes this clock; all else is idle
//   host_write       the host writes the word on port 0 of `write_data`
//   host_address     where; 0 in all other clocks
//   host_word        the word the host has read, one clock later
//   operand          the operand, in the next cycle
module operand_side #(
    parameter WIDTH = 32,
    parameter ADDRESS = 10,
    parameter WRITES = 1,
    parameter PHASE_BITS = 1,
    parameter INITIAL = 0,
    parameter IMAGE = "image"
) (
    input                       clock,
    input                       advance,
    input  [PHASE_BITS-1:0]     phase,
    input  [ADDRESS-1:0]        read_address,
    input  [WRITES-1:0]         write,
    input  [WRITES*ADDRESS-1:0] write_address,
    input  [WRITES*WIDTH-1:0]   write_data,
    input                       host_access,
    input                       host_write,
    input  [ADDRESS-1:0]        host_address,
    output [WIDTH-1:0]          host_word,
    output [WIDTH-1:0]          operand
);

    wire               port_write;
    wire [ADDRESS-1:0] port_address;
    wire [WIDTH-1:0]   port_data;
    wire               port_read;

    // A program's fields are zero while the host is at work, and the host's
    // address is zero while a program runs: an OR tells them apart.
    simple_dual_port_memory #(
        .WIDTH(WIDTH),
        .ADDRESS(ADDRESS),
        .INITIAL(INITIAL),
        .IMAGE(IMAGE)
    ) words (
        .clock(clock),
        .write(port_write | host_write),
        .write_address(port_address | host_address),
        .write_data(port_data),
        .read(port_read),
        .read_address(read_address | host_address),
        .read_data(host_word)
    );

    generate
        if (WRITES == 1) begin : single
            assign port_write = write[0];
            assign port_address = write_address;
            assign port_data = write_data;
            assign port_read = 1'b1;
            assign operand = host_word;
            wire unused = &{1'b0, advance, phase, host_access};
        end else begin : several
            reg [WIDTH-1:0] held;
            assign port_write = write[phase];
            assign port_address = write_address[phase*ADDRESS +: ADDRESS];
            assign port_data = host_write ? write_data[0 +: WIDTH]
                                          : write_data[phase*WIDTH +: WIDTH];
            assign port_read = (phase == 0) | host_access;
            assign operand = held;
            always @(posedge clock)
                if (advance) held <= host_word;
        end
    endgenerate

endmodule
