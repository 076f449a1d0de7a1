// The pins of a DE10-Nano, and the board module with the sizes of this
// machine. Clock: @clock@.
module de10_nano_top (
    input        FPGA_CLK1_50,
    input  [1:0] KEY,
    output [7:0] LED
);

    de10_nano_board #(
        .ADDRESS(@address@),
        .PLL(@pll@),
        .FREQUENCY("@frequency@ MHz")
    ) board (
        .board_clock(FPGA_CLK1_50),
        .key(KEY),
        .led(LED)
    );

endmodule
