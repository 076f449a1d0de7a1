//! Files of equations compiled by gcc and called at states that depend on the
//! names of the inputs alone, beside robovec's evaluation at the same states:
//! the same bits, or a difference that is described.
//!
//! Many files go into one program, because starting a compiler for each would
//! take longer than all the rest.

use robovec::robotran::{Language, read};
use robovec_ir::evaluate::evaluate;
use robovec_ir::{Boundary, Function, Input, Module, View};
use robovec_num::arithmetic::Binary64;
use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// Arrays of the compiled program have this many elements in each direction,
/// element 0 included, unless a test wants more.
pub(crate) const EXTENT: u32 = 48;
const STATES: u64 = 2;

/// A file of equations.
pub(crate) struct Subject {
    /// What messages call it, and what its kind is told from.
    pub(crate) name: String,
    pub(crate) text: String,
}

/// What gcc and robovec make of a file.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(crate) enum Outcome {
    /// robovec refuses it, with this message.
    Refused(String),
    /// gcc refuses it, robovec reads it.
    OnlyRead,
    /// robovec reads it, but only a part of it is a function, or an array is
    /// larger than those of the program.
    NotCompared,
    /// So many numbers are the same.
    Equal(usize),
    /// A number differs.
    Differs(String),
}

/// True when there is a gcc; says so where there is none.
pub(crate) fn has_gcc() -> bool {
    let found = Command::new("gcc").arg("--version").output().is_ok();
    if !found {
        eprintln!("no gcc: nothing is compared with it");
    }
    found
}

/// The number of an element in a state; the compiled program has the same.
pub(crate) fn number(state: u64, name: &str, i: u32, j: u32) -> f64 {
    let mut x = 1_469_598_103_934_665_603_u64.wrapping_add(state);
    for byte in name.bytes() {
        x = (x ^ u64::from(byte)).wrapping_mul(1_099_511_628_211);
    }
    x = x.wrapping_add(u64::from(i).wrapping_mul(0x9e37_79b9_7f4a_7c15));
    x = x.wrapping_add(u64::from(j).wrapping_mul(0xc2b2_ae3d_27d4_eb4f));
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^= x >> 31;
    ((x >> 11) as f64 + 0.5) / (1u64 << 52) as f64 - 1.0
}

/// A read file that can be called.
struct Callable {
    /// Its place among the subjects.
    subject: usize,
    module: Module,
    /// The function as the file names it.
    function: String,
}

/// Reads and compiles the files, calls them, and compares.
pub(crate) fn compare(subjects: &[Subject], headers: &[PathBuf]) -> Vec<Outcome> {
    compare_within(EXTENT, subjects, headers)
}

/// The same with arrays of any number of elements in each direction.
pub(crate) fn compare_within(
    extent: u32,
    subjects: &[Subject],
    headers: &[PathBuf],
) -> Vec<Outcome> {
    let mut outcomes = vec![Outcome::NotCompared; subjects.len()];
    let mut callables = Vec::new();
    for (subject, Subject { name, text }) in subjects.iter().enumerate() {
        match read(name, text.as_bytes(), Some(Language::C)) {
            Err(error) => {
                let text = error.report.render_plain();
                let first = text.lines().next().unwrap_or_default();
                outcomes[subject] = Outcome::Refused(first.to_owned());
            }
            Ok(read) => callables.extend(callable(subject, read.module, text, extent)),
        }
    }
    let folder = tempfile::tempdir().expect("a temporary folder");
    let program = Program {
        folder: folder.path(),
        headers,
        extent,
    };
    program.write_files(subjects, &callables);
    let refused = program.refused(&callables);
    callables.retain(|callable| {
        let kept = !refused.contains(&callable.subject);
        if !kept {
            outcomes[callable.subject] = Outcome::OnlyRead;
        }
        kept
    });
    if callables.is_empty() {
        return outcomes;
    }
    let calls = program.calls(subjects, &callables);
    let found = program.run();
    for callable in &callables {
        outcomes[callable.subject] = Outcome::Equal(0);
    }
    for (call, &(place, function)) in calls.iter().enumerate() {
        let callable = &callables[place];
        let view = View {
            tables: &callable.module.tables,
            function: &callable.module.functions[function],
        };
        for state in 1..=STATES {
            let Outcome::Equal(count) = &mut outcomes[callable.subject] else {
                continue;
            };
            let compared = found.get(&(state, call));
            match compared.map(|changed| differences(view, state, changed)) {
                None => outcomes[callable.subject] = Outcome::OnlyRead,
                Some(Ok(equal)) => *count += equal,
                Some(Err(difference)) => outcomes[callable.subject] = Outcome::Differs(difference),
            }
        }
    }
    outcomes
}

