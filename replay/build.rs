//! Compresses the page, which would otherwise take 0.75 MB of the program.

use std::env::var_os;
use std::io::Error;
use std::path::PathBuf;

use miniz_oxide::deflate::compress_to_vec_zlib;

const PAGE: &str = "page/dist/index.html";

fn main() -> Result<(), Error> {
    println!("cargo::rerun-if-changed={PAGE}");
    let folder = PathBuf::from(var_os("OUT_DIR").ok_or_else(|| Error::other("cargo sets OUT_DIR"))?);
    std::fs::write(folder.join("page.zlib"), compress_to_vec_zlib(&std::fs::read(PAGE)?, 10))
}
