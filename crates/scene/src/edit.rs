//! Changes of the text of a scene, which keeps its comments and layout.

mod bracket;
mod entries;
mod fields;
mod methods;
mod rewrite;
mod vary;

pub use crate::text::kinds::Kind;
pub use entries::moved_place;
pub use fields::{Field, Value};
pub use methods::Setting;
pub use rewrite::{TextEdit, rewrite};
pub use vary::VariedScene;

#[cfg(test)]
mod tests;
