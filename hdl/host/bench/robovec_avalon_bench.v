// Self-checking bench of robovec_avalon: many random accesses with random
// gaps, answered by a host bus of random latency.
//
// An Avalon host gives one order of accesses, so a read must see exactly what
// the last whole write before it wrote; the host of this bench goes on as
// soon as an access is taken, so reads are followed by writes while their
// data are still under way.
`default_nettype none
`timescale 1ns / 1ps

module robovec_avalon_bench;
    localparam ADDRESS = 6;
    localparam WORDS = 50;
    localparam COUNT = 10000;
    localparam PHASE = 500;
    localparam [1:0] OKAY = 2'b00;
    localparam [1:0] DECODE_ERROR = 2'b11;

    reg clock = 1'b0;
    always #5 clock = ~clock;
    reg reset = 1'b1;

    reg  [ADDRESS-1:0] address = 0;
    reg                read = 1'b0, write = 1'b0;
    reg  [31:0]        data = 0;
    reg  [3:0]         enables = 0;
    wire               waitrequest, readdatavalid;
    wire [31:0]        readdata;
    wire [1:0]         response;
    wire               host_write, host_read, host_readvalid;
    wire [ADDRESS-1:0] host_address;
    wire [31:0]        host_writedata, host_readdata, broken, reads, writes;

    robovec_avalon #(.ADDRESS(ADDRESS), .WORDS(WORDS)) adapter (
        .clock(clock), .reset(reset),
        .avs_address(address), .avs_read(read), .avs_write(write), .avs_writedata(data),
        .avs_byteenable(enables), .avs_waitrequest(waitrequest), .avs_readdata(readdata),
        .avs_readdatavalid(readdatavalid), .avs_response(response),
        .host_write(host_write), .host_read(host_read), .host_address(host_address),
        .host_writedata(host_writedata), .host_readdata(host_readdata),
        .host_readvalid(host_readvalid));

    host_bus_model #(.ADDRESS(ADDRESS), .WORDS(WORDS)) bus (
        .clock(clock), .reset(reset),
        .host_write(host_write), .host_read(host_read), .host_address(host_address),
        .host_writedata(host_writedata), .host_readdata(host_readdata),
        .host_readvalid(host_readvalid), .broken(broken), .reads(reads), .writes(writes));

    // What the window must hold, and what the reads under way must find.
    reg [31:0] shadow   [0:(1 << ADDRESS)-1];
    reg [33:0] expected [0:COUNT-1];

    integer i;
    integer taken, reads_taken, answers;
    integer good_writes, good_reads, clocks;
    integer mistakes;
    integer chance;
    integer quiet;
    reg [31:0] dice, number;

    task mistake(input [8*40-1:0] what);
        begin
            mistakes = mistakes + 1;
            if (mistakes <= 10)
                $display("clock %0d: %0s (access %0d, answer %0d)", clocks, what, taken, answers);
        end
    endtask

    // Xorshift (Marsaglia, 2003), so that all simulators see the same numbers.
    function [31:0] following(input [31:0] number);
        begin
            following = number ^ (number << 13);
            following = following ^ (following >> 17);
            following = following ^ (following << 5);
        end
    endfunction

    initial begin
        dice = 32'd2345671;
        for (i = 0; i < (1 << ADDRESS); i = i + 1) shadow[i] = 32'd0;
        taken = 0; reads_taken = 0; answers = 0; good_writes = 0; good_reads = 0;
        clocks = 0; mistakes = 0; chance = 8; quiet = 0;
    end

    always @(posedge clock) begin
        clocks = clocks + 1;
        reset <= clocks <= 4;
        if (~reset) begin
            if (waitrequest !== 1'b0 && waitrequest !== 1'b1) mistake("unknown waitrequest");
            if (readdatavalid !== 1'b0 && readdatavalid !== 1'b1) mistake("unknown readdatavalid");
            // Data come at the earliest in the clock after their read.
            if (readdatavalid) begin
                if (answers >= reads_taken) mistake("data without a read");
                else if ({response, readdata} !== expected[answers]) mistake("wrong data or response");
                answers = answers + 1;
            end
            if ((read | write) & ~waitrequest) begin
                taken = taken + 1;
                if (write && address < WORDS && enables == 4'hF) begin
                    shadow[address] = data;
                    good_writes = good_writes + 1;
                end
                if (read) begin
                    if (reads_taken - answers >= 1) mistake("two reads under way");
                    expected[reads_taken] = address < WORDS ? {OKAY, shadow[address]}
                                                            : {DECODE_ERROR, 32'd0};
                    reads_taken = reads_taken + 1;
                    if (address < WORDS) good_reads = good_reads + 1;
                end
            end
            if (~(read | write) | ~waitrequest) begin
                dice   = following(dice);
                number = following(dice);
                dice   = following(number);
                write   <= taken < COUNT && dice[2:0] < chance && dice[3];
                read    <= taken < COUNT && dice[2:0] < chance && ~dice[3];
                address <= dice[4 +: ADDRESS];
                enables <= dice[18:16] != 0 ? 4'hF : dice[22:19];
                data    <= number;
            end
        end
        if (clocks % PHASE == 0) begin
            dice   = following(dice);
            chance = clocks % (4 * PHASE) == 0 ? 8 : 1 + dice[2:0];
        end

        // Some clocks later, so that an answer too many is seen as well.
        quiet = taken >= COUNT && answers >= reads_taken ? quiet + 1 : 0;
        if (quiet > 20 || clocks > 60 * COUNT || mistakes > 100) begin
            if (taken < COUNT || answers != reads_taken) mistake("accesses without an answer");
            if (broken != 0) mistake("host bus misused");
            if (writes != good_writes) mistake("writes lost or doubled");
            if (reads != good_reads) mistake("reads lost or doubled");
            if (mistakes != 0) begin
                $display("FAIL robovec_avalon: %0d mistakes", mistakes);
                $stop;
            end
            $display("PASS robovec_avalon: %0d writes and %0d reads in %0d clocks, %0d and %0d of them on the host bus",
                taken - reads_taken, reads_taken, clocks, good_writes, good_reads);
            $finish;
        end
    end
endmodule

`default_nettype wire
