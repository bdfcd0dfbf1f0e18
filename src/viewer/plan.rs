//! The plan of the render thread: a function from the wish of the window and the state of the render to the
//! next step. It uses no device.

use super::quantity::Quantity;
use super::shared::{Save, Target, Wish};

/// The state of the render thread.
#[derive(Clone, Copy, Debug)]
pub struct Standing<'a> {
    /// The value of [`Target::loads`] for which a scene was last read, with or without success.
    pub loads: u64,
    /// The render in progress.
    pub render: Option<Rendered<'a>>,
    /// The target that has failed. It is not tried again.
    pub failed: Option<&'a Target>,
    /// Whether the wished target was put aside with its iterations.
    pub is_aside: bool,
    /// The coarseness of the first image of a target.
    pub coarsest: u32,
    /// The largest number of iterations; 1 or more.
    pub most: u32,
    /// Files to write.
    pub saves: &'a [Save],
}

/// The render in progress.
#[derive(Clone, Copy, Debug)]
pub struct Rendered<'a> {
    /// The target of the render.
    pub target: &'a Target,
    /// The number of image pixels along each axis per rendered pixel.
    pub coarseness: u32,
    /// The number of finished iterations.
    pub iterations: u32,
    /// The number of iterations and the quantity of the last picture that the window has got.
    pub shown: Option<(u32, Quantity)>,
}

impl Rendered<'_> {
    /// Returns whether there is an image that can be saved: in full resolution, with an iteration.
    pub fn is_whole(&self) -> bool {
        self.coarseness == 1 && self.iterations > 0
    }
}

/// A step of the render thread.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Next {
    /// Write the file with this index: its target has an image.
    Save(usize),
    /// Change the target of waiting files to the wished target, because their own target has no iteration.
    Follow,
    /// The window is closed and everything is written.
    End,
    /// Read the scene.
    Load,
    /// Report that no file can be written.
    Refuse,
    /// Start to render the wished target at this coarseness, or continue a render that was put aside.
    Aim(u32),
    /// Send the window a picture.
    Show,
    /// Render an iteration.
    Iterate,
    /// Wait for another wish.
    Rest,
}

/// Returns the next step. `is_moving` says that the camera moved just now, so that coarse images are enough.
///
/// A file gets the image of the target that was wished when the user saved it, if this target has an
/// iteration, or else of the next wished target that has one. So no file has 0 iterations: whether paused or
/// not, every target that is shown gets an iteration.
pub fn next(wish: &Wish, standing: &Standing<'_>, is_moving: bool) -> Next {
    let Standing { loads, render, failed, saves, .. } = standing;
    let is_there = |save: &Save| render.is_some_and(|render| render.is_whole() && *render.target == save.target);
    if let Some(index) = saves.iter().position(is_there) {
        return Next::Save(index);
    }
    if saves.iter().any(|save| save.target != wish.target) {
        return Next::Follow;
    }
    if wish.close && saves.is_empty() {
        return Next::End;
    }
    if wish.target.loads != *loads {
        return Next::Load;
    }
    if *failed == Some(&wish.target) {
        return after_failure(wish, standing);
    }
    let Some(render) = render.filter(|render| *render.target == wish.target) else {
        return Next::Aim(if standing.is_aside { 1 } else { standing.coarsest });
    };
    if render.iterations == 0 {
        return Next::Iterate;
    }
    if render.coarseness > 1 && !is_moving {
        return Next::Aim(render.coarseness / 2);
    }
    if render.coarseness > 1 || !(wish.paused || render.iterations >= standing.most) {
        let is_shown = render.shown.is_some_and(|(_, quantity)| quantity == wish.quantity);
        return if is_shown { Next::Iterate } else { Next::Show };
    }
    if render.shown == Some((render.iterations, wish.quantity)) { Next::Rest } else { Next::Show }
}

/// Returns the next step if the wished target has failed. The previous render is shown as long as it exists.
fn after_failure(wish: &Wish, standing: &Standing<'_>) -> Next {
    if !standing.saves.is_empty() {
        return Next::Refuse;
    }
    let has_it = |render: &Rendered<'_>| {
        let shows = wish.quantity.is_in(&render.target.options);
        shows && render.iterations > 0 && render.shown.is_none_or(|(_, quantity)| quantity != wish.quantity)
    };
    if standing.render.as_ref().is_some_and(has_it) { Next::Show } else { Next::Rest }
}

#[cfg(test)]
mod tests {
    use std::path::PathBuf;
    use std::time::Instant;

    use super::*;
    use crate::image::exposure::Exposure;
    use crate::render::options::Options;

    const MOST: u32 = 5;
    const AOV: Quantity = Quantity::ALL[3];

    fn target(photons: u64) -> Target {
        Target { loads: 1, camera: None, options: Options { photons: Some(photons), ..Options::default() } }
    }

    fn wish(photons: u64, quantity: Quantity, paused: bool, close: bool) -> Wish {
        let scene = PathBuf::from("scene.pbrt");
        let (moves, moved, saves) = (0, None::<Instant>, Vec::new());
        Wish { scene, target: target(photons), moves, moved, quantity, paused, saves, close }
    }

    fn save(photons: u64) -> Save {
        Save {
            path: PathBuf::from("image.exr"),
            may_replace: false,
            exposure: Exposure::default(),
            target: target(photons),
            quantity: Quantity::Image,
        }
    }

