//! Tests of the file format with files that no render has written.

use glam::{DAffine3, DVec3};
use proptest::collection::vec;
use proptest::prelude::*;
use serde_json::{Value, json};

use super::*;
use crate::image::film::CoordinateSystem;
use crate::image::layers::{Group, Groups};
use crate::render::counters::ByPass;

/// Generates checkpoints of small images.
fn small() -> impl Strategy<Value = Checkpoint> {
    let pixels = (1..6_u32, 1..4_u32).prop_flat_map(|(width, height)| {
        let length = (width * height) as usize;
        let sums = vec(any::<[u32; 4]>(), length);
        let states = vec(any::<[u32; 4]>(), if width == 5 { 0 } else { length });
        (Just([width, height]), [sums.clone(), sums.clone(), sums.clone()], sums, states)
    });
    let done = proptest::collection::btree_map(0..7_u32, any::<u32>(), 0..5);
    let radius = proptest::option::of([0.0..1e9_f32, 1e-30..1e9_f32, 1e-30..1e9_f32]);
    let counts = vec(any::<u64>(), 21);
    (pixels, done, radius, counts, -900..900_i32, "\\PC{0,20}").prop_map(
        |((resolution, radiance, second_half, states), done, radius, counts, exponent, scene)| {
            // Of any values, and of as many groups as there are columns.
            let groups = Groups::of(&Group::ALL[..resolution[0] as usize - 1]);
            let sums: Vec<_> = groups.iter().map(|_| [(); 4].map(|()| second_half.clone())).collect();
            let form = LayerForm {
                groups,
                of_film: resolution[1] == 2,
                system: if resolution[1] == 1 { CoordinateSystem::World } else { CoordinateSystem::Camera },
                camera_from_render: DAffine3::from_translation(DVec3::splat(f64::from(exponent) / 7.0)),
                photons: counts[0],
                ..LayerForm::default()
            };
            let layers = if groups.is_empty() { Layers::default() } else { Layers { form, sums } };
            let iterations: u64 = done.values().map(|done| u64::from(*done)).sum();
            let identity =
                json!({ "alpha": "0.5", "the camera": "sha256:00", "resolution": format!("{resolution:?}") });
            Checkpoint {
                identity: serde_json::from_value(identity).unwrap(),
                made_by: MadeBy { version: "0".into(), device: scene.clone(), driver: "b".into() },
                scene,
                shards: 7,
                done,
                first_radius: radius.map(|[per_length, a, b]| FirstRadius {
                    per_length,
                    least: a.min(b),
                    most: a.max(b),
                }),
                frame: radius.map(|[a, b, c]| Frame {
                    world_to_camera: [[a, b, c, 1.0]; 4],
                    world_to_ndc: (resolution[0] > 1).then_some([[c; 4]; 4]),
                    length: a.into(),
                }),
                tally: tally(&counts),
                estimate: Estimate {
                    resolution,
                    window: if iterations.is_multiple_of(2) {
                        Window::whole(resolution)
                    } else {
                        Window { first: [3, 0], full: [resolution[0] + 3, resolution[1] + 9] }
                    },
                    unit: f64::from(exponent).exp2(),
                    white_balance: iterations
                        .is_multiple_of(3)
                        .then(|| DMat3::from_cols_array(&std::array::from_fn(|i| (i as f64 - 2.0) / 7.0))),
                    halves: [iterations / 3, iterations - iterations / 3],
                    radiance,
                    second_half,
                    layers,
                },
                states: states.into_iter().map(state).collect(),
            }
        },
    )
}

fn tally(counts: &[u64]) -> Tally {
    let [a, b, c, d, e, f, g, h, i, ..] = *counts else { panic!("{counts:?}") };
    let by_pass = |first: usize| ByPass {
        eye: counts[first],
        photon: counts[first + 1],
        gathering: counts[first + 2],
        update: counts[first + 3],
    };
    Tally {
        emitted: a,
        recorded: b,
        deposited: c,
        absorbed: d,
        escaped: e,
        truncated: f,
        cut: by_pass(17),
        lost_in_glass: g,
        eye_lost_in_glass: h,
        immersed: i,
        non_finite: by_pass(9),
        saturated: by_pass(13),
    }
}

/// Returns a state of a pixel with values in range.
fn state([found_low, found_high, shrink, rest]: [u32; 4]) -> PixelState {
    let [shrink, rest] = [shrink, rest].map(|bits| bits as f32 / u32::MAX as f32);
    PixelState { found_low, found_high, shrink, rest: -rest }
}

fn encoded(checkpoint: &Checkpoint) -> Vec<u8> {
    let mut file = Vec::new();
    checkpoint.encode(&mut file).unwrap();
    file
}

