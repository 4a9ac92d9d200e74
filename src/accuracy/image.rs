//! Pixels: water seen from above, differences in colour, and how they are written.

use super::errors::{Particle, mean};

/// A picture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Image {
    /// Pixels a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Three bytes of sRGB a pixel, row by row from the top.
    pub pixels: Vec<u8>,
}

/// Points a pixel, along either side: ripples are finer than one.
pub(super) const FINER: usize = 2;

impl Image {
    /// White.
    pub(super) fn white(width: usize, height: usize) -> Self {
        Self { width, height, pixels: vec![255; width * height * 3] }
    }

    /// Water of a significant wave height, metres, `side` pixels a side, from [`FINER`] times as many particles a side.
    pub(super) fn water(particles: &[Particle], side: usize, hs_m: f64) -> Self {
        let colours: Vec<[f64; 3]> = particles.iter().map(|particle| shade(particle, hs_m)).collect();
        // Linear to sRGB, nearly.
        let byte = |linear: f64| (linear.clamp(0.0, 1.0).powf(1.0 / 2.2) * 255.0).round() as u8;
        Self::of(side, |points| [0, 1, 2].map(|part| byte(mean(points.iter().map(|at| colours[*at][part])))))
    }

    /// Numbers at the same points: white is 0, red is `scale` and above, blue as far below. Depth of colour goes by the
    /// square root, so that a hundredth of the scale can be seen.
    pub(super) fn difference(values: &[f64], side: usize, scale: f64) -> Self {
        const RED: [f64; 3] = [178.0, 24.0, 43.0];
        const BLUE: [f64; 3] = [33.0, 82.0, 172.0];
        Self::of(side, |points| {
            let share = (mean(points.iter().map(|at| values[*at])) / scale).clamp(-1.0, 1.0);
            let full = if share > 0.0 { RED } else { BLUE };
            full.map(|full| (255.0 + (full - 255.0) * share.abs().sqrt()).round() as u8)
        })
    }

    /// A square, each pixel made of the numbers of its points.
    fn of(side: usize, pixel: impl Fn(&[usize; FINER * FINER]) -> [u8; 3]) -> Self {
        let points = |row: usize, column: usize| {
            std::array::from_fn(|at| (row * FINER + at / FINER) * side * FINER + column * FINER + at % FINER)
        };
        let pixels = (0..side * side).flat_map(|at| pixel(&points(at / side, at % side))).collect();
        Self { width: side, height: side, pixels }
    }

    /// Puts the middle of a picture into this one, as much of it as `width` x `height` pixels from (`x`, `y`) on hold.
    pub(super) fn put(&mut self, picture: &Self, [x, y]: [usize; 2], [width, height]: [usize; 2]) {
        let (width, height) = (width.min(picture.width), height.min(picture.height));
        let (left, top) = ((picture.width - width) / 2, (picture.height - height) / 2);
        for row in 0..height {
            let from = ((top + row) * picture.width + left) * 3;
            let to = ((y + row) * self.width + x) * 3;
            self.pixels[to..to + width * 3].copy_from_slice(&picture.pixels[from..from + width * 3]);
        }
    }

    /// As a file in the PNG format.
    pub fn png(&self) -> Vec<u8> {
        let mut file = Vec::new();
        let mut encoder = png::Encoder::new(&mut file, self.width as u32, self.height as u32);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        // Writing to memory can't fail, and there are as many pixels as the size says.
        let _ = encoder.write_header().and_then(|mut writer| writer.write_image_data(&self.pixels));
        file
    }
}

/// Dark water, brighter toward a low sun in the north-west and on crests; linear.
fn shade(particle: &Particle, hs_m: f64) -> [f64; 3] {
    const SUN: [f64; 3] = [-0.56, 0.61, -0.56];
    const DARK: [f64; 3] = [0.003, 0.016, 0.040];
    const BRIGHT: [f64; 3] = [0.50, 0.72, 0.80];
    let length = particle.normal.iter().map(|along| along * along).sum::<f64>().sqrt().max(f64::MIN_POSITIVE);
    let lit = particle.normal.iter().zip(SUN).map(|(normal, sun)| normal * sun).sum::<f64>() / length;
    let tone = 0.42 + 1.2 * (lit - SUN[1]) + 0.55 * particle.moved[1] / hs_m.max(f64::MIN_POSITIVE);
    let tone = tone.clamp(0.0, 1.0).powi(2);
    std::array::from_fn(|colour| DARK[colour] + (BRIGHT[colour] - DARK[colour]) * tone)
}