    /// Calls `check` with every state that the plan distinguishes, each with a wish for target 1.
    fn each_standing(check: impl Fn(&Wish, &Standing<'_>, bool)) {
        let [wished, other] = [target(1), target(2)];
        let renders = [None, Some(&wished), Some(&other)];
        let shown = [None, Some((1, Quantity::Image)), Some((MOST, AOV)), Some((MOST, Quantity::Image))];
        let saves = [vec![], vec![save(1)], vec![save(2)], vec![save(3), save(1)]];
        for (render, failed) in renders.iter().flat_map(|render| renders.map(|failed| (render, failed))) {
            for (coarseness, iterations, shown) in [1, 4]
                .into_iter()
                .flat_map(|coarseness| [0, 1, MOST].map(|iterations| (coarseness, iterations)))
                .flat_map(|(coarseness, iterations)| shown.map(|shown| (coarseness, iterations, shown)))
            {
                let render = render.map(|target| Rendered { target, coarseness, iterations, shown });
                for (saves, flags) in saves.iter().flat_map(|saves| (0..32).map(move |flags| (saves, flags))) {
                    let [is_aside, is_read, is_moving, paused, close] = [1, 2, 4, 8, 16].map(|flag| flags & flag != 0);
                    let loads = u64::from(is_read);
                    let standing = Standing { loads, render, failed, is_aside, coarsest: 8, most: MOST, saves };
                    check(&wish(1, Quantity::Image, paused, close), &standing, is_moving);
                }
            }
        }
    }

    #[test]
    fn what_is_saved_is_whole_and_no_file_is_forgotten() {
        each_standing(|wish, standing, is_moving| match next(wish, standing, is_moving) {
            Next::Save(index) => {
                let render = standing.render.unwrap();
                assert!(render.iterations > 0 && render.coarseness == 1, "{standing:?}");
                assert_eq!(*render.target, standing.saves[index].target);
            }
            Next::Rest | Next::End => assert!(standing.saves.is_empty(), "{wish:?} {standing:?}"),
            Next::Refuse => assert_eq!(standing.failed, Some(&wish.target)),
            _ => {}
        });
    }

    #[test]
    fn it_rests_only_where_all_is_done_and_shown() {
        each_standing(|wish, standing, is_moving| {
            let is_failed = standing.failed == Some(&wish.target);
            let next = next(wish, standing, is_moving);
            if next == Next::Rest && !is_failed {
                let render = standing.render.unwrap();
                assert!(render.target == &wish.target && render.coarseness == 1 && render.iterations > 0);
                assert!(wish.paused || render.iterations >= MOST, "{standing:?}");
                assert_eq!(render.shown, Some((render.iterations, wish.quantity)));
            }
            if next == Next::Show {
                let render = standing.render.unwrap();
                assert!(render.iterations > 0, "{standing:?}");
                assert_ne!(render.shown, Some((render.iterations, wish.quantity)), "{standing:?}");
            }
            if next == Next::Iterate {
                let render = standing.render.unwrap();
                assert!(!is_failed && standing.loads == wish.target.loads && render.target == &wish.target);
                let is_done = render.coarseness == 1 && (wish.paused || render.iterations >= MOST);
                assert!(render.iterations == 0 || !is_done, "{standing:?}");
            }
            assert!(!matches!(next, Next::Aim(0)));
        });
    }

    /// From every state, a paused window gets an image of the wished target, and the files are written.
    #[test]
    fn every_way_ends_at_a_whole_image() {
        each_standing(|wish, standing, _| {
            let wish = Wish { paused: true, ..wish.clone() };
            let mut standing = *standing;
            let mut saves = standing.saves.to_vec();
            for _ in 0..40 {
                standing = Standing { saves: &[], ..standing };
                let step = next(&wish, &Standing { saves: &saves, ..standing }, false);
                let none = Rendered { target: &wish.target, coarseness: 1, iterations: 0, shown: None };
                match step {
                    Next::Follow => saves.iter_mut().for_each(|save| save.target = wish.target.clone()),
                    Next::Save(index) => drop(saves.remove(index)),
                    Next::Refuse => saves.clear(),
                    Next::Load => (standing.loads, standing.render, standing.failed) = (1, None, None),
                    Next::Aim(coarseness) => {
                        let iterations = if standing.is_aside { 3 } else { 0 };
                        standing.render = Some(Rendered { coarseness, iterations, ..none });
                        standing.is_aside = false;
                    }
                    Next::Iterate => standing.render.iter_mut().for_each(|render| render.iterations += 1),
                    Next::Show => standing
                        .render
                        .iter_mut()
                        .for_each(|render| render.shown = Some((render.iterations, wish.quantity))),
                    Next::End => return assert!(wish.close && saves.is_empty()),
                    Next::Rest => return assert!(!wish.close && saves.is_empty()),
                }
            }
            panic!("no end from {wish:?}, {standing:?}");
        });
    }

    #[test]
    fn an_image_that_was_kept_is_taken_up_and_others_begin_coarsely() {
        let wish = wish(1, Quantity::Image, false, false);
        let nothing =
            Standing { loads: 1, render: None, failed: None, is_aside: false, coarsest: 8, most: MOST, saves: &[] };
        assert_eq!(next(&wish, &nothing, false), Next::Aim(8));
        assert_eq!(next(&wish, &Standing { is_aside: true, ..nothing }, false), Next::Aim(1));
        let render = Rendered { target: &wish.target, coarseness: 8, iterations: 1, shown: Some((1, Quantity::Image)) };
        let coarse = Standing { render: Some(render), ..nothing };
        assert_eq!(next(&wish, &coarse, false), Next::Aim(4));
        assert_eq!(next(&wish, &coarse, true), Next::Iterate);
        let looks = Wish { quantity: AOV, ..wish.clone() };
        assert_eq!(next(&looks, &coarse, true), Next::Show, "at once, and not after an iteration");
    }
}
