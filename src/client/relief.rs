//! A shaded relief of the water seen from straight above, north at the top.

use std::io::{self, Write};

use rayon::prelude::*;

use super::surface::{Patch, Point};

/// A square picture.
pub struct Rgb {
    /// Pixels a side.
    pub side: u32,
    /// Three bytes a pixel, row by row.
    pub pixels: Vec<u8>,
}

/// The square of `metres` a side around the origin, in `side` x `side` pixels.
pub fn relief(patches: &[Patch], metres: f64, side: u32) -> Rgb {
    let mut pixels = vec![0; side as usize * side as usize * 3];
    let metre = |pixel: usize| (pixel as f64 + 0.5) / f64::from(side) * metres - metres / 2.0;
    pixels.par_chunks_exact_mut(side as usize * 3).enumerate().for_each(|(row, line)| {
        for (column, pixel) in line.as_chunks_mut::<3>().0.iter_mut().enumerate() {
            *pixel = shade(&Point::seen_at(patches, metre(column), metre(row)));
        }
    });
    Rgb { side, pixels }
}

/// Sunlight from the north-west on dark water, brighter crests, white foam.
fn shade(point: &Point) -> [u8; 3] {
    const SUN: [f32; 3] = [-0.557, 0.616, -0.557];
    const DEEP: [f32; 3] = [0.010, 0.045, 0.085];
    const CREST: [f32; 3] = [0.060, 0.250, 0.280];
    const SKY: [f32; 3] = [0.340, 0.460, 0.560];
    const FOAM: [f32; 3] = [0.860, 0.900, 0.920];
    let n = point.normal();
    let lit = (n[0] * SUN[0] + n[1] * SUN[1] + n[2] * SUN[2]).max(0.0);
    // The eye is straight above: the half vector lies between it and the sun.
    let half = normalised([SUN[0], SUN[1] + 1.0, SUN[2]]);
    let glint = (n[0] * half[0] + n[1] * half[1] + n[2] * half[2]).max(0.0).powi(40);
    let crest = (0.5 + point.displacement[1] * 0.15).clamp(0.0, 1.0);
    let tilt = (1.0 - n[1].max(0.0)).clamp(0.0, 1.0);
    let foam = (point.foam * 1.2).clamp(0.0, 1.0);
    std::array::from_fn(|c| {
        let body = DEEP[c] + (CREST[c] - DEEP[c]) * crest;
        let water = body * (0.25 + 1.6 * lit * lit) + SKY[c] * (0.10 * lit + 0.5 * tilt * lit) + 0.10 * glint;
        let colour = water + (FOAM[c] * (0.45 + 0.6 * lit) - water) * foam;
        (colour.clamp(0.0, 1.0).powf(1.0 / 2.2) * 255.0).round() as u8
    })
}

fn normalised(v: [f32; 3]) -> [f32; 3] {
    let length = v.iter().map(|c| c * c).sum::<f32>().sqrt();
    v.map(|c| c / length)
}

impl Rgb {
    /// Writes the picture as PNG.
    ///
    /// # Errors
    /// When `to` can't be written.
    pub fn write_png(&self, to: impl Write) -> io::Result<()> {
        let mut encoder = png::Encoder::new(to, self.side, self.side);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        let mut writer = encoder.write_header().map_err(io::Error::from)?;
        writer.write_image_data(&self.pixels).map_err(io::Error::from)?;
        writer.finish().map_err(io::Error::from)
    }
}
