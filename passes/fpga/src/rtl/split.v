    wire unused_operands = &{1'b0, right};
    pe_split #(
        .WIDTH(@width@), .ADDRESS(@address_bits@), .WRITES(@ports@), .PHASE_BITS(@phase_bits@),
        .INITIAL(INITIAL), .LEFT_IMAGE(LEFT), .RIGHT_IMAGE(RIGHT)
    ) operands (
        .clock(clock), .advance(advance), .phase(phase),
        .host_access(host_access), .host_address(host_address),
@sides@        .left(left), .right(right)
    );
