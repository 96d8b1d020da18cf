//! The machine that a report was measured on.

use std::thread::available_parallelism;

use super::record::Machine;

impl Machine {
    /// This one.
    pub fn here() -> Self {
        Self {
            processor: processor(),
            cores: available_parallelism().map_or(1, usize::from),
            system: format!("{} on {}", std::env::consts::OS, std::env::consts::ARCH),
            instructions: instructions().to_owned(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
            compiler: env!("LAB_COMPILER").to_owned(),
        }
    }
}

/// The processor's name, where the system tells.
fn processor() -> String {
    let text = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let name = text.lines().find(|line| line.starts_with("model name")).and_then(|line| line.split_once(':'));
    name.map_or_else(|| "an unnamed processor".to_owned(), |(_, name)| name.trim().to_owned())
}

/// Vector instructions that the kernels take here.
fn instructions() -> &'static str {
    #[cfg(target_arch = "x86_64")]
    {
        if std::arch::is_x86_feature_detected!("avx2") {
            return "AVX2 for f64, SSE4.2 for f32";
        }
        "those of every x86-64"
    }
    #[cfg(not(target_arch = "x86_64"))]
    {
        "those of the target"
    }
}
