// A word taken apart.
//
// Parameters
//   EXPONENT, MANTISSA   the format: a word is sign, exponent, mantissa.
//   SUBNORMALS  1: kept; 0: they count as zero.
// Ports
//   word           the number.
//   sign           its sign.
//   exponent       the biased exponent; of a subnormal number that of the
//                  least normal one, which it has.
//   significand    with the leading bit. Where subnormal numbers count as
//                  zero, it is not cleared for them: see `zero`.
//   zero, infinite, nan   what else it may be.

module fp_unpack #(
    parameter EXPONENT = 8,
    parameter MANTISSA = 23,
    parameter SUBNORMALS = 1
) (
    input  [EXPONENT+MANTISSA:0] word,
    output                       sign,
    output [EXPONENT-1:0]        exponent,
    output [MANTISSA:0]          significand,
    output                       zero,
    output                       infinite,
    output                       nan
);
    wire [EXPONENT-1:0] field = word[EXPONENT+MANTISSA-1:MANTISSA];
    wire least = ~|field;
    wire most = &field;
    wire behind = |word[MANTISSA-1:0];

    assign sign = word[EXPONENT+MANTISSA];
    assign exponent = {field[EXPONENT-1:1], field[0] | least};
    assign significand = {~least, word[MANTISSA-1:0]};
    assign zero = least & (SUBNORMALS == 0 | ~behind);
    assign infinite = most & ~behind;
    assign nan = most & behind;
endmodule
