//! The picture of `watch`: sums and normals of cascades, and light on them.

use swellcast::client::{Patch, Point, relief};
use swellcast::wire::Group;

/// A patch of 64 m with a wave of `amplitude` along x, `waves` lengths to the patch, without choppiness.
fn wave(amplitude: f32, waves: f32, foam: f32) -> Patch {
    const N: usize = 64;
    let plane = |f: &dyn Fn(f32) -> f32| (0..N * N).map(|i| f((i % N) as f32 / N as f32)).collect::<Vec<f32>>();
    let k = std::f32::consts::TAU * waves;
    let still = || plane(&|_| 0.0);
    Patch::of(
        64.0,
        vec![
            (Group::Displacement, N, vec![still(), plane(&|x| amplitude * (k * x).sin()), still()]),
            (Group::Slopes, N, vec![plane(&|x| amplitude * k / 64.0 * (k * x).cos()), still()]),
            (Group::Foam, N, vec![plane(&|_| foam)]),
        ],
    )
}

#[test]
fn cascades_add_up_and_repeat() {
    let patches = [wave(1.0, 1.0, 0.5), wave(0.25, 4.0, 0.5)];
    let point = Point::at(&patches, 20.0, 5.0);
    let single =
        Point::at(&patches[..1], 20.0, 5.0).displacement[1] + Point::at(&patches[1..], 20.0, 5.0).displacement[1];
    assert!((point.displacement[1] - single).abs() < 1e-6);
    assert!((point.foam - 0.75).abs() < 1e-6, "two half covers leave a quarter bare");
    let far = Point::at(&patches, 20.0 - 64.0 * 7.0, 5.0 + 64.0 * 9.0);
    assert!((far.displacement[1] - point.displacement[1]).abs() < 1e-4);
}

#[test]
fn the_normal_leans_away_from_the_slope() {
    assert_eq!(Point::default().normal(), [0.0, 1.0, 0.0]);
    let n = Point { slopes: [0.5, 0.0], ..Point::default() }.normal();
    assert!(n[0] < 0.0 && n[1] > 0.0 && n[2] == 0.0);
    assert!((n[0] / n[1] + 0.5).abs() < 1e-6);
    // Squeezed along x by half, a slope along x is twice as steep.
    let n = Point { slopes: [0.5, 0.0], derivatives: [-0.5, 0.0, 0.0], ..Point::default() }.normal();
    assert!((n[0] / n[1] + 1.0).abs() < 1e-6);
}

#[test]
fn slopes_towards_the_sun_are_brighter_and_foam_is_brightest() {
    let picture = relief(&[wave(2.0, 1.0, 0.0)], 64.0, 64);
    let light = |x: usize| picture.pixels[(32 * 64 + x) * 3..][..3].iter().map(|c| u32::from(*c)).sum::<u32>();
    // Centred on the origin: column 32 is x = 0, where the height rises eastward and so faces the sun in the west.
    assert!(light(32) > light(0), "{} against {}", light(32), light(0));
    let white = relief(&[wave(2.0, 1.0, 1.0)], 64.0, 8);
    assert!(white.pixels.iter().all(|c| *c > 120));
    let mut file = Vec::new();
    picture.write_png(&mut file).unwrap();
    let read = png::Decoder::new(std::io::Cursor::new(&file)).read_info().unwrap();
    assert_eq!((read.info().width, read.info().height), (64, 64));
}
