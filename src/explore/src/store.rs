//! Finished points on disk, from which an interrupted exploration continues.
//!
//! A point is stored under a key made of all its dependences, with the build of
//! robovec. A file that does not match its name counts as missing.

use robovec_io::files::{Replace, make_folder, write_whole};
use robovec_ir::{Machine, Module, Symbol, print};
use robovec_num::fnv::Fnv;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// A hash of a text in 128 bits (FNV-1a), the same on every system.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct PointKey(u128);

impl PointKey {
    /// The hash of nothing.
    pub fn new() -> PointKey {
        PointKey(0x6c62_272e_07bb_0142_62b8_2175_6295_c58d)
    }

    /// Adds a text and a separator.
    pub fn with(mut self, text: &str) -> PointKey {
        self.add(text.as_bytes());
        self.add(&[0xff]);
        self
    }

    /// Adds a module as passes see it: its text, and the order in which its
    /// symbols were first met, which the text does not keep.
    pub fn with_module(mut self, module: &Module) -> PointKey {
        let symbols = &module.tables.symbols;
        for number in 0..symbols.len() {
            self = self.with(symbols.text(Symbol(number as u32)));
        }
        // Hashing cannot fail.
        let _ = print::write_module(module, &mut self);
        self.with("")
    }

    /// Adds a machine with all its fields.
    pub fn with_machine(self, machine: &Machine) -> PointKey {
        self.with(&serde_json::to_string(machine).expect("a machine is plain data"))
    }

    fn add(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            self.0 =
                (self.0 ^ u128::from(byte)).wrapping_mul(0x0000_0000_0100_0000_0000_0000_0000_013b);
        }
    }

    pub(crate) fn file_name(self) -> String {
        format!("{:032x}.json", self.0)
    }
}

impl Default for PointKey {
    fn default() -> PointKey {
        PointKey::new()
    }
}

impl Write for PointKey {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.add(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// The key of this build of robovec, its version and a digest of its program
/// file, against points of others; an error without the file.
pub(crate) fn build_key() -> io::Result<PointKey> {
    let program = std::env::current_exe().and_then(fs::read)?;
    let key = PointKey::new().with(env!("CARGO_PKG_VERSION"));
    // A digest of words is enough and quick for large programs.
    use std::hash::Hasher;
    let mut hasher = rustc_hash::FxHasher::default();
    hasher.write(&program);
    Ok(key.with(&format!("{:x} {}", hasher.finish(), program.len())))
}

#[derive(Serialize, Deserialize)]
struct StoredPoint<P> {
    /// Key that the point was computed from.
    key: String,
    /// Hash of the point's text, so that an edited point is none.
    content: String,
    point: P,
}

/// The hash of a point's text.
fn content(point: &impl Serialize) -> String {
    let text = serde_json::to_vec(point).expect("a point is plain data");
    Fnv::of(&text).text()
}

/// The folder of finished points.
#[derive(Debug)]
pub struct PointStore {
    folder: PathBuf,
    /// True if points found there are used.
    reuse: bool,
}

impl PointStore {
    /// Opens the folder, made if needed.
    pub fn open(folder: &Path, reuse: bool) -> io::Result<PointStore> {
        make_folder(folder)?;
        Ok(PointStore {
            folder: folder.to_owned(),
            reuse,
        })
    }

    /// The point of a key, if it is there and sound.
    pub(crate) fn load<P: Serialize + DeserializeOwned>(&self, key: PointKey) -> Option<P> {
        if !self.reuse {
            return None;
        }
        let text = fs::read_to_string(self.folder.join(key.file_name())).ok()?;
        let stored: StoredPoint<P> = serde_json::from_str(&text).ok()?;
        let sound = stored.key == key.file_name() && stored.content == content(&stored.point);
        sound.then_some(stored.point)
    }

    /// Keeps a point; a failure leaves an existing file of that name unchanged.
    pub(crate) fn save(&self, key: PointKey, point: &impl Serialize) -> io::Result<()> {
        let stored = StoredPoint {
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

    #[test]
    fn the_hash_is_fnv_1a() {
        let mut key = PointKey::new();
        key.add(b"a");
        assert_eq!(key.0, 0xd228_cb69_6f1a_8caf_7891_2b70_4e4a_8964);
    }

    #[test]
    fn what_is_stored_is_found_again_and_what_is_corrupt_is_not() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let store = PointStore::open(folder.path(), true).expect("it can be made");
        let key = PointKey::new().with("program");
        assert_eq!(store.load::<[u32; 2]>(key), None);
        let point = [743, 1];
        store.save(key, &point).expect("it can be written");
        assert_eq!(store.load(key), Some(point));
        let other = PointKey::new().with("another program");
        let path = folder.path();
        fs::copy(path.join(key.file_name()), path.join(other.file_name())).expect("copied");
        assert_eq!(
            store.load::<[u32; 2]>(other),
            None,
            "a copy under another name"
        );
        let text = fs::read_to_string(path.join(key.file_name())).expect("it is there");
        let edited = text.replace("743", "742");
        fs::write(path.join(key.file_name()), edited).expect("written");
        assert_eq!(store.load::<[u32; 2]>(key), None, "a point that was edited");
        fs::write(path.join(key.file_name()), "{\"key\":").expect("written");
        assert_eq!(store.load::<[u32; 2]>(key), None, "a file that is cut off");
    }
}
