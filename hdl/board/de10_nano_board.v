// The machine on a DE10-Nano: clock, reset, lights and a host.
//
// Everything runs on one clock, that of the board or one that a phase-locked
// loop makes of it. KEY[0] resets; LED[0] is on while a program runs, LED[1]
// when one has run since the reset, LED[7] blinks as long as the clock runs.
// The host is the programming cable (virtual_jtag_host).
//
// Parameters
//   ADDRESS     bits of the host's address
//   PLL         1: the clock is made by a loop; 0: it is the board's 50 MHz
//   FREQUENCY   of the loop, as the vendor's block wants it: "75.000000 MHz"
//   BLINK       bits of the counter behind LED[7]

module de10_nano_board #(
    parameter ADDRESS = 16,
    parameter PLL = 0,
    parameter FREQUENCY = "50.000000 MHz",
    parameter BLINK = 25
) (
    input        board_clock,
    input  [1:0] key,
    output [7:0] led
);

    wire clock;
    wire locked;

    generate
        if (PLL != 0) begin : made
            altera_pll #(
                .reference_clock_frequency("50.0 MHz"),
                .fractional_vco_multiplier("false"),
                .operation_mode("direct"),
                .number_of_clocks(1),
                .output_clock_frequency0(FREQUENCY),
                .phase_shift0("0 ps"),
                .duty_cycle0(50),
                .pll_type("General"),
                .pll_subtype("General")
            ) pll (
                .refclk(board_clock),
                .rst(1'b0),
                .fbclk(1'b0),
                .outclk(clock),
                .fboutclk(),
                .locked(locked)
            );
        end else begin : given
            assign clock = board_clock;
            assign locked = 1'b1;
        end
    endgenerate

    // The key is asynchronous, and so is the loop's lock: reset begins and
    // ends two clocks after them.
    reg [1:0] resetting = 2'b11;
    wire      reset = resetting[1];
    always @(posedge clock) resetting <= {resetting[0], ~key[0] | ~locked};

    wire               host_write;
    wire               host_read;
    wire [ADDRESS-1:0] host_address;
    wire [31:0]        host_writedata;
    wire [31:0]        host_readdata;
    wire               host_readvalid;
    wire               running;

    virtual_jtag_host #(.ADDRESS(ADDRESS)) host (
        .clock(clock),
        .reset(reset),
        .host_write(host_write),
        .host_read(host_read),
        .host_address(host_address),
        .host_writedata(host_writedata),
        .host_readdata(host_readdata),
        .host_readvalid(host_readvalid)
    );

    robovec_machine machine (
        .clock(clock),
        .reset(reset),
        .host_write(host_write),
        .host_read(host_read),
        .host_address(host_address),
        .host_writedata(host_writedata),
        .host_readdata(host_readdata),
        .host_readvalid(host_readvalid),
        .running(running),
        .results(),
        .results_cycle(),
        .results_running()
    );

    reg             has_run = 1'b0;
    reg [BLINK-1:0] counter = {BLINK{1'b0}};
    always @(posedge clock) begin
        has_run <= ~reset & (has_run | running);
        counter <= counter + 1'b1;
    end

    assign led = {counter[BLINK-1], 5'b00000, has_run & ~running, running};

endmodule
