//! Guided emission: the same mean, and less noise where most photons are wasted.

use goblet::image::film::{Image, luminance};
use goblet::{DirectLight, Guidance, Options};

use crate::support;

/// A glass ball in the sun on a square of ground of this half width.
fn sunlit_ball(ground: f64) -> String {
    let g = ground;
    format!(
        "Film \"rgb\" \"integer xresolution\" 48 \"integer yresolution\" 48\nPixelFilter \"box\"\n\
         Integrator \"sppm\" \"integer maxdepth\" 12\nLookAt 0 2 3 0 0 0 0 1 0\n\
         Camera \"perspective\" \"float fov\" 30\nWorldBegin\n\
         LightSource \"distant\" \"point3 from\" [1 3 1] \"point3 to\" [0 0 0] \"rgb L\" [3 3 3]\n\
         Material \"diffuse\" \"rgb reflectance\" [.5 .5 .5]\n\
         Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3]\n\
           \"point3 P\" [-{g} 0 -{g} -{g} 0 {g} {g} 0 {g} {g} 0 -{g}]\n\
         Material \"dielectric\"\nTranslate 0 0.8 0\nShape \"sphere\" \"float radius\" 0.4\n"
    )
}

fn render(text: &str, guidance: Guidance, photons: u64, seed: u32, iterations: u32) -> Image {
    render_with(text, &Options { guidance, photons: Some(photons), seed: Some(seed), ..Options::default() }, iterations)
}

fn render_with(text: &str, options: &Options, iterations: u32) -> Image {
    support::render(text, options, iterations).image
}

fn brightness(image: &Image, pixel: usize) -> f64 {
    f64::from(luminance(image.pixels[pixel]))
}

/// relMSE over some pixels.
fn error(image: &Image, reference: &Image, pixels: &[usize]) -> f64 {
    let squared = |pixel: &usize| {
        let [value, truth] = [image, reference].map(|image| brightness(image, *pixel));
        (value - truth).powi(2) / (truth * truth + 0.01)
    };
    pixels.iter().map(squared).sum::<f64>() / pixels.len() as f64
}

/// On ground that is three hundred times as wide, a photon in a hundred thousand meets the ball. Without a guide, none of
/// these photons is expected to; with it, the caustic has no more noise than on small ground.
#[test]
fn a_caustic_in_the_sun_is_as_good_on_wide_ground() {
    let [small, wide] = [3.0, 1000.0].map(sunlit_ball);
    let reference = render(&small, Guidance::Off, 65_536, 5, 48);
    // Plain ground has a radiance of 3 x 0.5 / pi x 3 / sqrt(11), 0.43.
    let caustic: Vec<usize> = (0..48 * 48).filter(|pixel| brightness(&reference, *pixel) > 0.5).collect();
    assert!(caustic.len() > 10, "{} pixels", caustic.len());
    let error_of = |text: &str, guidance| {
        (1..4).map(|seed| error(&render(text, guidance, 4096, seed, 32), &reference, &caustic)).sum::<f64>() / 3.0
    };
    let [unguided, guided] = [Guidance::Off, Guidance::Auto].map(|guidance| error_of(&small, guidance));
    let [lost, found] = [Guidance::Off, Guidance::Auto].map(|guidance| error_of(&wide, guidance));
    println!("small ground: {unguided:.5}, guided {guided:.5}; wide ground: {lost:.5}, guided {found:.5}");
    assert!(guided < unguided, "{guided} {unguided}");
    assert!(found < unguided, "{found} {unguided}");
    assert!(lost > 0.5, "the test shows nothing: {lost}");
}

/// Rooms with a lamp each; the camera is in the first, with a mirror ball. The last rooms are reached by no photon.
fn lamps(rooms: u32) -> String {
    let mut text = String::from(
        "Film \"rgb\" \"integer xresolution\" 24 \"integer yresolution\" 24\nIntegrator \"sppm\" \"integer maxdepth\" 6\n\
         LookAt 0 1 2.8 0 1 0 0 1 0\nCamera \"perspective\" \"float fov\" 50\nWorldBegin\n\
         Material \"diffuse\" \"rgb reflectance\" [.6 .6 .6]\n",
    );
    for room in 0..rooms {
        let [x, z] = [4.0 * f64::from(room % 8), -8.0 * f64::from(room / 8)];
        let [west, east, north, south] = [x - 1.0, x + 1.0, z - 1.0, z + 3.0];
        for corners in [
            [[west, 0.0, north], [east, 0.0, north], [east, 0.0, south], [west, 0.0, south]],
            [[west, 2.0, north], [east, 2.0, north], [east, 2.0, south], [west, 2.0, south]],
            [[west, 0.0, north], [west, 2.0, north], [west, 2.0, south], [west, 0.0, south]],
            [[east, 0.0, north], [east, 2.0, north], [east, 2.0, south], [east, 0.0, south]],
            [[west, 0.0, north], [east, 0.0, north], [east, 2.0, north], [west, 2.0, north]],
            [[west, 0.0, south], [east, 0.0, south], [east, 2.0, south], [west, 2.0, south]],
        ] {
            let points: Vec<String> = corners.iter().flatten().map(ToString::to_string).collect();
            text += &format!(
                "Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3] \"point3 P\" [{}]\n",
                points.join(" ")
            );
        }
        text += &format!("LightSource \"point\" \"point3 from\" [{} 1.7 {z}] \"rgb I\" [2 2 2]\n", x + 0.2);
    }
    text + "Material \"conductor\"\nTranslate -0.3 0.4 0\nShape \"sphere\" \"float radius\" 0.4\n"
}

/// The mean of one render with a guide is that of one without, to a half per cent. Photons bring all light to discs of one
/// size, so that there is no other noise and no other blur: of those that reach the room there are half a million without
/// a guide, and more with it.
#[test]
fn one_lamp_of_many_is_found_and_the_mean_stays() {
    let text = lamps(16);
    let render = |guidance, photons, seed, iterations| {
        let base = Options { direct: DirectLight::Photons, radius: Some(0.1), alpha: Some(1.0), ..Options::default() };
        let options = Options { guidance, photons: Some(photons), seed: Some(seed), ..base };
        render_with(&text, &options, iterations)
    };
    let mean = |image: &Image| support::mean(image).iter().sum::<f64>();
    let truth = render(Guidance::Off, 524_288, 7, 16);
    let guided = render(Guidance::Auto, 65_536, 8, 32);
    let ratio = mean(&guided) / mean(&truth);
    let pixels: Vec<usize> = (0..24 * 24).collect();
    let error_of = |guidance| error(&render(guidance, 8192, 9, 8), &truth, &pixels);
    let [without, with] = [Guidance::Off, Guidance::Auto].map(error_of);
    println!("mean {ratio:.5}, relMSE {without:.5}, guided {with:.5}");
    assert!((ratio - 1.0).abs() < 0.005, "{ratio}");
    assert!(3.0 * with < without, "{with} {without}");
}
