// A host on the programming cable: Altera's virtual JTAG onto the host bus.
//
// The cable that configures the device also reaches this block, so a program
// can be loaded, started and read from a script (quartus_stp) without any
// other wire and without a generated system of bridges. The block is the one
// place that knows the vendor's sld_virtual_jtag.
//
// Every scan of the data register is 33 bits long, lowest bit first: bit 0 is
// `valid`, bits 32..1 are a word. What a scan does depends on the virtual
// instruction:
//
//   1  ADDRESS  the word becomes the address, in 32-bit words
//   2  WRITE    the word is written at the address, which counts up
//   3  READ     shifts out the word that the last READ scan asked for, with
//               `valid` set, then asks for the word at the address, which
//               counts up. A scan that comes too early shifts out `valid` 0
//               and asks for nothing: the script repeats it. So does the
//               first READ scan after an ADDRESS scan.
//
// The cable's clock and the machine's know nothing of each other. A request
// crosses as a change of `request`, its answer as a change of `answer`; what
// goes with them stands still until the other side has changed. A write needs
// no answer, since 33 bits of the next scan take longer than its crossing.
//
// Parameters
//   ADDRESS   bits of the host's address
//
// Ports
//   clock, reset   the machine's
//   host_...       the host bus of robovec_machine

module virtual_jtag_host #(
    parameter ADDRESS = 16
) (
    input                    clock,
    input                    reset,
    output reg               host_write,
    output reg               host_read,
    output     [ADDRESS-1:0] host_address,
    output     [31:0]        host_writedata,
    input      [31:0]        host_readdata,
    input                    host_readvalid
);

    localparam [1:0] SET_ADDRESS = 2'd1;
    localparam [1:0] WRITE = 2'd2;
    localparam [1:0] READ = 2'd3;

    wire       tck;
    wire       tdi;
    wire       tdo;
    wire [1:0] instruction;
    wire       capture;
    wire       shift;
    wire       update;

    sld_virtual_jtag #(
        .sld_auto_instance_index("YES"),
        .sld_instance_index(0),
        .sld_ir_width(2),
        .sld_sim_action(""),
        .sld_sim_n_scan(0),
        .sld_sim_total_length(0)
    ) jtag (
        .tck(tck),
        .tdi(tdi),
        .tdo(tdo),
        .ir_in(instruction),
        .ir_out(2'b00),
        .virtual_state_cdr(capture),
        .virtual_state_sdr(shift),
        .virtual_state_udr(update)
    );

    // The cable's side. Nothing resets it: the device configures it to zero.
    reg [32:0]        scan = 33'd0;
    reg [ADDRESS-1:0] address = {ADDRESS{1'b0}};
    reg               request = 1'b0;
    reg               asked = 1'b0;
    reg               delivered = 1'b0;
    reg               writes = 1'b0;
    reg [ADDRESS-1:0] request_address = {ADDRESS{1'b0}};
    reg [31:0]        request_data = 32'd0;
    reg [1:0]         answer_seen = 2'b00;
    // The machine's side.
    reg        answer = 1'b0;
    reg [31:0] answer_data = 32'd0;

    assign tdo = scan[0];
    wire ready = request == answer_seen[1];

    always @(posedge tck) begin
        answer_seen <= {answer_seen[0], answer};
        if (capture) begin
            scan <= {answer_data, asked & ready};
            delivered <= asked & ready;
        end
        if (shift) scan <= {tdi, scan[32:1]};
        if (update)
            case (instruction)
                SET_ADDRESS: begin
                    address <= scan[ADDRESS:1];
                    asked <= 1'b0;
                end
                WRITE: begin
                    request <= ~request;
                    writes <= 1'b1;
                    request_address <= address;
                    request_data <= scan[32:1];
                    address <= address + 1'b1;
                end
                READ:
                    // What this scan did not bring is not passed over.
                    if (ready & (delivered | ~asked)) begin
                        request <= ~request;
                        writes <= 1'b0;
                        request_address <= address;
                        address <= address + 1'b1;
                        asked <= 1'b1;
                    end
                default: asked <= 1'b0;
            endcase
    end

    assign host_address = request_address;
    assign host_writedata = request_data;

    reg [2:0] request_seen = 3'b000;
    reg       waiting = 1'b0;
    wire      arrives = request_seen[2] ^ request_seen[1];

    always @(posedge clock) begin
        request_seen <= {request_seen[1:0], request};
        host_write <= arrives & writes;
        host_read <= arrives & ~writes;
        if (arrives) waiting <= ~writes;
        if (arrives & writes) answer <= request_seen[1];
        // A machine in reset answers nothing.
        if (waiting & (host_readvalid | reset)) begin
            waiting <= 1'b0;
            answer <= request_seen[1];
            answer_data <= host_readdata;
        end
    end

    initial begin
        host_write = 1'b0;
        host_read = 1'b0;
    end

endmodule
