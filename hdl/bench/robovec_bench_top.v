// What the benches drive: a machine with all three ways in.
//
// `window` chooses the way: 0 the machine's own host bus, 1 the Avalon-MM
// agent, 2 the AXI4-Lite subordinate. The two ways that are not chosen are
// cut off, so that what is loaded and read can only have come through the
// one that is. All three share one machine, because simulators take longer to
// build it than to run it.
`include "bench_config.vh"

module robovec_bench_top (
    input                                    clock,
    input                                    reset,
    input  [1:0]                             window,

    input                                    bus_write,
    input                                    bus_read,
    input  [`ROBOVEC_ADDRESS-1:0]            bus_address,
    input  [31:0]                            bus_writedata,
    output [31:0]                            bus_readdata,
    output                                   bus_readvalid,

    input  [`ROBOVEC_ADDRESS-1:0]            avs_address,
    input                                    avs_read,
    input                                    avs_write,
    input  [31:0]                            avs_writedata,
    input  [3:0]                             avs_byteenable,
    output                                   avs_waitrequest,
    output [31:0]                            avs_readdata,
    output                                   avs_readdatavalid,
    output [1:0]                             avs_response,

    input  [`ROBOVEC_ADDRESS+1:0]            axi_awaddr,
    input                                    axi_awvalid,
    output                                   axi_awready,
    input  [31:0]                            axi_wdata,
    input  [3:0]                             axi_wstrb,
    input                                    axi_wvalid,
    output                                   axi_wready,
    output [1:0]                             axi_bresp,
    output                                   axi_bvalid,
    input                                    axi_bready,
    input  [`ROBOVEC_ADDRESS+1:0]            axi_araddr,
    input                                    axi_arvalid,
    output                                   axi_arready,
    output [31:0]                            axi_rdata,
    output [1:0]                             axi_rresp,
    output                                   axi_rvalid,
    input                                    axi_rready,

    output                                   running,
    output [`ROBOVEC_ELEMENTS*`ROBOVEC_WIDTH-1:0] results,
    output [31:0]                            results_cycle,
    output                                   results_running
);
    wire                        avalon_write, avalon_read, axi_write, axi_read;
    wire [`ROBOVEC_ADDRESS-1:0] avalon_address, axi_address;
    wire [31:0]                 avalon_writedata, axi_writedata;

    wire        by_bus    = window == 2'd0;
    wire        by_avalon = window == 2'd1;
    wire        by_axi    = window == 2'd2;
    wire        host_readvalid;
    wire [31:0] host_readdata;

    robovec_avalon #(.ADDRESS(`ROBOVEC_ADDRESS), .WORDS(`ROBOVEC_WINDOW)) avalon (
        .clock(clock), .reset(reset | ~by_avalon),
        .avs_address(avs_address), .avs_read(avs_read), .avs_write(avs_write),
        .avs_writedata(avs_writedata), .avs_byteenable(avs_byteenable),
        .avs_waitrequest(avs_waitrequest), .avs_readdata(avs_readdata),
        .avs_readdatavalid(avs_readdatavalid), .avs_response(avs_response),
        .host_write(avalon_write), .host_read(avalon_read), .host_address(avalon_address),
        .host_writedata(avalon_writedata), .host_readdata(host_readdata),
        .host_readvalid(host_readvalid & by_avalon));

    robovec_axi4lite #(.ADDRESS(`ROBOVEC_ADDRESS), .WORDS(`ROBOVEC_WINDOW)) axi (
        .aclk(clock), .aresetn(~reset & by_axi),
        .s_axi_awaddr(axi_awaddr), .s_axi_awprot(3'd0), .s_axi_awvalid(axi_awvalid),
        .s_axi_awready(axi_awready), .s_axi_wdata(axi_wdata), .s_axi_wstrb(axi_wstrb),
        .s_axi_wvalid(axi_wvalid), .s_axi_wready(axi_wready), .s_axi_bresp(axi_bresp),
        .s_axi_bvalid(axi_bvalid), .s_axi_bready(axi_bready), .s_axi_araddr(axi_araddr),
        .s_axi_arprot(3'd0), .s_axi_arvalid(axi_arvalid), .s_axi_arready(axi_arready),
        .s_axi_rdata(axi_rdata), .s_axi_rresp(axi_rresp), .s_axi_rvalid(axi_rvalid),
        .s_axi_rready(axi_rready),
        .host_write(axi_write), .host_read(axi_read), .host_address(axi_address),
        .host_writedata(axi_writedata), .host_readdata(host_readdata),
        .host_readvalid(host_readvalid & by_axi));

    wire [`ROBOVEC_CYCLE-1:0] cycle;

    // Nothing is there at configuration, and all of it must come through a
    // window; or else the images are there.
`ifdef ROBOVEC_CONFIGURED
    localparam INITIAL = 1;
`else
    localparam INITIAL = 0;
`endif

    robovec_machine #(.INITIAL(INITIAL)) machine (
        .clock(clock), .reset(reset),
        .host_write(by_avalon ? avalon_write : by_axi ? axi_write : bus_write & by_bus),
        .host_read(by_avalon ? avalon_read : by_axi ? axi_read : bus_read & by_bus),
        .host_address(by_avalon ? avalon_address : by_axi ? axi_address : bus_address),
        .host_writedata(by_avalon ? avalon_writedata : by_axi ? axi_writedata : bus_writedata),
        .host_readdata(host_readdata), .host_readvalid(host_readvalid),
        .running(running),
        .results(results), .results_cycle(cycle), .results_running(results_running));

    assign bus_readdata  = host_readdata;
    assign bus_readvalid = host_readvalid & by_bus;
    assign results_cycle = {{32-`ROBOVEC_CYCLE{1'b0}}, cycle};
endmodule
