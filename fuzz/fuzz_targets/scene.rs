//! Reads any bytes as a scene: nothing may panic or hang, and no number of a successful result may be infinite or NaN.
#![no_main]

#[path = "../../tests/common/bench.rs"]
#[allow(dead_code)]
mod bench;
#[path = "../../tests/random/build.rs"]
mod build;
#[path = "../../tests/random/bytes.rs"]
mod bytes;
#[path = "../../tests/random/description.rs"]
mod description;
#[path = "../../tests/random/elements.rs"]
mod elements;
#[path = "../../tests/random/exact.rs"]
#[allow(dead_code)]
mod exact;
#[path = "../../tests/scenes/elements.rs"]
#[allow(dead_code)]
mod parts;

use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let description = bytes::Bytes(bytes).description();
    if let Err(defect) = exact::run(&description) {
        panic!("{defect} in {description:#?}");
    }
});
