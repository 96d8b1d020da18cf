//! Damage of shards: no flipped bit gets into a merge.

use std::fs;

use clap::Parser as _;
use tempfile::TempDir;

use crate::commands::{Cli, Command, merge, sweep};
use crate::failure::Failure;

fn run(line: &str) -> Result<(), Failure> {
    match Cli::try_parse_from(line.split_whitespace()).unwrap().command {
        Some(Command::Sweep(args)) => sweep::run(&args),
        Some(Command::Merge(args)) => merge::run(&args),
        _ => unreachable!("{line}"),
    }
}

#[test]
fn a_shard_with_a_flipped_bit_is_refused_and_the_merge_leaves_nothing() {
    // Bits per file, by a stride without a common factor with bytes.
    const FLIPS: usize = 400;
    let study = "sweep oscillator --vary method=all --vary step_hz=20,30 --seconds 0.2 --measure drift,state_hash";
    let files = ["sweep.json", "runs.csv"];
    let folder = TempDir::new().unwrap();
    let at = folder.path().display();
    for shard in ["1", "2"] {
        run(&format!("sandbox {study} --shard {shard}/2 --out {at}/{shard}")).unwrap();
    }
    let merge = format!("sandbox merge {at}/1 {at}/2 --out {at}/out");
    for name in files {
        let path = folder.path().join("1").join(name);
        let whole = fs::read(&path).unwrap();
        let bits = whole.len() * 8;
        for bit in (0..bits).step_by((bits / FLIPS) | 1) {
            let mut damaged = whole.clone();
            damaged[bit / 8] ^= 1 << (bit % 8);
            fs::write(&path, damaged).unwrap();
            let said = run(&merge).map_err(|failure| failure.exit_code());
            assert_eq!(said.err(), Some(2), "{study}: bit {bit} of {name}");
            assert!(!folder.path().join("out").exists(), "{study}: bit {bit} of {name}");
        }
        fs::write(&path, whole).unwrap();
    }
    run(&merge).unwrap();
}
