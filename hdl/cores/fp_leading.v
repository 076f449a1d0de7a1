// A significand whose leading bit is one, of any number but zero.
//
// Only a subnormal number lacks the leading one; without them nothing has to
// be done, and there are no cuts.
//
// Parameters
//   EXPONENT, MANTISSA, SUBNORMALS   as in the operators.
//   WIDE     bits of exponents with a sign, at least two more than EXPONENT
//            and than $clog2(MANTISSA + 1).
//   PAYLOAD  bits that travel beside, at least 1.
//   CUTS     with subnormal numbers those of an fp_normalise of MANTISSA + 1
//            bits.
// Ports
//   exponent, significand   as from fp_unpack.
//   true_exponent           biased, as if there were no least one; with sign.
//   leading                 the significand with its leading one on top; of
//                           zero nothing but zeros.
//   payload, companion      what travels along.

module fp_leading #(
    parameter EXPONENT = 8,
    parameter MANTISSA = 23,
    parameter SUBNORMALS = 1,
    parameter WIDE = 10,
    parameter PAYLOAD = 1,
    parameter [63:0] CUTS = 0
) (
    input                 clock,
    input                 enable,
    input  [EXPONENT-1:0] exponent,
    input  [MANTISSA:0]   significand,
    input  [PAYLOAD-1:0]  payload,
    output [WIDE-1:0]     true_exponent,
    output [MANTISSA:0]   leading,
    output [PAYLOAD-1:0]  companion
);
    localparam COUNT = $clog2(MANTISSA + 1);

    generate
        if (SUBNORMALS != 0) begin : kept
            wire [COUNT-1:0]    count;
            wire [EXPONENT-1:0] exponent_held;
            wire                unused_nonzero;
            fp_normalise #(
                .WIDTH(MANTISSA + 1),
                .LIMITED(0),
                .PAYLOAD(EXPONENT + PAYLOAD),
                .CUTS(CUTS)
            ) normalisation (
                .clock(clock),
                .enable(enable),
                .value(significand),
                .limit({COUNT{1'b0}}),
                .payload({exponent, payload}),
                .shifted(leading),
                .count(count),
                .nonzero(unused_nonzero),
                .companion({exponent_held, companion})
            );
            assign true_exponent = {{(WIDE - EXPONENT) {1'b0}}, exponent_held}
                - {{(WIDE - COUNT) {1'b0}}, count};
        end else begin : flushed
            wire unused = &{1'b0, clock, enable};
            assign leading = significand;
            assign companion = payload;
            assign true_exponent = {{(WIDE - EXPONENT) {1'b0}}, exponent};
        end
    endgenerate
endmodule
