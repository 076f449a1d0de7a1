// Streams vectors through `top` and compares its results: each exactly STAGES
// enabled clocks after its operands, and unchanged while enable is low.

module bench;
    parameter COUNT = 1;
    parameter STAGES = 1;
    parameter WIDTH = 32;

    reg [259:0] vectors [0:COUNT-1];
    reg         clock;
    reg         enable;
    reg [259:0] vector;
    wire [WIDTH-1:0] result;
    reg  [WIDTH-1:0] expected;

    top top (
        .clock(clock),
        .enable(enable),
        .operation(vector[257:256]),
        .left(vector[192+:WIDTH]),
        .right(vector[128+:WIDTH]),
        .addend(vector[64+:WIDTH]),
        .result(result)
    );

    integer issued;
    integer checked;
    integer wrong;
    integer seed;
    initial begin
        $readmemh("vectors.hex", vectors);
        clock = 0;
        issued = 0;
        checked = 0;
        wrong = 0;
        seed = 1;
        while (issued < COUNT + STAGES - 1) begin
            enable = $random(seed) % 8 != 0;
            vector = vectors[issued < COUNT ? issued : 0];
            if (!enable) vector = ~vector;
            #1 clock = 1;
            #1;
            if (enable) begin
                issued = issued + 1;
                if (issued >= STAGES) checked = checked + 1;
            end
            if (issued >= STAGES) begin
                vector = vectors[issued-STAGES];
                expected = vector[0+:WIDTH];
                if (result !== expected) begin
                    wrong = wrong + 1;
                    if (wrong <= 5)
                        $display("vector %h gives %h", vector, result);
                    else begin
                        $display("checked %0d wrong %0d", checked, wrong);
                        $finish;
                    end
                end
            end
            clock = 0;
            #1;
        end
        $display("checked %0d wrong %0d", checked, wrong);
        $finish;
    end
endmodule
