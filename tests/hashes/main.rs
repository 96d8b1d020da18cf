//! Prints the state hashes of every scene by every method, as `tests/determinism/methods.txt` has them.

fn main() {
    print!("{}", hashes::hashes());
}
