//! The timing constraints of the project.

use crate::hardware::MachineShape;

/// The constraints (Synopsys design constraints) of a machine on the board.
///
/// Where a cycle has several clocks, everything in the elements that changes
/// only at the end of a cycle has a whole cycle from register to register:
/// instruction words, operators, operands.
pub(super) fn constraints(shape: &MachineShape, plain: bool) -> String {
    let mut text = String::from(
        "# Written by robovec; Quartus has not been run on it.\n\
         create_clock -name board_clock -period 20.000 [get_ports {FPGA_CLK1_50}]\n",
    );
    if !plain {
        text += "derive_pll_clocks\n";
    }
    text += "derive_clock_uncertainty\n\n\
        # The cable's clock and the machine's know nothing of each other.\n\
        if {[get_collection_size [get_ports -nowarn {altera_reserved_tck}]] > 0} {\n    \
        create_clock -name cable -period 40.000 [get_ports {altera_reserved_tck}]\n    \
        set_clock_groups -asynchronous -group [get_clocks {cable}]\n}\n\
        set_false_path -from [get_ports {KEY[*]}]\n\
        set_false_path -to [get_ports {LED[*]}]\n";
    let phases = shape.phases();
    if phases > 1 {
        let hold = phases - 1;
        text += &format!(
            "\n# A cycle has {phases} clocks. What is named here changes in the last of them only.\n\
             set slow [get_registers {{\n    \
             *|instruction_memory:*|word[*]\n    \
             *|fp_*:*|*\n    \
             *|entering*\n    \
             *|leaving*\n    \
             *|pumped_operand:*|held[*]\n}}]\n\
             set_multicycle_path -setup -end -from $slow -to $slow {phases}\n\
             set_multicycle_path -hold -end -from $slow -to $slow {hold}\n"
        );
    }
    text
}
