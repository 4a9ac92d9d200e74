// Foam of a grid, f <- max(d f, r source(J)): twin of pass/foam.rs and of the step in sea/foam_step.rs.

struct Foam {
    frame: u32,
    samples: u32,
    // Begin with none; hold what is made; water can break.
    restart: u32,
    advance: u32,
    breaks: u32,
    threshold: f32,
    // Shares of foam left and of growth made since.
    decay: f32,
    growth: f32,
    // One over the range of Jacobians over which a source fills, and the least foam that is any.
    steepness: f32,
    flush: f32,
}

@group(0) @binding(0) var<uniform> foam: Foam;
@group(0) @binding(1) var<storage, read> jacobian: array<f32>;
// Foam and growth since the last foam tick.
@group(0) @binding(2) var<storage, read_write> held: array<vec2<f32>>;
@group(0) @binding(3) var<storage, read_write> shown: array<f32>;

@compute @workgroup_size(256)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let i = id.x;
    if i >= foam.samples {
        return;
    }
    var before = vec2<f32>(0.0, 0.0);
    if foam.restart == 0u {
        before = held[i];
    }
    var source = 0.0;
    if foam.breaks != 0u {
        source = clamp((foam.threshold - jacobian[HEADER + i]) * foam.steepness, 0.0, 1.0);
    }
    var growth = 0.0;
    if source > 0.0 {
        growth = min(before.y + foam.growth, 1.0);
    }
    let made = max(foam.decay * before.x, source * growth);
    let now = select(made, 0.0, made < foam.flush);
    shown[HEADER + i] = now;
    if foam.advance != 0u {
        held[i] = vec2<f32>(now, growth);
    }
    if i == 0u {
        shown[0] = f32(foam.frame);
    }
}
