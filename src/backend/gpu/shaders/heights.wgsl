// h(k, t) of every mode, for whoever looks between the passes.

@group(0) @binding(0) var<uniform> turn: vec4<u32>;
@group(0) @binding(1) var<storage, read> table: array<Mode>;
@group(0) @binding(2) var<storage, read_write> heights: array<vec2<f32>>;

@compute @workgroup_size(256)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x < arrayLength(&heights) {
        heights[id.x] = height(table[id.x], turned(table[id.x], turn.x));
    }
}
