// What stands between the two passes of a transform, as 16-bit floats, scaled so that none can overflow.

alias Stored = u32;

fn stored(v: vec2<f32>, scale: f32) -> Stored {
    return pack2x16float(v * scale);
}

fn restored(s: Stored, unscale: f32) -> vec2<f32> {
    return unpack2x16float(s) * unscale;
}
