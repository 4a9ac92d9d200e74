// Where column c, sample z of a slot stands between the passes: in blocks of 4 x 4, each read by one workgroup of rows.

fn intermediate(slot: u32, blocks: u32, c: u32, z: u32) -> u32 {
    return slot * (blocks * 4u * N) + ((z / 4u) * blocks + c / 4u) * 16u + (c % 4u) * 4u + z % 4u;
}
