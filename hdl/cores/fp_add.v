// Floating-point sum or difference, rounded to nearest, ties to even.
//
// One path: the larger operand keeps its place, the other is shifted
// down to it, they are added or subtracted, and the sum is shifted up until
// its leading one is at the top. Ordering the operands first keeps every
// difference positive. The contract (subnormal numbers, signs of zeros, NaN)
// is in docs/floating-point.md.
//
// A subnormal operand has the exponent of the least normal number, though its
// field says one less. Instead of correcting the field before the comparison,
// a subnormal smaller operand is taken at twice its significand when the
// larger one is normal, which the multiplexer that orders them does for free.
//
// Parameters
//   EXPONENT, MANTISSA   the format: a word is sign, exponent, mantissa.
//   SUBNORMALS  1: kept; 0: such operands count as zero and such results
//               become zero.
//   CUTS        bit i: a register at cut i. With A = ($clog2(MANTISSA+4)+1)/2
//               levels of alignment and N = ($clog2(MANTISSA+5)+1)/2 digits
//               of normalisation the cuts are: 0 operands, 1 exponents
//               compared, 2 operands ordered, 3.. behind each of the A levels,
//               then 1 in the middle of the sum, 1 behind it, 2N in the
//               normalisation, 3 in the rounding, the last at the result.
//   EXTRA       registers behind the result.
// Ports
//   enable      low holds every register.
//   subtract    1: left - right; 0: left + right.
//   left, right, result   words; the result comes as many enabled clocks
//               after its operands as CUTS has ones, and EXTRA more.

