// Floating-point product and sum in one, rounded once: to nearest, ties to
// even.
//
// The product keeps its place and the addend is shifted to it, through a
// window as wide as both beside each other. An addend too large for the
// window stays at its top, and the product, then below a quarter of its last
// bit, only says that something is there. Differences are formed in two ways
// at once, with and without the carry that completes a two's complement: one
// of them is the result, or its complement where it would be negative. The
// contract is in docs/floating-point.md.
//
// Factors are normalised first: a subnormal factor would leave the product
// with zeros at its top, and bits of the addend that are dropped could matter
// after a cancellation.
//
// Parameters
//   EXPONENT, MANTISSA   the format: a word is sign, exponent, mantissa.
//   SUBNORMALS  1: kept; 0: such operands count as zero, and a result below
//               the least normal number before it is rounded becomes zero.
//   CUTS        bit i: a register at cut i: 0 operands taken apart; with
//               subnormal numbers those of an fp_normalise of MANTISSA + 1
//               bits; then 1 factors, 2 product; one behind each of the
//               ($clog2(3*MANTISSA+6)+1)/2 levels of alignment; 1 in the
//               middle of the sum, 1 behind it, 1 behind the choice of the
//               difference; those of an fp_normalise of 3*MANTISSA + 6 bits;
//               3 in the rounding, the last at the result.
//   EXTRA       registers behind the result.
// Ports
//   enable      low holds every register.
//   operation   0: left*right + addend; 1: left*right - addend;
//               2: addend - left*right.
//   left, right, addend, result   words; the result comes as many enabled
//               clocks after its operands as CUTS has ones, and EXTRA more.

