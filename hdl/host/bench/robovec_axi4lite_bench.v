// Self-checking bench of robovec_axi4lite: many random accesses, with random
// gaps before every VALID and every READY of all five channels.
//
// Every write carries a number of its own, so that what a read finds says
// which write it saw.  A read must see the last write whose response was
// taken before the read was asked for, or one that was issued since.
`default_nettype none
`timescale 1ns / 1ps

module robovec_axi4lite_bench;
    localparam ADDRESS = 6;
    localparam WORDS = 50;
    localparam COUNT = 6000;
    localparam PHASE = 500;
    localparam [1:0] OKAY = 2'b00;
    localparam [1:0] SLVERR = 2'b10;

    reg clock = 1'b0;
    always #5 clock = ~clock;
    reg resetn = 1'b0;

    reg  [ADDRESS+1:0] awaddr = 0, araddr = 0;
    reg  [31:0]        wdata = 0;
    reg  [3:0]         wstrb = 0;
    reg                awvalid = 1'b0, wvalid = 1'b0, arvalid = 1'b0;
    reg                bready = 1'b0, rready = 1'b0;
    wire               awready, wready, arready, bvalid, rvalid;
    wire [1:0]         bresp, rresp;
    wire [31:0]        rdata;
    wire               host_write, host_read, host_readvalid;
    wire [ADDRESS-1:0] host_address;
    wire [31:0]        host_writedata, host_readdata, broken, reads, writes;

    robovec_axi4lite #(.ADDRESS(ADDRESS), .WORDS(WORDS)) adapter (
        .aclk(clock), .aresetn(resetn),
        .s_axi_awaddr(awaddr), .s_axi_awprot(3'd0), .s_axi_awvalid(awvalid),
        .s_axi_awready(awready),
        .s_axi_wdata(wdata), .s_axi_wstrb(wstrb), .s_axi_wvalid(wvalid), .s_axi_wready(wready),
        .s_axi_bresp(bresp), .s_axi_bvalid(bvalid), .s_axi_bready(bready),
        .s_axi_araddr(araddr), .s_axi_arprot(3'd0), .s_axi_arvalid(arvalid),
        .s_axi_arready(arready),
        .s_axi_rdata(rdata), .s_axi_rresp(rresp), .s_axi_rvalid(rvalid), .s_axi_rready(rready),
        .host_write(host_write), .host_read(host_read), .host_address(host_address),
        .host_writedata(host_writedata), .host_readdata(host_readdata),
        .host_readvalid(host_readvalid));

    host_bus_model #(.ADDRESS(ADDRESS), .WORDS(WORDS)) bus (
        .clock(clock), .reset(~resetn),
        .host_write(host_write), .host_read(host_read), .host_address(host_address),
        .host_writedata(host_writedata), .host_readdata(host_readdata),
        .host_readvalid(host_readvalid), .broken(broken), .reads(reads), .writes(writes));

    // The accesses, drawn beforehand.
    reg [ADDRESS+1:0] write_address [0:COUNT-1];
    reg [3:0]         write_strobes [0:COUNT-1];
    reg [ADDRESS+1:0] read_address  [0:COUNT-1];
    // Number of the last write of each word, from 1, whose response was
    // taken; and when each read was asked for.
    integer answered_write [0:(1 << ADDRESS)-1];
    integer oldest [0:COUNT-1];

    integer i;
    integer addresses, data, responses;
    integer asked, taken;
    integer good_writes, good_reads, clocks;
    integer mistakes, quiet;
    // Chances of eight that a VALID or READY comes in a clock.
    integer chance [0:4];

    // The word a write carries: its number below, something else above.
    function [31:0] payload(input integer number);
        payload = {number[15:0] ^ 16'h5A3C, number[15:0] + 16'd1};
    endfunction

    function in_range(input [ADDRESS+1:0] address);
        in_range = address[ADDRESS+1:2] < WORDS;
    endfunction

    function written(input integer number);
        written = in_range(write_address[number]) && write_strobes[number] == 4'hF;
    endfunction

    task mistake(input [8*40-1:0] what);
        begin
            mistakes = mistakes + 1;
            if (mistakes <= 10)
                $display("clock %0d: %0s (write %0d of address %0d, response %0d, read %0d)",
                    clocks, what, data, addresses, responses, taken);
        end
    endtask

    // Whether a channel moves in this clock; three bits of the dice for each.
    reg [31:0] dice;
    function go(input integer channel);
        go = ((dice >> (3 * channel)) & 32'd7) < chance[channel];
    endfunction

    // Xorshift (Marsaglia, 2003), so that all simulators see the same numbers.
    function [31:0] following(input [31:0] number);
        begin
            following = number ^ (number << 13);
            following = following ^ (following >> 17);
            following = following ^ (following << 5);
        end
    endfunction

    initial begin
        dice = 32'd12345;
        for (i = 0; i < COUNT; i = i + 1) begin
            dice = following(dice);
            write_address[i] = dice[8 +: ADDRESS + 2];
            read_address[i]  = dice[20 +: ADDRESS + 2];
            dice = following(dice);
            write_strobes[i] = dice[2:0] != 0 ? 4'hF : dice[6:3];
        end
        for (i = 0; i < (1 << ADDRESS); i = i + 1) answered_write[i] = 0;
        for (i = 0; i < 5; i = i + 1) chance[i] = 8;
        addresses = 0; data = 0; responses = 0; asked = 0; taken = 0;
        good_writes = 0; good_reads = 0; clocks = 0; mistakes = 0; quiet = 0;
    end

    // Channels as they were in the clock before.
    reg        bvalid_before = 1'b0, bready_before = 1'b0;
    reg        rvalid_before = 1'b0, rready_before = 1'b0;
    reg [1:0]  bresp_before = 2'd0, rresp_before = 2'd0;
    reg [31:0] rdata_before = 32'd0;

    integer version;
    always @(posedge clock) begin
        clocks = clocks + 1;
        resetn <= clocks > 4;
        if (resetn) begin
            // What was accepted in this clock.
            if (bvalid & bready) begin
                if (responses >= addresses) mistake("response before its address");
                if (responses >= data) mistake("response before its data");
                if (bresp !== ((in_range(write_address[responses])
                        && (written(responses) || write_strobes[responses] == 4'h0)) ? OKAY : SLVERR))
                    mistake("wrong write response");
                if (written(responses)) begin
                    good_writes = good_writes + 1;
                    answered_write[write_address[responses][ADDRESS+1:2]] = responses + 1;
                    if (writes < good_writes) mistake("response before the write");
                end
                responses = responses + 1;
            end
            if (rvalid & rready) begin
                if (!in_range(read_address[taken])) begin
                    if (rresp !== SLVERR || rdata !== 32'd0) mistake("wrong response beyond the end");
                end else begin
                    good_reads = good_reads + 1;
                    version = rdata[15:0];
                    if (rresp !== OKAY) mistake("wrong read response");
                    if (version < oldest[taken]) mistake("read of an old value");
                    if (version > data) mistake("read of a value of the future");
                    if (version != 0) begin
                        if (rdata !== payload(version - 1)) mistake("read of a torn value");
                        if (write_address[version - 1][ADDRESS+1:2] != read_address[taken][ADDRESS+1:2]
                                || !written(version - 1))
                            mistake("read of another word");
                    end else if (rdata !== 32'd0) mistake("read of nothing");
                end
                taken = taken + 1;
            end
            // What is offered stays until it is accepted.
            if (bvalid_before & ~bready_before & (~bvalid | (bresp !== bresp_before)))
                mistake("write response taken back");
            if (rvalid_before & ~rready_before
                    & (~rvalid | (rdata !== rdata_before) | (rresp !== rresp_before)))
                mistake("read data taken back");
            if ((bvalid !== 1'b0 && bvalid !== 1'b1) || (rvalid !== 1'b0 && rvalid !== 1'b1))
                mistake("unknown VALID");
            if (awvalid & awready) addresses = addresses + 1;
            if (wvalid & wready) data = data + 1;
            if (arvalid & arready) asked = asked + 1;

            // What is offered next.
            dice = following(dice);
            if (~awvalid | awready) begin
                awvalid <= addresses < COUNT && go(0);
                if (addresses < COUNT) awaddr <= write_address[addresses];
            end
            if (~wvalid | wready) begin
                wvalid <= data < COUNT && go(1);
                if (data < COUNT) begin
                    wdata <= payload(data);
                    wstrb <= write_strobes[data];
                end
            end
            bready <= go(2);
            if (~arvalid | arready) begin
                arvalid <= asked < COUNT && go(3);
                if (asked < COUNT) begin
                    araddr <= read_address[asked];
                    oldest[asked] = answered_write[read_address[asked][ADDRESS+1:2]];
                end
            end
            rready <= go(4);
        end
        bvalid_before <= bvalid; bready_before <= bready; bresp_before <= bresp;
        rvalid_before <= rvalid; rready_before <= rready;
        rresp_before  <= rresp;  rdata_before  <= rdata;

        // Other gaps every now and then, all channels at full speed among
        // them.
        if (clocks % PHASE == 0) begin
            for (i = 0; i < 5; i = i + 1) begin
                dice = following(dice);
                chance[i] = 1 + dice[2:0];
                if (clocks % (4 * PHASE) == 0) chance[i] = 8;
            end
        end

        // Some clocks later, so that an answer too many is seen as well.
        quiet = responses >= COUNT && taken >= COUNT ? quiet + 1 : 0;
        if (quiet > 20 || clocks > 60 * COUNT || mistakes > 100) begin
            if (responses != COUNT || taken != COUNT) mistake("accesses without an answer");
            if (broken != 0) mistake("host bus misused");
            if (writes != good_writes) mistake("writes lost or doubled");
            if (reads != good_reads) mistake("reads lost or doubled");
            if (mistakes != 0) begin
                $display("FAIL robovec_axi4lite: %0d mistakes", mistakes);
                $stop;
            end
            $display("PASS robovec_axi4lite: %0d writes and %0d reads in %0d clocks, %0d and %0d of them on the host bus",
                COUNT, COUNT, clocks, good_writes, good_reads);
            $finish;
        end
    end
endmodule

`default_nettype wire
