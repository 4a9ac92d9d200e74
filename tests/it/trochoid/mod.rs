//! The trochoid model: its shapes, its bits and its spectrum.

mod served;
mod shape;
mod spectrum;
mod surface;

use std::f64::consts::PI;

use rustfft::FftPlanner;
use rustfft::num_complex::Complex64;
use swellcast::backend::{Backend, Cpu};
use swellcast::pass::trochoid::Trochoids;
use swellcast::plan::{Field, FieldSet};
use swellcast::scene::{Model, Scene, Trochoid, preset};
use swellcast::sea::{CascadeModes, Sea, Timeline, TrochoidWave};

/// The preset with so many components.
fn preset_with(components: usize, turbulence: bool) -> Scene {
    let mut scene = preset("trochoid").unwrap();
    scene.effects.foam = None;
    scene.model = Model::Trochoid(Trochoid { components, turbulence, ..Trochoid::default() });
    scene
}

/// Fields of the first cascade on n x n samples.
fn filled(sea: &Sea, tick: i64, n: usize, fields: &[Field]) -> Vec<Vec<f32>> {
    let trochoids = Trochoids::new(&sea.cascades[0], sea);
    let mut planes = Default::default();
    trochoids.fill(tick, n, FieldSet::of(fields), &mut planes);
    fields.iter().map(|field| planes[*field as usize].clone()).collect()
}

/// Heights of the first cascade by the sum of all modes.
fn full(timeline: &Timeline, tick: i64) -> Vec<f32> {
    let sea = Sea { model: Model::Fft, ..timeline.at(tick) };
    let mut cpu = Cpu::new(Some(2));
    cpu.load(&sea).unwrap();
    let surface = cpu.step(tick, &crate::support::plan(&sea, &[Field::Height])).unwrap();
    surface.cascades[0].plane(Field::Height).unwrap().to_vec()
}

/// Energy of every mode of a real grid: rows of m, columns of n, frequencies of FFT order.
fn energies(n: usize, grid: &[f32]) -> Vec<f64> {
    let mut values: Vec<Complex64> = grid.iter().map(|v| Complex64::new(f64::from(*v), 0.0)).collect();
    let fft = FftPlanner::new().plan_fft_forward(n);
    for _ in 0..2 {
        values.chunks_exact_mut(n).for_each(|row| fft.process(row));
        values = (0..n * n).map(|i| values[i % n * n + i / n]).collect();
    }
    values.iter().map(|v| v.norm_sqr() / (n * n * n * n) as f64).collect()
}

/// |(n, m)| of each of those.
fn radius(n: usize, i: usize) -> f64 {
    let signed = |j: usize| if j < n / 2 { j as f64 } else { j as f64 - n as f64 };
    signed(i % n).hypot(signed(i / n))
}

/// Energy of every mode of a cascade, with |(n, m)|: of each wave that travels.
fn mode_energies(modes: &CascadeModes) -> Vec<(f64, f64)> {
    let dk = modes.cascade.dk();
    let waves = modes.with_wave_vectors().filter(|(kx, kz, _)| *kx > 0.0 || *kz > 0.0);
    waves
        .map(|(kx, kz, mode)| (kx.hypot(kz) / dk, 2.0 * (mode.forward.norm_sqr() + mode.backward.norm_sqr())))
        .collect()
}

/// Sums of energies by ring.
fn rings(edges: &[f64], energies: impl Iterator<Item = (f64, f64)>) -> Vec<f64> {
    let mut sums = vec![0.0; edges.len() - 1];
    for (radius, energy) in energies {
        let ring = edges.partition_point(|edge| *edge <= radius);
        if (1..edges.len()).contains(&ring) {
            sums[ring - 1] += energy;
        }
    }
    sums
}

/// One wave alone on a patch of 64 m.
fn single(amplitude: f64, chop: f64) -> (Sea, TrochoidWave) {
    let mut sea = Timeline::new(&crate::support::wind_sea(8.0, 64, &[64.0])).at(0);
    sea.model = Model::Trochoid(Trochoid { turbulence: false, ..Trochoid::default() });
    sea.choppiness = chop;
    let cascade = &mut sea.cascades[0];
    let chosen = 3 * cascade.rows() + cascade.cascade.half + 4;
    for (i, mode) in cascade.modes.iter_mut().enumerate() {
        mode.forward *= if i == chosen { 0.5 * amplitude / mode.forward.norm() } else { 0.0 };
        mode.backward *= 0.0;
    }
    let waves = swellcast::sea::kept_waves(&sea.cascades[0], &sea);
    assert_eq!(waves.len(), 1);
    (sea, waves[0])
}

/// Wavenumber of that wave, rad/m.
const SINGLE_K: f64 = 5.0 * 2.0 * PI / 64.0;