module fp_add #(
    parameter EXPONENT = 8,
    parameter MANTISSA = 23,
    parameter SUBNORMALS = 1,
    parameter [63:0] CUTS = 0,
    parameter EXTRA = 0
) (
    input                        clock,
    input                        enable,
    input                        subtract,
    input  [EXPONENT+MANTISSA:0] left,
    input  [EXPONENT+MANTISSA:0] right,
    output [EXPONENT+MANTISSA:0] result
);
    localparam E = EXPONENT;
    localparam M = MANTISSA;
    // Bits of the alignment: a shift by all ones leaves nothing.
    localparam AMOUNT = $clog2(M + 4);
    localparam LEVELS = (AMOUNT + 1) / 2;
    // The sum: carry, significand, guard, round and sticky bit.
    localparam SUM = M + 5;
    localparam HALF = SUM / 2;
    localparam COUNT = $clog2(SUM);
    localparam DIGITS = (COUNT + 1) / 2;

    localparam CUT_ALIGN = 3;
    localparam CUT_SUM = CUT_ALIGN + LEVELS;
    localparam CUT_NORMALISE = CUT_SUM + 2;
    localparam CUT_PACK = CUT_NORMALISE + 2 * DIGITS;

    // Operands.
    wire         left_enters;
    wire         right_enters;
    wire [E-1:0] left_exponent;
    wire [E-1:0] right_exponent;
    wire [M-1:0] left_fraction;
    wire [M-1:0] right_fraction;
    pipeline_cut #(
        .WIDTH(2 * (E + M + 1)),
        .REGISTERED(CUTS[0])
    ) operands_cut (
        .clock(clock),
        .enable(enable),
        .from({left, right[E+M] ^ subtract, right[E+M-1:0]}),
        .to({left_enters, left_exponent, left_fraction,
             right_enters, right_exponent, right_fraction})
    );

    // Comparison.
    wire [E:0] forward = {1'b0, left_exponent} - {1'b0, right_exponent};
    wire [E:0] backward = {1'b0, right_exponent} - {1'b0, left_exponent};

    wire         left_sign;
    wire         right_sign;
    wire [E-1:0] left_exponent_0;
    wire [E-1:0] right_exponent_0;
    wire [M-1:0] left_fraction_0;
    wire [M-1:0] right_fraction_0;
    wire [E:0]   forward_0;
    wire [E:0]   backward_0;
    wire         less;
    wire         left_least;
    wire         right_least;
    wire         left_most;
    wire         right_most;
    wire         left_behind;
    wire         right_behind;
    pipeline_cut #(
        .WIDTH(2 * (E + M + 1) + 2 * (E + 1) + 7),
        .REGISTERED(CUTS[1])
    ) compared_cut (
        .clock(clock),
        .enable(enable),
        .from({left_enters, right_enters, left_exponent, right_exponent, left_fraction,
               right_fraction, forward, backward, left_fraction < right_fraction,
               ~|left_exponent, ~|right_exponent, &left_exponent, &right_exponent,
               |left_fraction, |right_fraction}),
        .to({left_sign, right_sign, left_exponent_0, right_exponent_0, left_fraction_0,
             right_fraction_0, forward_0, backward_0, less, left_least, right_least, left_most,
             right_most, left_behind, right_behind})
    );

    // Ordering.
    wire swap = forward_0[E] | (~backward_0[E] & less);
    wire subtracts = left_sign ^ right_sign;
    wire nan = (left_most & left_behind) | (right_most & right_behind)
        | (left_most & right_most & subtracts);
    wire infinite = left_most | right_most;
    wire large_least = swap ? right_least : left_least;
    wire small_least = swap ? left_least : right_least;
    wire [M-1:0] large_fraction = swap ? right_fraction_0 : left_fraction_0;
    wire [M-1:0] small_fraction = swap ? left_fraction_0 : right_fraction_0;
    wire [E-1:0] large_exponent = swap ? right_exponent_0 : left_exponent_0;
    wire [E-1:0] difference = forward_0[E] ? backward_0[E-1:0] : forward_0[E-1:0];
    wire [M:0] larger;
    wire [M:0] smaller;
    generate
        if (SUBNORMALS != 0) begin : kept
            assign larger = {~large_least, large_fraction};
            assign smaller = small_least & ~large_least ? {small_fraction, 1'b0}
                : {~small_least, small_fraction};
        end else begin : flushed
            assign larger = {~large_least, large_fraction & {M{~large_least}}};
            assign smaller = {~small_least, small_fraction & {M{~small_least}}};
        end
    endgenerate
    wire [AMOUNT-1:0] amount;
    generate
        if (E > AMOUNT) begin : saturated_amount
            assign amount = difference[AMOUNT-1:0] | {AMOUNT{|difference[E-1:AMOUNT]}};
        end else begin : whole_amount
            wire [AMOUNT+E-1:0] padded = {{AMOUNT{1'b0}}, difference};
            assign amount = padded[AMOUNT-1:0];
        end
    endgenerate

    localparam FLAGS = 4;
    wire [M:0]        large_1;
    wire [M:0]        small_1;
    wire [AMOUNT-1:0] amount_1;
    wire [E-1:0]      exponent_1;
    wire [FLAGS-1:0]  flags_1;
    pipeline_cut #(
        .WIDTH(2 * (M + 1) + AMOUNT + E + FLAGS),
        .REGISTERED(CUTS[2])
    ) ordered_cut (
        .clock(clock),
        .enable(enable),
        .from({larger, smaller, amount, large_exponent, swap ? right_sign : left_sign, subtracts,
               nan, infinite}),
        .to({large_1, small_1, amount_1, exponent_1, flags_1})
    );

    // Alignment. Its last cut stands behind the inversion, which the last
    // level's look-up tables do beside the shift.
    localparam [63:0] ALIGN_CUTS = CUTS >> CUT_ALIGN & (64'd1 << (LEVELS - 1)) - 64'd1;
    wire [M+2:0]         aligned;
    wire                 sticky;
    wire [M+E+FLAGS:0]   beside;
    fp_shift_right #(
        .WIDTH(M + 3),
        .AMOUNT(AMOUNT),
        .PAYLOAD(M + 1 + E + FLAGS),
        .CUTS(ALIGN_CUTS)
    ) alignment (
        .clock(clock),
        .enable(enable),
        .value({small_1, 2'b00}),
        .amount(amount_1),
        .payload({large_1, exponent_1, flags_1}),
        .shifted(aligned),
        .sticky(sticky),
        .companion(beside)
    );
    wire inverts = beside[2];
    wire [SUM-1:0]   term;
    wire [M:0]       large_2;
    wire [E-1:0]     exponent_2;
    wire [FLAGS-1:0] flags_2;
    pipeline_cut #(
        .WIDTH(SUM + M + 1 + E + FLAGS),
        .REGISTERED(CUTS[CUT_SUM-1])
    ) aligned_cut (
        .clock(clock),
        .enable(enable),
        .from({{1'b0, aligned, sticky} ^ {SUM{inverts}}, beside}),
        .to({term, large_2, exponent_2, flags_2})
    );

    // Sum, in two halves. The carry into the lowest place completes the
    // two's complement of a term that was inverted.
    wire [SUM-1:0] large_term = {1'b0, large_2, 3'b000};
    wire subtracts_2 = flags_2[2];
    wire [HALF+1:0] low = {1'b0, large_term[HALF-1:0], 1'b1} + {1'b0, term[HALF-1:0], subtracts_2};
    wire [HALF:0]        low_3;
    wire [SUM-1:HALF]    large_3;
    wire [SUM-1:HALF]    term_3;
    wire [E-1:0]         exponent_3;
    wire [FLAGS-1:0]     flags_3;
    pipeline_cut #(
        .WIDTH(HALF + 1 + 2 * (SUM - HALF) + E + FLAGS),
        .REGISTERED(CUTS[CUT_SUM])
    ) half_cut (
        .clock(clock),
        .enable(enable),
        .from({low[HALF+1:1], large_term[SUM-1:HALF], term[SUM-1:HALF], exponent_2, flags_2}),
        .to({low_3, large_3, term_3, exponent_3, flags_3})
    );
    wire [SUM-HALF:0] high = {large_3, 1'b1} + {term_3, low_3[HALF]};
    wire unused_carries = &{1'b0, low[0], high[0]};
    // Both operands subnormal: the exponent is that of the least normal
    // number all the same.
    wire [E-1:0] effective = exponent_3 | {{(E - 1) {1'b0}}, ~|exponent_3};
    wire [COUNT-1:0] limit;
    generate
        if (E > COUNT) begin : saturated_limit
            assign limit = effective[COUNT-1:0] | {COUNT{|effective[E-1:COUNT]}};
        end else begin : whole_limit
            wire [COUNT+E-1:0] padded = {{COUNT{1'b0}}, effective};
            assign limit = padded[COUNT-1:0];
        end
    endgenerate

    wire [SUM-1:0]   sum;
    wire [COUNT-1:0] limit_4;
    wire [E-1:0]     exponent_4;
    wire [FLAGS-1:0] flags_4;
    pipeline_cut #(
        .WIDTH(SUM + COUNT + E + FLAGS),
        .REGISTERED(CUTS[CUT_SUM+1])
    ) sum_cut (
        .clock(clock),
        .enable(enable),
        .from({high[SUM-HALF:1], low_3[HALF-1:0], limit, effective, flags_3}),
        .to({sum, limit_4, exponent_4, flags_4})
    );

    // Normalisation. Only a carry out of the largest exponent overflows
    // before the rounding.
    wire overflows = sum[SUM-1] & (&exponent_4[E-1:1]) & ~exponent_4[0];
    wire [SUM-1:0]   shifted;
    wire [COUNT-1:0] count;
    wire             nonzero;
    wire [E-1:0]     exponent_5;
    wire [FLAGS-1:0] flags_5;
    fp_normalise #(
        .WIDTH(SUM),
        .LIMITED(SUBNORMALS),
        .PAYLOAD(E + FLAGS),
        .CUTS(CUTS >> CUT_NORMALISE)
    ) normalisation (
        .clock(clock),
        .enable(enable),
        .value(sum),
        .limit(limit_4),
        .payload({exponent_4, flags_4[3:1], flags_4[0] | overflows}),
        .shifted(shifted),
        .count(count),
        .nonzero(nonzero),
        .companion({exponent_5, flags_5})
    );

    // Rounding.
    wire top = shifted[SUM-1];
    localparam WIDE = (E > COUNT ? E : COUNT) + 2;
    wire [WIDE-1:0] exact = {{(WIDE - E) {1'b0}}, exponent_5} + {{(WIDE - 1) {1'b0}}, 1'b1}
        - {{(WIDE - COUNT) {1'b0}}, count};
    wire below = exact[WIDE-1] | ~|exact;
    wire sign_5 = flags_5[3];
    wire subtracts_5 = flags_5[2];
    wire vanishes;
    generate
        if (SUBNORMALS != 0) begin : vanishes_exactly
            wire unused = below;
            assign vanishes = 1'b0;
        end else begin : vanishes_below
            assign vanishes = below | ~nonzero;
        end
    endgenerate
    fp_pack #(
        .EXPONENT(E),
        .MANTISSA(M),
        .CUTS(CUTS >> CUT_PACK),
        .EXTRA(EXTRA)
    ) rounding (
        .clock(clock),
        .enable(enable),
        .sign(sign_5 & (nonzero | ~subtracts_5)),
        .exponent(exact[E-1:0] & {E{top}}),
        .fraction(shifted[SUM-2:4]),
        .guard(shifted[3]),
        .sticky(|shifted[2:0]),
        .nan(flags_5[1]),
        .infinite(flags_5[0]),
        .zero(vanishes),
        .result(result)
    );
endmodule
