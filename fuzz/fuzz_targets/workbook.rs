#![no_main]

use latchgate_fuzz::targets;

libfuzzer_sys::fuzz_target!(|data: &[u8]| targets::workbook(data));
