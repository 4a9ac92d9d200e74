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
    let metre = |pixel: f64| pixel / f64::from(side) * metres - metres / 2.0;
    let steepness = 1.0 / (4.0 * height_rms(patches, metres)).max(1e-3);
    pixels.par_chunks_exact_mut(side as usize * 3).enumerate().for_each(|(row, line)| {
        for (column, pixel) in line.as_chunks_mut::<3>().0.iter_mut().enumerate() {
            // Four points a pixel: ripples are finer than one.
            let colours = [(0.25, 0.25), (0.75, 0.25), (0.25, 0.75), (0.75, 0.75)].map(|(right, down)| {
                let (x, z) = (metre(column as f64 + right), metre(row as f64 + down));
                shade(&Point::seen_at(patches, x, z), steepness)
            });
            *pixel = std::array::from_fn(|c| byte(colours.iter().map(|colour| colour[c]).sum::<f32>() / 4.0));
        }
    });
    Rgb { side, pixels }
}

/// Root mean square of the height, from a coarse grid over the picture.
fn height_rms(patches: &[Patch], metres: f64) -> f32 {
    const GRID: usize = 48;
    let at = |i: usize| ((i as f64 + 0.5) / GRID as f64 - 0.5) * metres;
    let square = |i: usize| Point::at(patches, at(i % GRID), at(i / GRID)).displacement[1].powi(2);
    ((0..GRID * GRID).map(square).sum::<f32>() / (GRID * GRID) as f32).sqrt()
}

/// A linear brightness as a byte of sRGB, nearly.
fn byte(linear: f32) -> u8 {
    (linear.clamp(0.0, 1.0).powf(1.0 / 2.2) * 255.0).round() as u8
}

/// Sunlight from the north-west on dark water, brighter crests, white foam; linear. `steepness` makes heights relative.
fn shade(point: &Point, steepness: f32) -> [f32; 3] {
    const SUN: [f32; 3] = [-0.557, 0.616, -0.557];
    const DEEP: [f32; 3] = [0.004, 0.022, 0.050];
    const CREST: [f32; 3] = [0.055, 0.270, 0.300];
    const SKY: [f32; 3] = [0.340, 0.460, 0.560];
    const FOAM: [f32; 3] = [0.860, 0.900, 0.920];
    let n = point.normal();
    let lit = (n[0] * SUN[0] + n[1] * SUN[1] + n[2] * SUN[2]).max(0.0);
    // The eye is straight above: the half vector lies between it and the sun.
    let half = normalised([SUN[0], SUN[1] + 1.0, SUN[2]]);
    let glint = (n[0] * half[0] + n[1] * half[1] + n[2] * half[2]).max(0.0).powi(40);
    let crest = (0.45 + point.displacement[1] * steepness).clamp(0.0, 1.0).powf(1.5);
    let tilt = (1.0 - n[1].max(0.0)).clamp(0.0, 1.0);
    let foam = (point.foam * 1.2).clamp(0.0, 1.0);
    std::array::from_fn(|c| {
        let body = DEEP[c] + (CREST[c] - DEEP[c]) * crest;
        let water = body * (0.2 + 2.2 * lit * lit) + SKY[c] * (0.05 * lit + 0.5 * tilt * lit) + 0.08 * glint;
        water + (FOAM[c] * (0.45 + 0.6 * lit) - water) * foam
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