fn gzip(header: &[u8], data: &[u8]) -> Vec<u8> {
    let mut out = GzEncoder::new(Vec::new(), Compression::fast());
    out.write_all(&[header, b"\n", data].concat()).unwrap();
    out.finish().unwrap()
}

fn decode(file: &[u8]) -> Result<Checkpoint, CheckpointError> {
    Checkpoint::decode(file, &Budget::default())
}

/// Returns a valid header, of which a test changes a part.
fn header() -> Value {
    json!({
        "goblet_checkpoint": FORMAT, "identity": { "seed": "0" }, "scene": "x.pbrt",
        "made_by": { "version": "0", "device": "a", "driver": "b" },
        "shards": 2, "done": { "0": 3, "1": 2 }, "first_radius": [0.0, 0.1, 0.1],
        "tally": serde_json::to_value(Tally::default()).unwrap(),
        "resolution": [2, 1], "unit": 0.5, "halves": [3, 2], "has_states": false,
    })
}

fn decode_header(header: &Value) -> Result<Checkpoint, CheckpointError> {
    decode(&gzip(header.to_string().as_bytes(), &[0; 2 * 4 * 16]))
}

/// Generates any JSON of small depth.
fn any_json() -> impl Strategy<Value = Value> {
    let leaf = prop_oneof![
        Just(Value::Null),
        any::<bool>().prop_map(Value::from),
        any::<u64>().prop_map(Value::from),
        any::<i64>().prop_map(Value::from),
        any::<f64>().prop_map(Value::from),
        ".{0,8}".prop_map(Value::from),
    ];
    leaf.prop_recursive(3, 16, 4, |inner| {
        prop_oneof![
            vec(inner.clone(), 0..4).prop_map(Value::from),
            proptest::collection::btree_map("[0-9]{1,10}|[a-z_]{1,9}", inner, 0..4)
                .prop_map(|map| Value::Object(map.into_iter().collect())),
        ]
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn what_is_written_is_read(checkpoint in small()) {
        prop_assert_eq!(&decode(&encoded(&checkpoint)).unwrap(), &checkpoint);
    }

    #[test]
    fn arbitrary_bytes_are_refused(bytes in vec(any::<u8>(), 0..300)) {
        prop_assert!(decode(&bytes).is_err());
        prop_assert!(decode(&gzip(&bytes, &[])).is_err());
    }

    /// A part of the file is replaced by other bytes, by fewer bytes or by more bytes.
    #[test]
    fn a_changed_file_is_refused_or_the_same(
        checkpoint in small(),
        place in any::<prop::sample::Index>(),
        removed in 0..40_usize,
        bytes in vec(any::<u8>(), 0..40),
    ) {
        let mut file = encoded(&checkpoint);
        let place = place.index(file.len());
        let end = (place + removed).min(file.len());
        file.splice(place..end, bytes);
        match decode(&file) {
            Ok(read) => prop_assert_eq!(read, checkpoint),
            Err(error) => prop_assert!(matches!(error, CheckpointError::Format(_)), "{}", error),
        }
    }

    /// Whole streams with any header cause no panic, and neither does merging two of them.
    #[test]
    fn any_header_is_read_or_refused(key in 0..12_usize, value in any_json(), drop in any::<bool>()) {
        let mut header = header();
        let keys: Vec<String> = header.as_object().unwrap().keys().cloned().collect();
        if drop {
            header.as_object_mut().unwrap().remove(&keys[key]);
        } else {
            header[&keys[key]] = value;
        }
        if let Ok(mut read) = decode_header(&header) {
            let mut other = decode_header(&self::header()).unwrap();
            let _ = other.merge(&read);
            let _ = read.merge(&decode_header(&self::header()).unwrap());
            let _ = (read.missing(), read.estimate.image(), read.estimate.relative_error());
        }
    }
}

#[test]
fn a_header_that_lies_is_refused() {
    let changes = [
        ("resolution", json!([0, 5])),
        ("resolution", json!([4_294_967_295_u32, 4_294_967_295_u32])),
        ("resolution", json!([3, 1])),
        ("resolution", json!([1, 1])),
        ("unit", json!(0.0)),
        ("unit", json!(-1.0)),
        ("white_balance", json!([[1.0, 0.0, 0.0]])),
        ("white_balance", json!([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, "white"]])),
        ("halves", json!([3, 3])),
        ("halves", json!([u64::MAX, 6])),
        ("done", json!({ "0": 3, "2": 2 })),
        ("shards", json!(0)),
        ("shards", json!(4_294_967_295_u32)),
        ("has_states", json!(true)),
        ("first_radius", json!([0.0, 0.0, 0.0])),
        ("first_radius", json!([0.0, 0.2, 0.1])),
        ("first_radius", json!([-1.0, 0.1, 0.1])),
        ("first_radius", json!([0.0, 0.1, 1e38])),
        ("first_radius", json!([0.0, 0.1, 1e39])),
    ];
    for (key, value) in changes {
        let mut header = header();
        header[key] = value;
        assert!(matches!(decode_header(&header), Err(CheckpointError::Format(_))), "{header}");
    }
    assert!(decode_header(&header()).is_ok());
    let mut other = header();
    other["goblet_checkpoint"] = json!(7);
    other["done"] = json!("something new");
    assert!(matches!(decode_header(&other), Err(CheckpointError::Version(7))));
}

/// States that would give no image, or an impossible one.
#[test]
fn states_that_no_render_makes_are_refused() {
    let mut header = header();
    header["has_states"] = json!(true);
    let read = |states: [PixelState; 2]| {
        let data = [&[0; 2 * 4 * 16], bytemuck::bytes_of(&states)].concat();
        decode(&gzip(header.to_string().as_bytes(), &data))
    };
    let good = PixelState { found_low: 1, found_high: 0, shrink: 0.5, rest: 0.0 };
    assert_eq!(read([good; 2]).unwrap().states, [good; 2]);
    for [shrink, rest] in [[f32::NAN, 0.0], [0.5, f32::NAN], [-0.5, 0.0], [1.5, 0.0], [0.5, f32::INFINITY]] {
        let error = read([good, PixelState { shrink, rest, ..good }]).unwrap_err();
        assert!(matches!(error, CheckpointError::Format(_)), "{shrink} {rest}");
    }
}

/// With radii from the data, states are sums of discs.
#[test]
fn sums_of_discs_are_in_range() {
    let mut header = header();
    header["has_states"] = json!(true);
    header["identity"]["radius schedule"] = json!("data");
    let read = |[found, excess, reach, area]: [f32; 4]| {
        let state = PixelState { found_low: found.to_bits(), found_high: excess.to_bits(), shrink: reach, rest: area };
        decode(&gzip(header.to_string().as_bytes(), &[&[0; 2 * 4 * 16], bytemuck::bytes_of(&[state; 2])].concat()))
    };
    for good in [[0.0; 4], [9.0, -9.0, 1e6, 3.0], [1e9, 5.0, 0.5, 2.0]] {
        assert!(read(good).is_ok(), "{good:?}");
    }
    let (nan, most) = (f32::NAN, f32::INFINITY);
    for bad in [
        [nan, 0.0, 1.0, 1.0],
        [9.0, 10.0, 1.0, 1.0],
        [-1.0, 0.0, 1.0, 1.0],
        [9.0, nan, 1.0, 1.0],
        [9.0, 0.0, most, 1.0],
    ] {
        assert!(matches!(read(bad), Err(CheckpointError::Format(_))), "{bad:?}");
    }
    for bad in [[9.0, 0.0, -1.0, 1.0], [9.0, 0.0, nan, 1.0], [9.0, 0.0, 1.0, -1.0], [9.0, 0.0, 1.0, nan]] {
        assert!(matches!(read(bad), Err(CheckpointError::Format(_))), "{bad:?}");
    }
}

#[test]
fn nothing_follows_the_end() {
    let mut file = gzip(header().to_string().as_bytes(), &[0; 2 * 4 * 16]);
    assert!(decode(&file).is_ok());
    file.extend(b"more");
    assert!(matches!(decode(&file), Err(CheckpointError::Format(_))));
}

/// Ten megabytes of zeros may expand to ten gigabytes.
#[test]
fn images_larger_than_the_budget_are_refused_before_they_are_read() {
    let mut header = header();
    header["resolution"] = json!([16_384, 8_192]);
    let file = gzip(header.to_string().as_bytes(), &[]);
    let error = Checkpoint::decode(&file[..], &Budget::new(1 << 30)).unwrap_err().to_string();
    assert!(error.contains("for its 16384x8192 pixels") && error.contains("memory"), "{error}");
}

/// The largest image takes 20 GiB. This memory is not reserved in advance.
#[test]
fn memory_follows_the_data_and_not_the_header() {
    let mut reader = CountedZeros(0);
    let error = read_array::<[u32; 4]>(&mut reader, MAX_PIXELS).unwrap_err();
    assert_eq!(error.kind(), io::ErrorKind::UnexpectedEof);
    assert!(reader.0 < 1 << 20, "asked for {} bytes at once", reader.0);
}

/// A reader that ends after one buffer, and stores the size of the buffer.
struct CountedZeros(usize);

impl Read for CountedZeros {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let first = self.0 == 0;
        self.0 = self.0.max(buffer.len());
        Ok(if first { buffer.len() } else { 0 })
    }
}

