// A shift to the right that remembers whether ones were dropped.
//
// Two bits of the amount are used per level, the highest first: a choice of
// four is one six-input look-up table per bit. Coarse steps come first,
// because the many bits they drop take longest to collect.
//
// Parameters
//   WIDTH    bits of the value.
//   AMOUNT   bits of the amount; 2^AMOUNT - 1 >= WIDTH is not needed: what is
//            shifted beyond the end is dropped.
//   PAYLOAD  bits that travel beside the value, at least 1.
//   CUTS     bit j: a register behind level j, of (AMOUNT + 1) / 2 levels.
// Ports
//   value, amount, payload   what is shifted, how far, what travels along.
//   shifted, sticky          value >> amount; whether ones were dropped.
//   companion                the payload, as late as the result.

module fp_shift_right #(
    parameter WIDTH = 26,
    parameter AMOUNT = 5,
    parameter PAYLOAD = 1,
    parameter [63:0] CUTS = 0
) (
    input                clock,
    input                enable,
    input  [WIDTH-1:0]   value,
    input  [AMOUNT-1:0]  amount,
    input  [PAYLOAD-1:0] payload,
    output [WIDTH-1:0]   shifted,
    output               sticky,
    output [PAYLOAD-1:0] companion
);
    localparam LEVELS = (AMOUNT + 1) / 2;

    genvar j;
    generate
        for (j = 0; j < LEVELS; j = j + 1) begin : level
            // The lowest bit of the amount that this level uses; an odd one
            // is left alone for the last level.
            localparam BIT = AMOUNT - 2 * (j + 1) < 0 ? 0 : AMOUNT - 2 * (j + 1);
            localparam DIGIT = AMOUNT - 2 * (j + 1) < 0 ? 1 : 2;
            localparam UNIT = 1 << BIT;

            wire [WIDTH-1:0]   value_in;
            wire [AMOUNT-1:0]  amount_in;
            wire               sticky_in;
            wire [PAYLOAD-1:0] payload_in;
            wire [WIDTH-1:0]   value_out;
            wire [AMOUNT-1:0]  amount_out;
            wire               sticky_out;
            wire [PAYLOAD-1:0] payload_out;

            if (j == 0) begin : first
                assign value_in = value;
                assign amount_in = amount;
                assign sticky_in = 1'b0;
                assign payload_in = payload;
            end else begin : next
                assign value_in = level[j-1].value_out;
                assign amount_in = level[j-1].amount_out;
                assign sticky_in = level[j-1].sticky_out;
                assign payload_in = level[j-1].payload_out;
            end

            // What a shift by one, two and three units drops, group by group.
            wire [4*UNIT+WIDTH-1:0] padded = {{(4 * UNIT) {1'b0}}, value_in};
            wire unused = &{1'b0, padded, amount_out};
            wire [1:0] digit;
            wire [2:0] group;
            assign group[0] = |padded[UNIT-1:0];
            if (DIGIT == 2) begin : four_ways
                assign digit = amount_in[BIT+1:BIT];
                assign group[1] = |padded[2*UNIT-1:UNIT];
                assign group[2] = |padded[3*UNIT-1:2*UNIT];
            end else begin : two_ways
                assign digit = {1'b0, amount_in[0]};
                assign group[2:1] = 2'b00;
            end
            wire dropped = (digit != 2'd0 & group[0]) | (digit[1] & group[1]) | (&digit & group[2]);
            wire [WIDTH-1:0] moved =
                digit == 2'd0 ? padded[WIDTH-1:0] :
                digit == 2'd1 ? padded[UNIT+WIDTH-1:UNIT] :
                digit == 2'd2 ? padded[2*UNIT+WIDTH-1:2*UNIT] :
                                padded[3*UNIT+WIDTH-1:3*UNIT];

            pipeline_cut #(
                .WIDTH(WIDTH + AMOUNT + 1 + PAYLOAD),
                .REGISTERED(CUTS[j])
            ) cut (
                .clock(clock),
                .enable(enable),
                .from({moved, amount_in, sticky_in | dropped, payload_in}),
                .to({value_out, amount_out, sticky_out, payload_out})
            );
        end
    endgenerate

    assign shifted = level[LEVELS-1].value_out;
    assign sticky = level[LEVELS-1].sticky_out;
    assign companion = level[LEVELS-1].payload_out;
endmodule
