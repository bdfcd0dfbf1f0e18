//! The display: maps a picture to the pixels of the window.

use std::sync::Arc;

use goblet_host::{Buffer, Interface, Pass, Result, Screen, Texels};
use winit::window::Window;

use super::layout::Placement;
use super::paint::Shade;
use crate::cli::cache;
use crate::image::film::LUMINANCE;
use crate::kernels::{
    CURVE_ACES, CURVE_AGX, CURVE_LINEAR, CURVE_SRGB, REQUIREMENTS, Specialization, ToneMap, ToneMapPush,
};

const WORKGROUP_SIZE: u32 = 64;

/// A tone curve.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Curve {
    /// No curve.
    Linear,
    /// The sRGB curve, as in PNG outputs.
    #[default]
    Srgb,
    /// A curve like film.
    Aces,
    /// A curve like film, in which bright colours fade to white.
    Agx,
}

impl Curve {
    /// All curves, in the order of the panel's list.
    pub const ALL: [Self; 4] = [Self::Linear, Self::Srgb, Self::Aces, Self::Agx];

    /// Returns the name that the panel shows.
    pub fn name(self) -> &'static str {
        match self {
            Self::Linear => "linear",
            Self::Srgb => "sRGB",
            Self::Aces => "ACES-like",
            Self::Agx => "AgX",
        }
    }

    fn number(self) -> u32 {
        match self {
            Self::Linear => CURVE_LINEAR,
            Self::Srgb => CURVE_SRGB,
            Self::Aces => CURVE_ACES,
            Self::Agx => CURVE_AGX,
        }
    }
}

/// The mapping of light to the screen.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Look {
    /// Exposure in stops.
    pub stops: f32,
    /// Tone curve.
    pub curve: Curve,
}

/// The pixels of a window, and the pass that computes them from a picture.
pub struct Display {
    shown: Texels<[f32; 4]>,
    pixels: Buffer<u32>,
    pass: Pass<ToneMapPush>,
    /// Size of the picture, how it shows values, and the look, place and window size of the last mapping.
    image: [u32; 2],
    shade: Shade,
    mapped: Option<(Look, Placement, [u32; 2])>,
    screen: Screen,
}

impl Display {
    /// Opens the device that `selector` names for a window, or the first device that can show images in it.
    ///
    /// # Errors
    /// No such device can show images in the window.
    pub fn new(window: Arc<Window>, selector: Option<&str>, validation: bool) -> Result<Self> {
        let (size, cache) = (window.inner_size().into(), cache::folder());
        let screen = Screen::new(Arc::clone(&window), size, selector, &REQUIREMENTS, validation, cache.as_deref())?;
        let (shown, pixels, pass) = arrays(&screen, screen.size())?;
        screen.device().write_texels(&shown, &[[0.0; 4]])?;
        Ok(Self { shown, pixels, pass, image: [1, 1], shade: Shade::Light, mapped: None, screen })
    }

    /// Uploads the colours of a picture, which is shown from now on. `pixels` are row by row, the top row first; the
    /// fourth number is unused.
    ///
    /// # Errors
    /// The device fails.
    pub fn take(&mut self, size: [u32; 2], pixels: &[[f32; 4]], shade: Shade) -> Result<()> {
        self.make_room(size)?;
        self.screen.device().write_texels(&self.shown, pixels)?;
        (self.image, self.shade, self.mapped) = (size, shade, None);
        Ok(())
    }

    fn make_room(&mut self, size: [u32; 2]) -> Result<()> {
        let wanted: u64 = size.map(u64::from).iter().product();
        if wanted > self.shown.len() || wanted > self.pixels.len() {
            self.screen.finish()?;
            let kept = self.screen.device().read_texels(&self.shown)?;
            (self.shown, self.pixels, self.pass) = arrays(&self.screen, size)?;
            let fits = kept.len().min(self.shown.len() as usize);
            self.screen.device().write_texels(&self.shown, &kept[..fits])?;
            self.mapped = None;
        }
        Ok(())
    }

    /// Adapts to a new size of the window in pixels.
    ///
    /// # Errors
    /// The device fails.
    pub fn resize(&mut self, size: [u32; 2]) -> Result<()> {
        self.screen.resize(size)?;
        self.make_room(self.screen.size())
    }

    /// Shows the picture at a place, and the interface above it. Returns false if the window has another size
    /// by now.
    ///
    /// # Errors
    /// The device fails.
    pub fn show(&mut self, look: Look, placement: Placement, interface: Interface) -> Result<bool> {
        let window = self.screen.size();
        if self.mapped != Some((look, placement, window)) {
            let Placement { origin, size, .. } = placement;
            let per_pixel = [0, 1].map(|axis| self.image[axis] as f32 / size[axis]);
            let curve = if self.shade == Shade::Light { look.curve } else { Curve::Linear };
            let exposure = if self.shade == Shade::Fixed { 1.0 } else { look.stops.exp2() };
            let push = ToneMapPush {
                luminance: LUMINANCE.map(|weight| weight as f32),
                exposure,
                window,
                image: self.image,
                origin,
                per_pixel,
                curve: curve.number(),
                bgra: self.screen.is_bgra().into(),
                nearest: u32::from(placement.has_squares(self.image)),
                pad0: 0,
            };
            // The previous frame may still be reading the pixels.
            self.screen.finish()?;
            let mut frame = self.screen.device().frame()?;
            frame.dispatch(&self.pass, push, window.map(u64::from).iter().product());
            frame.run()?;
            self.mapped = Some((look, placement, window));
        }
        self.screen.show(&self.pixels, interface)
    }

    /// Returns the messages of the validation layers so far.
    pub fn validation_messages(&self) -> Vec<String> {
        self.screen.device().validation_messages()
    }
}

type Arrays = (Texels<[f32; 4]>, Buffer<u32>, Pass<ToneMapPush>);

/// Allocates arrays for an image of this size and for the window.
fn arrays(screen: &Screen, size: [u32; 2]) -> Result<Arrays> {
    let device = screen.device();
    let [width, height] = [0, 1].map(|axis| u64::from(size[axis].max(screen.size()[axis])));
    let shown = device.texels("shown", width * height)?;
    let pixels = device.buffer("pixels", width * height)?;
    let kernel = ToneMap { shown: &shown, pixels: &pixels };
    let pass = device.pass(&kernel, &Specialization::DECLARED, WORKGROUP_SIZE)?;
    Ok((shown, pixels, pass))
}
