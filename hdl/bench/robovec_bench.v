// Self-checking bench of a machine with a program, in plain Verilog.
//
// It plays a host that knows nothing but the manifest: it carries out the
// commands of host.hex through one of the machine's windows, with gaps and
// back-pressure where a bus has them. While a program runs, every result of
// every operation is compared with the one the cycle-accurate simulator has
// computed (results.hex), in the cycle and on the element where it belongs
// (places.hex).
//
// The way in is the machine's own host bus, or with +avalon the Avalon-MM
// agent, or with +axi4lite the AXI4-Lite subordinate. Compiled with
// ROBOVEC_CONFIGURED the machine holds the images from configuration on, and
// only inputs are loaded (configured.hex). The last line says PASS or FAIL; `vvp -N` ends with a code other than zero after FAIL.
`include "bench_config.vh"
`timescale 1ns / 1ps

module robovec_bench;
    localparam WIDTH = `ROBOVEC_WIDTH;
    localparam ADDRESS = `ROBOVEC_ADDRESS;
    localparam OPERATIONS = `ROBOVEC_OPERATIONS;

`ifdef ROBOVEC_CONFIGURED
    localparam COMMANDS = `ROBOVEC_CONFIGURED_COMMANDS;
`else
    localparam COMMANDS = `ROBOVEC_COMMANDS;
`endif

    // Commands; see the generated host.hex.
    localparam [7:0] END = 8'd0, WRITE = 8'd1, READ = 8'd2, START = 8'd3, WAIT = 8'd4;
    // Mistakes that are told one by one.
    localparam MOST_TOLD = 10;

    reg clock = 1'b0;
    always #5 clock = ~clock;
    reg       reset = 1'b1;
    reg [1:0] window = 2'd0;

    reg                bus_write = 1'b0, bus_read = 1'b0;
    reg  [ADDRESS-1:0] bus_address = 0;
    reg  [31:0]        bus_writedata = 0;
    wire [31:0]        bus_readdata;
    wire               bus_readvalid;
    reg                avs_write = 1'b0, avs_read = 1'b0;
    wire               avs_waitrequest, avs_readdatavalid;
    wire [31:0]        avs_readdata;
    wire [1:0]         avs_response;
    reg                axi_awvalid = 1'b0, axi_wvalid = 1'b0, axi_bready = 1'b0;
    reg                axi_arvalid = 1'b0, axi_rready = 1'b0;
    wire               axi_awready, axi_wready, axi_bvalid, axi_arready, axi_rvalid;
    wire [1:0]         axi_bresp, axi_rresp;
    wire [31:0]        axi_rdata;

    wire                               running, results_running;
    wire [`ROBOVEC_ELEMENTS*WIDTH-1:0] results;
    wire [31:0]                        results_cycle;

    robovec_bench_top top (
        .clock(clock), .reset(reset), .window(window),
        .bus_write(bus_write), .bus_read(bus_read), .bus_address(bus_address),
        .bus_writedata(bus_writedata), .bus_readdata(bus_readdata),
        .bus_readvalid(bus_readvalid),
        .avs_address(bus_address), .avs_read(avs_read), .avs_write(avs_write),
        .avs_writedata(bus_writedata), .avs_byteenable(4'hF),
        .avs_waitrequest(avs_waitrequest), .avs_readdata(avs_readdata),
        .avs_readdatavalid(avs_readdatavalid), .avs_response(avs_response),
        .axi_awaddr({bus_address, 2'b00}), .axi_awvalid(axi_awvalid), .axi_awready(axi_awready),
        .axi_wdata(bus_writedata), .axi_wstrb(4'hF), .axi_wvalid(axi_wvalid),
        .axi_wready(axi_wready), .axi_bresp(axi_bresp), .axi_bvalid(axi_bvalid),
        .axi_bready(axi_bready), .axi_araddr({bus_address, 2'b00}), .axi_arvalid(axi_arvalid),
        .axi_arready(axi_arready), .axi_rdata(axi_rdata), .axi_rresp(axi_rresp),
        .axi_rvalid(axi_rvalid), .axi_rready(axi_rready),
        .running(running), .results(results), .results_cycle(results_cycle),
        .results_running(results_running));

    // Kind, note, address, data.
    reg [95:0]      commands [0:COMMANDS-1];
    // Element, cycle: in order of cycle and element.
    reg [63:0]      places   [0:OPERATIONS];
    // As the places, run after run.
    reg [WIDTH-1:0] expected [0:OPERATIONS*`ROBOVEC_RUNS];

    integer mistakes, clocks, compared, read_back;

    // A line of a text, counted from 0, to say what a mistake is about.
    task tell_line(input [8*16-1:0] name, input integer number);
        integer file, i, length;
        reg [8*512-1:0] line;
        begin
            file = $fopen(name, "r");
            line = 0;
            length = 1;
            for (i = 0; i <= number && length != 0; i = i + 1) length = $fgets(line, file);
            $fclose(file);
            // The line ends with the end of its line.
            $write("  %0s", line);
        end
    endtask

    // ---- Results, each in its cycle.

    // The run, the next place in it, the next cycle.
    integer run, place, next_cycle;
    integer element;
    reg     in_run;

    task mistake;
        mistakes = mistakes + 1;
    endtask

    always @(posedge clock) begin
        clocks = clocks + 1;
        if (!reset && results_running !== 1'b0 && results_running !== 1'b1) begin
            mistake;
            if (mistakes <= MOST_TOLD) $display("clock %0d: results_running is unknown", clocks);
        end
        if (results_running === 1'b1) begin
            if (!in_run || results_cycle !== next_cycle) begin
                mistake;
                if (mistakes <= MOST_TOLD)
                    $display("run %0d: the machine is in cycle %0d instead of %0d",
                        run, results_cycle, in_run ? next_cycle : -1);
            end
            next_cycle = results_cycle + 1;
            while (place < OPERATIONS && places[place][31:0] < next_cycle) begin
                element = places[place][63:32];
                if (places[place][31:0] !== results_cycle
                        || results[element*WIDTH +: WIDTH] !== expected[run*OPERATIONS + place]) begin
                    mistake;
                    if (mistakes <= MOST_TOLD) begin
                        $display("run %0d, cycle %0d: result %h instead of %h:", run, results_cycle,
                            results[element*WIDTH +: WIDTH], expected[run*OPERATIONS + place]);
                        tell_line("operations.txt", place);
                    end
                end
                compared = compared + 1;
                place = place + 1;
            end
        end
        if (clocks > `ROBOVEC_MOST_CLOCKS) begin
            $display("FAIL: no end after %0d clocks", clocks);
            $stop;
        end
    end

    // ---- The host.

    // Xorshift (Marsaglia, 2003), for gaps.
    reg [31:0] dice = 32'd20251;
    task roll;
        begin
            dice = dice ^ (dice << 13);
            dice = dice ^ (dice >> 17);
            dice = dice ^ (dice << 5);
        end
    endtask

    // Everything is driven a while after the edge; what is seen then, after
    // another while, is what registers take at the next edge.
    task step;
        begin
            @(posedge clock);
            #1;
        end
    endtask

    // One access in sixteen has gaps of up to seven clocks in it.
    reg is_slow;
    task gap;
        integer i;
        begin
            roll;
            is_slow = dice[11:8] == 4'd0;
            if (is_slow) for (i = dice[2:0]; i > 0; i = i - 1) step;
        end
    endtask

    // Whether a side is ready in this clock.
    reg goes;
    task decide;
        begin
            goes = 1'b1;
            if (is_slow) begin
                roll;
                goes = dice[9:8] == 2'd0;
            end
        end
    endtask

    task complain(input [8*48-1:0] what);
        begin
            mistake;
            if (mistakes <= MOST_TOLD)
                $display("clock %0d, address %0h: %0s", clocks, bus_address, what);
        end
    endtask

    task host_write(input [31:0] address, input [31:0] data);
        begin
            gap;
            bus_address   = address[ADDRESS-1:0];
            bus_writedata = data;
            case (window)
                2'd1: begin
                    avs_write = 1'b1;
                    avalon_taken;
                    avs_write = 1'b0;
                end
                2'd2: axi_write;
                default: begin
                    bus_write = 1'b1;
                    step;
                    bus_write = 1'b0;
                end
            endcase
        end
    endtask

    task host_read(input [31:0] address, output [31:0] data);
        begin
            gap;
            bus_address = address[ADDRESS-1:0];
            case (window)
                2'd1: begin
                    avs_read = 1'b1;
                    avalon_taken;
                    avs_read = 1'b0;
                    left = 1'b1;
                    while (left) begin
                        #1 left = avs_readdatavalid !== 1'b1;
                        data = avs_readdata;
                        if (!left && avs_response !== 2'b00)
                            complain("the read response is an error");
                        step;
                    end
                end
                2'd2: axi_read(data);
                default: begin
                    bus_read = 1'b1;
                    left = 1'b1;
                    while (left) begin
                        #1 left = bus_readvalid !== 1'b1;
                        data = bus_readdata;
                        step;
                        bus_read = 1'b0;
                    end
                end
            endcase
        end
    endtask

    // What an access still waits for.
    reg left, address_left, data_left, response_left, now;

    task avalon_taken;
        begin
            left = 1'b1;
            while (left) begin
                #1 left = avs_waitrequest !== 1'b0;
                step;
            end
        end
    endtask

    // Address and data are offered on their own, and the response is taken
    // when it suits.
    task axi_write;
        begin
            address_left = 1'b1;
            data_left = 1'b1;
            response_left = 1'b1;
            while (address_left || data_left || response_left) begin
                decide;
                if (address_left && goes) axi_awvalid = 1'b1;
                decide;
                if (data_left && goes) axi_wvalid = 1'b1;
                decide;
                axi_bready = goes;
                #1;
                if (axi_bvalid === 1'b1 && axi_bready) begin
                    if (address_left || data_left) complain("a response before its write");
                    if (axi_bresp !== 2'b00) complain("the write response is an error");
                    response_left = 1'b0;
                end
                if (axi_awvalid && axi_awready === 1'b1) address_left = 1'b0;
                if (axi_wvalid && axi_wready === 1'b1) data_left = 1'b0;
                step;
                if (!address_left) axi_awvalid = 1'b0;
                if (!data_left) axi_wvalid = 1'b0;
            end
            axi_bready = 1'b0;
        end
    endtask

    task axi_read(output [31:0] data);
        begin
            address_left = 1'b1;
            left = 1'b1;
            while (left) begin
                decide;
                if (address_left && goes) axi_arvalid = 1'b1;
                decide;
                axi_rready = goes;
                #1;
                now = axi_rvalid === 1'b1 && axi_rready;
                if (now) begin
                    left = 1'b0;
                    data = axi_rdata;
                    if (address_left || axi_rresp !== 2'b00)
                        complain("the read response is an error");
                end
                if (axi_arvalid && axi_arready === 1'b1) address_left = 1'b0;
                step;
                if (!address_left) axi_arvalid = 1'b0;
            end
            axi_rready = 1'b0;
        end
    endtask

    task finish_run;
        begin
            if (in_run && next_cycle != `ROBOVEC_CYCLES) begin
                mistake;
                $display("run %0d ended before cycle %0d of %0d", run, next_cycle, `ROBOVEC_CYCLES);
            end
            if (in_run && place != OPERATIONS) begin
                mistake;
                $display("run %0d: %0d of %0d results were not seen", run, OPERATIONS - place,
                    OPERATIONS);
            end
            in_run = 1'b0;
        end
    endtask

    integer    index, since;
    reg [95:0] command;
    reg [31:0] answer;
    initial begin
        mistakes = 0; clocks = 0; compared = 0; read_back = 0;
        run = -1; place = 0; next_cycle = 0; in_run = 1'b0;
`ifdef ROBOVEC_CONFIGURED
        $readmemh("configured.hex", commands, 0, COMMANDS-1);
`else
        $readmemh("host.hex", commands, 0, COMMANDS-1);
`endif
        $readmemh("places.hex", places, 0, OPERATIONS);
        $readmemh("results.hex", expected, 0, OPERATIONS*`ROBOVEC_RUNS);
        if ($test$plusargs("avalon")) window = 2'd1;
        if ($test$plusargs("axi4lite")) window = 2'd2;
        repeat (8) step;
        reset = 1'b0;
        repeat (4) step;
        index = 0;
        command = commands[0];
        while (command[95:88] !== END) begin
            case (command[95:88])
                WRITE: host_write(command[63:32], command[31:0]);
                READ: begin
                    host_read(command[63:32], answer);
                    read_back = read_back + 1;
                    if (answer !== command[31:0]) begin
                        mistake;
                        if (mistakes <= MOST_TOLD) begin
                            $display("address %0h reads %h instead of %h:", command[63:32], answer,
                                command[31:0]);
                            tell_line("reads.txt", command[87:64]);
                        end
                    end
                end
                START: begin
                    run = run + 1;
                    place = 0;
                    next_cycle = 0;
                    in_run = 1'b1;
                    host_write(command[63:32], command[31:0]);
                end
                WAIT: begin
                    since = clocks;
                    answer = 32'd0;
                    bus_address = command[32+:ADDRESS];
                    // On the bus the status is read in every clock, so that no
                    // state of it is missed.
                    bus_read = window == 2'd0;
                    while ((answer & command[31:0]) !== command[31:0]) begin
                        if (window != 2'd0)
                            host_read(command[63:32], answer);
                        else begin
                            #1 left = bus_readvalid !== 1'b1;
                            if (!left) answer = bus_readdata;
                            step;
                        end
                        if ((window != 2'd0 || !left) && answer[1:0] === 2'b00)
                            complain("the status is neither running nor done");
                        if (clocks - since > `ROBOVEC_MOST_WAIT) begin
                            $display("FAIL: run %0d has not ended after %0d clocks", run,
                                clocks - since);
                            $stop;
                        end
                    end
                    // Reads on their way are of no interest.
                    bus_read = 1'b0;
                    repeat (8) step;
                    finish_run;
                end
                default: begin
                    $display("FAIL: there is no command in line %0d", index + 1);
                    $stop;
                end
            endcase
            index = index + 1;
            command = commands[index];
        end
        if (run + 1 != `ROBOVEC_RUNS) complain("not all runs were started");
        $write("%0s %0s, Verilog, ", mistakes == 0 ? "PASS" : "FAIL", `ROBOVEC_NAME);
        case (window)
            2'd1: $write("Avalon-MM");
            2'd2: $write("AXI4-Lite");
`ifdef ROBOVEC_CONFIGURED
            default: $write("configured");
`else
            default: $write("host bus");
`endif
        endcase
        $display(": %0d runs of %0d cycles, %0d results compared each in its cycle, %0d words read back, %0d clocks, %0d mistakes",
            run + 1, `ROBOVEC_CYCLES, compared, read_back, clocks, mistakes);
        if (mistakes != 0) $stop;
        $finish;
    end
endmodule
