//! What the render thread does, and the words for it.

use std::time::Instant;

use crate::render::activity::Activity;

/// The activity of the render thread.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Doing {
    /// It opens the device.
    #[default]
    OpensDevice,
    /// It reads the scene file.
    Reads,
    /// It prepares the scene for a render, or finds where photons should begin.
    Prepares(Activity),
    /// It renders coarse images, because the camera moves.
    Looks,
    /// It renders the image.
    Renders,
    /// It waits until the user goes on.
    Pauses,
    /// It has rendered all iterations that were asked for.
    IsDone,
    /// Scene, options or device do not allow an image.
    Failed,
}

impl Doing {
    /// Returns the state in words. `is_paused` says whether the user wants a pause, and `since` when the state began.
    pub fn words(self, is_paused: bool, since: Option<Instant>) -> String {
        let activity;
        let words = match self {
            Self::Prepares(what) => {
                activity = what.to_string();
                &activity
            }
            Self::OpensDevice => "opening the device",
            Self::Reads => "reading the scene",
            Self::Looks => "coarse image",
            Self::Renders if is_paused => "pausing after this iteration",
            Self::Renders => "rendering",
            Self::Pauses => "paused",
            Self::IsDone => "all iterations done",
            Self::Failed => "failed",
        };
        let seconds = since.map_or(0, |since| since.elapsed().as_secs());
        if self.is_wait() && seconds > 0 { format!("{words}, {seconds} s") } else { words.to_owned() }
    }

    /// Returns whether the user waits for the first picture, so that the time is shown.
    pub fn is_wait(self) -> bool {
        matches!(self, Self::OpensDevice | Self::Reads | Self::Prepares(_))
    }

    /// Returns whether it goes on: the next kernel is the same activity.
    pub fn is_same(self, other: Self) -> bool {
        match (self, other) {
            (Self::Prepares(this), Self::Prepares(other)) => this.is_same(other),
            _ => self == other,
        }
    }

    /// Returns whether nothing changes until the user does something.
    pub fn is_rest(self) -> bool {
        matches!(self, Self::Pauses | Self::IsDone | Self::Failed)
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;

    #[test]
    fn a_pause_is_only_said_when_nothing_is_rendered_any_more() {
        assert_eq!(Doing::Renders.words(true, None), "pausing after this iteration");
        assert_eq!(Doing::Pauses.words(true, None), "paused");
        assert_eq!(Doing::Renders.words(false, None), "rendering");
        assert_eq!(Doing::IsDone.words(true, None), "all iterations done");
    }

    #[test]
    fn the_time_of_a_wait_is_said() {
        let since = Instant::now().checked_sub(Duration::from_secs(7));
        let compiles = |done| Doing::Prepares(Activity::CompilingKernels { done, all: 8 });
        assert_eq!(compiles(3).words(false, since), "compiling kernels 3/8, 7 s");
        assert!(compiles(3).is_same(compiles(4)) && !compiles(3).is_same(Doing::Renders), "its time goes on");
        assert_eq!(Doing::Renders.words(false, since), "rendering");
    }
}
