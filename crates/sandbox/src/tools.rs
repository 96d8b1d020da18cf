//! What can be opened beside the picture, one module each.

pub(crate) mod cost;
pub(crate) mod effects;
pub(crate) mod finder;
pub(crate) mod forecast;
pub(crate) mod ghosts;
pub(crate) mod help;
pub(crate) mod ledger;
pub(crate) mod settings;
pub(crate) mod timeline;
