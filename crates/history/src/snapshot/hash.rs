//! One number for the state of a world.

use xxhash_rust::xxh3::Xxh3;

/// XXH3-64 over the little-endian f64 bits of each position, m, and velocity, m/s, in the order that they come in.
#[must_use]
pub fn hash_of_states(states: impl IntoIterator<Item = ([f64; 3], [f64; 3])>) -> u64 {
    let mut hash = Xxh3::new();
    for (position, velocity) in states {
        for number in position.into_iter().chain(velocity) {
            hash.update(&number.to_bits().to_le_bytes());
        }
    }
    hash.digest()
}
