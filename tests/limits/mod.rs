//! Every number of the table of limits, at its ends and beyond.
//!
//! A number beyond a limit is refused with a message that gives the allowed
//! range; one within is treated, or refused for another reason, without a
//! panic, within 2 GB and in time. The trials follow from the table itself, so
//! a new option or field is tried as soon as it is declared.

#![cfg(unix)]

mod run;
mod templates;
mod values;

use crate::docs::limits::{LimitRow, sections};
use run::Invocation;
use std::path::Path;

/// Seconds of processors that a program gets. Programs that are not optimised
/// take longer.
const SECONDS: u64 = if cfg!(debug_assertions) { 200 } else { 20 };

/// A folder with all that trials need.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a temporary folder");
    templates::prepare(folder.path());
    folder
}

/// All rows that are tried: files have a test of their own.
fn rows() -> impl Iterator<Item = (&'static str, LimitRow)> {
    sections()
        .into_iter()
        .filter(|section| section.title != "Files that are read")
        .flat_map(|section| {
            section
                .rows
                .into_iter()
                .map(move |row| (section.title, row))
        })
}

fn name(row: &LimitRow, value: &str) -> String {
    format!("{} {} = {value}", row.place, row.name)
}

#[test]
fn every_number_has_a_template() {
    let folder = folder();
    for (title, row) in rows() {
        let value = row.limit.least().to_string();
        let trials = templates::trials(title, &row, &value, folder.path());
        assert!(
            !trials.is_empty(),
            "nothing tries {}: tests/limits/templates.rs wants a line for it",
            name(&row, &value)
        );
    }
}

/// True when the name of a number holds the text.
fn is_wanted(title: &str, row: &LimitRow, wanted: &str) -> bool {
    format!("{title}: {}", name(row, "")).contains(wanted)
}

/// Fault in a program's answer to a number that is not allowed.
fn refusal(row: &LimitRow, value: &str, trial: &Invocation, folder: &Path) -> Option<String> {
    let ending = trial.run(folder, SECONDS);
    let complaint = |what: &str| {
        let told: String = ending.told.chars().take(400).collect();
        Some(format!(
            "{}: {what}\n  {}\n{told}",
            name(row, value),
            trial.line()
        ))
    };
    if let Some(fault) = ending.fault() {
        return complaint(fault);
    }
    if ending.code == Some(0) {
        return complaint("it is taken");
    }
    // A reader of numbers may stumble over what is no number at all before the
    // limit is asked; beyond it is always the limit that answers.
    let is_beyond = value
        .parse::<u64>()
        .is_ok_and(|number| i64::try_from(number).is_ok());
    if is_beyond && !ending.told.contains("is not allowed") {
        return complaint("the message does not say what is allowed");
    }
    if is_beyond
        && !ending
            .told
            .contains(row.limit.reason().split(' ').next().unwrap_or(""))
    {
        return complaint("the message does not say why");
    }
    None
}

/// Tries values beyond limits, the requested number of each, of the numbers
/// whose names contain the text.
fn try_outside(most: usize, wanted: &str) -> (usize, Vec<String>) {
    let folder = folder();
    templates::prepare_more(folder.path());
    let mut count = 0;
    let mut complaints = Vec::new();
    for (title, row) in rows() {
        if !is_wanted(title, &row, wanted) {
            continue;
        }
        for value in values::outside(&row.limit).into_iter().take(most) {
            // A count of bodies cannot be minus one, nor no number.
            if row.name == "joint" && value.parse::<usize>().map_or(true, |count| count > 10_000) {
                continue;
            }
            let trials = templates::trials(title, &row, &value, folder.path());
            if let Some(trial) = trials.first() {
                count += 1;
                complaints.extend(refusal(&row, &value, trial, folder.path()));
            }
        }
    }
    (count, complaints)
}

#[test]
fn what_is_beyond_a_limit_is_refused_with_the_limit() {
    let (count, complaints) = try_outside(3, "");
    assert!(
        complaints.is_empty(),
        "{} of {count}:\n{}",
        complaints.len(),
        complaints.join("\n")
    );
}

#[test]
fn passes_and_machines_bear_their_extremes() {
    let folder = folder();
    let mut complaints = Vec::new();
    for (title, row) in rows() {
        if !matches!(
            title,
            "Options of passes" | "Machine files" | "Robotran's files"
        ) {
            continue;
        }
        for value in values::inside(&row.limit).into_iter().take(2) {
            let trials = templates::trials(title, &row, &value, folder.path());
            let Some(trial) = trials.first() else {
                continue;
            };
            if let Some(fault) = trial.run(folder.path(), SECONDS).fault() {
                complaints.push(format!(
                    "{}: {fault}\n  {}",
                    name(&row, &value),
                    trial.line()
                ));
            }
        }
    }
    assert!(complaints.is_empty(), "{}", complaints.join("\n"));
}

