//! Reading of lists from files within a memory limit: three bytes of a file can be seventy in memory.

use std::cell::Cell;
use std::fmt;
use std::marker::PhantomData;

use serde::de::{Deserialize, Deserializer, Error, SeqAccess, Visitor};

thread_local! {
    /// Bytes that entries of lists may still take.
    static ROOM: Cell<usize> = const { Cell::new(usize::MAX) };
}

/// Runs `read`, in which all lists together may take at most `bytes` bytes.
pub fn within<T>(bytes: usize, read: impl FnOnce() -> T) -> T {
    counted_within(bytes, read).0
}

/// [`within`], with the bytes that the lists took; `None` if they would have taken more than `bytes`.
pub fn counted_within<T>(bytes: usize, read: impl FnOnce() -> T) -> (T, Option<usize>) {
    /// Restores the previous limit, also if `read` panics.
    struct Before(usize, bool);

    impl Drop for Before {
        fn drop(&mut self) {
            ROOM.set(self.0);
            IS_FULL.set(self.1);
        }
    }

    let _before = Before(ROOM.replace(bytes), IS_FULL.replace(false));
    let read = read();
    let used = bytes - ROOM.get();
    (read, (!IS_FULL.get()).then_some(used))
}

thread_local! {
    static IS_FULL: Cell<bool> = const { Cell::new(false) };
}

/// Reads a list and counts its bytes: every list of a file must be read by this function.
///
/// # Errors
/// If the list takes more bytes than are left, as soon as it does.
pub fn list<'de, D: Deserializer<'de>, T: Deserialize<'de>>(source: D) -> Result<Vec<T>, D::Error> {
    source.deserialize_seq(Entries(PhantomData))
}

struct Entries<T>(PhantomData<T>);

impl<'de, T: Deserialize<'de>> Visitor<'de> for Entries<T> {
    type Value = Vec<T>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a sequence")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut entries: A) -> Result<Vec<T>, A::Error> {
        let mut list = Vec::new();
        while let Some(entry) = entries.next_element()? {
            let Some(room) = ROOM.get().checked_sub(size_of::<T>()) else {
                IS_FULL.set(true);
                return Err(A::Error::custom("it takes too much memory"));
            };
            ROOM.set(room);
            list.push(entry);
        }
        Ok(list)
    }
}

/// Bytes that a list has allocated for its own entries.
#[must_use]
pub const fn list_bytes<T>(list: &Vec<T>) -> usize {
    list.capacity() * size_of::<T>()
}
