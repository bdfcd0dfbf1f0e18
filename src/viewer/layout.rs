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

/// The place of an image in a window: in the middle of its area, in its own size, or smaller if the area is
/// smaller.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    /// The upper left corner, in pixels of the window.
    pub origin: [f32; 2],
    /// Width and height, in pixels of the window.
    pub size: [f32; 2],
}

impl Placement {
    /// Returns the place of an image of this resolution. Coarse pictures of the image are enlarged to the
    /// same place.
    pub fn new(area: Area, image: [u32; 2]) -> Self {
        let size = fit(image, area.size.map(|side| side.max(1)));
        let origin = [0, 1].map(|axis| area.origin[axis] + area.size[axis].saturating_sub(size[axis]) / 2);
        Self { origin: origin.map(|side| side as f32), size: size.map(|side| side as f32) }
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
            let Placement { origin, size } = Placement::new(Area { origin, size }, image);
            [origin, size].map(|pair| pair.map(|value| value as u32))
        };
        assert_eq!(placement([280, 0], [640, 480], [640, 480]), [[280, 0], [640, 480]]);
        assert_eq!(placement([280, 0], [240, 480], [128, 128]), [[336, 176], [128, 128]]);
        assert_eq!(placement([0, 0], [520, 480], [128, 128]), [[196, 176], [128, 128]]);
        assert_eq!(placement([280, 0], [320, 480], [640, 480]), [[280, 120], [320, 240]]);
        assert_eq!(placement([280, 0], [0, 480], [640, 480]), [[280, 239], [1, 1]], "no room");
    }
}
