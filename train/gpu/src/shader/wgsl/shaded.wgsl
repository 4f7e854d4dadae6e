// Colours are there, and nothing is kept for another program.

fn keep(number: u32) {}
