//! lavapipe of Mesa 22.3 gives no kernels away. RADV does, also without hardware:
//!
//! ```sh
//! VK_ICD_FILENAMES=/usr/share/vulkan/icd.d/radeon_icd.x86_64.json RADV_FORCE_FAMILY=navi21 \
//!     cargo test -p goblet-host pipeline_cache
//! ```

use std::sync::{Arc, Barrier};

use super::*;
use crate::instance::Instance;
use crate::kernel::{Binding, Kernel, Pass, SpecializationValues};
use crate::layout::Place;
use crate::physical::{ArrayKind, Requirements, compute_family};
use crate::pipeline::Code;
use crate::shared::DeviceShared;

const UUID: [u8; vk::UUID_SIZE] = *b"0123456789abcdef";

/// A file of a device that does not exist.
fn file(folder: &Path) -> CacheFile {
    let path = folder.join(file_name("a device", 1, UUID));
    CacheFile { folder: folder.to_owned(), path, header: header(7, 8, UUID) }
}

fn data(vendor: u32, device: u32, uuid: [u8; vk::UUID_SIZE], kernels: &[u8]) -> Vec<u8> {
    [&header(vendor, device, uuid), kernels].concat()
}

/// The names of all files of a folder.
fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap();
    entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect()
}

#[test]
fn only_data_of_the_same_device_and_driver_are_given_to_the_driver() {
    let folder = tempfile::tempdir().unwrap();
    let file = file(folder.path());
    let good = data(7, 8, UUID, b"kernels");
    assert_eq!(good[..16], [32, 0, 0, 0, 1, 0, 0, 0, 7, 0, 0, 0, 8, 0, 0, 0]);
    assert!(file.holds_kernels(&good));
    let changed = |at: usize| {
        let mut changed = good.clone();
        changed[at] ^= 2;
        changed
    };
    for (what, bad) in [
        ("nothing", Vec::new()),
        ("a part of the header", good[..20].to_vec()),
        ("the header alone", good[..HEADER_BYTES].to_vec()),
        ("another length of the header", changed(0)),
        ("another version", changed(4)),
        ("another vendor", data(6, 8, UUID, b"kernels")),
        ("another device", data(7, 9, UUID, b"kernels")),
        ("another driver", data(7, 8, [0; vk::UUID_SIZE], b"kernels")),
        ("anything", b"what is this file doing here, and who has put it there?".to_vec()),
    ] {
        assert!(!file.holds_kernels(&bad), "{what}");
        file.write(&bad).unwrap();
        assert_eq!(file.read(), None, "{what}");
    }
}

#[test]
fn a_file_that_is_cut_or_changed_is_not_read() {
    let folder = tempfile::tempdir().unwrap();
    let file = file(folder.path());
    assert_eq!(file.read(), None, "there is none");
    let good = data(7, 8, UUID, b"kernels");
    file.write(&good).unwrap();
    assert_eq!(file.read().as_deref(), Some(&good[..]));
    let bytes = fs::read(&file.path).unwrap();
    for length in 0..bytes.len() {
        fs::write(&file.path, &bytes[..length]).unwrap();
        assert_eq!(file.read(), None, "{length} bytes");
    }
    for at in 0..bytes.len() {
        let mut changed = bytes.clone();
        changed[at] ^= 1;
        fs::write(&file.path, changed).unwrap();
        assert_eq!(file.read(), None, "byte {at}");
    }
    fs::write(&file.path, &bytes).unwrap();
    assert_eq!(file.read().as_deref(), Some(&good[..]));
    fs::File::options().write(true).open(&file.path).unwrap().set_len(MOST_BYTES + 1).unwrap();
    assert_eq!(file.read(), None, "too large");
    file.write(&good).unwrap();
    assert_eq!(file.read().as_deref(), Some(&good[..]), "after one that was too large");
    assert_eq!(names(folder.path()).len(), 1);
}

#[test]
fn what_is_no_file_and_what_is_no_folder_are_left_alone() {
    let folder = tempfile::tempdir().unwrap();
    let good = data(7, 8, UUID, b"kernels");
    let in_place = file(folder.path());
    fs::create_dir(&in_place.path).unwrap();
    assert_eq!(in_place.read(), None);
    in_place.write(&good).unwrap_err();
    assert!(in_place.path.is_dir() && names(folder.path()).len() == 1);
    fs::write(folder.path().join("x"), "kept").unwrap();
    let below = file(&folder.path().join("x"));
    assert_eq!(below.read(), None);
    below.write(&good).unwrap_err();
    assert_eq!(fs::read(folder.path().join("x")).unwrap(), b"kept");
    // A folder that is not there yet is made.
    let deep = file(&folder.path().join("new/folder"));
    deep.write(&good).unwrap();
    assert_eq!(deep.read().as_deref(), Some(&good[..]));
}

