//! cermd
fn main() {}