module fp_fma #(
    parameter EXPONENT = 8,
    parameter MANTISSA = 23,
    parameter SUBNORMALS = 1,
    parameter [63:0] CUTS = 0,
    parameter EXTRA = 0
) (
    input                        clock,
    input                        enable,
    input  [1:0]                 operation,
    input  [EXPONENT+MANTISSA:0] left,
    input  [EXPONENT+MANTISSA:0] right,
    input  [EXPONENT+MANTISSA:0] addend,
    output [EXPONENT+MANTISSA:0] result
);
    localparam E = EXPONENT;
    localparam M = MANTISSA;
    localparam PRODUCT = 2 * M + 2;
    // Addend, two places, product; and the sticky bit.
    localparam WINDOW = 3 * M + 5;
    localparam SUM = WINDOW + 1;
    localparam HALF = SUM / 2;
    localparam AMOUNT = $clog2(WINDOW + 1);
    localparam LEVELS = (AMOUNT + 1) / 2;
    localparam COUNT = $clog2(SUM);
    localparam DIGITS = (COUNT + 1) / 2;
    localparam WIDE = (E > COUNT ? E : COUNT) + 3;
    localparam [WIDE-1:0] ONES = {{(WIDE - E) {1'b0}}, {E{1'b1}}};
    localparam [WIDE-1:0] BIAS = ONES >> 1;
    // From the product's exponent to that of the window's top.
    localparam [WIDE-1:0] ABOVE = M + 4;

    localparam CUT_LEADING = 1;
    localparam CUT_FACTORS =
        CUT_LEADING + (SUBNORMALS != 0 ? 2 * (($clog2(M + 1) + 1) / 2) : 0);
    localparam CUT_ALIGN = CUT_FACTORS + 3;
    localparam CUT_SUM = CUT_ALIGN + LEVELS;
    localparam CUT_NORMALISE = CUT_SUM + 3;
    localparam CUT_PACK = CUT_NORMALISE + 2 * DIGITS;

    // Operands.
    wire left_sign, left_zero, left_infinite, left_nan;
    wire right_sign, right_zero, right_infinite, right_nan;
    wire addend_sign, addend_zero, addend_infinite, addend_nan;
    wire [E-1:0] left_exponent, right_exponent, addend_exponent;
    wire [M:0] left_significand, right_significand, addend_significand;
    fp_unpack #(
        .EXPONENT(E),
        .MANTISSA(M),
        .SUBNORMALS(SUBNORMALS)
    ) left_unpack (
        .word(left),
        .sign(left_sign),
        .exponent(left_exponent),
        .significand(left_significand),
        .zero(left_zero),
        .infinite(left_infinite),
        .nan(left_nan)
    );
    fp_unpack #(
        .EXPONENT(E),
        .MANTISSA(M),
        .SUBNORMALS(SUBNORMALS)
    ) right_unpack (
        .word(right),
        .sign(right_sign),
        .exponent(right_exponent),
        .significand(right_significand),
        .zero(right_zero),
        .infinite(right_infinite),
        .nan(right_nan)
    );
    fp_unpack #(
        .EXPONENT(E),
        .MANTISSA(M),
        .SUBNORMALS(SUBNORMALS)
    ) addend_unpack (
        .word(addend),
        .sign(addend_sign),
        .exponent(addend_exponent),
        .significand(addend_significand),
        .zero(addend_zero),
        .infinite(addend_infinite),
        .nan(addend_nan)
    );
    wire product_sign = left_sign ^ right_sign ^ operation[1];
    wire sum_sign = addend_sign ^ operation[0];
    wire subtracts = product_sign ^ sum_sign;
    wire product_infinite = left_infinite | right_infinite;
    wire product_zero = left_zero | right_zero;
    wire nan = left_nan | right_nan | addend_nan | (product_infinite & product_zero)
        | (product_infinite & addend_infinite & subtracts);
    wire infinite = product_infinite | addend_infinite;
    // The sign of a result that has the product's; then whether it may still
    // change; then the special results.
    localparam FLAGS = 4;
    wire [FLAGS-1:0] flags = {
        addend_infinite & ~product_infinite ? sum_sign : product_sign,
        subtracts, nan, infinite};

    wire [E-1:0]     left_exponent_0;
    wire [E-1:0]     right_exponent_0;
    wire [E-1:0]     addend_exponent_0;
    wire [M:0]       left_0;
    wire [M:0]       right_0;
    wire [M:0]       addend_0;
    wire             product_zero_0;
    wire [FLAGS-1:0] flags_0;
    pipeline_cut #(
        .WIDTH(3 * (E + M + 1) + 1 + FLAGS),
        .REGISTERED(CUTS[0])
    ) operands_cut (
        .clock(clock),
        .enable(enable),
        .from({left_exponent, right_exponent, addend_exponent, left_significand,
               right_significand & {(M + 1) {~product_zero}},
               addend_significand & {(M + 1) {~addend_zero}}, product_zero, flags}),
        .to({left_exponent_0, right_exponent_0, addend_exponent_0, left_0, right_0, addend_0,
             product_zero_0, flags_0})
    );

    localparam BESIDE = E + M + 2 + FLAGS;
    wire [WIDE-1:0]   left_true;
    wire [WIDE-1:0]   right_true;
    wire [M:0]        left_leading_1;
    wire [M:0]        right_leading_1;
    wire [BESIDE-1:0] beside_1;
    wire              unused_companion;
    fp_leading #(
        .EXPONENT(E),
        .MANTISSA(M),
        .SUBNORMALS(SUBNORMALS),
        .WIDE(WIDE),
        .PAYLOAD(BESIDE),
        .CUTS(CUTS >> CUT_LEADING)
    ) left_leading (
        .clock(clock),
        .enable(enable),
        .exponent(left_exponent_0),
        .significand(left_0),
        .payload({addend_exponent_0, addend_0, product_zero_0, flags_0}),
        .true_exponent(left_true),
        .leading(left_leading_1),
        .companion(beside_1)
    );
    fp_leading #(
        .EXPONENT(E),
        .MANTISSA(M),
        .SUBNORMALS(SUBNORMALS),
        .WIDE(WIDE),
        .CUTS(CUTS >> CUT_LEADING)
    ) right_leading (
        .clock(clock),
        .enable(enable),
        .exponent(right_exponent_0),
        .significand(right_0),
        .payload(1'b0),
        .true_exponent(right_true),
        .leading(right_leading_1),
        .companion(unused_companion)
    );

    wire [M:0]       left_2;
    wire [M:0]       right_2;
    wire [WIDE-1:0]  top_2;
    wire [E-1:0]     addend_exponent_2;
    wire [M:0]       addend_2;
    wire             product_zero_2;
    wire [FLAGS-1:0] flags_2;
    pipeline_cut #(
        .WIDTH(2 * (M + 1) + WIDE + BESIDE),
        .REGISTERED(CUTS[CUT_FACTORS])
    ) factors_cut (
        .clock(clock),
        .enable(enable),
        .from({left_leading_1, right_leading_1, left_true + right_true + (ABOVE - BIAS),
               beside_1}),
        .to({left_2, right_2, top_2, addend_exponent_2, addend_2, product_zero_2, flags_2})
    );

    // The product, and how far the addend is below the window's top. Where
    // it would be above it, its exponent is the top's.
    wire [PRODUCT-1:0] product = left_2 * right_2;
    wire [WIDE-1:0] wide_addend = {{(WIDE - E) {1'b0}}, addend_exponent_2};
    wire [WIDE-1:0] distance = top_2 - wide_addend;
    wire clamped = distance[WIDE-1] | product_zero_2;

    wire [PRODUCT-1:0] product_3;
    wire [WIDE-1:0]    distance_3;
    wire [WIDE-1:0]    top_3;
    wire               clamped_3;
    wire [E-1:0]       addend_exponent_3;
    wire [M:0]         addend_3;
    wire [FLAGS-1:0]   flags_3;
    pipeline_cut #(
        .WIDTH(PRODUCT + 2 * WIDE + 1 + E + M + 1 + FLAGS),
        .REGISTERED(CUTS[CUT_FACTORS+1])
    ) product_cut (
        .clock(clock),
        .enable(enable),
        .from({product, distance, top_2, clamped, addend_exponent_2, addend_2, flags_2}),
        .to({product_3, distance_3, top_3, clamped_3, addend_exponent_3, addend_3, flags_3})
    );
    wire [AMOUNT-1:0] amount_3 =
        (distance_3[AMOUNT-1:0] | {AMOUNT{|distance_3[WIDE-1:AMOUNT]}}) & {AMOUNT{~clamped_3}};
    wire [WIDE-1:0] exponent_3 =
        clamped_3 ? {{(WIDE - E) {1'b0}}, addend_exponent_3} : top_3;

    wire [PRODUCT-1:0] product_4;
    wire [AMOUNT-1:0]  amount_4;
    wire [WIDE-1:0]    exponent_4;
    wire [M:0]         addend_4;
    wire [FLAGS-1:0]   flags_4;
    pipeline_cut #(
        .WIDTH(PRODUCT + AMOUNT + WIDE + M + 1 + FLAGS),
        .REGISTERED(CUTS[CUT_FACTORS+2])
    ) amount_cut (
        .clock(clock),
        .enable(enable),
        .from({product_3, amount_3, exponent_3, addend_3, flags_3}),
        .to({product_4, amount_4, exponent_4, addend_4, flags_4})
    );

    // Alignment; its last cut stands behind the inversion.
    localparam [63:0] ALIGN_CUTS = CUTS >> CUT_ALIGN & (64'd1 << (LEVELS - 1)) - 64'd1;
    wire [WINDOW-1:0]             aligned;
    wire                          sticky;
    wire [PRODUCT+WIDE+FLAGS-1:0] beside_5;
    fp_shift_right #(
        .WIDTH(WINDOW),
        .AMOUNT(AMOUNT),
        .PAYLOAD(PRODUCT + WIDE + FLAGS),
        .CUTS(ALIGN_CUTS)
    ) alignment (
        .clock(clock),
        .enable(enable),
        .value({addend_4, {(WINDOW - M - 1) {1'b0}}}),
        .amount(amount_4),
        .payload({product_4, exponent_4, flags_4}),
        .shifted(aligned),
        .sticky(sticky),
        .companion(beside_5)
    );
    wire [SUM-1:0]     term_5;
    wire [PRODUCT-1:0] product_5;
    wire [WIDE-1:0]    exponent_5;
    wire [FLAGS-1:0]   flags_5;
    pipeline_cut #(
        .WIDTH(SUM + PRODUCT + WIDE + FLAGS),
        .REGISTERED(CUTS[CUT_SUM-1])
    ) aligned_cut (
        .clock(clock),
        .enable(enable),
        .from({{aligned, sticky} ^ {SUM{beside_5[2]}}, beside_5}),
        .to({term_5, product_5, exponent_5, flags_5})
    );

    // The sum, with a carry into its lowest place and without, in halves.
    wire [SUM-1:0] wide_product = {{(SUM - PRODUCT - 1) {1'b0}}, product_5, 1'b0};
    wire [HALF:0] low_with = {1'b0, wide_product[HALF-1:0]} + {1'b0, term_5[HALF-1:0]}
        + {{HALF{1'b0}}, 1'b1};
    wire [HALF:0] low_without = {1'b0, wide_product[HALF-1:0]} + {1'b0, term_5[HALF-1:0]};
    wire [HALF:0]        low_with_6;
    wire [HALF:0]        low_without_6;
    wire [SUM-1:HALF]    product_6;
    wire [SUM-1:HALF]    term_6;
    wire [WIDE-1:0]      exponent_6;
    wire [FLAGS-1:0]     flags_6;
    pipeline_cut #(
        .WIDTH(2 * (HALF + 1) + 2 * (SUM - HALF) + WIDE + FLAGS),
        .REGISTERED(CUTS[CUT_SUM])
    ) half_cut (
        .clock(clock),
        .enable(enable),
        .from({low_with, low_without, wide_product[SUM-1:HALF], term_5[SUM-1:HALF], exponent_5,
               flags_5}),
        .to({low_with_6, low_without_6, product_6, term_6, exponent_6, flags_6})
    );
    wire [SUM-HALF+1:0] high_with = {1'b0, product_6, 1'b1} + {1'b0, term_6, low_with_6[HALF]};
    wire [SUM-HALF+1:0] high_without =
        {1'b0, product_6, 1'b1} + {1'b0, term_6, low_without_6[HALF]};
    wire unused_carries = &{1'b0, high_with, high_without};

    wire              carry_7;
    wire [SUM-1:0]    with_7;
    wire [SUM-1:0]    without_7;
    wire [WIDE-1:0]   exponent_7;
    wire [FLAGS-1:0]  flags_7;
    pipeline_cut #(
        .WIDTH(2 * SUM + 1 + WIDE + FLAGS),
        .REGISTERED(CUTS[CUT_SUM+1])
    ) sums_cut (
        .clock(clock),
        .enable(enable),
        .from({high_with[SUM-HALF+1:1], low_with_6[HALF-1:0], high_without[SUM-HALF:1],
               low_without_6[HALF-1:0], exponent_6, flags_6}),
        .to({carry_7, with_7, without_7, exponent_7, flags_7})
    );
    wire subtracts_7 = flags_7[2];
    wire negative = subtracts_7 & ~carry_7;
    wire [SUM-1:0] size = subtracts_7 & carry_7 ? with_7 : without_7 ^ {SUM{negative}};
    // The limit of the shift: the exponent stays at least 1.
    wire [WIDE-1:0] spare = exponent_7 - {{(WIDE - 1) {1'b0}}, 1'b1};

    wire [SUM-1:0]   size_8;
    wire [COUNT-1:0] limit_8;
    wire [WIDE-1:0]  exponent_8;
    wire [FLAGS-1:0] flags_8;
    pipeline_cut #(
        .WIDTH(SUM + COUNT + WIDE + FLAGS),
        .REGISTERED(CUTS[CUT_SUM+2])
    ) size_cut (
        .clock(clock),
        .enable(enable),
        .from({size, spare[COUNT-1:0] | {COUNT{|spare[WIDE-1:COUNT]}}, exponent_7,
               flags_7[3] ^ (negative & ~flags_7[0]), flags_7[2:0]}),
        .to({size_8, limit_8, exponent_8, flags_8})
    );

    wire [SUM-1:0]   shifted;
    wire [COUNT-1:0] count;
    wire             nonzero;
    wire [WIDE-1:0]  exponent_9;
    wire [FLAGS-1:0] flags_9;
    fp_normalise #(
        .WIDTH(SUM),
        .LIMITED(SUBNORMALS),
        .PAYLOAD(WIDE + FLAGS),
        .CUTS(CUTS >> CUT_NORMALISE)
    ) normalisation (
        .clock(clock),
        .enable(enable),
        .value(size_8),
        .limit(limit_8),
        .payload({exponent_8, flags_8}),
        .shifted(shifted),
        .count(count),
        .nonzero(nonzero),
        .companion({exponent_9, flags_9})
    );

    // Rounding. An exact zero of a difference is positive; what is only too
    // small keeps its sign.
    wire top = shifted[SUM-1];
    wire [WIDE-1:0] exact = exponent_9 - {{(WIDE - COUNT) {1'b0}}, count};
    wire below = exact[WIDE-1] | ~|exact;
    wire above = top & ~exact[WIDE-1] & exact >= ONES;
    fp_pack #(
        .EXPONENT(E),
        .MANTISSA(M),
        .CUTS(CUTS >> CUT_PACK),
        .EXTRA(EXTRA)
    ) rounding (
        .clock(clock),
        .enable(enable),
        .sign(flags_9[3] & (nonzero | ~flags_9[2] | flags_9[0])),
        .exponent(exact[E-1:0] & {E{top}}),
        .fraction(shifted[SUM-2-:M]),
        .guard(shifted[SUM-2-M]),
        .sticky(|shifted[SUM-3-M:0]),
        .nan(flags_9[1]),
        .infinite(flags_9[0] | above),
        .zero(~nonzero | (SUBNORMALS == 0 & below)),
        .result(result)
    );
endmodule