#[test]
fn whoever_reads_while_others_write_finds_one_whole_file() {
    let folder = tempfile::tempdir().unwrap();
    let all: Vec<Vec<u8>> = (1..=3).map(|n| data(7, 8, UUID, &vec![n; 100_000 * usize::from(n)])).collect();
    file(folder.path()).write(&all[0]).unwrap();
    std::thread::scope(|scope| {
        for data in &all {
            scope.spawn(|| (0..20).for_each(|_| file(folder.path()).write(data).unwrap()));
        }
        for _ in 0..40 {
            let found = file(folder.path()).read().expect("a whole file");
            assert!(all.contains(&found));
        }
    });
    assert_eq!(names(folder.path()).len(), 1);
}

#[test]
fn a_name_is_one_of_a_file_whatever_the_device_is_called() {
    let name = file_name("../A B:\\é", 0x2300, UUID);
    assert_eq!(name, "kernels----A-B----00002300-30313233343536373839616263646566.bin");
    assert!(file_name(&"x".repeat(1000), 0, UUID).len() < 128);
    let other = *b"0123456789abcdeg";
    assert_ne!(file_name("x", 1, UUID), file_name("x", 2, UUID));
    assert_ne!(file_name("x", 1, UUID), file_name("x", 1, other));
}

/// A kernel that does nothing, `void main() {}`, in workgroups of a size: another kernel for each.
struct Idle<const SIZE: u32>;

/// Values of no constants.
struct NoValues;

#[rustfmt::skip]
const WORDS: [u32; 35] = [
    0x0723_0203, 0x0001_0300, 0, 5, 0, // magic number, version 1.3, generator, bound, schema
    0x0002_0011, 1, // OpCapability Shader
    0x0003_000e, 0, 1, // OpMemoryModel Logical GLSL450
    0x0005_000f, 5, 1, 0x6e69_616d, 0, // OpEntryPoint GLCompute %1 "main"
    0x0006_0010, 1, 17, 1, 1, 1, // OpExecutionMode %1 LocalSize 1 1 1
    0x0002_0013, 2, // %2 = OpTypeVoid
    0x0003_0021, 3, 2, // %3 = OpTypeFunction %2
    0x0005_0036, 2, 1, 0, 3, // %1 = OpFunction %2 None %3
    0x0002_00f8, 4, // %4 = OpLabel
    0x0001_00fd, // OpReturn
    0x0001_0038, // OpFunctionEnd
];

/// Where the workgroup's size is among the words.
const SIZE_AT: usize = 18;

/// The words as bytes, for a workgroup size.
const fn spirv(size: u32) -> [u8; 4 * WORDS.len()] {
    let mut words = WORDS;
    words[SIZE_AT] = size;
    let mut bytes = [0; 4 * WORDS.len()];
    let mut at = 0;
    while at < bytes.len() {
        bytes[at] = words[at / 4].to_le_bytes()[at % 4];
        at += 1;
    }
    bytes
}

impl<const SIZE: u32> Kernel for Idle<SIZE> {
    const NAME: &'static str = "idle";
    const CODE: &'static [Code] = &[
        Code { arrays: ArrayKind::Images, workgroup_size: SIZE, spirv: &spirv(SIZE) },
        Code { arrays: ArrayKind::Buffers, workgroup_size: SIZE, spirv: &spirv(SIZE) },
    ];
    const PLACES: &'static [Place] = &[];
    type Push = ();
    type Specialization = NoValues;

    fn bindings(&self) -> Vec<Binding<'_>> {
        Vec::new()
    }
}

impl SpecializationValues for NoValues {
    fn value(&self, _: u32) -> Option<[u8; 4]> {
        None
    }
}

