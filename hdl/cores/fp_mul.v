// Floating-point product, rounded to nearest, ties to even.
//
// The significands are multiplied as they are; zeros at the top, which only a
// subnormal operand brings, are counted in that operand while the multiplier
// works. One shift then does both what they ask for and what a subnormal
// result needs: seen from the left end it always goes to the right. Without
// subnormal numbers there is no such shift, and the operator is a third of
// the size. The contract is in docs/floating-point.md.
//
// Registers directly at the multiplier's inputs and outputs can be taken into
// a DSP block; there are two cuts on each side, for a register in the block
// and one on the way to it. Significands that are wider than a block are cut
// into pieces; the products of the pieces are added up behind the first cut
// of the product, beside the amount of the shift.
//
// Operands come late in a clock, out of a block memory, so nothing stands
// before the first cut and a single look-up table before the second: which
// fours of an exponent's bits have a one, which the multiplier must know. What
// makes an operand special is found beside the multiplier, what the exponent
// says of the result beside the shift.
//
// Parameters
//   EXPONENT, MANTISSA   the format: a word is sign, exponent, mantissa.
//   SUBNORMALS  1: kept; 0: such operands count as zero, and a result below
//               the least normal number before it is rounded becomes zero.
//   BLOCK       bits of the widest factor of a multiplier block.
//   CUTS        bit i: a register at cut i: 0, 1 operands, 2, 3 product;
//               then one behind each of the ($clog2(2*MANTISSA+4)+1)/2 levels
//               of the shift, or only one without subnormal numbers; then 1
//               behind the choice of the leading bit, and 3 in the rounding,
//               the last at the result.
//   EXTRA       registers behind the result.
// Ports
//   enable      low holds every register.
//   left, right, result   words; the result comes as many enabled clocks
//               after its operands as CUTS has ones, and EXTRA more.

