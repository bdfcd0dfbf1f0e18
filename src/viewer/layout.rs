//! The layout of the window: the panel on the left, and the image in the rest.

/// Width of the panel in points.
pub const PANEL: f32 = 280.0;
/// The smallest area for the image in a window, in pixels.
const LEAST: [u32; 2] = [240, 480];

/// A rectangle in the window, in pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Area {
    /// The upper left corner.
    pub origin: [u32; 2],
    /// Width and height.
    pub size: [u32; 2],
}

impl Area {
    /// Returns its middle, in pixels of the window.
    pub fn middle(self) -> [f32; 2] {
        [0, 1].map(|axis| self.origin[axis] as f32 + 0.5 * self.size[axis] as f32)
    }

    /// Returns the area of the image in a window of this size in pixels, with or without the panel.
    pub fn of_image([width, height]: [u32; 2], has_panel: bool, pixels_per_point: f32) -> Self {
        let panel = if has_panel { panel_pixels(pixels_per_point).min(width) } else { 0 };
        Self { origin: [panel, 0], size: [width - panel, height] }
    }
}

/// The sizes with which a window opens.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Opening {
    /// Width and height of the window in pixels.
    pub window: [u32; 2],
    /// Width and height of the image in pixels.
    pub image: [u32; 2],
}

impl Opening {
    /// Returns the sizes for an image of this size beside a panel of this width. `screen` is the size of the
    /// screen, if it is known. The window has at least a usable size. The image keeps its size if it fits on
    /// the screen, with or without the panel; else it shrinks to the area beside the panel.
    pub fn new(image: [u32; 2], panel: u32, screen: Option<[u32; 2]>) -> Self {
        let screen = screen.unwrap_or([u32::MAX; 2]);
        let beside = [screen[0].saturating_sub(panel).max(1), screen[1].max(1)];
        let has_room = image[0] <= screen[0] && image[1] <= screen[1];
        let image = if has_room { image } else { fit(image, beside) };
        let wanted = [panel.saturating_add(image[0].max(LEAST[0])), image[1].max(LEAST[1])];
        Self { window: [wanted[0].min(screen[0]), wanted[1].min(screen[1])], image }
    }

    /// Returns the smallest size of a window with a panel of this width.
    pub fn least(panel: u32) -> [u32; 2] {
        [panel + LEAST[0], LEAST[1]]
    }
}

/// Returns the width of the panel in pixels.
pub fn panel_pixels(pixels_per_point: f32) -> u32 {
    (PANEL * pixels_per_point).round() as u32
}

/// Returns the size scaled down to fit into `most`, with the same aspect ratio.
fn fit([width, height]: [u32; 2], most: [u32; 2]) -> [u32; 2] {
    let scale = (f64::from(most[0]) / f64::from(width)).min(f64::from(most[1]) / f64::from(height)).min(1.0);
    [width, height].map(|side| ((f64::from(side) * scale) as u32).max(1))
}

/// How large the image is in the window, and which part of it is in the middle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Zoom {
    /// The whole image, in its own size, or smaller if the area is smaller.
    #[default]
    Fit,
    /// Of a size of its own.
    Own {
        /// Pixels of the window for each pixel of the image along an axis.
        scale: f32,
        /// The place on the image, whose corners are (0, 0) and (1, 1), in the middle of the area.
        middle: [f32; 2],
    },
}

/// The range of [`Zoom::Own::scale`].
const SCALES: [f32; 2] = [1.0 / 16.0, 64.0];

impl Zoom {
    /// Returns a zoom that is larger by a factor, where the image keeps its place under a pixel of the window.
    pub fn by(self, factor: f32, at: [f32; 2], area: Area, image: [u32; 2]) -> Self {
        let before = Placement::new(area, image, self);
        let scale = (factor * before.scale(image)).clamp(SCALES[0], SCALES[1]);
        let place = [0, 1].map(|axis| (at[axis] - before.origin[axis]) / before.size[axis]);
        let middle = [0, 1].map(|axis| {
            let size = scale * image[axis] as f32;
            place[axis] + (area.middle()[axis] - at[axis]) / size
        });
        Self::Own { scale, middle: middle.map(|place| place.clamp(0.0, 1.0)) }
    }

