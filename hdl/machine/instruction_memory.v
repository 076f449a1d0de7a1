// The instruction memory of one processing element.
//
// The sequencer's address of one cycle gives the word that acts two cycles
// later: one cycle for the block memory, one for the register behind it, so
// that no path of the element starts at the slow output of a block memory.
// Without a program the register holds zero: no operation starts, nothing is
// written, every select is 0. The host's window relies on that.
//
// Parameters
//   WIDTH     bits of an instruction word
//   ADDRESS   bits of an address; the longest program has 2**ADDRESS cycles
//   INITIAL, IMAGE   as simple_dual_port_memory
//
// Ports
//   advance         high in the last clock of every cycle
//   fetch_address   word to read
//   fetched         the word that was read belongs to a running program
//   word            the instruction word of this cycle
//   host_...        the host writes a word, in any clock in which no program
//                   runs
module instruction_memory #(
    parameter WIDTH = 55,
    parameter ADDRESS = 10,
    parameter INITIAL = 0,
    parameter IMAGE = "image"
) (
    input                    clock,
    input                    advance,
    input      [ADDRESS-1:0] fetch_address,
    input                    fetched,
    output reg [WIDTH-1:0]   word,
    input                    host_write,
    input      [ADDRESS-1:0] host_address,
    input      [WIDTH-1:0]   host_data
);

    wire [WIDTH-1:0] read_data;

    simple_dual_port_memory #(
        .WIDTH(WIDTH),
        .ADDRESS(ADDRESS),
        .INITIAL(INITIAL),
        .IMAGE(IMAGE)
    ) words (
        .clock(clock),
        .write(host_write),
        .write_address(host_address),
        .write_data(host_data),
        .read(advance),
        .read_address(fetch_address),
        .read_data(read_data)
    );

    initial word = {WIDTH{1'b0}};

    always @(posedge clock)
        if (advance) word <= fetched ? read_data : {WIDTH{1'b0}};

endmodule
