//! The bodies of the fuzz targets: plain functions of bytes, which the ordinary
//! tests run briefly and cargo-fuzz runs at length.
