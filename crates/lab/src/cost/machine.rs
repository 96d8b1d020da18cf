//! The machine that a report was measured on.

use std::thread::available_parallelism;

use super::record::Machine;

impl Machine {
    /// The machine that this program runs on.
    pub fn here() -> Self {
        Self {
            processor: processor(),
            cores: available_parallelism().map_or(1, usize::from),
            caches: caches(),
            system: format!("{} on {}", std::env::consts::OS, std::env::consts::ARCH),
            instructions: instructions().to_owned(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
            compiler: env!("LAB_COMPILER").to_owned(),
        }
    }
}

/// The processor's name, if the system reports it.
fn processor() -> String {
    let text = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let name = text
        .lines()
        .find(|line| line.starts_with("model name"))
        .and_then(|line| line.split_once(':'));
    name.map_or_else(|| "an unnamed processor".to_owned(), |(_, name)| name.trim().to_owned())
}

/// Sizes of the data caches by level, bytes.
fn caches() -> Vec<u64> {
    let of = |index: u32| {
        let read = |name: &str| {
            std::fs::read_to_string(format!(
                "/sys/devices/system/cpu/cpu0/cache/index{index}/{name}"
            ))
            .ok()
        };
        let kibibytes = read("size")?.trim().strip_suffix('K')?.parse::<u64>().ok()?;
        (read("type")?.trim() != "Instruction").then_some(kibibytes << 10)
    };
    (0..8).filter_map(of).collect()
}

/// Vector instructions that the kernels use on this machine.
fn instructions() -> &'static str {
    #[cfg(target_arch = "x86_64")]
    {
        if std::arch::is_x86_feature_detected!("avx2") {
            return "AVX2";
        }
        "those of every x86-64"
    }
    #[cfg(not(target_arch = "x86_64"))]
    {
        "those of the target"
    }
}
