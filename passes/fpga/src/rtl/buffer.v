
    result_buffer #(
        .WIDTH(@width@), .ADDRESS(@buffer_bits@), .READS(@reads@)
    ) buffer (
        .clock(clock), .advance(advance),
        .write(@write@), .write_address(@write_address@), .result(result),
        .read_address(@read_address@), .words(buffered)
    );