#[test]
fn files_beyond_their_limits_are_refused_unread() {
    let folder = folder();
    let path = folder.path().join("large");
    let section = sections()
        .into_iter()
        .find(|section| section.title == "Files that are read")
        .expect("it is there");
    let trial = |what: &str| {
        let line = match what {
            "file of equations" => "robovec-opt large -passes=atomise",
            "model" => "robovec model large.mbs",
            "pipeline" => "robovec-opt f.rvir -passes=@large",
            "machine" => "robovec-opt f.rvir -passes=atomise --machine large.toml",
            "scene" => "robovec fit --explain large",
            "file of laws" => "robovec sim p.mbs --laws large",
            "plan" => "robovec explore --plan large -o out",
            "file of rules" => "robovec rules check large.rules",
            "file of states" => "robovec eval f.rvir --states large",
            "memory image" => "robovec rtl simulate images --inputs=1,1",
            "description of a target" => {
                "robovec-opt f.rvir -passes=codegen{target=template} --target described"
            }
            "template" => "robovec-opt f.rvir -passes=codegen{target=template} --target written",
            other => panic!("nothing reads a {other}"),
        };
        let mut words = line.split(' ').map(str::to_owned);
        Invocation {
            program: match words.next().as_deref() {
                Some("robovec") => "robovec",
                _ => "robovec-opt",
            },
            arguments: words.collect(),
        }
    };
    for name in ["images", "described", "written"] {
        std::fs::create_dir(folder.path().join(name)).expect("a writable folder");
    }
    std::fs::write(path.with_file_name("written/target.toml"), "[operations]").expect("writable");
    for row in section.rows {
        let robovec_num::limits::Amount::Whole(most) = row.limit.most() else {
            panic!("bytes are counted");
        };
        // The file has holes only, and takes no room.
        for name in [
            "large",
            "large.mbs",
            "large.toml",
            "large.rules",
            "images/a.mif",
            "described/target.toml",
            "written/template.jinja",
        ] {
            let file = std::fs::File::create(path.with_file_name(name)).expect("writable");
            file.set_len(most + 1).expect("a file can have holes");
        }
        let trial = trial(&row.name);
        let ending = trial.run(folder.path(), SECONDS);
        let told = &ending.told;
        assert_eq!(ending.code, Some(1), "{}: {told}", trial.line());
        assert!(
            told.contains(&format!("more than {most} bytes")),
            "{}: {told}",
            trial.line()
        );
    }
}

/// The whole table with all values: `cargo test --release --test all limits::
/// -- --ignored --nocapture` prints all trials, and the slowest ones;
/// `LIMITS=TEXT` tries only numbers whose names contain the text.
#[test]
#[ignore = "takes long"]
fn the_whole_table_at_its_ends() {
    let wanted = std::env::var("LIMITS").unwrap_or_default();
    let folder = folder();
    templates::prepare_more(folder.path());
    let mut endings: Vec<(f64, String)> = Vec::new();
    let mut complaints = Vec::new();
    let mut largest = (0, String::new());
    for (title, row) in rows() {
        if !is_wanted(title, &row, &wanted) {
            continue;
        }
        for value in values::inside(&row.limit) {
            for trial in templates::trials(title, &row, &value, folder.path()) {
                let ending = trial.run(folder.path(), SECONDS);
                let line = format!("{}: {}", name(&row, &value), trial.line());
                if let Some(fault) = ending.fault() {
                    let told: String = ending.told.chars().take(600).collect();
                    println!("FAULT {line}: {fault}\n{told}");
                    complaints.push(format!("{line}: {fault}"));
                }
                let resident = resident();
                if resident > largest.0 {
                    largest = (resident, line.clone());
                }
                endings.push((ending.seconds, line));
            }
        }
    }
    let (outside, refused) = try_outside(usize::MAX, &wanted);
    for complaint in &refused {
        println!("TAKEN {complaint}");
    }
    endings.sort_by(|a, b| b.0.total_cmp(&a.0));
    println!(
        "{wanted}: {} trials within limits, {outside} beyond",
        endings.len()
    );
    for (seconds, line) in endings.iter().take(20) {
        println!("{seconds:7.2} s  {line}");
    }
    println!("largest: {} kB  {}", largest.0, largest.1);
    complaints.extend(refused);
    assert!(complaints.is_empty(), "{} faults", complaints.len());
}

/// Kilobytes of the largest child so far.
fn resident() -> i64 {
    use nix::sys::resource::{UsageWho, getrusage};
    getrusage(UsageWho::RUSAGE_CHILDREN).map_or(0, |usage| usage.max_rss())
}
