//! What `swellcast load` is asked to do, checked, as plans of clients.

use std::path::PathBuf;

use clap::Args;

use super::demand::{Demand, Part, demand_of};
use super::link::LinkSettings;
use super::viewer::{Manner, Plan};
use crate::client::{Choice, cascades, class, codec, group};
use crate::wire::{Codec, ErrorClass, Group};

/// Clients that come in a second when nothing else is said.
const COMING: f64 = 200.0;

/// Options of `swellcast load`.
#[derive(Args, Clone, Debug)]
pub struct LoadArguments {
    /// The server, like http://127.0.0.1:8080
    #[arg(long)]
    pub url: String,
    /// Clients that read all that comes
    #[arg(long, default_value_t = 100, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub clients: u32,
    /// How long to measure once all clients have come
    #[arg(long, default_value_t = 30.0, value_parser = seconds)]
    pub seconds: f64,
    /// How long it takes until all have come, seconds [default: one second for 200 clients]
    #[arg(long, value_parser = seconds)]
    pub ramp: Option<f64>,
    /// Frames a second [default: the server's lowest]
    #[arg(long)]
    pub rate: Option<u32>,
    /// Error class: 0.5mm, 1mm, 5mm or 20mm
    #[arg(long, default_value = "1mm", value_parser = class)]
    pub class: ErrorClass,
    /// Groups of channels, separated by commas; those that the scene lacks are left out
    #[arg(long, default_value = "displacement,slopes,foam", value_delimiter = ',', value_parser = group)]
    pub groups: Vec<Group>,
    /// Cascades, those of the longest waves first: a number or all
    #[arg(long, default_value = "all", value_parser = cascades)]
    pub cascades: usize,
    /// How samples are written: i16, rans, deflate, f16 or f32
    #[arg(long, default_value = "rans", value_parser = codec)]
    pub codec: Codec,
    /// Level of detail; 0 is the full grid
    #[arg(long, default_value_t = 0)]
    pub level: u8,
    /// A part of a mix, SHARE:RATE:CLASS:GROUPS, as in 30:60:1mm:displacement,slopes; may be repeated, and replaces
    /// --rate, --class and --groups
    #[arg(long, value_name = "PART", conflicts_with_all = ["rate", "class", "groups"])]
    pub mix: Vec<Part>,
    /// Share of the clients that keep whole frames and decode them
    #[arg(long, default_value_t = 0.01, value_parser = share)]
    pub decode: f64,
    /// Further clients that subscribe and then read nothing
    #[arg(long, default_value_t = 0, value_name = "K")]
    pub stalled: u32,
    /// After so many seconds stalled clients read on [default: never; they come back when the server has let them go]
    #[arg(long, value_parser = seconds, requires = "stalled")]
    pub wake: Option<f64>,
    /// Further clients that read at a fixed rate
    #[arg(long, default_value_t = 0, value_name = "K")]
    pub slow: u32,
    /// That rate, Mb/s
    #[arg(long, default_value_t = 1.0, value_parser = seconds, value_name = "MBPS")]
    pub slow_rate: f64,
    /// So many steady clients a second leave, each in its turn, and others come in their place
    #[arg(long, value_name = "N", value_parser = |text: &str| within(text, 1e-3, 1e4))]
    pub churn: Option<f64>,
    /// Every so many seconds the wind of the scene is changed; at the end it is set back
    #[arg(long, value_name = "S", value_parser = |text: &str| within(text, 0.1, 1e6))]
    pub wind_every: Option<f64>,
    /// All clients come over a bad link: delay=20,jitter=10,rate=50,stall=100/5000 (ms, Mb/s)
    #[arg(long)]
    pub link: Option<LinkSettings>,
    /// Measure the raw-socket ceiling of this machine with the same crowd, in the same run
    #[arg(long)]
    pub calibrate: bool,
    /// Share of frames that may be late, and that may be missing, and of ticks that the server may skip, for one that
    /// holds
    #[arg(long, default_value_t = 0.001, value_parser = share)]
    pub tolerate: f64,
    /// The server's memory may grow by so much, from the median of the window's second quarter to that of its last
    #[arg(long, value_name = "MIB", value_parser = |text: &str| within(text, 0.0, 1e6))]
    pub flat: Option<f64>,
    /// Write the figures as JSON to a file; - for standard output, and then nothing else
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
    /// Write a page with plots to a file
    #[arg(long, value_name = "FILE")]
    pub html: Option<PathBuf>,
    /// Print one row of a Markdown table and nothing else
    #[arg(long, conflicts_with = "json")]
    pub markdown: bool,
}

