//! Command line of `draw_patches`.
fn main() {}