fn parsed(change: impl FnOnce(&mut Value)) -> Checkpoint {
    let mut header = header();
    change(&mut header);
    decode_header(&header).unwrap()
}

#[test]
fn a_shard_without_iterations_knows_no_radius() {
    let full = || parsed(|header| header["done"] = json!({ "0": 5 }));
    let empty = || {
        parsed(|header| {
            (header["done"], header["halves"]) = (json!({ "1": 0 }), json!([0, 0]));
            header["first_radius"] = Value::Null;
        })
    };
    for [mut a, b] in [[full(), empty()], [empty(), full()]] {
        a.merge(&b).unwrap();
        assert_eq!((a.first_radius, a.missing()), (full().first_radius, vec![]));
    }
    let other = parsed(|header| {
        header["done"] = json!({ "1": 5 });
        header["first_radius"] = json!([0.0, 0.2, 0.2]);
    });
    assert!(matches!(full().merge(&other), Err(CheckpointError::Radii)));
}

/// So that files of goblet from before there were white balances and layers are read, and the same files are written.
#[test]
fn only_a_white_balance_and_layers_that_exist_are_in_the_header() {
    let first_line = |checkpoint: &Checkpoint| {
        let mut line = Vec::new();
        BufReader::new(GzDecoder::new(&encoded(checkpoint)[..])).read_until(b'\n', &mut line).unwrap();
        String::from_utf8(line).unwrap()
    };
    let mut checkpoint = parsed(|_| {});
    assert_eq!(checkpoint.estimate.white_balance, None);
    assert!(!first_line(&checkpoint).contains("white_balance") && !first_line(&checkpoint).contains("layers"));
    checkpoint.estimate.white_balance = Some(DMat3::IDENTITY);
    assert!(first_line(&checkpoint).contains("\"white_balance\":[[1.0,0.0,0.0],"));
}

