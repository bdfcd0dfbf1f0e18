//! Undo and redo of the camera.

use std::time::{Duration, Instant};

use super::camera_control::Place;

/// Moves with less than this time between them are one step: a drag, a flight, turns of the wheel.
const BETWEEN: Duration = Duration::from_millis(700);
/// The largest number of steps that are kept.
const MOST: usize = 200;

/// The places where the camera has been.
#[derive(Debug, Default)]
pub struct History {
    /// The places before the one where the camera is, the latest last.
    before: Vec<Place>,
    /// The places that were left by undoing, the latest last.
    after: Vec<Place>,
    /// The time of the last move.
    moved: Option<Instant>,
}

impl History {
    /// Notes a move of the camera from a place. Moves that follow each other soon are one step.
    pub fn moves(&mut self, from: Place, now: Instant) {
        let is_same = self.moved.is_some_and(|moved| now.duration_since(moved) < BETWEEN);
        if !is_same {
            self.before.push(from);
            let surplus = self.before.len().saturating_sub(MOST);
            self.before.drain(..surplus);
        }
        self.after.clear();
        self.moved = Some(now);
    }

    /// Ends a step: the next move begins another one.
    pub fn ends_step(&mut self) {
        self.moved = None;
    }

    /// Returns the place before the last step, from the place where the camera is.
    pub fn undo(&mut self, here: Place) -> Option<Place> {
        self.moved = None;
        let place = self.before.pop()?;
        self.after.push(here);
        Some(place)
    }

    /// Returns the place that was left by the last undoing.
    pub fn redo(&mut self, here: Place) -> Option<Place> {
        self.moved = None;
        let place = self.after.pop()?;
        self.before.push(here);
        Some(place)
    }

    /// Returns the numbers of steps that can be undone and done again.
    pub fn steps(&self) -> [usize; 2] {
        [self.before.len(), self.after.len()]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Scene;

    fn place(x: f64) -> Place {
        let scene = Scene::parse("WorldBegin\nLightSource \"point\"\nShape \"sphere\"\n", "scene.pbrt", ".").unwrap();
        let mut camera = scene.camera;
        camera.world_from_camera.translation.x = x;
        Place { camera, distance: Some(x) }
    }

    #[test]
    fn moves_that_follow_soon_are_one_step() {
        let mut history = History::default();
        let start = Instant::now();
        let at = |milliseconds| start + Duration::from_millis(milliseconds);
        for (milliseconds, x) in [(0, 0.0), (500, 1.0), (1000, 2.0), (2000, 3.0), (2100, 4.0)] {
            history.moves(place(x), at(milliseconds));
        }
        assert_eq!(history.steps(), [2, 0]);
        assert_eq!(history.undo(place(5.0)), Some(place(3.0)));
        assert_eq!(history.undo(place(3.0)), Some(place(0.0)));
        assert_eq!(history.undo(place(0.0)), None);
        assert_eq!(history.redo(place(0.0)), Some(place(3.0)));
        assert_eq!(history.redo(place(3.0)), Some(place(5.0)));
        assert_eq!(history.redo(place(5.0)), None);
    }

    #[test]
    fn a_move_after_undoing_forgets_what_was_undone_and_begins_a_step() {
        let mut history = History::default();
        let start = Instant::now();
        history.moves(place(0.0), start);
        history.undo(place(1.0));
        history.moves(place(0.0), start);
        assert_eq!(history.steps(), [1, 0]);
        history.ends_step();
        history.moves(place(2.0), start);
        assert_eq!(history.steps(), [2, 0]);
        for x in 0..1000 {
            history.ends_step();
            history.moves(place(f64::from(x)), start);
        }
        assert_eq!(history.steps(), [MOST, 0]);
        assert_eq!(history.undo(place(-1.0)), Some(place(999.0)), "the latest are kept");
    }
}