/// What can be called as MBsysC calls it: one function of a known kind, whole.
fn callable(subject: usize, module: Module, text: &str, extent: u32) -> Option<Callable> {
    let first = module.functions.first()?;
    let part = |function: &Function| function.metadata.iter().any(|(key, _)| key == "part");
    let kind = kind_of(first);
    if module.functions.iter().any(part) || module.functions.iter().any(|f| kind_of(f) != kind) {
        return None;
    }
    let small = |view: View<'_>| {
        let arrays = view.function.inputs().iter().chain(view.function.outputs());
        arrays.into_iter().all(|array| {
            let (indices, _) = match array.shape.len() {
                0 => ([0, 0], 0),
                length => array.shape.indices(length as u32 - 1),
            };
            indices.iter().all(|&index| index < extent)
        })
    };
    let tables = &module.tables;
    let all_small = module
        .functions
        .iter()
        .all(|function| small(View { tables, function }));
    let prefixed = format!("mbs_{kind}");
    let function = if text.contains(&prefixed) {
        prefixed
    } else {
        kind
    };
    (all_small && call_of(&function).is_some()).then_some(Callable {
        subject,
        module,
        function,
    })
}

/// `sensor` for `sensor_3`.
fn kind_of(function: &Function) -> String {
    let case = function.metadata.iter().find(|(key, _)| key == "case");
    match case {
        Some((_, number)) => function
            .name
            .trim_end_matches(&format!("_{number}"))
            .to_owned(),
        None => function.name.clone(),
    }
}

fn case_of(function: &Function) -> u32 {
    let case = function.metadata.iter().find(|(key, _)| key == "case");
    case.map_or(1, |(_, number)| number.parse().expect("a number"))
}

/// How MBsysC calls a function.
fn call_of(function: &str) -> Option<&'static str> {
    Some(match function.strip_prefix("mbs_").unwrap_or(function) {
        "dirdyna" => "(s->M, s->c, s, tsim)",
        "invdyna" => "(s->Qq, s, tsim)",
        "cons_hJ" => "(s->h, s->Jac, s, tsim)",
        "cons_jdqd" => "(s->Jdqd, s, tsim)",
        "link" => "(s->frc, s->trq, s->Flink, s->Z, s->Zd, s, tsim)",
        "link3D" | "extforces" => "(s->frc, s->trq, s, tsim)",
        "sensor" | "gensensor" => "(sens, s, isens)",
        "accelred" | "invdynared" | "dirdyna_odn" => "(s, tsim)",
        _ => return None,
    })
}

/// The elements a call changed, and what user functions were given.
type Changes = BTreeMap<(String, u32, u32), u64>;

struct Program<'a> {
    folder: &'a Path,
    headers: &'a [PathBuf],
    extent: u32,
}

