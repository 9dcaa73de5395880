#![no_main]

use nestd_fuzz::entries;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| entries::obj(bytes));
