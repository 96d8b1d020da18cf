//! Texts that people write: read with the places of their keys, and every fault told with its place and its cure.

pub(crate) mod faults;
pub(crate) mod kinds;
pub(crate) mod locate;
pub(crate) mod nearest;
pub(crate) mod syntax;
pub(crate) mod tokens;
pub(crate) mod tree;
