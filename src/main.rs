//! The program: window by default, otherwise one of the commands of the command line.
fn main() {}
