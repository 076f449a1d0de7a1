// Avalon-MM agent in front of the host bus of a robovec machine.
//
// Platform Designer connects hosts (the ARM cores of a Cyclone V, a JTAG
// bridge, a soft processor) to Avalon-MM agents, and the machine's own host
// bus knows neither waiting nor errors.  This adapter adds both and nothing
// else: it holds no data but the flag of a read that is under way.
//
// Contract
// - Addresses count 32-bit words (addressUnits = WORDS).
// - Pipelined reads of variable latency with `avs_readdatavalid`, one pending
//   at a time (maximumPendingReadTransactions = 1): everything that follows a
//   read waits until its data have come, so the host sees one order.
// - A write takes one clock.
// - A write whose byte enables are not all set is dropped: a register or
//   memory word of the machine is written whole or not at all.
// - At and beyond WORDS there is nothing.  A read there answers zero with the
//   response DECODEERROR in the clock after it was taken, a write is dropped;
//   neither reaches the host bus.
// - The host bus may answer a read in the clock of the read or any number of
//   clocks later, once for each read.
`default_nettype none

module robovec_avalon #(
    // Bits of a word address.
    parameter ADDRESS = 16,
    // Words of the window; addresses are below it.
    parameter [ADDRESS:0] WORDS = {1'b1, {ADDRESS{1'b0}}}
) (
    input  wire               clock,
    // Synchronous, high.
    input  wire               reset,

    // The agent, as Avalon-MM names its signals.
    input  wire [ADDRESS-1:0] avs_address,
    input  wire               avs_read,
    input  wire               avs_write,
    input  wire [31:0]        avs_writedata,
    input  wire [3:0]         avs_byteenable,
    output wire               avs_waitrequest,
    output reg  [31:0]        avs_readdata,
    output reg                avs_readdatavalid,
    output reg  [1:0]         avs_response,

    // The machine's host bus.
    output wire               host_write,
    output wire               host_read,
    output wire [ADDRESS-1:0] host_address,
    output wire [31:0]        host_writedata,
    input  wire [31:0]        host_readdata,
    input  wire               host_readvalid
);
    localparam [1:0] OKAY = 2'b00;
    localparam [1:0] DECODE_ERROR = 2'b11;

    // A read is under way on the host bus.
    reg pending;

    wire in_range = {1'b0, avs_address} < WORDS;

    assign avs_waitrequest = pending | reset;

    assign host_write     = avs_write & ~avs_waitrequest & in_range & (&avs_byteenable);
    assign host_read      = avs_read & ~avs_waitrequest & in_range;
    assign host_address   = avs_address;
    assign host_writedata = avs_writedata;

    wire outside_read = avs_read & ~avs_waitrequest & ~in_range;
    wire answered     = host_readvalid & (pending | host_read);

    always @(posedge clock) begin
        if (reset) begin
            pending           <= 1'b0;
            avs_readdata      <= 32'd0;
            avs_readdatavalid <= 1'b0;
            avs_response      <= OKAY;
        end else begin
            pending           <= (pending | host_read) & ~host_readvalid;
            avs_readdatavalid <= answered | outside_read;
            avs_readdata      <= outside_read ? 32'd0 : host_readdata;
            avs_response      <= outside_read ? DECODE_ERROR : OKAY;
        end
    end
endmodule

`default_nettype wire