    /// Returns the next scale for keys: a power of two above or below.
    pub fn step(self, is_in: bool, at: [f32; 2], area: Area, image: [u32; 2]) -> Self {
        let scale = Placement::new(area, image, self).scale(image);
        let octave = scale.log2();
        // A scale that is nearly a power of two is one.
        let next = if is_in { (octave + 0.01).floor() + 1.0 } else { (octave - 0.01).ceil() - 1.0 };
        self.by(next.exp2() / scale, at, area, image)
    }

    /// Returns the zoom after the image has been dragged by some pixels of the window.
    pub fn dragged(self, by: [f32; 2], area: Area, image: [u32; 2]) -> Self {
        let before = Placement::new(area, image, self);
        let place = [0, 1].map(|axis| (area.middle()[axis] - before.origin[axis] - by[axis]) / before.size[axis]);
        Self::Own { scale: before.scale(image), middle: place.map(|place| place.clamp(0.0, 1.0)) }
    }
}

/// The place of an image in a window.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    /// The upper left corner, in pixels of the window.
    pub origin: [f32; 2],
    /// Width and height, in pixels of the window.
    pub size: [f32; 2],
    /// Whether the user has chosen the size.
    is_own: bool,
}

impl Placement {
    /// Returns the place of an image of this resolution. Coarse pictures of the image are enlarged to the
    /// same place.
    pub fn new(area: Area, image: [u32; 2], zoom: Zoom) -> Self {
        match zoom {
            Zoom::Fit => {
                let size = fit(image, area.size.map(|side| side.max(1)));
                let origin = [0, 1].map(|axis| area.origin[axis] + area.size[axis].saturating_sub(size[axis]) / 2);
                let [origin, size] = [origin, size].map(|pair| pair.map(|side| side as f32));
                Self { origin, size, is_own: false }
            }
            Zoom::Own { scale, middle } => {
                let size = image.map(|side| scale * side as f32);
                let origin = [0, 1].map(|axis| (area.middle()[axis] - middle[axis] * size[axis]).round());
                Self { origin, size, is_own: true }
            }
        }
    }

    /// Returns the number of pixels of the window for each pixel of the image along an axis.
    pub fn scale(&self, image: [u32; 2]) -> f32 {
        self.size[0] / image[0] as f32
    }

