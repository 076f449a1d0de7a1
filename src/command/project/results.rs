//! Numbers that runs of a project print, compared to their last digit.

use robovec_io::files::limited;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

/// Endings of files of numbers.
const ENDINGS: [&str; 5] = ["res", "anim", "txt", "csv", "dat"];

#[derive(Clone, Copy, PartialEq, Debug)]
struct PrintedNumber {
    value: f64,
    /// Value of one unit in its last place; zero without a decimal point.
    unit: f64,
}

/// The lines of numbers of a file.
pub(super) struct ResultFile {
    pub(super) name: String,
    rows: Vec<Vec<PrintedNumber>>,
}

impl ResultFile {
    /// The numbers of a text; none without a line of numbers.
    pub(super) fn new(name: String, text: &str) -> Option<ResultFile> {
        let line = |line: &str| {
            let words = line.split(|letter: char| letter.is_whitespace() || ",;".contains(letter));
            let words = words.filter(|word| !word.is_empty());
            let numbers: Option<Vec<PrintedNumber>> = words.map(printed).collect();
            numbers.filter(|numbers| !numbers.is_empty())
        };
        let rows: Vec<Vec<PrintedNumber>> = text.lines().filter_map(line).collect();
        (!rows.is_empty()).then_some(ResultFile { name, rows })
    }

    /// The numbers of a file, named from a folder.
    pub(super) fn read(path: &Path, folder: &Path) -> Option<ResultFile> {
        let bytes = limited::read(path, &limited::STATES).ok()?;
        let name = path.strip_prefix(folder).unwrap_or(path).display();
        ResultFile::new(name.to_string(), &String::from_utf8_lossy(&bytes))
    }
}

/// The files of numbers among those of a folder that were written since a time.
pub(super) fn written(files: &[PathBuf], folder: &Path, since: SystemTime) -> Vec<ResultFile> {
    let is_new = |path: &&PathBuf| {
        let time = path.metadata().and_then(|data| data.modified());
        time.is_ok_and(|time| time >= since)
    };
    let is_named = |path: &&PathBuf| {
        let end = path.extension().and_then(|end| end.to_str());
        end.is_some_and(|end| ENDINGS.contains(&end))
    };
    let files = files.iter().filter(is_named).filter(is_new);
    files
        .filter_map(|path| ResultFile::read(path, folder))
        .collect()
}

/// A number with the place of its last digit.
fn printed(word: &str) -> Option<PrintedNumber> {
    let value = word.parse().ok()?;
    let (digits, exponent) = word.split_once(['e', 'E']).unwrap_or((word, "0"));
    let exponent: i32 = exponent.parse().unwrap_or(0);
    let places = digits.split_once('.').map(|(_, places)| places.len());
    let unit = places.map_or(0.0, |places| {
        let places = i32::try_from(places).unwrap_or(i32::MAX);
        10f64.powi(exponent.saturating_sub(places))
    });
    Some(PrintedNumber { value, unit })
}

/// The largest difference beyond one unit in the last printed place, in parts
/// of the largest number of its column, at least 1, and the file that has it;
/// infinite where files, or their rows, differ in number or length.
pub(super) fn difference(one: &[ResultFile], other: &[ResultFile]) -> (f64, String) {
    let missing = |files: &[ResultFile], name: &str| files.iter().all(|file| file.name != name);
    let more = other.iter().filter(|file| missing(one, &file.name));
    let more = more.map(|file| (f64::INFINITY, file));
    let both = one.iter().map(|file| {
        let same = other.iter().find(|other| other.name == file.name);
        let apart = same.and_then(|other| apart(&file.rows, &other.rows));
        (apart.unwrap_or(f64::INFINITY), file)
    });
    let worst = both
        .chain(more)
        .max_by(|one, other| one.0.total_cmp(&other.0));
    worst.map_or((0.0, String::new()), |(apart, file)| {
        (apart, file.name.clone())
    })
}

fn apart(one: &[Vec<PrintedNumber>], other: &[Vec<PrintedNumber>]) -> Option<f64> {
    let has_same_length = |(one, other): (&Vec<_>, &Vec<_>)| one.len() == other.len();
    if one.len() != other.len() || !one.iter().zip(other).all(has_same_length) {
        return None;
    }
    let width = one.iter().map(Vec::len).fold(0, usize::max);
    let mut scale = vec![1.0f64; width];
    for row in one {
        for (scale, number) in scale.iter_mut().zip(row) {
            *scale = scale.max(number.value.abs());
        }
    }
    let rows = one.iter().zip(other);
    let pairs = rows.flat_map(|(one, other)| one.iter().zip(other).zip(&scale));
    Some(pairs.fold(0.0, |worst, ((one, other), scale)| {
        if one.value.to_bits() == other.value.to_bits() {
            return worst;
        }
        // Where one has fewer places, zeros at its end were left out.
        let unit = if one.unit == 0.0 || other.unit == 0.0 {
            one.unit.max(other.unit)
        } else {
            one.unit.min(other.unit)
        };
        let apart = (one.value - other.value).abs();
        // Half a part in 1000 of the unit is the rounding of this difference.
        let beyond = if apart <= unit * 1.0005 {
            0.0
        } else {
            apart / scale
        };
        worst.max(if beyond.is_nan() {
            f64::INFINITY
        } else {
            beyond
        })
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn between(one: &str, other: &str) -> f64 {
        let file = |text| vec![ResultFile::new("q.res".to_owned(), text).expect("numbers")];
        difference(&file(one), &file(other)).0
    }

    #[test]
    fn differences_count_beyond_the_last_printed_place() {
        assert_eq!(printed("-1.25e-03").map(|number| number.unit), Some(1e-5));
        assert_eq!(between("t q\n0.10 2.5e-3", "0.10 2.6e-3"), 0.0);
        assert_eq!(between("0.3 1", "0.300001 1"), 0.0);
        assert!(between("0.10", "0.12") > 0.019);
        assert!(between("100.00 1.5", "98.00 1.5") < 0.021);
        assert_eq!(between("4 0.5", "3 0.5"), 0.25);
        assert_eq!(between("0.1 0.2", "0.1"), f64::INFINITY);
        assert_eq!(between("nan 0.5", "1.0 0.5"), f64::INFINITY);
        assert_eq!(between("nan 0.5", "nan 0.5"), 0.0);
    }
}
