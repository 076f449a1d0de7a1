//! Finished placements on disk, so that an interrupted study goes on where it
//! stopped.
//!
//! A point is stored under a key made of everything it depends on: the text
//! of the program, the pipeline, the machine, the options of the placer, and
//! the build of robovec. A file that is not what its name promises (cut off,
//! edited, of another version) counts as missing.

use super::plan::{NamedMachine, NamedPipeline, Request};
use super::point::Point;
use crate::files::{Replace, make_folder, write_whole};
use robovec_num::fnv::Fnv;
use serde::{Deserialize, Serialize};
use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// A hash of a text in 128 bits (FNV-1a), the same on every system.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Key(u128);

impl Key {
    /// The hash of nothing.
    pub fn new() -> Key {
        Key(0x6c62_272e_07bb_0142_62b8_2175_6295_c58d)
    }

    /// Adds a text and a separator.
    pub fn with(mut self, text: &str) -> Key {
        self.add(text.as_bytes());
        self.add(&[0xff]);
        self
    }

    fn add(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            self.0 =
                (self.0 ^ u128::from(byte)).wrapping_mul(0x0000_0000_0100_0000_0000_0000_0000_013b);
        }
    }

    fn file_name(self) -> String {
        format!("{:032x}.json", self.0)
    }
}

impl Default for Key {
    fn default() -> Key {
        Key::new()
    }
}

