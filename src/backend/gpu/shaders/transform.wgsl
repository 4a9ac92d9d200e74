// The inverse transform of lines of N samples, Stockham's, in steps of 8 and then of 4: 2048 / N lines in a workgroup,
// 8 samples an invocation. It takes and leaves sample pos + e N / 8 of a line in the invocation at `pos`.

override N: u32;
// Steps of 8 and of 4 that make N.
override EIGHTS: u32;
override FOURS: u32;

const HALF_ROOT: f32 = 0.70710678;

var<workgroup> exchange: array<vec2<f32>, 2048>;

// A line of an invocation, and its place there.
struct Place {
    line: u32,
    pos: u32,
}

fn place(invocation: u32) -> Place {
    return Place(invocation / (N / 8u), invocation % (N / 8u));
}

fn quarter(v: vec2<f32>) -> vec2<f32> {
    return vec2<f32>(-v.y, v.x);
}

// v e^(2 pi i k / N)
fn turn_by(v: vec2<f32>, k: u32) -> vec2<f32> {
    let w = twiddles[k];
    return vec2<f32>(v.x * w.x - v.y * w.y, v.x * w.y + v.y * w.x);
}

struct Four {
    a: vec2<f32>,
    b: vec2<f32>,
    c: vec2<f32>,
    d: vec2<f32>,
}

struct Eight {
    a: vec2<f32>,
    b: vec2<f32>,
    c: vec2<f32>,
    d: vec2<f32>,
    e: vec2<f32>,
    f: vec2<f32>,
    g: vec2<f32>,
    h: vec2<f32>,
}

fn four(x: Four) -> Four {
    let s = x.a + x.c;
    let d = x.a - x.c;
    let t = x.b + x.d;
    let q = quarter(x.b - x.d);
    return Four(s + t, d + q, s - t, d - q);
}

fn eight(x: Eight) -> Eight {
    let even = four(Four(x.a, x.c, x.e, x.g));
    let odd = four(Four(x.b, x.d, x.f, x.h));
    let one = HALF_ROOT * vec2<f32>(odd.b.x - odd.b.y, odd.b.x + odd.b.y);
    let two = quarter(odd.c);
    let three = HALF_ROOT * vec2<f32>(-odd.d.x - odd.d.y, odd.d.x - odd.d.y);
    return Eight(
        even.a + odd.a, even.b + one, even.c + two, even.d + three,
        even.a - odd.a, even.b - one, even.c - two, even.d - three,
    );
}

fn collect(at: Place) -> Eight {
    let first = at.line * N + at.pos;
    let step = N / 8u;
    return Eight(
        exchange[first], exchange[first + step], exchange[first + 2u * step], exchange[first + 3u * step],
        exchange[first + 4u * step], exchange[first + 5u * step], exchange[first + 6u * step], exchange[first + 7u * step],
    );
}

fn transform(input: Eight, at: Place) -> Eight {
    var x = input;
    let line = at.line * N;
    // Length of the transforms that are done.
    var done = 1u;
    for (var step = 0u; step < EIGHTS; step++) {
        let k = at.pos % done;
        if step > 0u {
            let w = k * (N / (8u * done));
            x.b = turn_by(x.b, w);
            x.c = turn_by(x.c, 2u * w);
            x.d = turn_by(x.d, 3u * w);
            x.e = turn_by(x.e, 4u * w);
            x.f = turn_by(x.f, 5u * w);
            x.g = turn_by(x.g, 6u * w);
            x.h = turn_by(x.h, 7u * w);
        }
        x = eight(x);
        if 8u * done < N {
            let first = line + (at.pos - k) * 8u + k;
            workgroupBarrier();
            exchange[first] = x.a;
            exchange[first + done] = x.b;
            exchange[first + 2u * done] = x.c;
            exchange[first + 3u * done] = x.d;
            exchange[first + 4u * done] = x.e;
            exchange[first + 5u * done] = x.f;
            exchange[first + 6u * done] = x.g;
            exchange[first + 7u * done] = x.h;
            workgroupBarrier();
            x = collect(at);
        }
        done = 8u * done;
    }
    for (var step = 0u; step < FOURS; step++) {
        // Two butterflies: samples a, c, e, g and b, d, f, h.
        let k = at.pos % done;
        let l = (at.pos + N / 8u) % done;
        if done > 1u {
            let w = k * (N / (4u * done));
            let v = l * (N / (4u * done));
            x.c = turn_by(x.c, w);
            x.e = turn_by(x.e, 2u * w);
            x.g = turn_by(x.g, 3u * w);
            x.d = turn_by(x.d, v);
            x.f = turn_by(x.f, 2u * v);
            x.h = turn_by(x.h, 3u * v);
        }
        let even = four(Four(x.a, x.c, x.e, x.g));
        let odd = four(Four(x.b, x.d, x.f, x.h));
        x = Eight(even.a, odd.a, even.b, odd.b, even.c, odd.c, even.d, odd.d);
        if 4u * done < N {
            let first = line + (at.pos - k) * 4u + k;
            let second = line + (at.pos + N / 8u - l) * 4u + l;
            workgroupBarrier();
            exchange[first] = x.a;
            exchange[first + done] = x.c;
            exchange[first + 2u * done] = x.e;
            exchange[first + 3u * done] = x.g;
            exchange[second] = x.b;
            exchange[second + done] = x.d;
            exchange[second + 2u * done] = x.f;
            exchange[second + 3u * done] = x.h;
            workgroupBarrier();
            x = collect(at);
        }
        done = 4u * done;
    }
    return x;
}
