//! Command line of qrad.
fn main() {}
