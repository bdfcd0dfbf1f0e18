//! Files of measured materials: what is read of them, and what is refused and how.

use std::sync::Arc;

use goblet::RevolutionSolver;
use goblet::base::input::Budget;
use goblet::gpu_scene::pack::pack;
use goblet::scene::{Material, Measured, Scene, SceneError};

use crate::support::measured::{Analytic, Field, MeasuredFile, Steps, Tables, tensor};
use crate::support::random::Rng;
use crate::support::work;

const SMALL: Steps = Steps { size: [5, 4], azimuths: 1, turn: 0.0, polar_angles: 3 };
const TINT: [[f32; 2]; 4] = [[400.0, 0.2], [500.0, 0.5], [600.0, 0.9], [700.0, 0.7]];

fn fields() -> Vec<Field> {
    Tables::new(&Analytic::lambertian(0.5), &SMALL).fields(&TINT)
}

fn scene_of(file: &MeasuredFile) -> String {
    format!("WorldBegin LightSource \"infinite\" {} Shape \"disk\"", file.material())
}

fn parse(bytes: &[u8]) -> Result<Arc<Measured>, SceneError> {
    let scene = Scene::parse(&scene_of(&MeasuredFile::new(bytes)), "t", "")?;
    let Material::Measured(measured) = &scene.materials[0] else { panic!("{:?}", scene.materials) };
    Ok(Arc::clone(measured))
}

#[test]
fn tables_are_read() {
    let fields = fields();
    let measured = parse(&tensor(&fields)).expect("a material");
    assert_eq!((measured.azimuths.len(), measured.polar_angles.len(), measured.reduction), (1, 3, 1));
    assert!(measured.is_isotropic() && measured.slices() == 3);
    assert_eq!((measured.normals.width, measured.normals.height), (5, 4));
    let floats = |name: &str| -> Vec<f32> {
        let field = fields.iter().find(|field| field.name == name).expect("a field");
        field.data.chunks(4).map(|word| f32::from_le_bytes(word.try_into().expect("a word"))).collect()
    };
    for (name, grid) in [
        ("ndf", &measured.normals),
        ("sigma", &measured.projected_area),
        ("vndf", &measured.visible_normals),
        ("luminance", &measured.luminance),
    ] {
        assert_eq!(grid.values, floats(name), "{name}");
    }
    // Colours are those of reflectances with the same spectra.
    let spectrum: String = TINT.map(|[nm, value]| format!("{nm} {} ", value * 0.9)).concat();
    let same = [[360.0, TINT[0][1] * 0.9], [800.0, TINT[3][1] * 0.9]];
    let text = format!(
        "WorldBegin LightSource \"infinite\" Material \"diffuse\" \"spectrum reflectance\" [{} {} {spectrum} {} {}] \
         Shape \"disk\"",
        same[0][0], same[0][1], same[1][0], same[1][1]
    );
    let diffuse = Scene::parse(&text, "t", "").expect("a scene");
    let Material::Diffuse { reflectance: goblet::scene::Input::Constant(expected) } = diffuse.materials[0] else {
        panic!("{:?}", diffuse.materials)
    };
    for (color, luminance) in measured.colors.values.iter().zip(&measured.luminance.values) {
        for channel in 0..3 {
            let expected = expected[channel] / 0.9 * f64::from(*luminance);
            assert!((f64::from(color[channel]) - expected).abs() < 1e-4 * (1.0 + expected), "{color:?} {expected}");
        }
    }
}

#[test]
fn a_file_is_read_once() {
    let file = MeasuredFile::new(&tensor(&fields()));
    let text = format!("{} {} Shape \"disk\"", scene_of(&file), file.material());
    let scene = Scene::parse(&text, "t", "").expect("a scene");
    let [Material::Measured(first), Material::Measured(second)] = &scene.materials[..] else {
        panic!("{:?}", scene.materials)
    };
    assert!(Arc::ptr_eq(first, second));
    let packed = pack(&scene, RevolutionSolver::default()).expect("a packed scene");
    assert_eq!(packed.arrays.materials[0].first, packed.arrays.materials[1].first);
    assert!(packed.material_features.has_measured && packed.material_features.has_rough);
    // What is given up as soon as the scene's memory is.
    let path = file.path().with_file_name("scene.pbrt");
    std::fs::write(&path, &text).expect("a file");
    let error = Scene::load_within(&path, Budget::new(5000)).expect_err("too little memory").to_string();
    assert!(error.contains("expected at most"), "{error}");
}

#[test]
fn a_missing_file_is_said_at_its_parameter() {
    let error = Scene::parse("WorldBegin Material \"measured\" \"string filename\" \"none.bsdf\"", "t", "");
    let error = error.expect_err("an error").to_string();
    assert!(error.starts_with("t:1:32: cannot read none.bsdf: "), "{error}");
}

/// Something done to the fields of a file, or to its bytes.
type Change = fn(&mut Vec<Field>);

fn field<'a>(fields: &'a mut [Field], name: &str) -> &'a mut Field {
    fields.iter_mut().find(|field| field.name == name).expect("a field")
}

fn set(fields: &mut [Field], name: &str, values: &[f64]) {
    let bytes: Vec<u8> = values.iter().flat_map(|value| (*value as f32).to_le_bytes()).collect();
    field(fields, name).data[..bytes.len()].copy_from_slice(&bytes);
}

