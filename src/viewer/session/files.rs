//! Files that the user names: scenes, images to compare with, and files to save to.

use std::path::{Path, PathBuf};

use super::{Effect, Session};
use crate::viewer::dialog::{Answer, Question};
use crate::viewer::shared::{News, Save};

impl Session {
    /// Writes the image or a checkpoint to the file that the panel names, or to the next free name.
    pub fn save(&mut self) {
        self.save_to(PathBuf::from(&self.save_text), false);
    }

    fn save_to(&mut self, path: PathBuf, may_replace: bool) {
        let save =
            Save { path, may_replace, exposure: self.exposure(), target: self.target(), quantity: self.quantity };
        self.message = Some(Ok(format!("saving {} after this iteration", save.path.display())));
        self.shared.wish(false, |wish| wish.saves.push(save));
    }

    /// Opens a dropped file: an image to compare with, else a scene.
    pub fn drop_file(&mut self, path: &Path) {
        let extension = path.extension().map(|extension| extension.to_string_lossy().to_lowercase());
        let images = ["exr", "hdr", "jpg", "jpeg", "pfm", "png", "tga"];
        if extension.is_some_and(|extension| images.contains(&extension.as_str())) {
            self.compare_with(path);
        } else {
            self.open(path);
        }
    }

    /// Returns the dialog that the window has to open, unless one is open.
    pub fn ask(&mut self, question: Question) -> Option<Effect> {
        if std::mem::replace(&mut self.is_asking, true) {
            return None;
        }
        let start = match question {
            Question::Scene => self.path.clone(),
            Question::Reference if self.reference_text.is_empty() => self.path.clone(),
            Question::Reference => PathBuf::from(&self.reference_text),
            Question::Save => PathBuf::from(&self.save_text),
        };
        Some(Effect::Ask(question, start))
    }

    /// Takes the answers of other threads.
    pub(super) fn take_answers(&mut self, news: &mut News) {
        if let Some((question, answer)) = news.answer.take() {
            self.take_answer(question, answer);
        }
        match news.other.take() {
            Some(Ok(other)) => {
                self.message = Some(Ok(format!("read {}: B shows it, V shows both", other.name)));
                self.take_other(other);
            }
            Some(Err(error)) => self.message = Some(Err(error)),
            None => {}
        }
        if let Some((number, error)) = news.comparison.take() {
            self.take_error(number, error);
        }
    }

    fn take_answer(&mut self, question: Question, answer: Answer) {
        self.is_asking = false;
        match (question, answer) {
            (_, Answer::Cancelled) => {}
            (_, Answer::Failed(error)) => {
                let other = match question {
                    Question::Scene => "type the name under Files, or drop the file on the window",
                    Question::Reference => "type the name under Compare, or drop the file on the window",
                    Question::Save => "type the name under Files, and press Ctrl+S",
                };
                self.message = Some(Err(format!("this desktop shows no file dialog ({error}): {other}")));
            }
            (Question::Scene, Answer::Chosen(path)) => self.open(&path),
            (Question::Reference, Answer::Chosen(path)) => self.compare_with(&path),
            (Question::Save, Answer::Chosen(path)) => {
                self.save_text = path.display().to_string();
                // The dialog has asked before it names a file that exists.
                self.save_to(path, true);
            }
        }
    }
}