impl Write for Key {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.add(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// The key of a placement, given that of the equations.
pub fn key(
    equations: Key,
    build: Key,
    pipeline: &NamedPipeline,
    machine: &NamedMachine,
    request: &Request,
) -> Key {
    let machine = serde_json::to_string(&machine.machine).expect("a machine is plain data");
    equations
        .with(&build.file_name())
        .with(&pipeline.pipeline.to_string())
        .with(&machine)
        .with(&format!("{}+{}", request.n_add, request.n_multi))
        .with(&format!("{:?} {:?}", request.priority, request.choice))
}

/// The build of robovec that runs: its version and the bytes of the program,
/// so that points of a changed compiler are not taken for its own.
///
/// # Errors
///
/// When the program cannot be read: nobody knows then which it is, and points
/// cannot be told apart.
pub fn build_key() -> io::Result<Key> {
    let program = std::env::current_exe().and_then(fs::read)?;
    let key = Key::new().with(env!("CARGO_PKG_VERSION"));
    // A digest of words is enough and quick for large programs.
    use std::hash::Hasher;
    let mut hasher = rustc_hash::FxHasher::default();
    hasher.write(&program);
    Ok(key.with(&format!("{:x} {}", hasher.finish(), program.len())))
}

#[derive(Serialize, Deserialize)]
struct Stored<P> {
    /// What the point was computed from.
    key: String,
    /// Hash of the point's text, so that an edited point is none.
    content: String,
    point: P,
}

/// The hash of a point's text.
fn content(point: &Point) -> String {
    let text = serde_json::to_vec(point).expect("a point is plain data");
    Fnv::of(&text).text()
}

/// The folder of finished points.
#[derive(Debug)]
pub struct Store {
    folder: PathBuf,
    /// Whether points found there are used.
    reuse: bool,
}

impl Store {
    /// Opens the folder, made if needed.
    ///
    /// # Errors
    ///
    /// When it cannot be made.
    pub fn open(folder: &Path, reuse: bool) -> io::Result<Store> {
        make_folder(folder)?;
        Ok(Store {
            folder: folder.to_owned(),
            reuse,
        })
    }

    /// The point of a key, if it is there and sound.
    pub fn load(&self, key: Key) -> Option<Point> {
        if !self.reuse {
            return None;
        }
        let text = fs::read_to_string(self.folder.join(key.file_name())).ok()?;
        let stored: Stored<Point> = serde_json::from_str(&text).ok()?;
        let sound = stored.key == key.file_name() && stored.content == content(&stored.point);
        sound.then_some(stored.point)
    }

    /// Keeps a point.
    ///
    /// # Errors
    ///
    /// When it cannot be written; a file of that name is then as it was.
    pub fn save(&self, key: Key, point: &Point) -> io::Result<()> {
        let stored = Stored {
            key: key.file_name(),
            content: content(point),
            point,
        };
        let path = self.folder.join(key.file_name());
        write_whole(&path, Replace::Anything, |writer| {
            serde_json::to_writer(writer, &stored).map_err(io::Error::from)
        })
        .map_err(io::Error::other)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::plan::{ChoiceKey, PriorityKey};
    use crate::study::point::Point;
    use robovec_ir::{Format, Machine};
    use robovec_passes::pipeline::parse;

    #[test]
    fn the_hash_is_fnv_1a() {
        let mut key = Key::new();
        key.add(b"a");
        assert_eq!(key.0, 0xd228_cb69_6f1a_8caf_7891_2b70_4e4a_8964);
    }

    #[test]
    fn what_is_stored_is_found_again_and_what_is_corrupt_is_not() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let store = Store::open(folder.path(), true).expect("it can be made");
        let key = Key::new().with("program");
        assert_eq!(store.load(key), None);
        let point = Point {
            cycles: 743,
            ..Point::default()
        };
        store.save(key, &point).expect("it can be written");
        assert_eq!(store.load(key), Some(point));
        let other = Key::new().with("another program");
        let path = folder.path();
        fs::copy(path.join(key.file_name()), path.join(other.file_name())).expect("copied");
        assert_eq!(store.load(other), None, "a copy under another name");
        let text = fs::read_to_string(path.join(key.file_name())).expect("it is there");
        let edited = text.replace("743", "742");
        fs::write(path.join(key.file_name()), edited).expect("written");
        assert_eq!(store.load(key), None, "a point that was edited");
        fs::write(path.join(key.file_name()), "{\"key\":").expect("written");
        assert_eq!(store.load(key), None, "a file that is cut off");
    }

    /// Keys of equations and build, pipeline, machine and request.
    type All = (Key, Key, NamedPipeline, NamedMachine, Request);

    fn example() -> All {
        let pipeline = NamedPipeline {
            name: "usual".to_owned(),
            pipeline: parse("atomise,cse,place").expect("a pipeline"),
            printed: None,
        };
        let machine = NamedMachine {
            name: "thesis".to_owned(),
            machine: Machine::built_in("thesis").expect("it ships"),
            couple: None,
        };
        let request = Request {
            model: 0,
            pipeline: 0,
            machine: 0,
            n_add: 4,
            n_multi: 4,
            priority: PriorityKey::Best,
            choice: ChoiceKey::Preferential,
        };
        let equations = Key::new().with("function f equations {}");
        let build = Key::new().with("build");
        (equations, build, pipeline, machine, request)
    }

    #[test]
    fn a_key_depends_on_everything_a_point_depends_on() {
        type Change = fn(&mut All);
        let changes: [(&str, Change); 12] = [
            ("nothing", |_| {}),
            ("equations", |all| all.0 = all.0.with("another")),
            ("build", |all| all.1 = all.1.with("another")),
            ("pipeline", |all| {
                all.2.pipeline = parse("atomise,place").expect("a pipeline");
            }),
            ("stages", |all| all.3.machine.elements[0].stages += 1),
            ("words", |all| all.3.machine.memory.words = Some(77)),
            ("number", |all| all.3.machine.number = Format::BINARY64),
            ("adders", |all| all.4.n_add += 1),
            ("multipliers", |all| all.4.n_multi += 1),
            ("priority", |all| all.4.priority = PriorityKey::Alap),
            ("another", |all| all.4.priority = PriorityKey::FanOut),
            ("choice", |all| all.4.choice = ChoiceKey::First),
        ];
        let mut keys = Vec::new();
        for (what, change) in changes {
            let mut all = example();
            change(&mut all);
            let key = key(all.0, all.1, &all.2, &all.3, &all.4);
            assert!(!keys.contains(&key), "{what}");
            keys.push(key);
        }
        // Two numbers that stand side by side are not taken for others.
        let mut all = example();
        (all.4.n_add, all.4.n_multi) = (1, 12);
        let one = key(all.0, all.1, &all.2, &all.3, &all.4);
        (all.4.n_add, all.4.n_multi) = (11, 2);
        assert_ne!(one, key(all.0, all.1, &all.2, &all.3, &all.4));
    }
}
