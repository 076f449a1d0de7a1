
# A cycle has @phases@ clocks. What is named here changes in the last of them only.
set slow [get_registers {
    *|instruction_memory:*|word[*]
    *|fp_*:*|*
    *|entering*
    *|leaving*
    *|pumped_operand:*|held[*]
}]
set_multicycle_path -setup -end -from $slow -to $slow @phases@
set_multicycle_path -hold -end -from $slow -to $slow @hold@