/// A valid header of layers, of which a part is changed.
#[test]
fn layers_that_make_no_sense_are_refused() {
    let transform = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, 0.0]];
    let layers = json!({
        "groups": ["Albedo", "square"], "of_film": true, "in_world_space": true,
        "camera_from_render": transform, "world_from_render": transform, "photons": 5,
    });
    let read = |key: &str, value: Value| {
        let mut header = header();
        header["layers"] = layers.clone();
        header["layers"][key] = value;
        decode(&gzip(header.to_string().as_bytes(), &[0; 2 * 4 * 16 * 3]))
    };
    let form = read("photons", json!(7)).unwrap().estimate.layers.form;
    assert_eq!((form.groups.names().as_str(), form.of_film, form.photons), ("Albedo, square", true, 7));
    for (key, value) in [
        ("groups", json!([])),
        ("groups", json!(["Albedo", "beauty"])),
        ("groups", json!(["square", "Albedo"])),
        ("groups", json!(["Albedo", "Albedo"])),
        ("groups", json!(["Albedo"])),
        ("groups", json!(["Albedo", "N", "square"])),
        ("world_from_render", json!(vec![vec![0.0; 3]; 4])),
        ("camera_from_render", json!(vec![vec![1.0; 3]; 4])),
        ("photons", json!(-1)),
    ] {
        assert!(matches!(read(key, value), Err(CheckpointError::Format(_))), "{key}");
    }
}

/// Both checkpoints have the same identity, so one of them must be forged.
#[test]
fn sums_of_another_form_are_not_added() {
    let first = || parsed(|header| header["done"] = json!({ "0": 5 }));
    let matrix = json!([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 2.0]]);
    for (key, value) in [("unit", json!(0.25)), ("resolution", json!([1, 2])), ("white_balance", matrix)] {
        let second = parsed(|header| {
            header["done"] = json!({ "1": 5 });
            header[key] = value;
        });
        assert!(matches!(first().merge(&second), Err(CheckpointError::Format(_))), "{key}");
    }
}

#[test]
fn numbers_are_written_as_ranges() {
    for (numbers, expected) in [
        (&[][..], ""),
        (&[7], "7"),
        (&[0, 1], "0, 1"),
        (&[0, 2, 3, 4, 5, 7], "0, 2-5, 7"),
        (&[u32::MAX - 2, u32::MAX - 1, u32::MAX], "4294967293-4294967295"),
    ] {
        assert_eq!(ranges(numbers.iter()), expected);
    }
}
