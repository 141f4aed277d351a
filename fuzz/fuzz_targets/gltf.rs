//! Bytes as a file called `.gltf`.

#![no_main]

mod shared;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| shared::read(bytes, "input.gltf"));
