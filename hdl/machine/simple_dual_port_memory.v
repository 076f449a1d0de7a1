// A block memory with one write port and one read port on one clock.
//
// A word that is read in the clock in which it is written shows its old
// content: the schedule reads a word for the last time in the very cycle in
// which it is overwritten. Block memories of Cyclone V and its kin do this by
// themselves for two ports on one clock ("old data"), so nothing is built
// around them; the attribute `no_rw_check` must therefore never be set here.
//
// Parameters
//   WIDTH     bits of a word
//   ADDRESS   bits of an address; there are 2**ADDRESS words
//   INITIAL   1: the content at configuration is IMAGE.hex; 0: none
//   IMAGE     path of that file without its extension
//
// Ports
//   write, write_address, write_data   written at the next edge
//   read, read_address                 read at the next edge; while `read` is
//                                      low, `read_data` stays
module simple_dual_port_memory #(
    parameter WIDTH = 32,
    parameter ADDRESS = 10,
    parameter INITIAL = 0,
    parameter IMAGE = "image"
) (
    input                    clock,
    input                    write,
    input      [ADDRESS-1:0] write_address,
    input      [WIDTH-1:0]   write_data,
    input                    read,
    input      [ADDRESS-1:0] read_address,
    output reg [WIDTH-1:0]   read_data
);

`ifdef ROBOVEC_ALTSYNCRAM
    (* ramstyle = "M10K" *)
`endif
    reg [WIDTH-1:0] memory [0:(1 << ADDRESS)-1];

    generate
        if (INITIAL != 0) begin : loaded
            initial $readmemh({IMAGE, ".hex"}, memory);
        end
    endgenerate

    always @(posedge clock) begin
        if (write) memory[write_address] <= write_data;
        if (read) read_data <= memory[read_address];
    end

endmodule
