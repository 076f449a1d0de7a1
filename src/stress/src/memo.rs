//! Results that the examination of a case computes once: programs that several
//! formats run, and runs that take long.

use std::sync::{Mutex, PoisonError};

/// A few results, with their keys.
pub(super) struct Memo<K, V>(Mutex<Vec<(K, V)>>);

impl<K, V> Default for Memo<K, V> {
    fn default() -> Memo<K, V> {
        Memo(Mutex::default())
    }
}

impl<K: PartialEq, V: Clone> Memo<K, V> {
    /// The result for a key, computed if there is none.
    ///
    /// # Errors
    ///
    /// Errors of the computation.
    pub(super) fn get<E>(&self, key: K, compute: impl FnOnce() -> Result<V, E>) -> Result<V, E> {
        // A thread that panicked left nothing half done here.
        let lock = || self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let known = lock()
            .iter()
            .find(|(known, _)| *known == key)
            .map(|(_, result)| result.clone());
        if let Some(known) = known {
            return Ok(known);
        }
        // Not under the lock: a computation may need another result first.
        let result = compute()?;
        lock().push((key, result.clone()));
        Ok(result)
    }
}