impl Program<'_> {
    fn write(&self, name: &str, text: &str) {
        std::fs::write(self.folder.join(name), text).expect("a temporary file");
    }

    fn write_files(&self, subjects: &[Subject], callables: &[Callable]) {
        self.write("stub.h", include_str!("stub.h"));
        self.write("main.c", include_str!("main.c"));
        for header in [
            "mbs_data.h",
            "mbs_sensor.h",
            "mbs_project_interface.h",
            "mbs_message.h",
            "MBSdataStruct.h",
            "MBSfun.h",
            "MBSdataStructR7.h",
            "MBSfunR7.h",
            "MBSsensorStruct.h",
        ] {
            self.write(header, "#include \"stub.h\"\n");
        }
        for callable in callables {
            let text = &subjects[callable.subject].text;
            self.write(&format!("file_{}.c", callable.subject), text);
        }
    }

    fn gcc(&self, arguments: &[String]) -> Output {
        let mut gcc = Command::new("gcc");
        gcc.current_dir(self.folder)
            .args(["-O0", "-ffp-contract=off", "-w", "-I."])
            .args(["-include", "stub.h"])
            .arg(format!("-DEXTENT={}", self.extent))
            .arg(format!("-DSTATES={STATES}"));
        for folder in self.headers {
            gcc.arg("-I").arg(folder);
        }
        gcc.args(arguments).output().expect("gcc is there")
    }

    /// The subjects that are no C to gcc: each file on its own.
    fn refused(&self, callables: &[Callable]) -> Vec<usize> {
        let mut refused = Vec::new();
        for some in callables.chunks(200) {
            let mut arguments: Vec<String> = [
                "-fsyntax-only",
                "-Werror=implicit-function-declaration",
                "-Werror=implicit-int",
                "-Werror=int-conversion",
                "-Werror=incompatible-pointer-types",
            ]
            .map(str::to_owned)
            .to_vec();
            arguments.extend(some.iter().map(|c| format!("file_{}.c", c.subject)));
            let output = self.gcc(&arguments);
            let messages = String::from_utf8_lossy(&output.stderr).into_owned();
            let mut current = None;
            for line in messages.lines() {
                let mention = line.split("file_").nth(1);
                let number = mention.and_then(|rest| rest.split(".c").next()?.parse().ok());
                current = number.or(current);
                if line.contains("error: ")
                    && let Some(subject) = current
                {
                    refused.push(subject);
                }
            }
        }
        refused
    }

    /// Writes the list of calls; says for each the callable and its function.
    fn calls(&self, subjects: &[Subject], callables: &[Callable]) -> Vec<(usize, usize)> {
        let (mut text, mut list, mut calls) = (String::new(), String::new(), Vec::new());
        for (place, callable) in callables.iter().enumerate() {
            let Callable {
                subject, function, ..
            } = callable;
            let call = call_of(function).expect("it is called");
            writeln!(text, "#define {function} of_{subject}").expect("a string");
            writeln!(text, "#include \"file_{subject}.c\"").expect("a string");
            // Macros of a file end with it.
            for line in subjects[*subject].text.lines() {
                let name = line.trim_start().strip_prefix('#').map(str::trim_start);
                if let Some(rest) = name.and_then(|line| line.strip_prefix("define ")) {
                    let rest = rest.trim_start();
                    let word = |c: char| c.is_ascii_alphanumeric() || c == '_';
                    let end = rest.find(|c| !word(c)).unwrap_or(rest.len());
                    writeln!(text, "#undef {}", &rest[..end]).expect("a string");
                }
            }
            writeln!(text, "#undef {function}").expect("a string");
            writeln!(
                text,
                "static void call_{subject}(MbsData *s, MbsSensor *sens, double tsim, int isens) \
                 {{ (void)s, (void)sens, (void)tsim, (void)isens; of_{subject}{call}; }}"
            )
            .expect("a string");
            for (index, function) in callable.module.functions.iter().enumerate() {
                writeln!(list, "    {{call_{subject}, {}}},", case_of(function)).expect("a string");
                calls.push((place, index));
            }
        }
        let head = "static const struct { void (*function)(MbsData *, MbsSensor *, double, int); int number; } calls[] = {\n";
        self.write("calls.h", &format!("{text}{head}{list}}};\n"));
        calls
    }

    /// Compiles and runs; the changes by state and call.
    fn run(&self) -> BTreeMap<(u64, usize), Changes> {
        let arguments = ["-fcommon", "-o", "program", "main.c", "-lm"];
        let compiled = self.gcc(&arguments.map(str::to_owned));
        let messages = String::from_utf8_lossy(&compiled.stderr);
        assert!(compiled.status.success(), "{messages}");
        let output = Command::new(self.folder.join("program"))
            .output()
            .expect("it runs");
        assert!(output.status.success(), "the program ends: {output:?}");
        parse_changes(&String::from_utf8_lossy(&output.stdout))
    }
}

/// The changes a program printed, by state and call.
pub(crate) fn parse_changes(text: &str) -> BTreeMap<(u64, usize), Changes> {
    let mut found: BTreeMap<(u64, usize), Changes> = BTreeMap::new();
    let mut current = (0, 0);
    for line in text.lines() {
        let words: Vec<&str> = line.split(' ').collect();
        match words[..] {
            ["call", state, call] => {
                current = (
                    state.parse().expect("a state"),
                    call.parse().expect("a call"),
                );
                found.insert(current, Changes::new());
            }
            ["refused", ..] => {
                found.remove(&current);
            }
            [""] => {}
            [name, i, j, bits] => {
                let place = |text: &str| text.parse().expect("an index");
                let bits = u64::from_str_radix(bits, 16).expect("hexadecimal");
                let changes = found.get_mut(&current).expect("it is called before");
                changes.insert((name.to_owned(), place(i), place(j)), bits);
            }
            _ => panic!("the program prints elements: {line}"),
        }
    }
    found
}

