//! `swellcast plan`: what a demand takes, pass by pass, and what each effect costs on this machine.

use anyhow::{Result, bail};
use clap::Args;
use serde_json::json;

use super::scene;
use crate::backend::Cpu;
use crate::engine::{Clock, EffectCost, Times, demand_cost, effect_costs, interval_of_rate};
use crate::plan::{Demand, Listing};
use crate::sea::Timeline;
use crate::wire::{Codec, ErrorClass, Group, RATES_HZ, UnitName};

#[derive(Debug, Args)]
pub struct PlanArguments {
    /// Preset or scene file
    #[arg(long, default_value = scene::DEFAULT_SCENE)]
    scene: String,
    /// Groups of fields that are wanted [default: all that the scene has]
    #[arg(long, value_name = "F,..", value_delimiter = ',', value_parser = group)]
    fields: Option<Vec<Group>>,
    /// Numbers of the cascades they are wanted of [default: all]
    #[arg(long, value_name = "I,..", value_delimiter = ',')]
    cascades: Option<Vec<u8>>,
    /// Level of detail, 0 the full grid
    #[arg(long, default_value_t = 0)]
    level: u8,
    /// Frames a second
    #[arg(long, default_value_t = 30, value_parser = rate)]
    rate: u32,
    /// Threads that compute [default: one for each core]
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..=256))]
    threads: Option<u16>,
    /// Print JSON and nothing else
    #[arg(long)]
    json: bool,
}

fn group(name: &str) -> Result<Group, String> {
    let known = Group::ALL.map(Group::name).join(", ");
    Group::ALL.into_iter().find(|group| group.name() == name).ok_or(format!("must be of {known}"))
}

fn rate(text: &str) -> Result<u32, String> {
    text.parse().ok().filter(|rate| RATES_HZ.contains(rate)).ok_or(format!("must be one of {RATES_HZ:?}"))
}

pub fn run(arguments: &PlanArguments) -> Result<()> {
    let timeline = Timeline::new(&scene::load(&arguments.scene, None)?);
    let demand = demand(arguments, &timeline)?;
    let listing = Listing::new(&demand, None, timeline.layout(), timeline.scene(), &timeline.at(0));
    let (mut backend, clock) = (Cpu::new(arguments.threads.map(usize::from)), Clock::start(Clock::unix_now_ns()));
    let frame = demand_cost(&mut backend, &timeline, &demand, 0, &clock)?;
    let effects = effect_costs(&mut backend, &timeline, 0, &clock)?;
    if arguments.json {
        let units: Vec<&UnitName> = demand.keys().collect();
        let mut answer = serde_json::to_value(&listing)?;
        answer["scene"] = json!(timeline.scene().name);
        answer["units"] = json!(units);
        answer["rate_hz"] = json!(arguments.rate);
        answer["frame"] = json!(frame);
        answer["effects"] = json!(effects);
        println!("{answer:#}");
    } else {
        print(&listing, frame, &effects);
    }
    Ok(())
}

fn demand(arguments: &PlanArguments, timeline: &Timeline) -> Result<Demand> {
    let (layout, effects) = (timeline.layout(), &timeline.scene().effects);
    let known: Vec<u8> = layout.cascades.iter().map(|cascade| cascade.index).collect();
    if let Some(wrong) = arguments.cascades.iter().flatten().find(|number| !known.contains(number)) {
        bail!("cascades is {wrong}, must be of {known:?}");
    }
    let had: Vec<Group> = Group::ALL.into_iter().filter(|group| effects.has(*group)).collect();
    if let Some(wrong) = arguments.fields.iter().flatten().find(|group| !had.contains(group)) {
        bail!("fields is {}, must be of {}", wrong.name(), had.iter().map(|g| g.name()).collect::<Vec<_>>().join(", "));
    }
    let (groups, numbers) = (arguments.fields.as_ref().unwrap_or(&had), arguments.cascades.as_ref().unwrap_or(&known));
    let mut demand = Demand::new();
    for cascade in layout.cascades.iter().filter(|cascade| numbers.contains(&cascade.index)) {
        if arguments.level >= cascade.levels() {
            bail!("level is {}, must be below {} for cascade {}", arguments.level, cascade.levels(), cascade.index);
        }
        for group in groups {
            // As fine and as often as the scene has it.
            let detail = timeline.scene().detail_of(cascade.index, cascade.levels(), *group);
            let most = detail.and_then(|detail| detail.rate_hz).unwrap_or(arguments.rate).min(arguments.rate);
            if most == 0 {
                continue;
            }
            let level = arguments.level.max(detail.map_or(0, |detail| detail.finest_level));
            let (cascade, class) = (cascade.index, ErrorClass::Millimetre);
            demand.insert(UnitName { cascade, level, class, group: *group, codec: Codec::I16 }, interval_of_rate(most));
        }
    }
    Ok(demand)
}

fn print(listing: &Listing, frame: Times, effects: &[EffectCost]) {
    println!("{:>7} {:>5}  {:<13}{:>5} {:>9}  {:>11}  fields", "cascade", "level", "pass", "n", "points", "columns");
    for line in &listing.passes {
        let columns = line.columns.map(|[some, all]| format!("{some} of {all}")).unwrap_or_default();
        println!(
            "{:>7} {:>5}  {:<13}{:>5} {:>9}  {columns:>11}  {}",
            line.cascade,
            line.level,
            line.pass,
            line.n,
            line.points,
            line.fields.join(" ")
        );
    }
    let Listing { transforms, samples, transforms_per_second, samples_per_second, .. } = listing;
    println!("\na frame: {transforms} transforms of {samples} samples in all, {} without encoding", time(frame));
    println!("a second: {transforms_per_second:.0} transforms of {samples_per_second:.0} samples");
    println!("\n{:<28}{:>4}{:>12}{:>12}  alone", "effect", "on", "transforms", "samples");
    for EffectCost { effect, on, transforms, samples, step } in effects {
        let on = if *on { "yes" } else { "no" };
        println!("{effect:<28}{on:>4}{transforms:>12}{samples:>12}  {}", time(*step));
    }
}

fn time(Times { median_ms, lower_ms, upper_ms, .. }: Times) -> String {
    format!("{median_ms:.2} ms ({lower_ms:.2} to {upper_ms:.2})")
}
