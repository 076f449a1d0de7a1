// Floating-point square root, rounded to nearest, ties to even.
//
// Restoring, one bit of the root per step, as by hand: two bits of the
// radicand are brought down, and twice the root so far with a one behind it
// is subtracted where it fits. The numbers grow by one bit per step, so that
// the early steps are small. The contract is in docs/floating-point.md.
//
// Parameters
//   EXPONENT, MANTISSA   the format: a word is sign, exponent, mantissa.
//   SUBNORMALS  1: kept; 0: such operands count as zero. A root is subnormal
//               only in formats with more mantissa than half their range of
//               exponents, MANTISSA >= 2^(EXPONENT-1) - 1.
//   CUTS        bit i: a register at cut i: 0 operand taken apart; with
//               subnormal numbers those of an fp_normalise of MANTISSA + 1
//               bits; then 1 in front of the steps and one behind each of
//               the MANTISSA + 2 steps, or behind every second one when
//               MANTISSA > 40; where roots can be subnormal one behind each
//               of the ($clog2(MANTISSA+4)+1)/2 levels of a shift; 3 in the
//               rounding, the last at the result.
//   EXTRA       registers behind the result.
// Ports
//   enable      low holds every register.
//   left, result   words; the result comes as many enabled clocks after its
//               operand as CUTS has ones, and EXTRA more.

