//! `fuzz_scene` of the tests under libFuzzer.
#![no_main]

#[path = "../../tests/fuzz/scene.rs"]
mod scene;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    scene::fuzz_scene(bytes);
});
