// A chain of registers: latency beyond what an operator's cuts give.
//
// Parameters
//   WIDTH   bits that pass.
//   STAGES  registers in a row; 0 for wires.
// Ports
//   clock, enable   every register moves on at a rising edge with enable
//                   high, and holds otherwise.
//   from, to        `to` is `from` STAGES enabled clocks ago.

module pipeline_delay #(
    parameter WIDTH = 1,
    parameter STAGES = 0
) (
    input              clock,
    input              enable,
    input  [WIDTH-1:0] from,
    output [WIDTH-1:0] to
);
    genvar index;
    generate
        if (STAGES == 0) begin : none
            wire unused = &{1'b0, clock, enable};
            assign to = from;
        end else begin : some
            for (index = 0; index < STAGES; index = index + 1) begin : stage
                wire [WIDTH-1:0] entering;
                wire [WIDTH-1:0] leaving;
                if (index == 0) begin : first
                    assign entering = from;
                end else begin : next
                    assign entering = stage[index-1].leaving;
                end
                pipeline_cut #(
                    .WIDTH(WIDTH),
                    .REGISTERED(1)
                ) cut (
                    .clock(clock),
                    .enable(enable),
                    .from(entering),
                    .to(leaving)
                );
            end
            assign to = stage[STAGES-1].leaving;
        end
    endgenerate
endmodule