module fp_mul #(
    parameter EXPONENT = 8,
    parameter MANTISSA = 23,
    parameter SUBNORMALS = 1,
    parameter BLOCK = 27,
    parameter [63:0] CUTS = 0,
    parameter EXTRA = 0
) (
    input                        clock,
    input                        enable,
    input  [EXPONENT+MANTISSA:0] left,
    input  [EXPONENT+MANTISSA:0] right,
    output [EXPONENT+MANTISSA:0] result
);
    localparam E = EXPONENT;
    localparam M = MANTISSA;
    localparam PRODUCT = 2 * M + 2;
    localparam COUNT = $clog2(M + 1);
    // Bits of the shift: all ones drop the whole product.
    localparam AMOUNT = $clog2(PRODUCT + 2);
    localparam LEVELS = SUBNORMALS != 0 ? (AMOUNT + 1) / 2 : 1;
    // Exponents with a sign, wide enough for counts too.
    localparam WIDE = (E > AMOUNT ? E : AMOUNT) + 2;
    localparam [WIDE-1:0] ONES = {{(WIDE - E) {1'b0}}, {E{1'b1}}};
    localparam [WIDE-1:0] BIAS = ONES >> 1;
    // What decides the rounding: a significand, the bit above it that may be
    // zero, and the guard bit.
    localparam WINDOW = M + 3;
    // Pieces of a significand, and bits of a piece; of the products of the
    // pieces, or of the one product.
    localparam PIECES = (M + BLOCK) / BLOCK;
    localparam PIECE = (M + PIECES) / PIECES;
    localparam PARTIAL = PIECES == 1 ? PRODUCT : PIECES * PIECES * 2 * PIECE;

    localparam CUT_SHIFT = 4;
    localparam CUT_LEADING = CUT_SHIFT + LEVELS;
    localparam CUT_PACK = CUT_LEADING + 1;

    // Operands.
    localparam FOURS = (E + 3) / 4;
    localparam WORDS = 2 * (E + M + 1);
    localparam OPERANDS = WORDS + 2 * FOURS;
    wire [E+M:0]        left_0;
    wire [E+M:0]        right_0;
    wire                left_sign;
    wire                right_sign;
    wire [FOURS-1:0]    left_fours;
    wire [FOURS-1:0]    right_fours;
    wire [FOURS-1:0]    left_set;
    wire [FOURS-1:0]    right_set;
    wire [E-1:0]        left_exponent;
    wire [E-1:0]        right_exponent;
    wire [M-1:0]        left_fraction;
    wire [M-1:0]        right_fraction;
    pipeline_cut #(
        .WIDTH(WORDS),
        .REGISTERED(CUTS[0])
    ) operands_cut (
        .clock(clock),
        .enable(enable),
        .from({left, right}),
        .to({left_0, right_0})
    );
    genvar four;
    generate
        for (four = 0; four < FOURS; four = four + 1) begin : exponents
            localparam LOW = M + 4 * four;
            localparam HIGH = LOW + 3 < M + E ? LOW + 3 : M + E - 1;
            assign left_fours[four] = |left_0[HIGH:LOW];
            assign right_fours[four] = |right_0[HIGH:LOW];
        end
    endgenerate
    pipeline_cut #(
        .WIDTH(OPERANDS),
        .REGISTERED(CUTS[1])
    ) factors_cut (
        .clock(clock),
        .enable(enable),
        .from({left_fours, left_0, right_fours, right_0}),
        .to({left_set, left_sign, left_exponent, left_fraction,
             right_set, right_sign, right_exponent, right_fraction})
    );

    // Special operands.
    localparam FLAGS = 4;
    wire left_least = ~|left_set;
    wire right_least = ~|right_set;
    wire left_behind = |left_fraction;
    wire right_behind = |right_fraction;
    wire left_most = &left_exponent;
    wire right_most = &right_exponent;
    wire left_zero = left_least & (SUBNORMALS == 0 | ~left_behind);
    wire right_zero = right_least & (SUBNORMALS == 0 | ~right_behind);
    wire nan = (left_most & left_behind) | (right_most & right_behind)
        | (left_most & right_zero) | (right_most & left_zero);
    wire [FLAGS-1:0] flags_1 = {left_sign ^ right_sign, nan, left_most | right_most,
                                left_zero | right_zero};

    // Products of pieces, which lie one behind the other.
    wire [M:0] left_1 = {~left_least, left_fraction};
    wire [M:0] right_1 = {~right_least, right_fraction};
    wire [PARTIAL-1:0] partial;
    wire [PARTIAL-1:0] partial_2;
    wire [PRODUCT-1:0] product_2;
    genvar i, j;
    generate
        if (PIECES == 1) begin : whole
            assign partial = left_1 * right_1;
            assign product_2 = partial_2;
        end else begin : pieces
            wire [PIECES*PIECE+M:0] left_padded = {{(PIECES * PIECE) {1'b0}}, left_1};
            wire [PIECES*PIECE+M:0] right_padded = {{(PIECES * PIECE) {1'b0}}, right_1};
            wire unused_padding = &{1'b0, left_padded, right_padded};
            for (i = 0; i < PIECES; i = i + 1) begin : row
                for (j = 0; j < PIECES; j = j + 1) begin : place
                    localparam AT = (i * PIECES + j) * 2 * PIECE;
                    wire [PIECE-1:0] one = left_padded[i*PIECE+:PIECE];
                    wire [PIECE-1:0] other = right_padded[j*PIECE+:PIECE];
                    assign partial[AT+:2*PIECE] = one * other;
                end
            end
            // Their sum.
            reg [PRODUCT+2*PIECE-1:0] sum;
            integer at;
            always @* begin
                sum = {(PRODUCT + 2 * PIECE) {1'b0}};
                for (at = 0; at < PIECES * PIECES; at = at + 1)
                    sum = sum + ({{PRODUCT{1'b0}}, partial_2[at*2*PIECE+:2*PIECE]}
                        << (PIECE * (at / PIECES + at % PIECES)));
            end
            wire unused = &{1'b0, sum[PRODUCT+2*PIECE-1:PRODUCT]};
            assign product_2 = sum[PRODUCT-1:0];
        end
    endgenerate

    // The product's exponent (of the second highest bit), and zeros at the top
    // of the one operand that may be subnormal, whose exponent counts as 1.
    wire [WIDE-1:0] exponent = {{(WIDE - E) {1'b0}}, left_exponent[E-1:1],
                                left_exponent[0] | left_least}
        + {{(WIDE - E) {1'b0}}, right_exponent[E-1:1], right_exponent[0] | right_least} - BIAS;
    wire [COUNT-1:0] zeros;
    generate
        if (SUBNORMALS != 0) begin : counted
            wire [M:0] unused_shifted;
            wire unused_nonzero;
            wire unused_companion;
            fp_normalise #(
                .WIDTH(M + 1),
                .LIMITED(0)
            ) counter (
                .clock(clock),
                .enable(enable),
                .value(left_1[M] ? right_1 : left_1),
                .limit({COUNT{1'b0}}),
                .payload(1'b0),
                .shifted(unused_shifted),
                .count(zeros),
                .nonzero(unused_nonzero),
                .companion(unused_companion)
            );
        end else begin : none
            assign zeros = {COUNT{1'b0}};
        end
    endgenerate

    wire [WIDE-1:0]    exponent_2;
    wire [COUNT-1:0]   zeros_2;
    wire [FLAGS-1:0]   flags_2;
    pipeline_cut #(
        .WIDTH(PARTIAL + WIDE + COUNT + FLAGS),
        .REGISTERED(CUTS[2])
    ) product_cut (
        .clock(clock),
        .enable(enable),
        .from({partial, exponent, zeros, flags_1}),
        .to({partial_2, exponent_2, zeros_2, flags_2})
    );

    // The shift to the left that takes the zeros away, or as much of it as
    // the exponent allows, is a shift to the right seen from the other end.
    wire [WIDE-1:0]   base;
    wire [AMOUNT-1:0] amount;
    generate
        if (SUBNORMALS != 0) begin : shift_amount
            localparam [WIDE-1:0] MOST = M;
            wire [WIDE-1:0] wide_zeros = {{(WIDE - COUNT) {1'b0}}, zeros_2};
            wire [WIDE-1:0] left_over = exponent_2 - wide_zeros;
            wire limited = left_over[WIDE-1];
            // Both differences beside each other: chains in a row are slow.
            wire [WIDE-1:0] free = MOST - wide_zeros;
            wire [WIDE-1:0] bound = MOST - exponent_2;
            wire unused = &{1'b0, free};
            assign base = left_over & {WIDE{~limited}};
            assign amount = limited
                ? bound[AMOUNT-1:0] | {AMOUNT{|bound[WIDE-1:AMOUNT]}} : free[AMOUNT-1:0];
        end else begin : no_shift
            wire unused = &{1'b0, zeros_2};
            assign base = exponent_2;
            assign amount = {AMOUNT{1'b0}};
        end
    endgenerate

    wire [PRODUCT-1:0] product_3;
    wire [WIDE-1:0]    base_3;
    wire [AMOUNT-1:0]  amount_3;
    wire [FLAGS-1:0]   flags_3;
    pipeline_cut #(
        .WIDTH(PRODUCT + WIDE + AMOUNT + FLAGS),
        .REGISTERED(CUTS[3])
    ) amount_cut (
        .clock(clock),
        .enable(enable),
        .from({product_2, base, amount, flags_2}),
        .to({product_3, base_3, amount_3, flags_3})
    );

    // What the base says of the result, with the leading bit the second
    // highest, and with it the highest, where the exponent is one more.
    localparam SIDE = 2 * E + 4 + FLAGS;
    wire [E-1:0]    one = {{(E - 1) {1'b0}}, 1'b1};
    wire [SIDE-1:0] side_3 = {base_3[E-1:0] + one, base_3[E-1:0],
                              base_3[WIDE-1] | ~|base_3, base_3[WIDE-1],
                              ~base_3[WIDE-1] & base_3 >= ONES,
                              ~base_3[WIDE-1] & base_3 >= ONES - 1, flags_3};

    wire [WINDOW-1:0] window;
    wire              sticky;
    wire [E-1:0]      raised_4;
    wire [E-1:0]      kept_4;
    wire              least_4;
    wire              negative_4;
    wire              above_4;
    wire              above_raised_4;
    wire [FLAGS-1:0]  flags_4;
    generate
        if (SUBNORMALS != 0) begin : shift
            wire [PRODUCT:0] shifted;
            wire             dropped;
            wire             unused = &{1'b0, shifted[PRODUCT:WINDOW]};
            fp_shift_right #(
                .WIDTH(PRODUCT + 1),
                .AMOUNT(AMOUNT),
                .PAYLOAD(SIDE),
                .CUTS(CUTS >> CUT_SHIFT & (64'd1 << LEVELS) - 64'd1)
            ) shifter (
                .clock(clock),
                .enable(enable),
                .value({product_3, 1'b0}),
                .amount(amount_3),
                .payload(side_3),
                .shifted(shifted),
                .sticky(dropped),
                .companion({raised_4, kept_4, least_4, negative_4, above_4, above_raised_4,
                            flags_4})
            );
            assign window = shifted[WINDOW-1:0];
            assign sticky = dropped;
        end else begin : straight
            wire unused = &{1'b0, amount_3};
            // The lowest M - 1 bits, of which there may be none.
            wire [M-1:0] rest = product_3[M-1:0] & {M{1'b1}} >> 1;
            pipeline_cut #(
                .WIDTH(WINDOW + 1 + SIDE),
                .REGISTERED(CUTS[CUT_SHIFT])
            ) sticky_cut (
                .clock(clock),
                .enable(enable),
                .from({product_3[PRODUCT-1:M-1], |rest, side_3}),
                .to({window, sticky, raised_4, kept_4, least_4, negative_4, above_4,
                     above_raised_4, flags_4})
            );
        end
    endgenerate

    // The leading bit is the highest or the second highest; with a base of
    // zero nothing may move any more.
    wire top = window[WINDOW-1];
    wire stays = top | (SUBNORMALS != 0 & least_4);
    wire [M-1:0] fraction = stays ? window[M+1:2] : window[M:1];
    wire guard = stays ? window[1] : window[0];
    wire below = negative_4 | (~top & least_4);
    wire above = above_4 | (top & above_raised_4);
    wire [E-1:0] final_exponent = top ? raised_4 : kept_4;
    wire zero = flags_4[0] | (SUBNORMALS == 0 & below);

    wire [E-1:0] exponent_5;
    wire [M-1:0] fraction_5;
    wire         guard_5;
    wire         sticky_5;
    wire [3:0]   flags_5;
    pipeline_cut #(
        .WIDTH(E + M + 2 + FLAGS),
        .REGISTERED(CUTS[CUT_LEADING])
    ) leading_cut (
        .clock(clock),
        .enable(enable),
        .from({final_exponent, fraction, guard, sticky | (stays & window[0]), flags_4[3:2],
               flags_4[1] | above, zero}),
        .to({exponent_5, fraction_5, guard_5, sticky_5, flags_5})
    );

    fp_pack #(
        .EXPONENT(E),
        .MANTISSA(M),
        .CUTS(CUTS >> CUT_PACK),
        .EXTRA(EXTRA)
    ) rounding (
        .clock(clock),
        .enable(enable),
        .sign(flags_5[3]),
        .exponent(exponent_5),
        .fraction(fraction_5),
        .guard(guard_5),
        .sticky(sticky_5),
        .nan(flags_5[2]),
        .infinite(flags_5[1]),
        .zero(flags_5[0]),
        .result(result)
    );
endmodule
