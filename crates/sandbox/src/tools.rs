//! The tools: everything that a key opens beside the picture, one folder or file each, and the one list of them.

pub(crate) mod cost;
mod curves;
pub(crate) mod editor;
pub(crate) mod effects;
pub(crate) mod finder;
pub(crate) mod forecast;
pub(crate) mod ghosts;
mod graphs;
mod help;
pub(crate) mod ledger;
mod settings;
mod timeline;
pub(crate) mod tool;

use self::tool::Tool;
use crate::panels::{Panel, with_panels};

/// Makes the struct of all tools from the list of panels.
macro_rules! tools {
    ($($Tool:ident in $tool:ident: $name:literal, $key:tt, $title:literal, $what:literal;)*) => {
        /// The state of all tools of a scene.
        #[derive(Default)]
        pub(crate) struct Tools {
            $(pub $tool: $tool::$Tool,)*
        }

        impl Tools {
            /// All of them, in the order of the rows.
            pub fn each(&mut self) -> impl Iterator<Item = (Panel, &mut dyn Tool)> {
                [$((Panel::$Tool, &mut self.$tool as &mut dyn Tool),)*].into_iter()
            }
        }
    };
}

with_panels!(tools);
