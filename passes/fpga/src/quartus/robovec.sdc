# Written by robovec; Quartus has not been run on it.
create_clock -name board_clock -period 20.000 [get_ports {FPGA_CLK1_50}]
@pll@derive_clock_uncertainty

# The cable's clock and the machine's know nothing of each other.
if {[get_collection_size [get_ports -nowarn {altera_reserved_tck}]] > 0} {
    create_clock -name cable -period 40.000 [get_ports {altera_reserved_tck}]
    set_clock_groups -asynchronous -group [get_clocks {cable}]
}
set_false_path -from [get_ports {KEY[*]}]
set_false_path -to [get_ports {LED[*]}]
