//! The texts of a scene through its changes: for undo and redo, and the text of its file.

use std::collections::VecDeque;
use std::path::PathBuf;
use std::sync::Arc;

use scene::Scene;

/// Greatest size of all texts to which undo can go, bytes; the oldest are forgotten first.
const MOST_BYTES: usize = 256 << 20;

/// The texts of a scene before and after the present one.
pub(crate) struct Document {
    past: VecDeque<Arc<str>>,
    future: Vec<Arc<str>>,
    /// The file that saving replaces, and its text.
    pub file: Option<(PathBuf, Arc<str>)>,
    /// The text of the file or of the shipped scene; `None` for a scene that is in no file.
    pub saved: Option<Arc<str>>,
}

impl Document {
    pub fn of(scene: &Scene) -> Self {
        let file = scene.source.file().map(|path| (path.to_owned(), Arc::clone(&scene.text)));
        Self {
            past: VecDeque::new(),
            future: Vec::new(),
            file,
            saved: Some(Arc::clone(&scene.text)),
        }
    }

    /// Remembers the text before a change.
    pub fn changed(&mut self, before: Arc<str>) {
        self.future.clear();
        self.past.push_back(before);
        let mut bytes: usize = self.past.iter().map(|text| text.len()).sum();
        while bytes > MOST_BYTES {
            bytes -= self.past.pop_front().map_or(bytes, |oldest| oldest.len());
        }
    }

    /// Returns the text before the last change; redo goes to `present`.
    pub fn undo(&mut self, present: Arc<str>) -> Option<Arc<str>> {
        let text = self.past.pop_back()?;
        self.future.push(present);
        Some(text)
    }

    /// Returns the text after the change that was undone last; undo goes to `present`.
    pub fn redo(&mut self, present: Arc<str>) -> Option<Arc<str>> {
        let text = self.future.pop()?;
        self.past.push_back(present);
        Some(text)
    }

    pub fn can_undo(&self) -> bool {
        !self.past.is_empty()
    }

    pub const fn can_redo(&self) -> bool {
        !self.future.is_empty()
    }

    /// Whether `present` is saved nowhere.
    pub fn is_unsaved(&self, present: &str) -> bool {
        self.saved.as_deref() != Some(present)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(text: &str) -> Document {
        Document::of(&Scene::parse("t", text).expect("a scene"))
    }

    #[test]
    fn undo_and_redo_go_through_the_texts() {
        let mut document = of("(version: 1)");
        document.changed("a".into());
        document.changed("b".into());
        assert_eq!(document.undo("c".into()).as_deref(), Some("b"));
        assert_eq!(document.undo("b".into()).as_deref(), Some("a"));
        assert_eq!(document.undo("a".into()), None);
        assert_eq!(document.redo("a".into()).as_deref(), Some("b"));
        document.changed("b".into());
        assert_eq!(
            document.redo("d".into()),
            None,
            "a new change comes in place of what was undone"
        );
        assert!(document.can_undo() && !document.can_redo());
        assert!(document.is_unsaved("d") && !document.is_unsaved("(version: 1)"));
    }

    #[test]
    fn the_oldest_texts_are_forgotten_where_all_take_too_much() {
        let mut document = of("(version: 1)");
        let text: Arc<str> = "x".repeat(MOST_BYTES / 4).into();
        for _ in 0..6 {
            document.changed(Arc::clone(&text));
        }
        assert_eq!((0..).take_while(|_| document.undo(Arc::clone(&text)).is_some()).count(), 4);
    }
}
