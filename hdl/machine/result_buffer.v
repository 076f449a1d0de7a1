// The buffer of a processing element: it takes the element's own results and
// shows them to the crossbar in later cycles.
//
// It is read without a clock, so that a result written in one cycle can be on
// the crossbar in the next; the logic cells' own memory does that. One copy per
// read port, all written alike.
//
// Which kind of memory it is follows from the reading, in every vendor's
// tools. Quartus is told besides, by an attribute that other tools take for a
// kind of memory their devices lack, so only Quartus sees it.
//
// Parameters
//   WIDTH     bits of a word
//   ADDRESS   bits of an address; there are 2**ADDRESS words
//   READS     read ports
//
// Ports
//   advance          high in the last clock of a cycle, at whose end is written
//   write, write_address, result   the word on the element's bus
//   read_address     one address per read port, port 0 lowest
//   words            what the ports show in this cycle
module result_buffer #(
    parameter WIDTH = 32,
    parameter ADDRESS = 4,
    parameter READS = 1
) (
    input                      clock,
    input                      advance,
    input                      write,
    input  [ADDRESS-1:0]       write_address,
    input  [WIDTH-1:0]         result,
    input  [READS*ADDRESS-1:0] read_address,
    output [READS*WIDTH-1:0]   words
);

    genvar port;
    generate
        for (port = 0; port < READS; port = port + 1) begin : ports
`ifdef ROBOVEC_ALTSYNCRAM
            (* ramstyle = "MLAB, no_rw_check" *)
`endif
            reg [WIDTH-1:0] memory [0:(1 << ADDRESS)-1];
            assign words[port*WIDTH +: WIDTH] =
                memory[read_address[port*ADDRESS +: ADDRESS]];
            always @(posedge clock)
                if (write & advance) memory[write_address] <= result;
        end
    endgenerate

endmodule
