// What stands between the two passes of a transform, as 32-bit floats.

alias Stored = vec2<f32>;

fn stored(v: vec2<f32>, scale: f32) -> Stored {
    return v;
}

fn restored(s: Stored, unscale: f32) -> vec2<f32> {
    return s;
}
