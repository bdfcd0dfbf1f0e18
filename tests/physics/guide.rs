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

/// Eye paths choose the lamp that is seen, not one of all by power: the walls are so dark that little light is photons'.
#[test]
fn direct_light_is_that_of_the_lamp_that_is_seen() {
    let text = lamps(13).replace("[.6 .6 .6]", "[.02 .02 .02]");
    let render = |guidance, seed, iterations| {
        let options =
            Options { guidance, photons: Some(8192), seed: Some(seed), eye_paths: Some(1), ..Options::default() };
        render_with(&text, &options, iterations)
    };
    let mean = |image: &Image| support::mean(image).iter().sum::<f64>();
    let truth = render(Guidance::Off, 7, 1024);
    let pixels: Vec<usize> = (0..24 * 24).collect();
    let [without, with] = [Guidance::Off, Guidance::Auto].map(|guidance| render(guidance, 8, 24));
    let [without, found] = [&without, &with].map(|image| error(image, &truth, &pixels));
    let ratio = mean(&with) / mean(&truth);
    println!("mean {ratio:.5}, relMSE {without:.5}, guided {found:.5}");
    assert!((ratio - 1.0).abs() < 0.01, "{ratio}");
    assert!(4.0 * found < without, "{found} {without}");
}

/// The sun shines into a chamber by a wide opening and by a pinhole, through a pane that bends nothing, so that only
/// photons light the floor. A photon in 50,000 takes the pinhole: the pilot, of whose photons a quarter begin without a
/// guide, expects half of one. The light of the pinhole is still of the right mean: of 8 million photons, 36 are expected
/// to bring it, a sixth of which is their standard deviation.
#[test]
fn what_a_pilot_has_not_seen_comes_with_the_right_mean() {
    let side = 0.009;
    let rectangle = |[x0, x1, y0, y1]: [f64; 4], z: f64| {
        format!(
            "Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3] \
             \"point3 P\" [{x0} {y0} {z} {x1} {y0} {z} {x1} {y1} {z} {x0} {y1} {z}]\n"
        )
    };
    let [low, high] = [0.5 - 0.5 * side, 0.5 + 0.5 * side];
    let lid: String = [
        [-1.0, 1.0, -1.0, -0.4],
        [-1.0, 1.0, 0.4, 1.0],
        [-1.0, -0.9, -0.4, 0.4],
        [-0.1, low, -0.4, 0.4],
        [high, 1.0, -0.4, 0.4],
        [low, high, -0.4, -0.5 * side],
        [low, high, 0.5 * side, 0.4],
    ]
    .map(|corners| rectangle(corners, 1.0))
    .concat();
    let text = format!(
        "Film \"rgb\" \"integer xresolution\" 32 \"integer yresolution\" 32\nPixelFilter \"box\"\n\
         LookAt 0 0 .9  0 0 0  0 1 0\nCamera \"orthographic\"\nWorldBegin\n\
         LightSource \"distant\" \"point3 from\" [0 0 1] \"point3 to\" [0 0 0] \"rgb L\" [1 1 1]\n\
         Material \"diffuse\" \"rgb reflectance\" [.5 .5 .5]\n{}\
         Material \"diffuse\" \"rgb reflectance\" [0 0 0]\n{lid}\
         Material \"dielectric\" \"float eta\" 1\n{}{}",
        rectangle([-1.0, 1.0, -1.0, 1.0], 0.0),
        rectangle([-1.0, 1.0, -1.0, 1.0], 0.97),
        rectangle([-1.0, 1.0, -1.0, 1.0], 0.95),
    );
    let options = Options {
        guidance: Guidance::On,
        photons: Some(1 << 20),
        radius: Some(0.1),
        alpha: Some(1.0),
        max_depth: Some(3),
        eye_paths: Some(1),
        ..Options::default()
    };
    let image = render_with(&text, &options, 8);
    let flux = |is_in: &dyn Fn(usize) -> bool| {
        let radiances = (0..32 * 32).filter(|pixel| is_in(pixel % 32)).map(|pixel| brightness(&image, pixel));
        radiances.sum::<f64>() * (2.0_f64 / 32.0).powi(2) * std::f64::consts::PI / 0.5
    };
    // The image of a camera that looks down may be mirrored: the pinhole is on the side with less light.
    let [left, right] = [flux(&|x| x < 16), flux(&|x| x > 16)];
    let [opening, pinhole] = [left.max(right) / 0.64, left.min(right) / (side * side)];
    println!("of the light of the opening {opening:.4}, of the pinhole {pinhole:.3}");
    assert!((opening - 1.0).abs() < 0.01, "{opening}");
    assert!((pinhole - 1.0).abs() < 0.5, "{pinhole}");
}

