//! Limits of the numbers that flags take.
//!
//! A flag declares its limit beside itself (`add = whole(1, 1000, "…")`);
//! [`enforce`] gives every flag with a limit a parser that tests it. A test
//! refuses a flag that is a number and has none.

use clap::builder::{ArgExt, PossibleValue, PossibleValuesParser, TypedValueParser};
use clap::{Arg, Command};
use robovec_num::limits::NumberLimit;
use std::any::TypeId;

/// Limit of a flag's number, kept by `clap` beside the flag.
#[derive(Clone, Copy, Debug)]
pub struct FlagLimit(pub NumberLimit);

impl ArgExt for FlagLimit {}

pub(crate) const fn whole(least: u64, most: u64, reason: &'static str) -> FlagLimit {
    FlagLimit(NumberLimit::whole(least, most, reason))
}

pub(crate) const fn real(least: f64, most: f64, reason: &'static str) -> FlagLimit {
    FlagLimit(NumberLimit::real(least, most, reason))
}

pub(crate) const SEED: FlagLimit = FlagLimit(NumberLimit::SEED);

pub(crate) const EFFORT: FlagLimit = FlagLimit(robovec_passes::optimise::EFFORT);

/// The limit of numbers that are data: all numbers of binary64.
pub(crate) const NUMBER: FlagLimit = real(
    -f64::MAX,
    f64::MAX,
    "numbers of programs are finite numbers of binary64",
);

/// Limit of random states or points with a value of every output each.
pub(crate) const fn states(least: u64, most: u64) -> FlagLimit {
    whole(
        least,
        most,
        "the functions are evaluated at every state, and results are kept",
    )
}

/// Words of a flag, the usual one first; their help; the value that they mean.
pub(crate) type FlagChoice<T> = (&'static [&'static str], &'static str, T);

pub(crate) fn choice<T: Copy + Send + Sync + 'static>(
    choices: &'static [FlagChoice<T>],
) -> impl TypedValueParser<Value = T> {
    let words = choices.iter().map(|(words, help, _)| {
        PossibleValue::new(words[0])
            .aliases(&words[1..])
            .help(*help)
    });
    PossibleValuesParser::new(words).map(move |word: String| {
        let mut known = choices.iter();
        let found = known.find(|(words, ..)| words.contains(&word.as_str()));
        found.expect("clap has refused other words").2
    })
}

/// The command, with a parser for every flag that has a limit.
pub(crate) fn enforce(command: Command) -> Command {
    command.mut_args(limited).mut_subcommands(enforce)
}

fn limited(flag: Arg) -> Arg {
    let Some(&FlagLimit(limit)) = flag.get::<FlagLimit>() else {
        return flag;
    };
    let kind = flag.get_value_parser().type_id();
    let read = move |text: &str| limit.read_whole(text);
    if kind == TypeId::of::<u32>() {
        // The limits of such flags are numbers of 32 bits, as the test says.
        flag.value_parser(move |text: &str| read(text).map(|number| number as u32))
    } else if kind == TypeId::of::<usize>() {
        flag.value_parser(move |text: &str| read(text).map(|number| number as usize))
    } else if kind == TypeId::of::<u64>() {
        flag.value_parser(read)
    } else if kind == TypeId::of::<f64>() {
        flag.value_parser(move |text: &str| limit.read_real(text))
    } else {
        flag
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use robovec_num::limits::Amount;

    /// Complains of flags that are numbers without a limit, or whose limit
    /// does not fit their type.
    fn complaints(command: &Command) -> Vec<String> {
        let mut complaints = Vec::new();
        for flag in command.get_arguments() {
            let kind = flag.get_value_parser().type_id();
            let is = |types: &[TypeId]| types.iter().any(|known| kind == *known);
            let small = is(&[TypeId::of::<u32>()]);
            let whole = small || is(&[TypeId::of::<u64>(), TypeId::of::<usize>()]);
            let real = is(&[TypeId::of::<f64>()]);
            let other = is(&[
                TypeId::of::<u8>(),
                TypeId::of::<u16>(),
                TypeId::of::<i32>(),
                TypeId::of::<i64>(),
                TypeId::of::<f32>(),
            ]);
            let name = format!("{} {}", command.get_name(), flag.get_id());
            match flag.get::<FlagLimit>() {
                None if whole || real || other => complaints.push(format!("{name}: no limit")),
                None => {}
                Some(_) if other => complaints.push(format!("{name}: its limit is not enforced")),
                Some(FlagLimit(limit)) => {
                    let fits = match limit.most() {
                        Amount::Whole(most) if small => most <= u64::from(u32::MAX),
                        Amount::Whole(_) => whole,
                        Amount::Real(_) => real,
                    };
                    if !fits {
                        complaints.push(format!("{name}: the limit does not fit its type"));
                    }
                }
            }
        }
        complaints.extend(command.get_subcommands().flat_map(complaints_of));
        complaints
    }

    fn complaints_of(command: &Command) -> Vec<String> {
        complaints(command)
    }

    #[test]
    fn every_flag_that_is_a_number_has_a_limit() {
        for command in crate::command::commands() {
            let complaints = complaints(&command);
            assert!(complaints.is_empty(), "{}", complaints.join("\n"));
        }
    }

    #[test]
    fn flags_are_read_by_their_limits() {
        let command = Command::new("try")
            .arg(
                Arg::new("points")
                    .long("points")
                    .add(whole(1, 9, "nine is enough"))
                    .value_parser(clap::value_parser!(u32)),
            )
            .arg(
                Arg::new("time")
                    .long("time")
                    .add(real(0.5, 2.0, "two is enough"))
                    .value_parser(clap::value_parser!(f64)),
            );
        let command = enforce(command);
        let read = |words: &[&str]| {
            let words = ["try"].iter().chain(words);
            command.clone().try_get_matches_from(words)
        };
        let matches = read(&["--points=9", "--time=2"]).expect("both are allowed");
        assert_eq!(matches.get_one::<u32>("points"), Some(&9));
        assert_eq!(matches.get_one::<f64>("time"), Some(&2.0));
        for (words, part) in [
            (
                "--points=10",
                "10 is not allowed: an integer from 1 to 9 is, since nine is enough",
            ),
            ("--points=0", "from 1 to 9"),
            ("--points=-1", "from 1 to 9"),
            ("--points=99999999999999999999", "from 1 to 9"),
            ("--time=nan", "NaN is not allowed"),
            ("--time=1e308", "from 0.5 to 2"),
        ] {
            let error = read(&[words]).expect_err(words).to_string();
            assert!(
                error.contains(part) || error.contains(&part.replace("NaN", "nan")),
                "{error}"
            );
        }
    }
}