fn seconds(text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|number: &f64| *number > 0.0 && *number <= 1e6);
    number.ok_or_else(|| "must be a number above 0 and at most 1e6".to_owned())
}

fn share(text: &str) -> Result<f64, String> {
    within(text, 0.0, 1.0)
}

fn within(text: &str, least: f64, most: f64) -> Result<f64, String> {
    let number = text.parse().ok().filter(|number: &f64| (least..=most).contains(number));
    number.ok_or_else(|| format!("must be a number from {least} to {most}"))
}

impl LoadArguments {
    /// Seconds until all have come.
    pub fn ramp_s(&self) -> f64 {
        self.ramp.unwrap_or_else(|| (self.all() as f64 / COMING).max(1.0))
    }

    /// Clients of every manner.
    pub fn all(&self) -> usize {
        (self.clients + self.stalled + self.slow) as usize
    }

    /// What is asked for.
    pub fn demands(&self) -> Vec<Demand> {
        let (cascades, level, codec) = (self.cascades, self.level, self.codec);
        if self.mix.is_empty() {
            let (rate, class, groups) = (self.rate, self.class, self.groups.clone());
            return vec![Demand { share: 1.0, choice: Choice { rate, class, groups, cascades, level, codec } }];
        }
        let demand = |part: &Part| Demand {
            share: part.share,
            choice: Choice {
                rate: Some(part.rate_hz),
                class: part.class,
                groups: part.groups.clone(),
                cascades,
                level,
                codec,
            },
        };
        self.mix.iter().map(demand).collect()
    }

    /// The steady clients in the order they come: the first of each demand notes what frames look like, and a share
    /// of the others decodes.
    pub fn steady(&self) -> Vec<Plan> {
        let demands = self.demands();
        let plan = |client: usize| Plan {
            manner: Manner::Steady,
            choice: demands[demand_of(&demands, client)].choice.clone(),
            // As often as the share of the clients so far reaches beyond a whole number: the first does, unless none.
            decodes: ((client + 1) as f64 * self.decode).ceil() > (client as f64 * self.decode).ceil(),
            notes: client < demands.len(),
        };
        (0..self.clients as usize).map(plan).collect()
    }

    /// All clients: the stalled and the slow ones evenly among the others, but behind the first of each demand.
    pub fn plans(&self) -> Vec<Plan> {
        let (mut plans, demands) = (self.steady(), self.demands());
        let stalled = Manner::Stalled(self.wake.map(|seconds| (seconds * 1e6) as i64));
        let stalled = std::iter::repeat_n(stalled, self.stalled as usize);
        let slow = std::iter::repeat_n(Manner::Slow(self.slow_rate * 125e3), self.slow as usize);
        let others: Vec<Manner> = stalled.chain(slow).collect();
        let first = demands.len().min(plans.len());
        let others_in_all = others.len().max(1);
        for (number, manner) in others.into_iter().enumerate().rev() {
            let choice = demands[demand_of(&demands, number)].choice.clone();
            let at = first + (plans.len() - first).min(number * (self.clients as usize - first) / others_in_all);
            plans.insert(at, Plan { manner, choice, decodes: false, notes: false });
        }
        plans
    }
}
