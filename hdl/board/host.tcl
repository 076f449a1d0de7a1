# Loads and runs a robovec machine over the programming cable.
#
#   quartus_stp -t host.tcl load IMAGES          all memories, from IMAGES/*.hex
#   quartus_stp -t host.tcl run NAME=VALUE ...   inputs, a run, all outputs
#   quartus_stp -t host.tcl status               what is loaded, and whether it runs
#
# Values are decimal numbers of binary32, or 0x and the digits of a word, which is
# the only way for other formats. Names are those of map.tcl; inputs that are not
# named keep what is in the memories.

set robovec_folder [file dirname [file normalize [info script]]]
source [file join $robovec_folder map.tcl]

# Virtual instructions of virtual_jtag_host.v.
set ADDRESS 1
set WRITE 2
set READ 3

# One scan of 33 bits: a word in, {valid word} out.
proc shift {instruction word} {
    device_virtual_ir_shift -instance_index 0 -ir_value $instruction -no_captured_ir_value
    binary scan [binary format I $word] B32 bits
    set seen [device_virtual_dr_shift -instance_index 0 -length 33 -dr_value ${bits}0]
    binary scan [binary format B32 [string range $seen 0 31]] Iu got
    return [list [string index $seen end] $got]
}

proc write_words {address words} {
    global ADDRESS WRITE
    shift $ADDRESS $address
    foreach word $words { shift $WRITE $word }
}

# A scan that comes before its answer shifts out `valid` 0 and is repeated.
proc read_words {address count} {
    global ADDRESS READ
    shift $ADDRESS $address
    set words {}
    set tries 0
    while {[llength $words] < $count} {
        lassign [shift $READ 0] valid word
        if {$valid} {
            lappend words $word
            set tries 0
        } elseif {[incr tries] > 1000} {
            error "the machine does not answer at address $address"
        }
    }
    return $words
}

# The words of an image: lines of hexadecimal digits, `//` starts a comment,
# `@` an address. Gives {address digits} pairs.
proc image_words {path} {
    set file [open $path]
    set place 0
    set words {}
    foreach line [split [read $file] \n] {
        set line [string trim [regsub {//.*} $line {}]]
        foreach item $line {
            if {[string index $item 0] eq "@"} {
                set place [expr "0x[string range $item 1 end]"]
            } else {
                # Words of x are the inputs', which only a run has.
                if {[string is xdigit -strict $item]} { lappend words [list $place $item] }
                incr place
            }
        }
    }
    close $file
    return $words
}

# The limbs of a word, the lowest first.
proc limbs_of {digits count} {
    set padded [string repeat 0 [expr {8 * $count}]]$digits
    set limbs {}
    for {set limb 0} {$limb < $count} {incr limb} {
        set last [expr {[string length $padded] - 1 - 8 * $limb}]
        lappend limbs [expr "0x[string range $padded [expr {$last - 7}] $last]"]
    }
    return $limbs
}

proc load_images {images} {
    global robovec_memories robovec_cycles robovec_schedule_hash robovec_machine_hash
    lassign [read_words 5 2] low high
    set found [format %08x%08x $high $low]
    if {$found ne $robovec_machine_hash} {
        error "the device holds a machine with hash $found; the images are for $robovec_machine_hash"
    }
    foreach {name place} $robovec_memories {
        lassign $place address limbs stride image
        foreach pair [image_words [file join $images $image.hex]] {
            lassign $pair index digits
            write_words [expr {$address + $index * $stride}] [limbs_of $digits $limbs]
        }
    }
    write_words 2 [list $robovec_cycles]
    write_words 3 [limbs_of $robovec_schedule_hash 2]
}

# A decimal number as a binary32 word.
proc word_of {text} {
    binary scan [binary format R $text] Iu word
    return $word
}

# A value as limbs: 0x and digits of any word, or a number of binary32.
proc limbs_of_value {text} {
    global robovec_limbs
    if {[string match 0x* $text]} {
        return [limbs_of [string range $text 2 end] $robovec_limbs]
    }
    if {$robovec_limbs != 1} { error "words of this machine are given as 0x and digits" }
    return [list [word_of $text]]
}

proc number_of {word} {
    binary scan [binary format I $word] R number
    return $number
}

proc run_program {values} {
    global robovec_inputs robovec_outputs robovec_limbs
    array set inputs $robovec_inputs
    foreach value $values {
        set split [string last = $value]
        set name [string range $value 0 [expr {$split - 1}]]
        if {![info exists inputs($name)]} { error "there is no input '$name'" }
        set limbs [limbs_of_value [string range $value [expr {$split + 1}] end]]
        foreach address $inputs($name) { write_words $address $limbs }
    }
    write_words 0 {3}
    set tries 0
    while {!([lindex [read_words 1 1] 0] & 2)} {
        if {[incr tries] > 1000} { error "the program does not end" }
    }
    foreach {name address} $robovec_outputs {
        set limbs [read_words $address $robovec_limbs]
        set digits {}
        foreach limb $limbs { set digits [format %08x $limb]$digits }
        if {$robovec_limbs == 1} {
            puts "$name = [number_of $limbs] (0x$digits)"
        } else {
            puts "$name = 0x$digits"
        }
    }
}

proc tell_status {} {
    global robovec_machine_hash robovec_schedule_hash
    set words [read_words 1 6]
    lassign $words state cycles low high machine_low machine_high
    puts "running [expr {$state & 1}], done [expr {$state >> 1 & 1}], $cycles cycles"
    puts [format "schedule %08x%08x, here %s" $high $low $robovec_schedule_hash]
    puts [format "machine  %08x%08x, here %s" $machine_high $machine_low $robovec_machine_hash]
}

proc open_cable {} {
    set cable [lindex [get_hardware_names] 0]
    if {$cable eq ""} { error "no programming cable is connected" }
    foreach device [get_device_names -hardware_name $cable] {
        if {[string match *5CSE* $device]} {
            open_device -hardware_name $cable -device_name $device
            device_lock -timeout 10000
            return
        }
    }
    error "no device of the board answers on $cable"
}

proc main {arguments} {
    lassign $arguments command
    open_cable
    switch -- $command {
        load { load_images [lindex $arguments 1] }
        run { run_program [lrange $arguments 1 end] }
        status { tell_status }
        default { error "say load, run or status" }
    }
    device_unlock
    close_device
}

if {![info exists robovec_test]} { main $quartus(args) }
