    wire @word_range@ addend;
    wire unused_operands = &{1'b0, right, addend, host_access};
    pe_pumped #(
        .WIDTH(@width@), .ADDRESS(@address_bits@), .WRITES(@ports@), .PHASES(@phases@), .PHASE_BITS(@phase_bits@),
        .FUSED(@fused@), .INITIAL(INITIAL), .IMAGE(DATA)
    ) operands (
        .clock(clock), .advance(advance), .phase(phase),
        .left_address(@left@),
        .right_address(@right@),
        .addend_address(@addend@),
        .write(@enables@),
        .write_address(@addresses@),
        .write_data(arriving),
        .host_write(host_write[0]), .host_address(host_address), .host_word(host_words),
        .left(left), .right(right), .addend(addend)
    );
