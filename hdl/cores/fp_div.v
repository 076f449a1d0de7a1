// Floating-point quotient, rounded to nearest, ties to even.
//
// Restoring division, one bit of the quotient per step: the divisor is
// subtracted where it fits. A step is one carry chain and one multiplexer,
// and between steps stands a cut, so that any latency up to more than one
// stage per bit can be had. The contract is in docs/floating-point.md.
//
// Parameters
//   EXPONENT, MANTISSA   the format: a word is sign, exponent, mantissa.
//   SUBNORMALS  1: kept; 0: such operands count as zero and such results
//               become zero.
//   CUTS        bit i: a register at cut i: 0 operands taken apart; with
//               subnormal numbers those of an fp_normalise of MANTISSA + 1
//               bits; then 1 in front of the steps and one behind each of
//               the MANTISSA + 3 steps, or behind every second one when
//               MANTISSA > 40; 1 behind the choice of the leading bit; with
//               subnormal numbers one behind each of the
//               ($clog2(MANTISSA+4)+1)/2 levels of the shift; 3 in the
//               rounding, the last at the result.
//   EXTRA       registers behind the result.
// Ports
//   enable      low holds every register.
//   left, right, result   words, result = left / right; the result comes as
//               many enabled clocks after its operands as CUTS has ones, and
//               EXTRA more.