/// A device without memory: the compilers of drivers without hardware have none.
fn open(folder: Option<&Path>) -> Arc<DeviceShared> {
    let requirements = Requirements { texels_per_row: 1024, workgroup_size: 2, ..Requirements::default() };
    let instance = Instance::new(true).unwrap();
    let (physical, info) = instance.choose(None, &requirements).unwrap();
    let family = compute_family(&instance.shared.raw, physical).unwrap();
    Arc::new(DeviceShared::open(instance, physical, info, requirements.texels_per_row, family, &[], folder).unwrap())
}

/// Opens a device, compiles, and closes it. Returns whether it was given the data of the file.
fn compile(folder: Option<&Path>) -> bool {
    let device = open(folder);
    drop(Pass::new(&device, &Idle::<1>, &NoValues, 1).unwrap());
    assert_eq!(device.instance.validation_messages(), Vec::<String>::new());
    device.pipelines.cache().has_read()
}

/// Returns the file of the device that tests open.
fn file_of_device(folder: &Path) -> CacheFile {
    let device = open(None);
    // SAFETY: the device is alive, and with it its instance.
    let properties = unsafe { device.instance.shared.raw.get_physical_device_properties(device.physical) };
    CacheFile::new(folder, &properties)
}

#[test]
fn the_next_device_reads_what_this_one_has_compiled() {
    let folder = tempfile::tempdir().unwrap();
    let file = file_of_device(folder.path());
    drop(open(Some(folder.path())));
    assert_eq!(names(folder.path()), Vec::<String>::new(), "nothing was compiled");
    assert!(!compile(Some(folder.path())));
    // lavapipe keeps nothing, and then there is no file.
    let gives_data = file.path.exists();
    println!("the driver gives data: {gives_data}");
    assert_eq!(names(folder.path()).len(), usize::from(gives_data));
    let first = fs::read(&file.path).ok();
    assert_eq!(compile(Some(folder.path())), gives_data);
    assert_eq!(fs::read(&file.path).ok(), first, "there was nothing new");
    assert!(!compile(None), "without a folder there is no cache");
}

#[test]
fn a_device_works_beside_any_file() {
    let folder = tempfile::tempdir().unwrap();
    let file = file_of_device(folder.path());
    for bad in [&b""[..], b"goblet 1", b"not a cache", &[0xff; 4096]] {
        fs::write(&file.path, bad).unwrap();
        assert!(!compile(Some(folder.path())));
        // It is replaced where the driver gives data, else left as it is.
        assert!(file.read().is_some() || fs::read(&file.path).unwrap() == bad);
    }
    fs::remove_file(&file.path).unwrap();
    fs::create_dir(&file.path).unwrap();
    assert!(!compile(Some(folder.path())));
    // A folder that cannot be made.
    fs::write(folder.path().join("x"), "").unwrap();
    assert!(!compile(Some(&folder.path().join("x"))));
}

#[test]
fn two_devices_at_a_time_lose_nothing_of_each_other() {
    let folder = tempfile::tempdir().unwrap();
    let file = file_of_device(folder.path());
    let devices = [(); 2].map(|()| open(Some(folder.path())));
    drop(Pass::new(&devices[0], &Idle::<1>, &NoValues, 1).unwrap());
    drop(Pass::new(&devices[1], &Idle::<2>, &NoValues, 2).unwrap());
    let [first, second] = devices;
    drop(first);
    let one = file.read();
    drop(second);
    let both = file.read();
    assert!(one.is_none() || both.as_ref().map(Vec::len) > one.map(|one| one.len()), "one has replaced the other");
    let third = open(Some(folder.path()));
    drop(Pass::new(&third, &Idle::<1>, &NoValues, 1).unwrap());
    drop(Pass::new(&third, &Idle::<2>, &NoValues, 2).unwrap());
    assert_eq!(third.instance.validation_messages(), Vec::<String>::new());
    drop(third);
    assert_eq!(file.read(), both, "there was nothing new");
}

#[test]
fn devices_that_close_at_once_leave_one_whole_file() {
    let folder = tempfile::tempdir().unwrap();
    let file = file_of_device(folder.path());
    let barrier = Barrier::new(3);
    std::thread::scope(|scope| {
        for _ in 0..3 {
            scope.spawn(|| {
                let device = open(Some(folder.path()));
                drop(Pass::new(&device, &Idle::<1>, &NoValues, 1).unwrap());
                barrier.wait();
            });
        }
    });
    assert_eq!(file.read().is_some(), file.path.exists());
    assert_eq!(names(folder.path()).len(), usize::from(file.path.exists()));
}