/// Ten thousand small lamps hang 3 above a floor, in a grid of distance 2; a hundred of them matter to the square that is
/// seen. The radiance there is a sum in f64: a sphere brings the irradiance pi L (r / d)² times the cosine. A glass ball
/// in a corner is what photons are for.
#[test]
fn of_ten_thousand_lamps_the_near_ones_are_chosen() {
    const LAMPS: i32 = 100;
    const HEIGHT: f64 = 3.0;
    const RADIUS: f64 = 0.02;
    let at = |index: i32| f64::from(2 * index - LAMPS + 1);
    let mut text = String::from(
        "Film \"rgb\" \"integer xresolution\" 24 \"integer yresolution\" 24\nPixelFilter \"box\"\n\
         Integrator \"sppm\" \"integer maxdepth\" 6\nLookAt 0 1 0 0 0 0 0 0 1\n\
         Camera \"orthographic\" \"float screenwindow\" [-1.5 1.5 -1.5 1.5]\nWorldBegin\n\
         Material \"diffuse\" \"rgb reflectance\" [.5 .5 .5]\n\
         Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3]\n\
           \"point3 P\" [-100 0 -100 -100 0 100 100 0 100 100 0 -100]\n\
         AttributeBegin\nMaterial \"dielectric\"\nTranslate 1.3 .2 1.3\nShape \"sphere\" \"float radius\" .15\nAttributeEnd\n\
         AreaLightSource \"diffuse\" \"rgb L\" [200 200 200]\n",
    );
    let places = || (0..LAMPS * LAMPS).map(|lamp| [at(lamp % LAMPS), at(lamp / LAMPS)]);
    for [x, z] in places() {
        text += &format!(
            "AttributeBegin\nTranslate {x} {HEIGHT} {z}\nShape \"sphere\" \"float radius\" {RADIUS}\nAttributeEnd\n"
        );
    }
    // The grid is the same from both sides, so that it does not matter which way the image is turned.
    let place = |pixel: usize| (pixel as f64 + 0.5) / 8.0 - 1.5;
    let truth = |x: f64, z: f64| -> f64 {
        let irradiance = |[lamp_x, lamp_z]: [f64; 2]| {
            let d2 = (lamp_x - x).powi(2) + (lamp_z - z).powi(2) + HEIGHT * HEIGHT;
            std::f64::consts::PI * 200.0 * RADIUS * RADIUS / d2 * (HEIGHT / d2.sqrt())
        };
        places().map(irradiance).sum::<f64>() * 0.5 / std::f64::consts::PI
    };
    let pixels: Vec<usize> =
        (0..24 * 24).filter(|pixel| [pixel % 24, pixel / 24].iter().all(|side| place(*side).abs() < 1.0)).collect();
    let errors = |guidance, seed| {
        let image = render(&text, guidance, 4096, seed, 16);
        let share = |pixel: &usize| brightness(&image, *pixel) / truth(place(pixel % 24), place(pixel / 24));
        let shares: Vec<f64> = pixels.iter().map(share).collect();
        let count = shares.len() as f64;
        [shares.iter().sum::<f64>() / count, shares.iter().map(|share| (share - 1.0).powi(2)).sum::<f64>() / count]
    };
    let [_, without] = errors(Guidance::Off, 1);
    // With each of these seeds the pilot takes other rounds.
    for seed in [1, 2] {
        let [mean, with] = errors(Guidance::Auto, seed);
        println!("mean {mean:.4}, squared error {with:.4}, without a guide {without:.4}");
        assert!((mean - 1.0).abs() < 4.0 * (with / pixels.len() as f64).sqrt(), "{mean}");
        assert!(2.0 * with < without, "{with} {without}");
    }
}
