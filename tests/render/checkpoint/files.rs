//! Files that are no checkpoints.

use std::io::Write;

use flate2::Compression;
use flate2::write::GzEncoder;
use goblet::base::input::Budget;
use goblet::render::checkpoint::{Checkpoint, CheckpointError};

use crate::support::command::Bench;

fn bench() -> Bench {
    let bench = Bench::new();
    bench.rendered(&["--quiet", "--checkpoint", "x.checkpoint", "-o", "x.exr"]);
    bench
}

fn gzip(contents: &[u8]) -> Vec<u8> {
    let mut out = GzEncoder::new(Vec::new(), Compression::fast());
    out.write_all(contents).unwrap();
    out.finish().unwrap()
}

#[test]
fn what_is_no_checkpoint_is_refused() {
    let bench = bench();
    let whole = bench.bytes("x.checkpoint");
    let not_whole = "not a whole checkpoint of goblet";
    let cases: &[(&str, &[u8], &str)] = &[
        ("empty", b"", not_whole),
        ("text", b"{\"goblet_checkpoint\":2}", not_whole),
        ("half", &whole[..whole.len() / 2], not_whole),
        ("other gzip", &gzip(b"nothing\n"), not_whole),
        ("other format", &gzip(b"{\"goblet_checkpoint\":1}\n"), "a checkpoint of format 1: expected format 2"),
        ("image", &bench.bytes("x.exr"), not_whole),
    ];
    for (case, contents, words) in cases {
        bench.write("bad", contents);
        for arguments in
            [&["render", "scene.pbrt", "--resume", "bad", "-o", "y.exr"][..], &["merge", "bad", "-o", "y.exr"]]
        {
            let run = bench.run(arguments);
            run.assert_refused(case, 2, &[&format!("goblet: bad: {words}")]);
            assert!(run.stderr.lines().count() == 1 && !bench.path("y.exr").exists(), "{case}: {run:?}");
        }
    }
    let run = bench.render(&["--resume", "absent", "-o", "y.exr"]);
    run.assert_refused("absent", 2, &["goblet: absent: cannot read the checkpoint: No such file"]);
    bench.render(&["--resume", ".", "-o", "y.exr"]).assert_refused("folder", 2, &["goblet: .: "]);
}

#[test]
fn a_part_of_a_file_is_not_read() {
    let whole = bench().bytes("x.checkpoint");
    for length in (0..whole.len()).step_by(7).chain(whole.len() - 16..whole.len()) {
        let result = Checkpoint::decode(&whole[..length], &Budget::default());
        assert!(matches!(result, Err(CheckpointError::Format(_))), "{length} bytes of {}: {result:?}", whole.len());
    }
}

/// It gives none, or the same: gzip has a time stamp, and names the same bytes in many ways.
#[test]
fn a_flipped_byte_never_gives_another_checkpoint() {
    let whole = bench().bytes("x.checkpoint");
    let expected = Checkpoint::decode(&whole[..], &Budget::default()).unwrap();
    for place in 0..whole.len() {
        let mut flipped = whole.clone();
        flipped[place] ^= [0x01, 0x80, 0xff][place % 3];
        if let Ok(checkpoint) = Checkpoint::decode(&flipped[..], &Budget::default()) {
            assert!(checkpoint == expected, "byte {place}");
        }
    }
}
