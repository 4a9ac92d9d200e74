//! Which numbers the sea is computed in, and by what: at the samples themselves, so that nothing but arithmetic errs.

use super::axis::{Draft, axis};
use super::errors::Errors;
use super::ground::{Ground, LOOKED_AT, Made, fields_on_grid, particles, particles_on_grid, with_grid};
use super::report::{Axis, Cost, Measure};
use crate::backend::Backend;
use crate::engine::Opener;
use crate::plan::{CascadePlan, Plan};
use crate::reference;
use crate::sea::Sea;

/// A GPU that may be had, and what it is called in the table.
pub type MayBe<'a> = (&'static str, Option<&'a Opener>);

/// The reference, the CPU and those GPUs; also the name of a GPU that was there, and what could not be measured.
pub fn arithmetic(ground: &Ground, gpus: &[MayBe], left_out: &mut Vec<String>) -> (Axis, Option<String>) {
    // The reference takes the cube of the side.
    let n = if ground.quick { 64 } else { 256 };
    let sea = with_grid(&ground.sea, n);
    let truth = particles(&fields_on_grid(&sea, ground.tick, &ground.spots));
    let errors = |surface: &crate::backend::Surface| {
        Errors::of(&particles_on_grid(surface, &sea, &ground.spots), &truth, ground.hs_m)
    };
    let all: Vec<_> = LOOKED_AT.iter().collect();
    let by_reference = |_: i64| {
        for cascade in 0..sea.cascades.len() {
            drop(reference::fields(&sea, cascade, ground.tick, &all));
        }
    };
    let mut cpu = Made::new(sea.clone(), LOOKED_AT, &ground.scene.effects);
    let of_cpu = errors(cpu.step(ground.tick));
    let exact = Errors::of(&truth, &truth, ground.hs_m);
    let mut drafts = vec![
        Draft::new("reference, f64", exact).costing(by_reference),
        Draft::new("CPU, f32", of_cpu).costing(|round| {
            cpu.step(ground.tick + round * 240);
        }),
    ];
    let mut adapter = None;
    let plan = CascadePlan::new([(0, LOOKED_AT)], None, &ground.scene.effects);
    let plan = Plan { cascades: vec![plan; sea.cascades.len()] };
    for (name, opener) in gpus {
        match open(*opener, &sea) {
            Ok(mut gpu) => {
                let errors = match gpu.step(ground.tick, &plan) {
                    Ok(surface) => errors(surface),
                    Err(error) => {
                        left_out.push(format!("{name}: {error}"));
                        continue;
                    }
                };
                adapter = Some(gpu.device().to_owned());
                let (plan, tick) = (plan.clone(), ground.tick);
                // A device that is lost now has shown what it errs; its times end here.
                let work = move |round: i64| drop(gpu.step(tick + round * 240, &plan).map(drop));
                drafts.push(Draft::new(*name, errors).costing(work));
            }
            Err(why) => left_out.push(format!("{name}: {why}")),
        }
    }
    let about = format!(
        "Eight fields of every cascade at {n} x {n} samples. The reference sums in f64, one dimension after the other; it is \
         what all else is measured by. A GPU's time includes reading its fields back."
    );
    (axis(ground, "arithmetic", about, (Measure::Height, Cost::Time), drafts), adapter)
}

fn open(opener: Option<&Opener>, sea: &Sea) -> Result<Box<dyn Backend>, String> {
    let Opener(open) = opener.ok_or("this build has no GPU backend")?;
    let mut gpu = open()?;
    gpu.load(sea).map_err(|error| error.to_string())?;
    Ok(gpu)
}