/// Compares the evaluation with what a call changed: the number of equal
/// elements, or the first that differs.
pub(crate) fn differences(view: View<'_>, state: u64, changed: &Changes) -> Result<usize, String> {
    let inputs: Vec<f64> = (0..view.function.input_len() as u32)
        .map(|input| input_number(view, Input(input), state))
        .collect();
    let numbers = evaluate(view.function, &Binary64, &inputs);
    let mut left = changed.clone();
    left.retain(|(name, _, _), _| !name.starts_with("call"));
    let mut equal = 0;
    for (assignment, number_of_ours) in view.function.assignments.iter().zip(numbers) {
        let (array, indices, rank) = view.function.output_element(assignment.output);
        let name = view.tables.symbols.text(array.name);
        let indices = [indices[0], indices[1]].map(|index| if rank == 0 { 0 } else { index });
        let keys = places(view, name);
        for key in keys {
            let key = (key, indices[0], indices[1]);
            let theirs = match changed.get(&key) {
                Some(&bits) => f64::from_bits(bits),
                None if key.0.starts_with("call") => continue,
                None => number(state, &key.0, key.1, key.2),
            };
            left.remove(&key);
            let both_nan = theirs.is_nan() && number_of_ours.is_nan();
            if theirs.to_bits() != number_of_ours.to_bits() && !both_nan {
                return Err(format!(
                    "{} in state {state}: {}[{},{}] is {theirs:e}, robovec has {number_of_ours:e}",
                    view.function.name, key.0, key.1, key.2
                ));
            }
            equal += 1;
        }
    }
    match left.into_iter().next() {
        None => Ok(equal),
        Some(((name, i, j), bits)) => Err(format!(
            "{} in state {state}: {name}[{i},{j}] is set to {:e}, robovec does not set it",
            view.function.name,
            f64::from_bits(bits)
        )),
    }
}

/// Where an output array is found: in the structure, or, when it is handed to
/// user functions, among their arguments.
fn places(view: View<'_>, name: &str) -> Vec<String> {
    let known = [
        "q", "qd", "qdd", "m", "g", "lrod", "c", "Qq", "h", "Jdqd", "Flink", "Z", "Zd", "dpt", "l",
        "In", "frc", "trq", "M", "Jac",
    ];
    if name == "Flnk" {
        return vec!["Flink".to_owned()];
    }
    if known.contains(&name) || name.starts_with("sens.") {
        return vec![name.to_owned()];
    }
    let mut places = Vec::new();
    for call in &view.function.boundaries {
        let arguments = call.arguments.iter().enumerate();
        let places_of_call = arguments.filter(|(_, argument)| *argument == name);
        places
            .extend(places_of_call.map(|(place, _)| format!("call{}.{place}", call_number(call))));
    }
    if places.is_empty() {
        // Nothing the program has: a difference, not a panic.
        places.push(name.to_owned());
    }
    places
}

fn call_number(call: &Boundary) -> u32 {
    let last = call.arguments.last().map(|text| text.parse());
    last.and_then(Result::ok).unwrap_or(0)
}

/// The number of an input: given by the state, or by a user function.
fn input_number(view: View<'_>, input: Input, state: u64) -> f64 {
    let (array, indices, rank) = view.function.input_element(input);
    let name = view.tables.symbols.text(array.name);
    let mut calls = view.function.boundaries.iter();
    let call = calls.find(|call| call.result.as_deref() == Some(name));
    match (call, rank) {
        (Some(call), 0) => number(state, "Force", call_number(call), 0),
        (Some(call), _) if call.callee.ends_with("ExtForces") => {
            number(state, &format!("SWr{}", call_number(call)), indices[0], 0)
        }
        (_, 0) => number(state, name, 0, 0),
        (_, 1) => number(state, name, indices[0], 0),
        (_, _) => number(state, name, indices[0], indices[1]),
    }
}

