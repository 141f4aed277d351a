// What is noted of where each layer ends, four bits each: right, left, down, up.

// It lacks its neighbour there.
const LACKS: u32 = 1u;
// Its surface ends there: it does not go on with another layer of the part that lacks its neighbour.
const ENDS: u32 = 16u;
// It ends openly there: nothing meets it.
const ENDS_OPENLY: u32 = 256u;
// It lacks its neighbour and lies behind what ends openly there.
const BEHIND: u32 = 4096u;
