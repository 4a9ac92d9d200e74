// From the height of a mode to the spectra of other fields, twin of pass/operator.rs: D = i (k / |k|) h, slopes are
// i k h, derivatives i k D. Two fields a and b share a transform as a + i b.

// Kinds of packing, as `kind` in bundle.rs numbers them.
const HEIGHT: u32 = 0u;
const SIDEWAYS: u32 = 1u;
const SLOPES: u32 = 2u;
const STRETCH: u32 = 3u;
const SHEAR: u32 = 4u;

// The spectrum of a packing at k = (kx, kz), kx >= 0, or at -k, where both fields are the conjugates.
fn spectrum(kind: u32, height: vec2<f32>, kx: f32, kz: f32, chop: f32, opposite: bool) -> vec2<f32> {
    // An i beside the factor turns the height by a quarter.
    var h = height;
    var a = 1.0;
    var b = 0.0;
    switch kind {
        case SIDEWAYS: {
            h = vec2<f32>(-height.y, height.x);
            a = kx * chop;
            b = kz * chop;
        }
        case SLOPES: {
            h = vec2<f32>(-height.y, height.x);
            a = kx;
            b = kz;
        }
        case STRETCH: {
            a = -kx * kx * chop;
            b = -kz * kz * chop;
        }
        case SHEAR: {
            return height * (-kx * kz * chop);
        }
        default: {
            return height;
        }
    }
    if opposite {
        return vec2<f32>(h.x * a + h.y * b, h.x * b - h.y * a);
    }
    return vec2<f32>(h.x * a - h.y * b, h.y * a + h.x * b);
}