/// Runs files of Python at the same states and compares; what Python refuses
/// is [`Outcome::OnlyRead`].
pub(crate) fn compare_python(subjects: &[Subject]) -> Vec<Outcome> {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let script = folder.path().join("run.py");
    std::fs::write(&script, include_str!("run.py")).expect("a temporary file");
    let mut outcomes = vec![Outcome::NotCompared; subjects.len()];
    let (mut list, mut calls) = (String::new(), Vec::new());
    for (subject, Subject { name, text }) in subjects.iter().enumerate() {
        let module = match read(name, text.as_bytes(), Some(Language::Python)) {
            Err(error) => {
                let text = error.report.render_plain();
                let first = text.lines().next().unwrap_or_default();
                outcomes[subject] = Outcome::Refused(first.to_owned());
                continue;
            }
            Ok(read) => read.module,
        };
        let Some(callable) = callable(subject, module, text, EXTENT) else {
            continue;
        };
        outcomes[subject] = Outcome::Equal(0);
        let file = folder.path().join(format!("file_{subject}.py"));
        std::fs::write(&file, text).expect("a temporary file");
        let function = kind_of(&callable.module.functions[0]);
        for (index, case) in callable.module.functions.iter().map(case_of).enumerate() {
            for state in 1..=STATES {
                let call = calls.len();
                writeln!(list, "{state} {call} {} {function} {case}", file.display())
                    .expect("a string");
            }
            calls.push((callable.module.clone(), subject, index));
        }
    }
    let input = folder.path().join("calls");
    std::fs::write(&input, list).expect("a temporary file");
    let output = Command::new("python3")
        .arg(&script)
        .stdin(std::fs::File::open(&input).expect("a temporary file"))
        .output()
        .expect("python3 is there");
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    let found = parse_changes(&String::from_utf8_lossy(&output.stdout));
    for (call, (module, subject, index)) in calls.iter().enumerate() {
        for state in 1..=STATES {
            let view = View {
                tables: &module.tables,
                function: &module.functions[*index],
            };
            let Outcome::Equal(count) = &mut outcomes[*subject] else {
                continue;
            };
            match found
                .get(&(state, call))
                .map(|changed| differences(view, state, changed))
            {
                None => outcomes[*subject] = Outcome::OnlyRead,
                Some(Ok(equal)) => *count += equal,
                Some(Err(difference)) => outcomes[*subject] = Outcome::Differs(difference),
            }
        }
    }
    outcomes
}

/// Runs functions `invdyna` of Matlab in Octave at the same states.
pub(crate) fn compare_octave(subjects: &[Subject]) -> Vec<Outcome> {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut outcomes = Vec::new();
    let (mut names, mut modules) = (Vec::new(), Vec::new());
    for (subject, Subject { name, text }) in subjects.iter().enumerate() {
        match read(name, text.as_bytes(), Some(Language::Matlab)) {
            Err(error) => {
                let text = error.report.render_plain();
                let first = text.lines().next().unwrap_or_default();
                outcomes.push(Outcome::Refused(first.to_owned()));
            }
            Ok(read) => {
                outcomes.push(Outcome::Equal(0));
                let file = folder.path().join(format!("file_{subject}.m"));
                // A script file: its first statement is no function.
                std::fs::write(&file, format!("1;\n{text}\nend\n")).expect("a temporary file");
                names.push(format!("'{}'", file.display()));
                modules.push((subject, read.module));
            }
        }
    }
    let script = format!(
        "STATES = {STATES}; EXTENT = 9; NAMES = {{{}}};\n{}",
        names.join(", "),
        include_str!("run.m")
    );
    let file = folder.path().join("run.m");
    std::fs::write(&file, script).expect("a temporary file");
    let output = Command::new("octave-cli")
        .args(["--no-init-file", "--quiet"])
        .arg(&file)
        .output()
        .expect("octave is there");
    let found = parse_changes(&String::from_utf8_lossy(&output.stdout));
    for (call, (subject, module)) in modules.iter().enumerate() {
        for state in 1..=STATES {
            let view = View {
                tables: &module.tables,
                function: &module.functions[0],
            };
            let Outcome::Equal(count) = &mut outcomes[*subject] else {
                continue;
            };
            match found.get(&(state, call)) {
                None => outcomes[*subject] = Outcome::OnlyRead,
                Some(changed) => match same_outputs(view, state, changed) {
                    Ok(equal) => *count += equal,
                    Err(difference) => outcomes[*subject] = Outcome::Differs(difference),
                },
            }
        }
    }
    outcomes
}

/// Compares the elements that robovec sets with those Octave gives back.
fn same_outputs(view: View<'_>, state: u64, results: &Changes) -> Result<usize, String> {
    let outputs = view.function.assignments.iter().map(|assignment| {
        let (_, indices, _) = view.function.output_element(assignment.output);
        ("Qq".to_owned(), indices[0], 0)
    });
    let set: Vec<_> = outputs.collect();
    let mut given = results.clone();
    // What the function does not set is zero in Octave.
    given.retain(|key, _| set.contains(key));
    differences(view, state, &given)
}
