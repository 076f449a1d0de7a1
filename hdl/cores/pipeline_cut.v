// A place where a pipeline may be cut.
//
// The operators are written once, for every latency: between their steps
// stand cuts, and a parameter says which of them hold a register. What is
// chosen decides latency and clock and never the results.
//
// Parameters
//   WIDTH       bits that pass.
//   REGISTERED  1: a register; 0: wires.
// Ports
//   clock, enable   the register takes `from` at a rising edge with enable
//                   high, and holds otherwise.
//   from, to        what passes.

module pipeline_cut #(
    parameter WIDTH = 1,
    parameter REGISTERED = 0
) (
    input              clock,
    input              enable,
    input  [WIDTH-1:0] from,
    output [WIDTH-1:0] to
);
    generate
        if (REGISTERED != 0) begin : registered
            reg [WIDTH-1:0] held;
            always @(posedge clock) if (enable) held <= from;
            assign to = held;
        end else begin : transparent
            wire unused = &{1'b0, clock, enable};
            assign to = from;
        end
    endgenerate
endmodule
