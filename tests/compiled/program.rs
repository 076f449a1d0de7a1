//! The program that gcc makes of many files.

use super::callable::{Callable, call_of, case_of};
use super::{STATES, Subject};
use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// The elements that a call changed, and the arguments of user functions.
pub(super) type Changes = BTreeMap<(String, u32, u32), u64>;

pub(super) struct Program<'a> {
    pub(super) folder: &'a Path,
    pub(super) headers: &'a [PathBuf],
    pub(super) extent: u32,
}

impl Program<'_> {
    pub(super) fn write(&self, name: &str, text: &str) {
        std::fs::write(self.folder.join(name), text).expect("a temporary file");
    }

    pub(super) fn write_files(&self, subjects: &[Subject], callables: &[Callable]) {
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

    pub(super) fn gcc(&self, arguments: &[String]) -> Output {
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
    pub(super) fn refused(&self, callables: &[Callable]) -> Vec<usize> {
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

    /// Writes the list of calls; gives for each the callable and its function.
    pub(super) fn calls(
        &self,
        subjects: &[Subject],
        callables: &[Callable],
    ) -> Vec<(usize, usize)> {
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
    pub(super) fn run(&self) -> BTreeMap<(u64, usize), Changes> {
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