module fp_div #(
    parameter EXPONENT = 8,
    parameter MANTISSA = 23,
    parameter SUBNORMALS = 1,
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
    localparam COUNT = $clog2(M + 1);
    localparam WIDE = (E > COUNT ? E : COUNT) + 3;
    localparam [WIDE-1:0] ONES = {{(WIDE - E) {1'b0}}, {E{1'b1}}};
    localparam [WIDE-1:0] BIAS = ONES >> 1;
    // Quotient bits: significand, one more because the first may be zero, and
    // the guard bit.
    localparam STEPS = M + 3;
    localparam EVERY = M > 40 ? 2 : 1;
    localparam AMOUNT = $clog2(M + 4);

    localparam CUT_LEADING = 1;
    localparam CUT_STEPS = CUT_LEADING + (SUBNORMALS != 0 ? 2 * ((COUNT + 1) / 2) : 0);
    localparam CUT_CHOICE = CUT_STEPS + 1 + (STEPS + EVERY - 1) / EVERY;
    localparam CUT_SHIFT = CUT_CHOICE + 1;
    localparam CUT_PACK = CUT_SHIFT + (SUBNORMALS != 0 ? (AMOUNT + 1) / 2 : 0);

    // Operands.
    wire left_sign, left_zero, left_infinite, left_nan;
    wire right_sign, right_zero, right_infinite, right_nan;
    wire [E-1:0] left_exponent, right_exponent;
    wire [M:0] left_significand, right_significand;
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
    wire nan = left_nan | right_nan | (left_zero & right_zero) | (left_infinite & right_infinite);

    // Sign, and the special results as fp_pack takes them.
    localparam FLAGS = 4;
    wire [E-1:0]     left_exponent_0;
    wire [E-1:0]     right_exponent_0;
    wire [M:0]       left_significand_0;
    wire [M:0]       right_significand_0;
    wire [FLAGS-1:0] flags_0;
    pipeline_cut #(
        .WIDTH(2 * (E + M + 1) + FLAGS),
        .REGISTERED(CUTS[0])
    ) operands_cut (
        .clock(clock),
        .enable(enable),
        .from({left_exponent, right_exponent, left_significand, right_significand,
               left_sign ^ right_sign, nan, left_infinite | right_zero,
               left_zero | right_infinite}),
        .to({left_exponent_0, right_exponent_0, left_significand_0, right_significand_0, flags_0})
    );

    wire [WIDE-1:0]  left_true;
    wire [WIDE-1:0]  right_true;
    wire [M:0]       dividend;
    wire [M:0]       divisor;
    wire [FLAGS-1:0] flags_1;
    wire             unused_companion;
    fp_leading #(
        .EXPONENT(E),
        .MANTISSA(M),
        .SUBNORMALS(SUBNORMALS),
        .WIDE(WIDE),
        .PAYLOAD(FLAGS),
        .CUTS(CUTS >> CUT_LEADING)
    ) left_leading (
        .clock(clock),
        .enable(enable),
        .exponent(left_exponent_0),
        .significand(left_significand_0),
        .payload(flags_0),
        .true_exponent(left_true),
        .leading(dividend),
        .companion(flags_1)
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
        .significand(right_significand_0),
        .payload(1'b0),
        .true_exponent(right_true),
        .leading(divisor),
        .companion(unused_companion)
    );
    wire [WIDE-1:0] exponent = left_true - right_true + BIAS;

    // The steps. The remainder stays below twice the divisor.
    localparam SIDE = WIDE + FLAGS;
    wire [M+1:0]     first_remainder;
    wire [M:0]       first_divisor;
    wire [SIDE-1:0]  first_side;
    pipeline_cut #(
        .WIDTH(2 * M + 3 + SIDE),
        .REGISTERED(CUTS[CUT_STEPS])
    ) steps_cut (
        .clock(clock),
        .enable(enable),
        .from({1'b0, dividend, divisor, exponent, flags_1}),
        .to({first_remainder, first_divisor, first_side})
    );
    genvar j;
    generate
        for (j = 0; j < STEPS; j = j + 1) begin : step
            wire [M+1:0]     remainder_in;
            wire [M:0]       divisor_in;
            wire [STEPS-1:0] quotient_in;
            wire [SIDE-1:0]  side_in;
            wire [M+1:0]     remainder_out;
            wire [M:0]       divisor_out;
            wire [STEPS-1:0] quotient_out;
            wire [SIDE-1:0]  side_out;
            wire unused_step = &{1'b0, quotient_in, divisor_out};
            if (j == 0) begin : first
                assign remainder_in = first_remainder;
                assign divisor_in = first_divisor;
                assign quotient_in = {STEPS{1'b0}};
                assign side_in = first_side;
            end else begin : next
                assign remainder_in = step[j-1].remainder_out;
                assign divisor_in = step[j-1].divisor_out;
                assign quotient_in = step[j-1].quotient_out;
                assign side_in = step[j-1].side_out;
            end
            wire [M+2:0] difference = {1'b0, remainder_in} - {2'b00, divisor_in};
            wire fits = ~difference[M+2];
            wire [M:0] rest = fits ? difference[M:0] : remainder_in[M:0];
            pipeline_cut #(
                .WIDTH(2 * M + 3 + STEPS + SIDE),
                .REGISTERED((j % EVERY == EVERY - 1 || j == STEPS - 1)
                    ? (CUTS >> (CUT_STEPS + 1 + j / EVERY)) & 64'd1 : 64'd0)
            ) cut (
                .clock(clock),
                .enable(enable),
                .from({rest, 1'b0, divisor_in, quotient_in[STEPS-2:0], fits, side_in}),
                .to({remainder_out, divisor_out, quotient_out, side_out})
            );
        end
    endgenerate
    wire [STEPS-1:0] quotient = step[STEPS-1].quotient_out;
    wire             rest = |step[STEPS-1].remainder_out;
    wire [WIDE-1:0]  exponent_2;
    wire [FLAGS-1:0] flags_2;
    assign {exponent_2, flags_2} = step[STEPS-1].side_out;

    // The leading bit; what overflows or is too small is known before the
    // rounding.
    wire top = quotient[STEPS-1];
    wire [M+1:0] significand = top ? quotient[STEPS-1:1] : quotient[STEPS-2:0];
    wire [WIDE-1:0] exact = exponent_2 - {{(WIDE - 1) {1'b0}}, ~top};
    wire below = exact[WIDE-1] | ~|exact;
    wire above = ~exact[WIDE-1] & exact >= ONES;
    wire [WIDE-1:0] missing = {{(WIDE - 1) {1'b0}}, 1'b1} - exact;
    wire [AMOUNT-1:0] amount = (missing[AMOUNT-1:0] | {AMOUNT{|missing[WIDE-1:AMOUNT]}})
        & {AMOUNT{below}};
    wire              zero = flags_2[0] | (SUBNORMALS == 0 & below);

    wire [M+1:0]      significand_3;
    wire              sticky_3;
    wire [AMOUNT-1:0] amount_3;
    wire [E-1:0]      exponent_3;
    wire [FLAGS-1:0]  flags_3;
    pipeline_cut #(
        .WIDTH(M + 3 + AMOUNT + E + FLAGS),
        .REGISTERED(CUTS[CUT_CHOICE])
    ) choice_cut (
        .clock(clock),
        .enable(enable),
        .from({significand, rest | (top & quotient[0]), amount, exact[E-1:0] & {E{~below}},
               flags_2[3:2], flags_2[1] | (above & ~flags_2[0]), zero}),
        .to({significand_3, sticky_3, amount_3, exponent_3, flags_3})
    );

    wire [M+1:0]     shifted;
    wire             unused_top = &{1'b0, shifted};
    wire             dropped;
    wire [E-1:0]     exponent_4;
    wire             sticky_4;
    wire [FLAGS-1:0] flags_4;
    generate
        if (SUBNORMALS != 0) begin : shift
            fp_shift_right #(
                .WIDTH(M + 2),
                .AMOUNT(AMOUNT),
                .PAYLOAD(E + 1 + FLAGS),
                .CUTS(CUTS >> CUT_SHIFT & (64'd1 << ((AMOUNT + 1) / 2)) - 64'd1)
            ) shifter (
                .clock(clock),
                .enable(enable),
                .value(significand_3),
                .amount(amount_3),
                .payload({exponent_3, sticky_3, flags_3}),
                .shifted(shifted),
                .sticky(dropped),
                .companion({exponent_4, sticky_4, flags_4})
            );
        end else begin : straight
            wire unused = &{1'b0, amount_3};
            assign shifted = significand_3;
            assign dropped = 1'b0;
            assign {exponent_4, sticky_4, flags_4} = {exponent_3, sticky_3, flags_3};
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
        .sign(flags_4[3]),
        .exponent(exponent_4),
        .fraction(shifted[M:1]),
        .guard(shifted[0]),
        .sticky(sticky_4 | dropped),
        .nan(flags_4[2]),
        .infinite(flags_4[1]),
        .zero(flags_4[0]),
        .result(result)
    );
endmodule
