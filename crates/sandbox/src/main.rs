//! The `sandbox` program.

use std::process::ExitCode;

fn main() -> ExitCode {
    // wgpu tries every driver and logs those that fail; what matters comes back as an error.
    let quiet = "error,wgpu_hal=off,wgpu_core=off";
    env_logger::Builder::from_env(env_logger::Env::default().default_filter_or(quiet)).init();
    match sandbox::cli::run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            eprintln!("sandbox: {failure}");
            ExitCode::from(failure.exit_code())
        }
    }
}
