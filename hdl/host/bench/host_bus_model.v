// A host bus as a machine has it, for the benches of the adapters: a memory
// that takes writes at once and answers reads after none to five clocks, and
// that watches the promises of an adapter.
`default_nettype none
`timescale 1ns / 1ps

module host_bus_model #(
    parameter ADDRESS = 6,
    parameter WORDS = 50
) (
    input  wire               clock,
    input  wire               reset,
    input  wire               host_write,
    input  wire               host_read,
    input  wire [ADDRESS-1:0] host_address,
    input  wire [31:0]        host_writedata,
    output wire [31:0]        host_readdata,
    output wire               host_readvalid,
    // Broken promises: strobes together, beyond the window, a read before the
    // one before was answered.
    output reg  [31:0]        broken,
    // Reads and writes so far.
    output reg  [31:0]        reads,
    output reg  [31:0]        writes
);
    reg [31:0]        memory [0:(1 << ADDRESS)-1];
    reg               waiting;
    reg [2:0]         left;
    reg [2:0]         latency;
    reg [ADDRESS-1:0] address;

    wire at_once = host_read & ~waiting & (latency == 3'd0);
    assign host_readvalid = at_once | (waiting & (left == 3'd0));
    // Nothing sensible stands on the bus but in the clock of the answer.
    assign host_readdata  = at_once ? memory[host_address]
                          : host_readvalid ? memory[address] : 32'hDEADBEEF;

    integer i;
    reg [31:0] dice;
    // Xorshift (Marsaglia, 2003), so that all simulators see the same numbers.
    function [31:0] following(input [31:0] number);
        begin
            following = number ^ (number << 13);
            following = following ^ (following >> 17);
            following = following ^ (following << 5);
        end
    endfunction

    initial begin
        dice = 32'd7654321;
        for (i = 0; i < (1 << ADDRESS); i = i + 1) memory[i] = 32'd0;
    end

    always @(posedge clock) begin
        if (reset) begin
            waiting <= 1'b0;
            latency <= 3'd0;
            left    <= 3'd0;
            broken  <= 32'd0;
            reads   <= 32'd0;
            writes  <= 32'd0;
        end else begin
            if ((host_write & host_read)
                | ((host_write | host_read) & ({26'd0, host_address} >= WORDS))
                | (host_read & waiting)) broken <= broken + 32'd1;
            if (host_write) begin
                memory[host_address] <= host_writedata;
                writes <= writes + 32'd1;
            end
            if (host_read) begin
                reads   <= reads + 32'd1;
                dice = following(dice);
                latency <= dice[2:0] < 3'd6 ? dice[2:0] : 3'd0;
            end
            if (host_read & ~waiting & ~at_once) begin
                waiting <= 1'b1;
                left    <= latency - 3'd1;
                address <= host_address;
            end else if (waiting) begin
                waiting <= left != 3'd0;
                left    <= left - 3'd1;
            end
        end
    end
endmodule

`default_nettype wire
