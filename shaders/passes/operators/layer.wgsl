//@ use common/frame
// What an operator is called for: one layer of one pixel (Carnecky 2013, section 4.5).

struct Layer {
    x: u32,
    y: u32,
    pixel: u32,
    // Where the pixel's layers begin, and how many there are.
    base: u32,
    count: u32,
    // Which of them, the nearest first.
    index: u32,
}
