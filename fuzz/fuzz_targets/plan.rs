//! `fuzz_plan` of the tests under libFuzzer.
#![no_main]

#[path = "../../tests/fuzz/plan.rs"]
mod plan;
#[path = "../../tests/fuzz/source.rs"]
mod source;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    plan::fuzz_plan(bytes);
});