    /// Returns whether the pixels of a picture of this size are shown as squares: at the size of a pixel or more, if the
    /// user has chosen the size. Coarse pictures during a movement are too.
    pub fn has_squares(&self, picture: [u32; 2]) -> bool {
        self.is_own && self.scale(picture) >= 1.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SCREEN: Option<[u32; 2]> = Some([1920, 1080]);

    #[test]
    fn windows_open_with_the_image_beside_the_panel() {
        let opening = |image, screen| Opening::new(image, 280, screen);
        let of = |window, image| Opening { window, image };
        assert_eq!(opening([640, 480], SCREEN), of([920, 480], [640, 480]));
        assert_eq!(opening([128, 128], SCREEN), of([520, 480], [128, 128]), "a size that can be used");
        assert_eq!(opening([1, 4000], SCREEN), of([520, 1080], [1, 1080]));
        assert_eq!(opening([1800, 900], SCREEN), of([1920, 900], [1800, 900]), "it has room without the panel");
        assert_eq!(opening([4000, 1000], SCREEN), of([1920, 480], [1640, 410]));
        assert_eq!(opening([4000, 1000], None), of([4280, 1000], [4000, 1000]));
        assert_eq!(opening([4000, 1000], Some([200, 100])), of([200, 100], [1, 1]), "no panic");
    }

    #[test]
    fn without_the_panel_the_image_has_the_whole_window() {
        let area = |origin, size| Area { origin, size };
        assert_eq!(Area::of_image([520, 480], true, 1.0), area([280, 0], [240, 480]));
        assert_eq!(Area::of_image([520, 480], false, 1.0), area([0, 0], [520, 480]));
        assert_eq!(Area::of_image([1040, 960], true, 1.5), area([420, 0], [620, 960]));
        assert_eq!(Area::of_image([100, 480], true, 1.0), area([100, 0], [0, 480]), "no room");
    }

    #[test]
    fn images_are_in_the_middle_and_no_larger_than_they_are() {
        let placement = |origin, size, image| {
            let Placement { origin, size, .. } = Placement::new(Area { origin, size }, image, Zoom::Fit);
            [origin, size].map(|pair| pair.map(|value| value as u32))
        };
        assert_eq!(placement([280, 0], [640, 480], [640, 480]), [[280, 0], [640, 480]]);
        assert_eq!(placement([280, 0], [240, 480], [128, 128]), [[336, 176], [128, 128]]);
        assert_eq!(placement([0, 0], [520, 480], [128, 128]), [[196, 176], [128, 128]]);
        assert_eq!(placement([280, 0], [320, 480], [640, 480]), [[280, 120], [320, 240]]);
        assert_eq!(placement([280, 0], [0, 480], [640, 480]), [[280, 239], [1, 1]], "no room");
    }

    const AREA: Area = Area { origin: [280, 0], size: [640, 480] };
    const IMAGE: [u32; 2] = [640, 480];

    fn at(zoom: Zoom, window: [f32; 2]) -> [f32; 2] {
        let Placement { origin, size, .. } = Placement::new(AREA, IMAGE, zoom);
        [0, 1].map(|axis| (window[axis] - origin[axis]) / size[axis] * IMAGE[axis] as f32)
    }

    #[test]
    fn a_zoom_keeps_what_is_under_the_cursor() {
        let cursor = [500.0, 100.0];
        let mut zoom = Zoom::Fit;
        let place = at(zoom, cursor);
        for _ in 0..8 {
            zoom = zoom.by(1.3, cursor, AREA, IMAGE);
            // Pictures begin at whole pixels of the window.
            let moved = [0, 1].map(|axis| (at(zoom, cursor)[axis] - place[axis]).abs());
            assert!(moved.iter().all(|side| *side <= 0.6), "{zoom:?}: {moved:?}");
        }
    }

    #[test]
    fn keys_go_to_powers_of_two_within_the_range() {
        let scale = |zoom| Placement::new(AREA, IMAGE, zoom).scale(IMAGE);
        let mut zoom = Zoom::Fit.by(1.3, AREA.middle(), AREA, IMAGE);
        for expected in [2.0, 4.0, 8.0, 16.0, 32.0, 64.0, 64.0] {
            zoom = zoom.step(true, AREA.middle(), AREA, IMAGE);
            assert!((scale(zoom) - expected).abs() < 1e-3, "{zoom:?}");
            assert!(Placement::new(AREA, IMAGE, zoom).has_squares(IMAGE));
        }
        for _ in 0..20 {
            zoom = zoom.step(false, AREA.middle(), AREA, IMAGE);
        }
        assert_eq!(scale(zoom), SCALES[0]);
        let placement = Placement::new(AREA, IMAGE, zoom);
        assert!(!placement.has_squares(IMAGE), "it is smaller than it is");
        assert!(!Placement::new(AREA, IMAGE, Zoom::Fit).has_squares(IMAGE), "the same in either way");
    }

    #[test]
    fn a_dragged_image_follows_the_hand_and_stays_in_the_window() {
        let zoom = Zoom::Fit.by(8.0, AREA.middle(), AREA, IMAGE);
        let place = at(zoom, [400.0, 300.0]);
        let dragged = zoom.dragged([16.0, -24.0], AREA, IMAGE);
        let found = at(dragged, [416.0, 276.0]);
        assert!([0, 1].iter().all(|axis| (found[*axis] - place[*axis]).abs() < 0.1), "{found:?} {place:?}");
        let far = zoom.dragged([1e6, 1e6], AREA, IMAGE);
        assert_eq!(far, Zoom::Own { scale: 8.0, middle: [0.0; 2] });
    }
}
