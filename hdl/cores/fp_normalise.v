// A shift to the left until the leading one stands at the top, but by no more
// than a limit.
//
// Counting zeros and shifting go together, two bits of the count at a time,
// the highest first: whether the first groups of bits are all zero decides
// how far the value moves, and what has moved decides the next two bits. So
// no counter of its own is needed. The limit, which keeps the exponent of a
// subnormal result from falling below the least one, is compared digit by
// digit on the way, as numbers are compared that are written down.
//
// A value of zero moves as far as the digits allow; its count means nothing.
//
// Parameters
//   WIDTH    bits of the value, at least 2.
//   LIMITED  1: `limit` counts; 0: it is ignored.
//   PAYLOAD  bits that travel beside the value, at least 1.
//   CUTS     bits 2j and 2j+1: a register behind the choice of digit j, and
//            behind the shift by it, of ($clog2(WIDTH) + 1) / 2 digits.
// Ports
//   value, limit, payload   what is shifted, at most how far, what travels
//                           along.
//   shifted, count          value << count with count = min(zeros, limit).
//   nonzero                 whether the value has a one at all.
//   companion               the payload, as late as the result.

module fp_normalise #(
    parameter WIDTH = 28,
    parameter LIMITED = 1,
    parameter PAYLOAD = 1,
    parameter [63:0] CUTS = 0,
    // Derived; not to be set.
    parameter COUNT = $clog2(WIDTH)
) (
    input                clock,
    input                enable,
    input  [WIDTH-1:0]   value,
    input  [COUNT-1:0]   limit,
    input  [PAYLOAD-1:0] payload,
    output [WIDTH-1:0]   shifted,
    output [COUNT-1:0]   count,
    output               nonzero,
    output [PAYLOAD-1:0] companion
);
    localparam DIGITS = (COUNT + 1) / 2;
    localparam SIDE = COUNT + 1 + PAYLOAD;

    genvar j;
    generate
        for (j = 0; j < DIGITS; j = j + 1) begin : level
            localparam BIT = COUNT - 2 * (j + 1) < 0 ? 0 : COUNT - 2 * (j + 1);
            localparam TWO = COUNT - 2 * (j + 1) < 0 ? 0 : 1;
            localparam UNIT = 1 << BIT;
            localparam PADDED = WIDTH + 4 * UNIT;

            wire [WIDTH-1:0]   value_in;
            wire [COUNT-1:0]   count_in;
            wire [COUNT-1:0]   limit_in;
            // `less`: the digits so far are less than those of the limit, so
            // it no longer matters. `cap` is the highest digit allowed here.
            // Where a digit was cut short, more zeros are left than all
            // lower digits can ask for, and these meet their caps by
            // themselves.
            wire               less_in;
            wire [1:0]         cap_in;
            wire               nonzero_in;
            wire [PAYLOAD-1:0] payload_in;
            wire [WIDTH-1:0]   value_out;
            wire [COUNT-1:0]   count_out;
            wire [COUNT-1:0]   limit_out;
            wire               less_out;
            wire [1:0]         cap_out;
            wire               nonzero_out;
            wire [PAYLOAD-1:0] payload_out;

            if (j == 0) begin : first
                assign value_in = value;
                assign count_in = {COUNT{1'b0}};
                assign limit_in = limit;
                assign less_in = LIMITED == 0;
                assign cap_in = {2{less_in}} | {TWO != 0 & limit[BIT+TWO], limit[BIT]};
                assign nonzero_in = |value;
                assign payload_in = payload;
            end else begin : next
                assign value_in = level[j-1].value_out;
                assign count_in = level[j-1].count_out;
                assign limit_in = level[j-1].limit_out;
                assign less_in = level[j-1].less_out;
                assign cap_in = level[j-1].cap_out;
                assign nonzero_in = level[j-1].nonzero_out;
                assign payload_in = level[j-1].payload_out;
            end

            // The digit that the value asks for, and the one it gets: three
            // groups and the cap fit one look-up table.
            wire [PADDED-1:0] padded = {value_in, {(4 * UNIT) {1'b0}}};
            wire unused = &{1'b0, padded, place, limit_out, less_out, cap_out};
            wire [1:0] wanted;
            if (TWO != 0) begin : four_ways
                wire [2:0] group;
                assign group[0] = |padded[PADDED-1-:UNIT];
                assign group[1] = |padded[PADDED-1-UNIT-:UNIT];
                assign group[2] = |padded[PADDED-1-2*UNIT-:UNIT];
                assign wanted[1] = ~group[0] & ~group[1];
                assign wanted[0] = ~group[0] & (group[1] | ~group[2]);
            end else begin : two_ways
                assign wanted = {1'b0, ~value_in[WIDTH-1]};
            end
            // Comparisons of two bits, spelt out to keep them off carry chains.
            wire more = (wanted[1] & ~cap_in[1])
                | ((wanted[1] | ~cap_in[1]) & wanted[0] & ~cap_in[0]);
            wire [1:0] digit = more ? cap_in : wanted;
            wire [COUNT+1:0] place = {{COUNT{1'b0}}, digit} << BIT;

            wire [WIDTH-1:0]   value_held;
            wire [COUNT-1:0]   limit_held;
            wire [1:0]         digit_held;
            wire [1:0]         cap_held;
            wire               less_held;
            wire [SIDE-1:0]    side_held;
            pipeline_cut #(
                .WIDTH(WIDTH + COUNT + 5 + SIDE),
                .REGISTERED(CUTS[2*j])
            ) choice_cut (
                .clock(clock),
                .enable(enable),
                .from({value_in, limit_in, digit, cap_in, less_in, count_in | place[COUNT-1:0],
                       nonzero_in, payload_in}),
                .to({value_held, limit_held, digit_held, cap_held, less_held, side_held})
            );

            wire [WIDTH-1:0] moved =
                digit_held == 2'd0 ? value_held :
                digit_held == 2'd1 ? value_held << UNIT :
                digit_held == 2'd2 ? value_held << (2 * UNIT) :
                                     value_held << (3 * UNIT);
            wire less = less_held | (~digit_held[1] & cap_held[1])
                | ((~digit_held[1] | cap_held[1]) & ~digit_held[0] & cap_held[0]);
            wire [1:0] cap;
            if (BIT == 0) begin : last
                assign cap = 2'b00;
            end else if (BIT == 1) begin : last_but_one
                assign cap = {1'b0, less | limit_held[0]};
            end else begin : preceding
                assign cap = {2{less}} | limit_held[BIT-1:BIT-2];
            end
            pipeline_cut #(
                .WIDTH(WIDTH + COUNT + 3 + SIDE),
                .REGISTERED(CUTS[2*j+1])
            ) shift_cut (
                .clock(clock),
                .enable(enable),
                .from({moved, limit_held, cap, less, side_held}),
                .to({value_out, limit_out, cap_out, less_out, count_out, nonzero_out, payload_out})
            );
        end
    endgenerate

    assign shifted = level[DIGITS-1].value_out;
    assign count = level[DIGITS-1].count_out;
    assign nonzero = level[DIGITS-1].nonzero_out;
    assign companion = level[DIGITS-1].payload_out;
endmodule
