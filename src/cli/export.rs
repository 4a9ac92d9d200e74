//! `swellcast export`: the fields of one tick as NumPy arrays.

use std::fs::File;
use std::io::{BufWriter, IsTerminal};
use std::path::PathBuf;

use anyhow::{Context, Result};
use clap::{Args, ValueEnum};

use super::gpu::GpuArguments;
use super::npz::NpzWriter;
use super::scene::{MomentArguments, check_reference};
use crate::backend::{Backend, Cpu};
use crate::engine::Stepper;
use crate::plan::{Field, FieldSet};
use crate::reference;
use crate::sea::Timeline;

#[derive(Debug, Args)]
pub struct ExportArguments {
    #[command(flatten)]
    moment: MomentArguments,
    /// What computes it; `reference` is the slow sum in f64.
    #[arg(long, value_enum, default_value_t = ExportBackend::Cpu)]
    backend: ExportBackend,
    #[command(flatten)]
    gpu: GpuArguments,
    /// File to write.
    #[arg(long)]
    out: PathBuf,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum ExportBackend {
    Cpu,
    Gpu,
    Reference,
}

/// Fields that are written, beside the normal.
const WRITTEN: [Field; 7] =
    [Field::Height, Field::Dx, Field::Dz, Field::SlopeX, Field::SlopeZ, Field::Jacobian, Field::Foam];

/// Planes of one cascade by [`Field`]; foam is empty where the scene has none.
type Planes = Vec<Vec<f32>>;

pub fn run(arguments: &ExportArguments) -> Result<()> {
    let (scene, tick) = arguments.moment.load()?;
    let timeline = Timeline::new(&scene);
    let cascades = match arguments.backend {
        ExportBackend::Cpu => by(Box::new(Cpu::new(None)), &timeline, tick)?,
        ExportBackend::Gpu => by(arguments.gpu.open()?, &timeline, tick)?,
        ExportBackend::Reference => {
            check_reference(&scene)?;
            by_reference(&timeline, tick)
        }
    };
    let file = File::create(&arguments.out).with_context(|| format!("creating {}", arguments.out.display()))?;
    let mut npz = NpzWriter::new(BufWriter::new(file));
    for (i, (planes, cascade)) in cascades.iter().zip(&timeline.layout().cascades).enumerate() {
        let n = cascade.n;
        for field in WRITTEN.into_iter().filter(|field| !planes[*field as usize].is_empty()) {
            npz.floats(&format!("c{i}_{}", field.name()), &[n, n], planes[field as usize].iter().copied())?;
        }
        npz.floats(&format!("c{i}_normal"), &[n, n, 3], (0..n * n).flat_map(|sample| normal(planes, sample)))?;
    }
    let layout = &timeline.layout().cascades;
    let meta = serde_json::json!({
        "scene": scene.name,
        "seed": scene.seed,
        "tick": tick,
        "hs_m": timeline.hs_at(tick),
        "wanted_hs_m": timeline.wanted_hs_at(tick),
        "patch_m": layout.iter().map(|c| c.patch_m).collect::<Vec<_>>(),
        "n": layout.iter().map(|c| c.n).collect::<Vec<_>>(),
        "choppiness": scene.effects.choppiness,
        "statistics": timeline.statistics_at(tick),
        "warnings": timeline.warnings(),
        "backend": format!("{:?}", arguments.backend).to_lowercase(),
    });
    npz.text("meta", &meta.to_string())?;
    npz.finish()
}

/// Normal of one cascade's displaced surface: exact, from its slopes and derivatives.
fn normal(planes: &Planes, sample: usize) -> [f32; 3] {
    let at = |field: Field| planes[field as usize][sample];
    let (hx, hz, dxx, dzz, dxz) =
        (at(Field::SlopeX), at(Field::SlopeZ), at(Field::Dxx), at(Field::Dzz), at(Field::Dxz));
    let across = glam::Vec3::new(
        hz * dxz - hx * (1.0 + dzz),
        (1.0 + dxx) * (1.0 + dzz) - dxz * dxz,
        hx * dxz - hz * (1.0 + dxx),
    );
    across.normalize_or(glam::Vec3::Y).to_array()
}

fn by(backend: Box<dyn Backend>, timeline: &Timeline, tick: i64) -> Result<Vec<Planes>> {
    let mut stepper = Stepper::new(backend, std::sync::Arc::new(timeline.clone()), 0);
    let mut wanted = FieldSet::SPECTRAL.with(Field::Jacobian);
    if timeline.scene().effects.foam.is_some() {
        wanted = wanted.with(Field::Foam);
    }
    let surface = stepper.surface(tick, wanted)?;
    let planes = |cascade: &crate::backend::CascadeSurface| -> Planes {
        Field::ALL.map(|field| cascade.plane(field).map(<[f32]>::to_vec).unwrap_or_default()).to_vec()
    };
    Ok(surface.cascades.iter().map(planes).collect())
}

fn by_reference(timeline: &Timeline, tick: i64) -> Vec<Planes> {
    let sea = timeline.at(tick);
    let single = |plane: Vec<f64>| plane.into_iter().map(|v| v as f32).collect::<Vec<f32>>();
    let planes = |cascade: usize| -> Planes {
        let fields = reference::fields(&sea, cascade, tick, &Field::SPECTRAL);
        let jacobian = reference::jacobian(&fields[5], &fields[6], &fields[7]);
        let foam = timeline.scene().effects.foam.map(|foam| reference::foam(timeline, cascade, tick, &foam));
        let mut planes: Planes = fields.into_iter().map(single).collect();
        planes.resize(Field::ALL.len(), Vec::new());
        planes[Field::Jacobian as usize] = single(jacobian);
        planes[Field::Foam as usize] = single(foam.unwrap_or_default());
        planes
    };
    let count = sea.cascades.len();
    let told = |cascade: usize| {
        // Seconds a cascade, most of them for foam's memory.
        if std::io::stderr().is_terminal() {
            eprint!("\r\x1b[2Kreference: cascade {} of {count}", cascade + 1);
        }
        planes(cascade)
    };
    let all = (0..count).map(told).collect();
    if std::io::stderr().is_terminal() {
        eprintln!("\r\x1b[2Kreference: {count} cascades");
    }
    all
}
