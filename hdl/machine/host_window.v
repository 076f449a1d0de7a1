// The host's window into the machine: control registers, and a way into
// every instruction and operand memory.
//
// Addresses count 32-bit words.
//
//   0   CONTROL        written: bit 0 starts the program, bit 1 clears `done`
//   1   STATUS         bit 0: running, bit 1: done; from a start until `done`
//                      is cleared one of them is set
//   2   CYCLES         length of the program
//   3,4 SCHEDULE HASH  low and high half: which program is loaded, for the
//                      host to keep
//   5,6 MACHINE HASH   low and high half: which programs fit
//   7   VERSION        of this map, 1
//
// Memories follow from address 8 on (the generated top decodes them). Words
// of more than 32 bits are written limb by limb, the lowest first, without
// another memory access in between; writing the highest limb writes the
// word. While a program runs the memories are its own: writes to them have
// no effect and reads give nothing of use.
//
// Reads are pipelined and take READ_LATENCY = 4 clocks.
//
// Parameters
//   ADDRESS         bits of the host's address
//   LIMBS           32-bit limbs of the widest word that is written
//   WIDTH           bits of a data word, at most 64
//   CYCLE           bits of a cycle's number, at most 30
//   CYCLES, SCHEDULE_HASH   of the program loaded at configuration
//   MACHINE_HASH    what the machine can run
//
// Ports
//   host_...        the host's bus; `host_readvalid` tells when
//                   `host_readdata` is what was asked for
//   start, cycles   to the sequencer
//   running, finished   from it
//   unit_access     the host reads or writes a memory in this clock
//   unit_write      it writes a limb
//   unit_address    which; 0 in all other clocks
//   unit_data       the limb and those written before it, the last one
//                   highest: a word of k limbs is its highest k limbs
//   unit_word       the operand word that was addressed two clocks before
module host_window #(
    parameter ADDRESS = 16,
    parameter LIMBS = 2,
    parameter WIDTH = 32,
    parameter CYCLE = 10,
    parameter CYCLES = 0,
    parameter [63:0] SCHEDULE_HASH = 64'd0,
    parameter [63:0] MACHINE_HASH = 64'd0
) (
    input                     clock,
    input                     reset,
    input                     host_write,
    input                     host_read,
    input      [ADDRESS-1:0]  host_address,
    input      [31:0]         host_writedata,
    output reg [31:0]         host_readdata,
    output                    host_readvalid,
    output reg                start,
    output reg [CYCLE:0]      cycles,
    input                     running,
    input                     finished,
    output reg                unit_access,
    output reg                unit_write,
    output reg [ADDRESS-1:0]  unit_address,
    output     [32*LIMBS-1:0] unit_data,
    input      [WIDTH-1:0]    unit_word
);

    wire control = host_address[ADDRESS-1:3] == 0;
    wire access = (host_read | host_write) & ~control & ~running;

    // Memories: the access of the last clock.
    reg [32*LIMBS-1:0] limbs;
    assign unit_data = limbs;

    always @(posedge clock) begin
        unit_access <= access & ~reset;
        unit_write <= access & host_write & ~reset;
        unit_address <= access ? host_address : {ADDRESS{1'b0}};
    end

    generate
        if (LIMBS == 1) begin : narrow
            always @(posedge clock)
                if (host_write & ~control) limbs <= host_writedata;
        end else begin : wide
            always @(posedge clock)
                if (host_write & ~control) limbs <= {host_writedata, limbs[32*LIMBS-1:32]};
        end
    endgenerate

    // Control registers.
    reg        done;
    reg [63:0] schedule_hash;
    wire       registers = host_write & control;

    always @(posedge clock)
        if (reset) begin
            start <= 1'b0;
            done <= 1'b0;
            cycles <= CYCLES;
            schedule_hash <= SCHEDULE_HASH;
        end else begin
            start <= registers & (host_address[2:0] == 0) & host_writedata[0];
            if (finished)
                done <= 1'b1;
            else if (registers & (host_address[2:0] == 0) & (|host_writedata[1:0]))
                done <= 1'b0;
            if (registers & (host_address[2:0] == 2)) cycles <= host_writedata[CYCLE:0];
            if (registers & (host_address[2:0] == 3)) schedule_hash[31:0] <= host_writedata;
            if (registers & (host_address[2:0] == 4)) schedule_hash[63:32] <= host_writedata;
        end

    // Reading: control registers are taken in the clock of the access, an
    // operand word arrives two clocks after the memory saw its address.
    reg [3:0]  reading;
    reg [95:0] register_read;
    reg [2:0]  register_is_read;
    reg [2:0]  high_limb;
    reg [31:0] register_now;

    assign host_readvalid = reading[3];

    always @* begin
        case (host_address[2:0])
            3'd1: register_now = {30'd0, done, running | start | finished};
            3'd2: register_now = {{(31 - CYCLE) {1'b0}}, cycles};
            3'd3: register_now = schedule_hash[31:0];
            3'd4: register_now = schedule_hash[63:32];
            3'd5: register_now = MACHINE_HASH[31:0];
            3'd6: register_now = MACHINE_HASH[63:32];
            3'd7: register_now = 32'd1;
            default: register_now = 32'd0;
        endcase
    end

    wire [63:0] wide_word = {{(64 - WIDTH) {1'b0}}, unit_word};

    always @(posedge clock) begin
        reading <= reset ? 4'd0 : {reading[2:0], host_read};
        register_is_read <= {register_is_read[1:0], control};
        high_limb <= {high_limb[1:0], host_address[0]};
        register_read <= {register_read[63:0], register_now};
        if (register_is_read[2])
            host_readdata <= register_read[95:64];
        else if (WIDTH > 32 && high_limb[2])
            host_readdata <= wide_word[63:32];
        else
            host_readdata <= wide_word[31:0];
    end

endmodule
