//! Random bytes for the bodies of the fuzz targets, where cargo-fuzz is not at
//! hand or a number of programs is wanted.
//!
//!     cargo run --release -p robovec-fuzz --example attack -- programs 100000
//!     cargo run --release -p robovec-fuzz --example attack -- bodies 600 round_trip
//!
//! `programs COUNT [SEED] [WITHOUT…]` runs that many programs with hostile
//! constants through random pipelines ([`robovec_fuzz::results`]), without the
//! passes named at the end, and lists the faults found, with the smallest
//! program of each pass in full. `bodies SECONDS [NAME…]` runs the named
//! bodies, or all, for so many seconds of the processor each. A finding gives
//! exit code 1; the number of a case reproduces it with `case BODY NUMBER`;
//! `show NUMBER` prints the pipeline and the program of a case of `programs`.

use arbitrary::Unstructured;
use robovec_framework::manager::usage;
use robovec_fuzz::results::{Finding, Tally, describe_case, examine};
use robovec_fuzz::*;
use robovec_num::random::Random;
use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::process::ExitCode;

type Body = fn(&[u8]);

const BODIES: [(&str, Body); 26] = [
    ("bounds_hold_over_boxes", bounds_hold_over_boxes),
    ("norms_hold", norms_hold),
    ("check_catches_mutants", check_catches_mutants),
    ("domains_are_compared", domains_are_compared),
    ("derivatives_hold", derivatives_hold),
    ("errors_are_predicted", errors_are_predicted),
    ("errors_stay_within_bounds", errors_stay_within_bounds),
    ("false_rules_are_caught", false_rules_are_caught),
    ("formats_agree", formats_agree),
    ("generated_functions_hold", generated_functions_hold),
    ("inline_undoes_atomise", inline_undoes_atomise),
    ("model_round_trip", model_round_trip),
    ("parse_text", parse_text),
    ("precision_keeps_programs", precision_keeps_programs),
    ("random_pipeline", random_pipeline),
    ("read_fpcore", read_fpcore),
    ("read_model", read_model),
    ("read_robot", read_robot),
    ("read_robotran", read_robotran),
    ("results_stay_in_class", results_stay_in_class),
    ("round_trip", round_trip),
    ("rules_are_judged", rules_are_judged),
    ("series_keep_their_errors", series_keep_their_errors),
    ("simulate_garbage", simulate_garbage),
    ("whole_steps_move_models", whole_steps_move_models),
    ("written_reads_back", written_reads_back),
];

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let number = |text: &str| text.parse::<u64>().ok();
    let quiet = match words.as_slice() {
        ["programs", count, rest @ ..] => {
            let seed = rest.first().and_then(|text| number(text));
            let without = &arguments[2 + usize::from(seed.is_some())..];
            number(count).map(|count| programs(count, seed.unwrap_or(1), without))
        }
        ["bodies", seconds, names @ ..]
            if names
                .iter()
                .all(|name| BODIES.iter().any(|(body, _)| body == name)) =>
        {
            number(seconds).map(|seconds| bodies(seconds, names))
        }
        ["case", name, case] => number(case).map(|case| {
            let body = BODIES.iter().find(|(body, _)| body == name);
            body.is_some_and(|(_, body)| {
                body(&bytes(case));
                true
            })
        }),
        ["show", case] => number(case).map(|case| {
            let text = describe_case(&mut Unstructured::new(&bytes(case)));
            text.is_ok_and(|text| {
                println!("{text}");
                true
            })
        }),
        _ => None,
    };
    match quiet {
        Some(true) => ExitCode::SUCCESS,
        Some(false) => ExitCode::FAILURE,
        None => {
            eprintln!(
                "attack programs COUNT [SEED] [WITHOUT…] | bodies SECONDS [NAME…] | case BODY NUMBER | show NUMBER"
            );
            ExitCode::from(2)
        }
    }
}

/// The bytes of a case: some hundred to some thousand.
fn bytes(case: u64) -> Vec<u8> {
    let mut random = Random::new(case);
    let words = 32 + random.below(700);
    (0..words)
        .flat_map(|_| random.bits().to_le_bytes())
        .collect()
}

/// Faults of a pass: their number, the first case, the smallest program.
struct Found {
    count: u64,
    case: u64,
    finding: Box<Finding>,
}

fn programs(count: u64, seed: u64, without: &[String]) -> bool {
    let start = usage().0;
    let mut tally = Tally::default();
    let mut found: BTreeMap<String, Found> = BTreeMap::new();
    let (mut cases, mut findings) = (0, 0);
    let first = seed << 40;
    while tally.programs + findings < count {
        let case = first + cases;
        cases += 1;
        match examine(&mut Unstructured::new(&bytes(case)), without) {
            // Too few bytes for a program.
            Err(_) => {}
            Ok(Ok(one)) => tally.add(&one),
            Ok(Err(finding)) => {
                findings += 1;
                let pass = finding
                    .pass
                    .split('{')
                    .next()
                    .unwrap_or_default()
                    .to_owned();
                let accused = if finding.what.contains("the check saw nothing") {
                    "not seen by the check"
                } else {
                    "seen by the check"
                };
                let entry = found
                    .entry(format!("{pass}, {accused}"))
                    .or_insert_with(|| Found {
                        count: 0,
                        case,
                        finding: finding.clone(),
                    });
                entry.count += 1;
                if finding.program.len() < entry.finding.program.len() {
                    (entry.case, entry.finding) = (case, finding);
                }
            }
        }
    }
    for (pass, found) in &found {
        println!(
            "{pass}: {} times, case {}\n{}\n",
            found.count, found.case, found.finding
        );
    }
    println!("{tally}; {findings} findings; {:.1} s", usage().0 - start);
    findings == 0
}

fn bodies(seconds: u64, names: &[&str]) -> bool {
    let mut quiet = true;
    for (name, body) in BODIES {
        if !names.is_empty() && !names.contains(&name) {
            continue;
        }
        let start = usage().0;
        let (mut case, mut failures) = (0u64, 0u32);
        while usage().0 - start < seconds as f64 {
            let data = bytes(case);
            if catch_unwind(AssertUnwindSafe(|| body(&data))).is_err() {
                eprintln!("case {name} {case}");
                failures += 1;
            }
            case += 1;
        }
        let spent = usage().0 - start;
        println!("{name}: {case} inputs, {failures} failures, {spent:.1} s");
        quiet &= failures == 0;
    }
    quiet
}
