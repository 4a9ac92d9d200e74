// What stands before the samples in every buffer of planes: the name of the frame that made them, in the first word, and
// room up to where copies may begin.

const HEADER: u32 = 64u;
