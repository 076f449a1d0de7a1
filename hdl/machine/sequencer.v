// Counts the cycles of a program, and the clocks of a cycle.
//
// A start takes effect at the end of a cycle. From the next cycle on the
// address counts through the program; the word of an address acts two cycles
// after it was given (instruction_memory), and `cycle` is the one it belongs
// to.
//
// Parameters
//   ADDRESS      bits of a cycle's number
//   PHASES       clocks of a cycle
//   PHASE_BITS   bits that count them, at least 1
//
// Ports
//   start           start a program of `cycles` cycles; ignored while one runs
//   cycles          0 ends at once
//   phase, advance  the clock of the cycle, and whether it is the last one
//   fetch_address   to the instruction memories
//   fetched         the word that leaves the instruction memories is a program's
//   active, cycle   a program acts in this cycle, and in which of its own
//   running         from the start to the end of the last cycle
//   finished        for one clock: the last cycle has ended
module sequencer #(
    parameter ADDRESS = 10,
    parameter PHASES = 1,
    parameter PHASE_BITS = 1
) (
    input                       clock,
    input                       reset,
    input                       start,
    input      [ADDRESS:0]      cycles,
    output     [PHASE_BITS-1:0] phase,
    output                      advance,
    output reg [ADDRESS-1:0]    fetch_address,
    output reg                  fetched,
    output reg                  active,
    output reg [ADDRESS-1:0]    cycle,
    output                      running,
    output reg                  finished
);

    generate
        if (PHASES == 1) begin : single
            assign phase = 1'b0;
            assign advance = 1'b1;
        end else begin : several
            reg [PHASE_BITS-1:0] clocks;
            reg                  last;
            assign phase = clocks;
            assign advance = last;
            always @(posedge clock)
                if (reset | last) begin
                    clocks <= {PHASE_BITS{1'b0}};
                    last <= 1'b0;
                end else begin
                    clocks <= clocks + 1'b1;
                    last <= {{(32 - PHASE_BITS) {1'b0}}, clocks} == PHASES - 2;
                end
        end
    endgenerate

    // A program that waits for the end of a cycle, and one whose addresses
    // are given out; `left` counts those that follow.
    reg               waiting;
    reg               fetching;
    reg [ADDRESS:0]   left;
    reg [ADDRESS-1:0] fetched_address;

    assign running = waiting | fetching | fetched | active;

    always @(posedge clock)
        if (reset) begin
            waiting <= 1'b0;
            fetching <= 1'b0;
            fetched <= 1'b0;
            active <= 1'b0;
            finished <= 1'b0;
        end else begin
            finished <= (advance & active & ~fetched)
                        | (start & ~running & (cycles == 0));
            if (start & ~running)
                waiting <= cycles != 0;
            if (advance) begin
                fetched <= fetching;
                active <= fetched;
                if (waiting) begin
                    waiting <= 1'b0;
                    fetching <= 1'b1;
                end else if (left == 0)
                    fetching <= 1'b0;
            end
        end

    always @(posedge clock)
        if (advance) begin
            fetched_address <= fetch_address;
            cycle <= fetched_address;
            if (waiting) begin
                fetch_address <= {ADDRESS{1'b0}};
                left <= cycles - 1'b1;
            end else begin
                fetch_address <= fetch_address + 1'b1;
                left <= left - 1'b1;
            end
        end

endmodule
