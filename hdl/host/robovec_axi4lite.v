// AXI4-Lite subordinate in front of the host bus of a robovec machine.
//
// The five channels of AXI are independent of one another, and each side may
// make the other wait; the machine's own host bus is a single address with a
// write and a read strobe and never waits.  This adapter keeps what comes
// until both halves of a write are there, lets reads and writes take turns on
// the bus, and holds every answer until it is taken.
//
// Contract
// - Data are 32 bits; addresses count bytes and their lowest two bits are
//   ignored, as every access is a whole word.
// - Address and data of a write may come in any order.  One write is kept
//   while the response of the one before is waiting.
// - One read is under way at a time.
// - A write response is given after the word was written, so that a read
//   issued later sees it.  Reads and writes under way together have no order,
//   as AXI has it; when both can go, they take turns.
// - SLVERR, and nothing reaches the host bus: at and beyond WORDS; for a
//   write whose strobes are neither all set nor all clear (a register or
//   memory word of the machine is written whole or not at all).  A write
//   without any strobe is OKAY and writes nothing.
// - No output depends on an input within a clock.
// - The host bus may answer a read in the clock of the read or any number of
//   clocks later, once for each read.
`default_nettype none

module robovec_axi4lite #(
    // Bits of a word address; byte addresses have two more.
    parameter ADDRESS = 16,
    // Words of the window; word addresses are below it.
    parameter [ADDRESS:0] WORDS = {1'b1, {ADDRESS{1'b0}}}
) (
    input  wire               aclk,
    // Synchronous, low.
    input  wire               aresetn,

    // verilator lint_off UNUSED
    // Part of the interface and not looked at: the lowest bits of addresses,
    // and what kind of access it is.
    input  wire [ADDRESS+1:0] s_axi_awaddr,
    input  wire [2:0]         s_axi_awprot,
    input  wire [ADDRESS+1:0] s_axi_araddr,
    input  wire [2:0]         s_axi_arprot,
    // verilator lint_on UNUSED
    input  wire               s_axi_awvalid,
    output wire               s_axi_awready,

    input  wire [31:0]        s_axi_wdata,
    input  wire [3:0]         s_axi_wstrb,
    input  wire               s_axi_wvalid,
    output wire               s_axi_wready,

    output reg  [1:0]         s_axi_bresp,
    output reg                s_axi_bvalid,
    input  wire               s_axi_bready,

    input  wire               s_axi_arvalid,
    output wire               s_axi_arready,

    output reg  [31:0]        s_axi_rdata,
    output reg  [1:0]         s_axi_rresp,
    output reg                s_axi_rvalid,
    input  wire               s_axi_rready,

    // The machine's host bus.
    output wire               host_write,
    output wire               host_read,
    output wire [ADDRESS-1:0] host_address,
    output wire [31:0]        host_writedata,
    input  wire [31:0]        host_readdata,
    input  wire               host_readvalid
);
    localparam [1:0] OKAY = 2'b00;
    localparam [1:0] SLVERR = 2'b10;

    // What has come and waits for its turn on the bus.
    reg               write_address_held;
    reg [ADDRESS-1:0] write_address;
    reg               write_data_held;
    reg [31:0]        write_data;
    reg [3:0]         write_strobes;
    reg               read_address_held;
    reg [ADDRESS-1:0] read_address;
    // A read is under way on the host bus.
    reg               reading;
    // The last turn on the bus was a write's.
    reg               wrote_last;
    // High from the first clock after reset: nothing is taken before.
    reg               awake;

    assign s_axi_awready = awake & ~write_address_held;
    assign s_axi_wready  = awake & ~write_data_held;
    assign s_axi_arready = awake & ~read_address_held;

    // Each may go when what it needs is there and its answer has a place.
    wire write_ready = write_address_held & write_data_held & ~s_axi_bvalid;
    wire read_ready  = read_address_held & ~reading & ~s_axi_rvalid;
    wire write_turn  = write_ready & ~(read_ready & wrote_last);
    wire read_turn   = read_ready & ~write_turn;

    wire write_in_range  = {1'b0, write_address} < WORDS;
    wire read_in_range   = {1'b0, read_address} < WORDS;
    wire all_strobes   = &write_strobes;
    wire some_strobes  = (|write_strobes) & ~all_strobes;

    assign host_write     = write_turn & write_in_range & all_strobes;
    assign host_read      = read_turn & read_in_range;
    assign host_address   = write_turn ? write_address : read_address;
    assign host_writedata = write_data;

    wire answered = host_readvalid & (reading | host_read);

    always @(posedge aclk) begin
        if (!aresetn) begin
            write_address_held <= 1'b0;
            write_data_held    <= 1'b0;
            read_address_held  <= 1'b0;
            reading            <= 1'b0;
            wrote_last         <= 1'b0;
            awake              <= 1'b0;
            s_axi_bvalid       <= 1'b0;
            s_axi_bresp        <= OKAY;
            s_axi_rvalid       <= 1'b0;
            s_axi_rresp        <= OKAY;
            s_axi_rdata        <= 32'd0;
        end else begin
            awake <= 1'b1;

            if (s_axi_awvalid & s_axi_awready) begin
                write_address_held <= 1'b1;
                write_address      <= s_axi_awaddr[ADDRESS+1:2];
            end
            if (s_axi_wvalid & s_axi_wready) begin
                write_data_held <= 1'b1;
                write_data      <= s_axi_wdata;
                write_strobes   <= s_axi_wstrb;
            end
            if (write_turn) begin
                write_address_held <= 1'b0;
                write_data_held    <= 1'b0;
                wrote_last         <= 1'b1;
                s_axi_bvalid       <= 1'b1;
                s_axi_bresp        <= (write_in_range & ~some_strobes) ? OKAY : SLVERR;
            end else if (s_axi_bready) begin
                s_axi_bvalid <= 1'b0;
            end

            if (s_axi_arvalid & s_axi_arready) begin
                read_address_held <= 1'b1;
                read_address      <= s_axi_araddr[ADDRESS+1:2];
            end
            if (read_turn) begin
                read_address_held <= 1'b0;
                wrote_last        <= 1'b0;
            end
            reading <= (reading | host_read) & ~host_readvalid;
            if (read_turn & ~read_in_range) begin
                s_axi_rvalid <= 1'b1;
                s_axi_rresp  <= SLVERR;
                s_axi_rdata  <= 32'd0;
            end else if (answered) begin
                s_axi_rvalid <= 1'b1;
                s_axi_rresp  <= OKAY;
                s_axi_rdata  <= host_readdata;
            end else if (s_axi_rready) begin
                s_axi_rvalid <= 1'b0;
            end
        end
    end
endmodule

`default_nettype wire
