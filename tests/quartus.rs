//! The Quartus project that `robovec rtl` writes, as far as it can be checked
//! without Quartus.

use std::fs;
use std::path::Path;
use std::process::Command;

/// Writes hardware for an example on the machine of the board.
fn write(folder: &Path) {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let output = Command::new(env!("CARGO_BIN_EXE_robovec"))
        .arg("rtl")
        .arg(root.join("examples/suspension/mbs_dirdyna_suspension.m"))
        .args([
            "--function",
            "dirdyna",
            "--machine",
            "de10-nano",
            "--passes",
        ])
        .arg("atomise,zero-removal,balance,cse,dce,place")
        .arg("-o")
        .arg(folder)
        .output()
        .expect("the program can be started");
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{said}");
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(text.contains("Quartus has not been run"), "{text}");
}

/// Runs a script of Tcl; none where Tcl is not installed.
fn tcl(folder: &Path, script: &str) -> Option<String> {
    let path = folder.join("check.tcl");
    fs::write(&path, script).expect("the folder can be written");
    let output = Command::new("tclsh")
        .arg(&path)
        .current_dir(folder)
        .output()
        .ok()?;
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{said}");
    Some(String::from_utf8_lossy(&output.stdout).into_owned())
}

#[test]
fn the_project_names_files_that_are_there() {
    let folder = tempfile::tempdir().expect("a folder can be made");
    write(folder.path());
    let quartus = folder.path().join("quartus");
    let settings = fs::read_to_string(quartus.join("robovec.qsf")).expect("it was written");
    let mut files = 0;
    for line in settings.lines() {
        let words: Vec<&str> = line.split_whitespace().collect();
        if let ["set_global_assignment", "-name", kind, path] = words[..]
            && kind.ends_with("_FILE")
        {
            assert!(quartus.join(path).is_file(), "{path}");
            files += 1;
        }
    }
    // Two memories of eight elements, and the Verilog.
    assert!(files > 16 + 10, "{files}");
    // The commands of Quartus as procedures that do nothing: what remains is
    // the syntax.
    let checked = tcl(
        &quartus,
        "foreach name {set_global_assignment set_location_assignment set_instance_assignment \
         create_clock derive_pll_clocks derive_clock_uncertainty set_clock_groups set_false_path \
         get_ports get_clocks set_multicycle_path get_registers} { proc $name {args} {} }\n\
         proc get_collection_size {collection} { return 1 }\n\
         source robovec.qsf\nsource robovec.sdc\nset robovec_test 1\nsource host.tcl\n\
         puts [llength $robovec_memories]\n",
    );
    if let Some(text) = checked {
        // Name and place of an instruction and an operand memory each.
        assert_eq!(text.trim(), (2 * 2 * 8).to_string());
    }
}

/// The cable, from the host's script, with a machine on it that answers every
/// third scan too late.
const CABLE: &str = r"
set robovec_test 1
set asked 0; set answer 0; set at 0; set scans 0
proc device_virtual_ir_shift {args} { global instruction; set instruction [lindex $args 3] }
proc device_virtual_dr_shift {args} {
    global instruction asked answer at memory scans
    array set option $args
    if {[string length $option(-dr_value)] != 33} { error length }
    binary scan [binary format B32 [string range $option(-dr_value) 0 31]] Iu word
    set valid [expr {$asked && [incr scans] % 3}]
    set shown $answer
    switch $instruction {
        1 { set at $word; set asked 0 }
        2 { set memory($at) $word; incr at }
        3 {
            if {!$asked || $valid} {
                set answer [expr {[info exists memory($at)] ? $memory($at) : 0}]
                set asked 1
                incr at
            }
        }
    }
    binary scan [binary format I $shown] B32 bits
    return $bits$valid
}
source host.tcl
lassign [limbs_of $robovec_machine_hash 2] memory(5) memory(6)
load_images ../img
puts [read_words 2 1]
write_words 1000 {1 2 4294967295}
puts [read_words 1000 3]
puts [limbs_of 1ffffffff0 2]
set memory(1) 2
run_program {}
";

#[test]
fn the_host_s_script_loads_and_reads() {
    let folder = tempfile::tempdir().expect("a folder can be made");
    write(folder.path());
    let Some(text) = tcl(&folder.path().join("quartus"), CABLE) else {
        return;
    };
    let mut lines = text.lines();
    let cycles: u32 = lines
        .next()
        .and_then(|line| line.parse().ok())
        .expect("the program's length was loaded");
    assert!(cycles > 20, "{cycles}");
    assert_eq!(lines.next(), Some("1 2 4294967295"));
    assert_eq!(lines.next(), Some("4294967280 31"));
    assert!(
        lines.next().is_some_and(|line| line.contains(" = ")),
        "{text}"
    );
}
