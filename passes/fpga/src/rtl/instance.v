    @module@ #(
        .INITIAL(INITIAL), .INSTRUCTIONS({IMAGES, "@name@.instructions"}),
        @images@
    ) @name@ (
        .clock(clock), .advance(advance), .phase(phase),
        .fetch_address(fetch_address), .fetched(fetched),
        .selects(@selects@),
        .arriving(@arriving@),
@buffered@        .host_instruction_write(@commit@ & @own@),
        .host_instruction_address(instruction_address),
        .host_instruction(@instruction@),
        .host_access(unit_access), .host_write(@writes@),
        .host_address(operand_address), .host_words(@words@),
        .result(@result@)
    );

