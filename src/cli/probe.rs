//! `swellcast probe`: the water at one point of the world.

use anyhow::Result;
use clap::Args;

use super::scene::MomentArguments;
use crate::reference;
use crate::sea::Timeline;

#[derive(Debug, Args)]
pub struct ProbeArguments {
    #[command(flatten)]
    moment: MomentArguments,
    /// World position in metres, east and south.
    #[arg(long, value_name = "X,Z", allow_hyphen_values = true, value_parser = position)]
    at: [f64; 2],
}

/// Farthest from the origin that a point may lie, metres: there an f64 still tells a tenth of a millimetre.
const FARTHEST_M: f64 = 1e9;

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
    let timeline = Timeline::new(&scene);
    let [x, z] = arguments.at;
    let found = reference::probe(&timeline.at(tick), tick, x, z);
    let mut answer = serde_json::to_value(found)?;
    answer["tick"] = tick.into();
    answer["hs_m"] = timeline.hs_at(tick).into();
    answer["statistics"] = serde_json::to_value(timeline.statistics_at(tick))?;
    println!("{answer:#}");
    Ok(())
}