#[test]
fn faulty_fields_are_refused_by_name() {
    let changes: [(Change, &str); 18] = [
        (|f| f.retain(|field| field.name != "vndf"), "no field \"vndf\"; expected 32-bit floats of 4 dimensions"),
        (|f| f.retain(|field| field.name != "spectra"), "end in _spec.bsdf"),
        (|f| f.retain(|field| field.name != "jacobian"), "no field \"jacobian\"; expected 8-bit integers"),
        (|f| field(f, "jacobian").data = vec![0], "field \"jacobian\" has the value [0.0]; expected 1"),
        (|f| field(f, "ndf").code = 6, "expected 32-bit floats of 2 dimensions (type 10)"),
        (|f| field(f, "ndf").code = 99, "has numbers of type 99; expected a type from 1 to 11"),
        (|f| field(f, "ndf").shape = vec![20], "has 1 dimensions"),
        (|f| field(f, "ndf").shape = vec![20, 1], "a grid of 20 x 1 values; expected 2 or more"),
        (|f| field(f, "ndf").shape = vec![u64::MAX, 3], "expected data that is in the file"),
        (|f| field(f, "spectra").shape = vec![1; 200], "has 200 dimensions; expected at most 16"),
        (|f| field(f, "vndf").shape = vec![3, 1, 4, 5], "expected [1, 3, 4, 5], by the other fields"),
        (|f| field(f, "luminance").shape = vec![1, 3, 5, 4], "field \"spectra\" has the dimensions"),
        (|f| set(f, "theta_i", &[0.5, 0.2]), "expected numbers from 0 to pi / 2, ascending"),
        (|f| set(f, "wavelengths", &[700.0, 600.0]), "expected wavelengths in nm, ascending"),
        (|f| set(f, "sigma", &[0.0]), "field \"sigma\" has the value 0; expected numbers above 0"),
        (|f| set(f, "vndf", &[f64::NAN]), "field \"vndf\" has the value NaN; expected finite numbers"),
        (|f| set(f, "luminance", &[-1.0]), "field \"luminance\" has the value -1; expected 0 or more"),
        (|f| set(f, "luminance", &[0.0; 20]), "has a grid of zeros; expected a value above 0 in each grid"),
    ];
    for (change, expected) in changes {
        let mut fields = fields();
        change(&mut fields);
        let error = parse(&tensor(&fields)).expect_err("an error").to_string();
        assert!(error.contains(expected) && error.contains("measured.bsdf: it"), "{expected}: {error}");
    }
    // Anisotropic tables cover a full turn, a half or a quarter.
    let steps = Steps { azimuths: 4, turn: 0.3, ..SMALL };
    let error = parse(&tensor(&Tables::new(&Analytic::lambertian(0.5), &steps).fields(&TINT))).expect_err("an error");
    assert!(error.to_string().contains("expected a full turn, a half or a quarter"), "{error}");
    let steps = Steps { azimuths: 4, turn: 0.25, ..SMALL };
    let quarter = parse(&tensor(&Tables::new(&Analytic::lambertian(0.5), &steps).fields(&TINT))).expect("a material");
    assert!(!quarter.is_isotropic() && quarter.reduction == 4);
}

#[test]
fn files_that_are_none_are_refused() {
    let bytes = tensor(&fields());
    let with = |at: usize, byte: u8| {
        let mut bytes = bytes.clone();
        bytes[at] = byte;
        bytes
    };
    for (bytes, expected) in [
        (Vec::new(), "no tensor file; expected \"tensor_file\" at its start"),
        (with(3, b'x'), "no tensor file"),
        (with(12, 2), "its version of the tensor format is 2.0; expected 1.0"),
        (with(17, 255), "fields; expected at most 256"),
        (bytes[..13].to_vec(), "it ends within the version"),
        (bytes[..40].to_vec(), "it ends within the list of fields"),
        (bytes[..bytes.len() - 1].to_vec(), "expected data that is in the file"),
    ] {
        let error = parse(&bytes).expect_err("an error").to_string();
        assert!(error.contains(expected), "{expected}: {error}");
    }
}

/// Files with bytes changed at random are read and packed, or refused.
#[test]
fn no_file_makes_a_panic() {
    let bytes = tensor(&fields());
    let file = MeasuredFile::new(&bytes);
    let text = scene_of(&file);
    let header = bytes.len() - fields().iter().map(|field| field.data.len()).sum::<usize>();
    let (mut rng, mut read) = (Rng(9), 0);
    let cases = work(3000, 100_000);
    for _ in 0..cases {
        let mut changed = bytes.clone();
        for _ in 0..1 + rng.below(3) {
            // The header is where most depends on a byte.
            let end = if rng.chance(0.7) { header } else { bytes.len() };
            changed[rng.below(end)] = [0, 1, 127, 128, 255, rng.below(256) as u8][rng.below(6)];
        }
        if rng.chance(0.05) {
            changed.truncate(rng.below(bytes.len()));
        }
        std::fs::write(file.path(), &changed).expect("a file");
        if let Ok(scene) = Scene::parse(&text, "t", "") {
            pack(&scene, RevolutionSolver::default()).expect("a packed scene");
            read += 1;
        }
    }
    println!("{cases} files, of which {read} could be read");
    assert!(read * 20 > cases && read < cases, "{read} of {cases}");
}
