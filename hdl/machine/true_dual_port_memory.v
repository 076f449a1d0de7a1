// A block memory with two ports on one clock, each of which reads or writes
// one word per clock: the memory of the pumped processing element.
//
// This is the one place where simulation and the device differ in text. For
// Quartus, define ROBOVEC_ALTSYNCRAM: the vendor's block is then named
// outright, since inference of two writing ports differs from version to
// version. Everywhere else the model below stands for it. Open synthesis has
// no cell for two writing ports; there, use memories that are split by side.
//
// Nothing may depend on what a port shows in the clock after it has written,
// nor on one port reading what the other writes: the model shows the old
// content, the device may show anything.
//
// Parameters: as simple_dual_port_memory; the device takes IMAGE.mif.
//
// Ports: `X_write`, `X_address`, `X_data` act at the next edge, from which on
// `X_word` is what the word held before.
module true_dual_port_memory #(
    parameter WIDTH = 32,
    parameter ADDRESS = 11,
    parameter INITIAL = 0,
    parameter IMAGE = "image"
) (
    input                clock,
    input                a_write,
    input  [ADDRESS-1:0] a_address,
    input  [WIDTH-1:0]   a_data,
    output [WIDTH-1:0]   a_word,
    input                b_write,
    input  [ADDRESS-1:0] b_address,
    input  [WIDTH-1:0]   b_data,
    output [WIDTH-1:0]   b_word
);

`ifdef ROBOVEC_ALTSYNCRAM

    altsyncram #(
        .operation_mode("BIDIR_DUAL_PORT"),
        .ram_block_type("M10K"),
        .width_a(WIDTH),
        .widthad_a(ADDRESS),
        .numwords_a(1 << ADDRESS),
        .width_b(WIDTH),
        .widthad_b(ADDRESS),
        .numwords_b(1 << ADDRESS),
        .width_byteena_a(1),
        .width_byteena_b(1),
        .outdata_reg_a("UNREGISTERED"),
        .outdata_reg_b("UNREGISTERED"),
        .address_reg_b("CLOCK0"),
        .indata_reg_b("CLOCK0"),
        .wrcontrol_wraddress_reg_b("CLOCK0"),
        .read_during_write_mode_port_a("NEW_DATA_NO_NBE_READ"),
        .read_during_write_mode_port_b("NEW_DATA_NO_NBE_READ"),
        .read_during_write_mode_mixed_ports("DONT_CARE"),
        .init_file((INITIAL != 0) ? {IMAGE, ".mif"} : "UNUSED"),
        .power_up_uninitialized("FALSE"),
        .lpm_type("altsyncram")
    ) block (
        .clock0(clock),
        .wren_a(a_write),
        .address_a(a_address),
        .data_a(a_data),
        .q_a(a_word),
        .wren_b(b_write),
        .address_b(b_address),
        .data_b(b_data),
        .q_b(b_word)
    );

`else

    reg [WIDTH-1:0] memory [0:(1 << ADDRESS)-1];
    reg [WIDTH-1:0] a_read;
    reg [WIDTH-1:0] b_read;

    assign a_word = a_read;
    assign b_word = b_read;

    generate
        if (INITIAL != 0) begin : loaded
            initial $readmemh({IMAGE, ".hex"}, memory);
        end
    endgenerate

    always @(posedge clock) begin
        a_read <= memory[a_address];
        b_read <= memory[b_address];
        if (a_write) memory[a_address] <= a_data;
        if (b_write) memory[b_address] <= b_data;
    end

`endif

endmodule
