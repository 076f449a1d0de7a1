// One of four words. One six-input table per bit, where synthesis keeps the
// boundary of this module: left to itself, open synthesis spreads a tree of
// these over more and smaller tables. The module does not ask for that, since
// some flows put pads on every module that is kept.
module multiplexer_4 #(
    parameter WIDTH = 32
) (
    input  [1:0]       select,
    input  [WIDTH-1:0] word0,
    input  [WIDTH-1:0] word1,
    input  [WIDTH-1:0] word2,
    input  [WIDTH-1:0] word3,
    output [WIDTH-1:0] word
);

    assign word = select[1] ? (select[0] ? word3 : word2)
                            : (select[0] ? word1 : word0);

endmodule
