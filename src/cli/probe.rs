//! `swellcast probe`: the water at points of the world.

use std::sync::Arc;

use anyhow::Result;
use clap::{Args, ValueEnum};
use serde_json::Value;

use super::scene::{MomentArguments, check_reference};
use crate::backend::Cpu;
use crate::engine::{ProbeFields, ProbeMethod, Prober};
use crate::reference;
use crate::scene::Model;
use crate::sea::Timeline;
use crate::wire::FARTHEST_M;

#[derive(Debug, Args)]
pub struct ProbeArguments {
    #[command(flatten)]
    moment: MomentArguments,
    /// World position in metres, east and south; may be repeated, and is then answered by an array
    #[arg(long, value_name = "X,Z", allow_hyphen_values = true, value_parser = position, required = true)]
    at: Vec<[f64; 2]>,
    /// What computes it: bicubic from the grids of the CPU, or the slow sum in f64 [default: reference, where the scene
    /// is a sum of modes]
    #[arg(long, value_enum)]
    backend: Option<ProbeBackend>,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum ProbeBackend {
    Cpu,
    Reference,
}

fn position(text: &str) -> Result<[f64; 2], String> {
    let number = |part: &str| {
        let value = part.trim().parse::<f64>().ok().filter(|v| v.abs() <= FARTHEST_M);
        value.ok_or_else(|| format!("{part:?} is not a number of metres within {FARTHEST_M}"))
    };
    let (x, z) = text.split_once(',').ok_or("must be two numbers, X,Z")?;
    Ok([number(x)?, number(z)?])
}

pub fn run(arguments: &ProbeArguments) -> Result<()> {
    let (scene, tick) = arguments.moment.load()?;
    let timeline = Arc::new(Timeline::new(&scene));
    let usual = if scene.model == Model::Fft { ProbeBackend::Reference } else { ProbeBackend::Cpu };
    let found: Vec<Value> = match arguments.backend.unwrap_or(usual) {
        ProbeBackend::Reference => {
            check_reference(&scene)?;
            let sea = timeline.at(tick);
            let probe = |[x, z]: &[f64; 2]| serde_json::to_value(reference::probe(&sea, tick, *x, *z));
            arguments.at.iter().map(probe).collect::<Result<_, _>>()?
        }
        ProbeBackend::Cpu => {
            let mut prober = Prober::new(Box::new(Cpu::new(None)), Arc::clone(&timeline));
            let probed = prober.probe(tick, &arguments.at, ProbeFields::ALL, ProbeMethod::Grid)?;
            probed.answers.iter().map(serde_json::to_value).collect::<Result<_, _>>()?
        }
    };
    let (hs, statistics) = (timeline.hs_at(tick), serde_json::to_value(timeline.statistics_at(tick))?);
    let told = |mut answer: Value| {
        answer["tick"] = tick.into();
        answer["hs_m"] = hs.into();
        answer["statistics"] = statistics.clone();
        answer
    };
    let mut told: Vec<Value> = found.into_iter().map(told).collect();
    let all = if told.len() == 1 { told.swap_remove(0) } else { Value::Array(told) };
    println!("{all:#}");
    Ok(())
}
