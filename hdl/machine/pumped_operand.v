// Keeps an operand of a pumped memory for the cycle after the one that read
// it. The memory shows the word in the second clock of a cycle only, since
// the clocks after the first one write.
//
// With two clocks per cycle one register is enough: it takes the word at the
// end of the cycle. With more, a first register takes it at the end of the
// second clock, and a second one at the end of the cycle.
//
// Ports: `word` is what the memory shows, `operand` the operand of the
// previous cycle's instruction; the rest as sequencer.
module pumped_operand #(
    parameter WIDTH = 32,
    parameter PHASES = 2,
    parameter PHASE_BITS = 1
) (
    input                   clock,
    input                   advance,
    input  [PHASE_BITS-1:0] phase,
    input  [WIDTH-1:0]      word,
    output [WIDTH-1:0]      operand
);

    reg [WIDTH-1:0] held;
    assign operand = held;

    generate
        if (PHASES == 2) begin : double
            wire unused = &{1'b0, phase};
            always @(posedge clock)
                if (advance) held <= word;
        end else begin : longer
            reg [WIDTH-1:0] taken;
            always @(posedge clock) begin
                if (phase == 1) taken <= word;
                if (advance) held <= taken;
            end
        end
    endgenerate

endmodule