module fp_sqrt #(
    parameter EXPONENT = 8,
    parameter MANTISSA = 23,
    parameter SUBNORMALS = 1,
    parameter [63:0] CUTS = 0,
    parameter EXTRA = 0
) (
    input                        clock,
    input                        enable,
    input  [EXPONENT+MANTISSA:0] left,
    output [EXPONENT+MANTISSA:0] result
);
    localparam E = EXPONENT;
    localparam M = MANTISSA;
    localparam COUNT = $clog2(M + 1);
    localparam WIDE = (E > COUNT ? E : COUNT) + 3;
    localparam [WIDE-1:0] BIAS = {{(WIDE - E) {1'b0}}, {E{1'b1}}} >> 1;
    // Bits of the root: significand and guard bit.
    localparam STEPS = M + 2;
    localparam EVERY = M > 40 ? 2 : 1;
    localparam AMOUNT = $clog2(M + 4);
    localparam SHIFTS = SUBNORMALS != 0 && M >= (1 << (E - 1)) - 1 ? 1 : 0;

    localparam CUT_LEADING = 1;
    localparam CUT_STEPS = CUT_LEADING + (SUBNORMALS != 0 ? 2 * ((COUNT + 1) / 2) : 0);
    localparam CUT_SHIFT = CUT_STEPS + 1 + (STEPS + EVERY - 1) / EVERY;
    localparam CUT_PACK = CUT_SHIFT + (SHIFTS != 0 ? (AMOUNT + 1) / 2 : 0);

    // Operand.
    wire sign, zero, infinite, nan;
    wire [E-1:0] exponent;
    wire [M:0] significand;
    fp_unpack #(
        .EXPONENT(E),
        .MANTISSA(M),
        .SUBNORMALS(SUBNORMALS)
    ) unpack (
        .word(left),
        .sign(sign),
        .exponent(exponent),
        .significand(significand),
        .zero(zero),
        .infinite(infinite),
        .nan(nan)
    );

    // Sign, and the special results as fp_pack takes them. The root of a
    // negative zero is that zero.
    localparam FLAGS = 4;
    wire [E-1:0]     exponent_0;
    wire [M:0]       significand_0;
    wire [FLAGS-1:0] flags_0;
    pipeline_cut #(
        .WIDTH(E + M + 1 + FLAGS),
        .REGISTERED(CUTS[0])
    ) operand_cut (
        .clock(clock),
        .enable(enable),
        .from({exponent, significand, sign, nan | (sign & ~zero), infinite, zero}),
        .to({exponent_0, significand_0, flags_0})
    );

    wire [WIDE-1:0]  true_exponent;
    wire [M:0]       leading;
    wire [FLAGS-1:0] flags_1;
    fp_leading #(
        .EXPONENT(E),
        .MANTISSA(M),
        .SUBNORMALS(SUBNORMALS),
        .WIDE(WIDE),
        .PAYLOAD(FLAGS),
        .CUTS(CUTS >> CUT_LEADING)
    ) operand_leading (
        .clock(clock),
        .enable(enable),
        .exponent(exponent_0),
        .significand(significand_0),
        .payload(flags_0),
        .true_exponent(true_exponent),
        .leading(leading),
        .companion(flags_1)
    );

    // An odd power of two leaves a factor of two to the radicand. The bias is
    // odd, so the power is odd where the biased exponent is even.
    wire odd = ~true_exponent[0];
    wire [WIDE-1:0] twice = true_exponent + BIAS;
    wire [WIDE-1:0] half = {twice[WIDE-1], twice[WIDE-1:1]};

    localparam SIDE = WIDE + FLAGS;
    localparam RADICAND = 2 * STEPS;
    wire [M+1:0]    scaled;
    wire [SIDE-1:0] first_side;
    pipeline_cut #(
        .WIDTH(M + 2 + SIDE),
        .REGISTERED(CUTS[CUT_STEPS])
    ) steps_cut (
        .clock(clock),
        .enable(enable),
        .from({odd ? {leading, 1'b0} : {1'b0, leading}, half, flags_1}),
        .to({scaled, first_side})
    );
    wire [RADICAND-1:0] first_radicand = {scaled, {(M + 2) {1'b0}}};

    // The steps. After j of them the root has j bits, and the remainder, at
    // most twice the root, j + 1.
    genvar j;
    generate
        for (j = 0; j < STEPS; j = j + 1) begin : step
            wire [RADICAND-1:0] radicand_in;
            wire [j:0]          root_in;
            wire [j+1:0]        remainder_in;
            wire [SIDE-1:0]     side_in;
            wire [RADICAND-1:0] radicand_out;
            wire [j+1:0]        root_out;
            wire [j+2:0]        remainder_out;
            wire [SIDE-1:0]     side_out;
            wire unused_step = &{1'b0, radicand_out, root_out};
            if (j == 0) begin : first
                assign radicand_in = first_radicand;
                assign root_in = 1'b0;
                assign remainder_in = 2'b00;
                assign side_in = first_side;
            end else begin : next
                assign radicand_in = step[j-1].radicand_out;
                assign root_in = step[j-1].root_out;
                assign remainder_in = step[j-1].remainder_out;
                assign side_in = step[j-1].side_out;
            end
            wire [j+3:0] brought = {remainder_in, radicand_in[RADICAND-1-:2]};
            wire [j+3:0] difference = brought - {1'b0, root_in, 2'b01};
            wire fits = ~difference[j+3];
            wire [j+2:0] rest = fits ? difference[j+2:0] : brought[j+2:0];
            pipeline_cut #(
                .WIDTH(RADICAND + 2 * j + 5 + SIDE),
                .REGISTERED((j % EVERY == EVERY - 1 || j == STEPS - 1)
                    ? (CUTS >> (CUT_STEPS + 1 + j / EVERY)) & 64'd1 : 64'd0)
            ) cut (
                .clock(clock),
                .enable(enable),
                .from({radicand_in << 2, root_in, fits, rest, side_in}),
                .to({radicand_out, root_out, remainder_out, side_out})
            );
        end
    endgenerate
    wire [STEPS-1:0] root = step[STEPS-1].root_out[STEPS-1:0];
    wire             rest = |step[STEPS-1].remainder_out;
    wire [WIDE-1:0]  exponent_2;
    wire [FLAGS-1:0] flags_2;
    assign {exponent_2, flags_2} = step[STEPS-1].side_out;

    wire [M+1:0]     shifted;
    wire             unused_top = &{1'b0, exponent_2, shifted};
    wire             sticky;
    wire [E-1:0]     exponent_3;
    wire [FLAGS-1:0] flags_3;
    generate
        if (SHIFTS != 0) begin : shift
            wire below = exponent_2[WIDE-1] | ~|exponent_2;
            wire [WIDE-1:0] missing = {{(WIDE - 1) {1'b0}}, 1'b1} - exponent_2;
            wire dropped;
            wire rest_held;
            fp_shift_right #(
                .WIDTH(M + 2),
                .AMOUNT(AMOUNT),
                .PAYLOAD(E + 1 + FLAGS),
                .CUTS(CUTS >> CUT_SHIFT & (64'd1 << ((AMOUNT + 1) / 2)) - 64'd1)
            ) shifter (
                .clock(clock),
                .enable(enable),
                .value(root),
                .amount(missing[AMOUNT-1:0] & {AMOUNT{below}}),
                .payload({exponent_2[E-1:0] & {E{~below}}, rest, flags_2}),
                .shifted(shifted),
                .sticky(dropped),
                .companion({exponent_3, rest_held, flags_3})
            );
            assign sticky = rest_held | dropped;
        end else begin : straight
            assign shifted = root;
            assign sticky = rest;
            assign {exponent_3, flags_3} = {exponent_2[E-1:0], flags_2};
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
        .sign(flags_3[3]),
        .exponent(exponent_3),
        .fraction(shifted[M:1]),
        .guard(shifted[0]),
        .sticky(sticky),
        .nan(flags_3[2]),
        .infinite(flags_3[1]),
        .zero(flags_3[0]),
        .result(result)
    );
endmodule
