//! Decides which copies of the sweeps are compiled: those for machines without fused multiply-add only where they are asked
//! for (the feature `portable`) or needed. Half as much again to compile.

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rustc-check-cfg=cfg(portable)");
    if std::env::var_os("CARGO_FEATURE_PORTABLE").is_some() || !this_machine_has_fused() {
        println!("cargo:rustc-cfg=portable");
    }
}

/// Whether the build is for this machine, and this machine has the instructions that `lie::Instructions` requires.
fn this_machine_has_fused() -> bool {
    let is_for_this_machine = std::env::var_os("TARGET") == std::env::var_os("HOST");
    #[cfg(target_arch = "x86_64")]
    let has_fused = is_for_this_machine
        && is_x86_feature_detected!("avx2")
        && is_x86_feature_detected!("fma")
        && is_x86_feature_detected!("bmi1")
        && is_x86_feature_detected!("bmi2")
        && is_x86_feature_detected!("lzcnt")
        && is_x86_feature_detected!("popcnt");
    #[cfg(not(target_arch = "x86_64"))]
    let has_fused = is_for_this_machine && cfg!(target_arch = "aarch64"); // which always has them
    has_fused
}
