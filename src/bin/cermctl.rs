//! cermctl
fn main() {}
