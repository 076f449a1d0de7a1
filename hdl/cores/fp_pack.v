// The last steps of every operator: special results, rounding, packing.
//
// A significand is rounded to nearest, ties to even, by adding one to
// exponent and fraction as to one number: a carry out of the fraction then
// raises the exponent, makes the least normal number of the largest subnormal
// one, and infinity of the largest number. Special results replace both
// before that sum, where they cost nothing.
//
// Parameters
//   EXPONENT, MANTISSA   the format.
//   CUTS   bit 0: a register before the sum; bit 1: in its middle; bit 2: at
//          the result.
//   EXTRA  registers behind the result.
// Ports
//   sign               of the result, unless it is no number.
//   exponent           the biased exponent, 0 for a subnormal significand.
//   fraction           behind the leading bit.
//   guard, sticky      the next bit of the significand, and whether one of
//                      those behind it is set.
//   nan, infinite, zero   the special results, the first that is set wins;
//                      with none, exponent and fraction count.
//   result             the word.

module fp_pack #(
    parameter EXPONENT = 8,
    parameter MANTISSA = 23,
    parameter [63:0] CUTS = 0,
    parameter EXTRA = 0
) (
    input                          clock,
    input                          enable,
    input                          sign,
    input  [EXPONENT-1:0]          exponent,
    input  [MANTISSA-1:0]          fraction,
    input                          guard,
    input                          sticky,
    input                          nan,
    input                          infinite,
    input                          zero,
    output [EXPONENT+MANTISSA:0]   result
);
    localparam SIZE = EXPONENT + MANTISSA;
    localparam LOW = SIZE / 2;

    wire special = nan | infinite | zero;
    wire up = guard & (sticky | fraction[0]) & ~special;
    wire [EXPONENT-1:0] chosen_exponent =
        {EXPONENT{nan | infinite}} | (exponent & {EXPONENT{~special}});
    // The quiet NaN without sign and payload is the only one there is.
    wire [MANTISSA:0] quiet = {{MANTISSA{1'b0}}, nan} << (MANTISSA - 1);
    wire unused = quiet[MANTISSA];
    wire [MANTISSA-1:0] chosen_fraction = quiet[MANTISSA-1:0] | (fraction & {MANTISSA{~special}});

    wire            sign_1;
    wire [SIZE-1:0] size_1;
    wire            up_1;
    pipeline_cut #(
        .WIDTH(SIZE + 2),
        .REGISTERED(CUTS[0])
    ) chosen_cut (
        .clock(clock),
        .enable(enable),
        .from({sign & ~nan, chosen_exponent, chosen_fraction, up}),
        .to({sign_1, size_1, up_1})
    );

    wire [LOW:0]      low_sum = {1'b0, size_1[LOW-1:0]} + {{LOW{1'b0}}, up_1};
    wire              sign_2;
    wire [SIZE-1:LOW] high_2;
    wire [LOW:0]      low_2;
    pipeline_cut #(
        .WIDTH(SIZE + 2),
        .REGISTERED(CUTS[1])
    ) middle_cut (
        .clock(clock),
        .enable(enable),
        .from({sign_1, size_1[SIZE-1:LOW], low_sum}),
        .to({sign_2, high_2, low_2})
    );

    wire [SIZE-1:LOW] high_sum = high_2 + {{(SIZE - LOW - 1) {1'b0}}, low_2[LOW]};
    wire [SIZE:0]     rounded;
    pipeline_cut #(
        .WIDTH(SIZE + 1),
        .REGISTERED(CUTS[2])
    ) result_cut (
        .clock(clock),
        .enable(enable),
        .from({sign_2, high_sum, low_2[LOW-1:0]}),
        .to(rounded)
    );

    pipeline_delay #(
        .WIDTH(SIZE + 1),
        .STAGES(EXTRA)
    ) extra (
        .clock(clock),
        .enable(enable),
        .from(rounded),
        .to(result)
    );
endmodule
