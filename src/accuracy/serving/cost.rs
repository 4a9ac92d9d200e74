//! What every setting that a server can be run at costs: whole frames, step and encoding, in interleaved rounds.

use std::sync::Arc;
use std::time::Duration;

use thiserror::Error;

use super::Setting;
use super::off::{errors, errors_at};
use crate::accuracy::{Axis, Cost, Errors, Measure, Point, SERVING};
use crate::backend::{Backend, BackendError};
use crate::engine::{Clock, Stepper, Times, interval_of_rate};
use crate::plan::{Demand, fields_of};
use crate::scene::{Effects, Foam, Normals, Scene};
use crate::sea::{Cascade, Timeline};
use crate::wire::{Codec, ErrorClass, Group, TICKS_PER_SECOND, UnitName};

/// Ticks between frames, unless the scene allows a group fewer: 30 a second.
const INTERVAL: i64 = interval_of_rate(30);
/// Rounds of frames. Every setting has a frame in each, or in each second, fourth or eighth: whole seconds of them, since
/// some frames of a second are made twice, for who joins ...
const ROUNDS: usize = 240;
const EVERY: [usize; 4] = [1, 2, 4, 8];
/// ... and no more than take so long, milliseconds, if that is a second of them.
const ENOUGH_MS: f64 = 250.0;
/// A server rests between frames, and its threads have to wake for each. What that adds is measured on the cheapest setting,
/// by so many frames with pauses as long as a server's between them, and added to all.
const PACED: usize = 30;
const PAUSE: Duration = Duration::from_millis(33);
/// No time is taken of a setting whose frame takes so many times what a frame may take.
const HOPELESS: f64 = 2.0;
/// Settings are measured together as long as they have no more samples than this: a quarter of a gigabyte of memory.
const TOGETHER: usize = 1 << 20;

/// Who measures, and how far.
pub struct Measuring<'a> {
    /// Tells the time.
    pub clock: &'a Clock,
    /// Opens a backend, or says why there is none.
    pub open: &'a dyn Fn() -> Result<Box<dyn Backend>, String>,
    /// Most backends at a time: 1 of a device that there is one of.
    pub most_backends: usize,
    /// How long a frame may take, milliseconds. Of settings that take far longer no time is taken, but of the cheapest.
    pub most_ms: f64,
    /// Told how many of so many pieces of work are done; false: the rest is left.
    pub goes_on: &'a mut dyn FnMut(usize, usize) -> bool,
}

/// Why nothing was measured.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum Unmeasured {
    /// Somebody said so.
    #[error("the measurement was stopped")]
    Stopped,
    /// A backend could not be opened.
    #[error("no backend to measure on: {0}")]
    NoBackend(String),
    /// A backend failed.
    #[error(transparent)]
    Backend(#[from] BackendError),
}

/// A server's frames at one setting, made one after the other for clients that want all that the scene has.
pub struct Frames {
    timeline: Arc<Timeline>,
    stepper: Stepper,
    demand: Demand,
    /// The next one.
    tick: i64,
    samples: usize,
    memory_bytes: u64,
}

/// Groups of channels that make up all that a scene has, each channel once: what a client with every effect subscribes to.
fn whole(effects: &Effects) -> impl Iterator<Item = Group> {
    Group::ALL.into_iter().filter(|group| match group {
        // Part of the displacement.
        Group::Height => false,
        // Part of the derivatives, where there are those.
        Group::Stretch => effects.normals == Normals::Diagonal,
        // Another way to what slopes and derivatives give.
        Group::Normals => !matches!(effects.normals, Normals::None | Normals::Exact | Normals::Diagonal),
        group => effects.has(*group),
    })
}

/// All that clients can have, at most 30 times a second.
fn demand(scene: &Scene, timeline: &Timeline) -> Demand {
    let mut demand = Demand::new();
    for cascade in &timeline.layout().cascades {
        for group in whole(&scene.effects) {
            let detail = scene.detail_of(cascade.index, cascade.levels(), group);
            let (level, rate_hz) = detail.map_or((0, None), |detail| (detail.finest_level, detail.rate_hz));
            let (cascade, class, codec) = (cascade.index, ErrorClass::Millimetre, Codec::Rans);
            let interval = match rate_hz {
                Some(0) => continue,
                Some(rate) => interval_of_rate(rate).max(INTERVAL),
                None => INTERVAL,
            };
            demand.insert(UnitName { cascade, level, class, group, codec }, interval);
        }
    }
    demand
}

impl Frames {
    /// Frames of a scene at a setting, from the second after a tick on.
    pub fn new(scene: &Scene, setting: &Setting, backend: Box<dyn Backend>, tick: i64) -> Self {
        let mut scene = setting.of(scene);
        // The shortest memory, so that it fills soon; a step of foam costs the same whatever it remembers.
        scene.effects.foam = scene.effects.foam.map(|foam| Foam { growth_s: 0.0, decay_s: 0.1, ..foam });
        let timeline = Arc::new(Timeline::uncalibrated(&scene));
        let (demand, cascades) = (demand(&scene, &timeline), &timeline.layout().cascades);
        let channels = whole(&scene.effects).map(|group| fields_of(group).len()).sum();
        let samples = cascades.iter().map(|cascade| cascade.n * cascade.n).sum();
        let memory_bytes = memory(cascades, channels);
        let mut stepper = Stepper::new(backend, Arc::clone(&timeline), 1);
        stepper.set_demand(&demand);
        let tick = tick.div_euclid(TICKS_PER_SECOND) * TICKS_PER_SECOND + TICKS_PER_SECOND;
        Self { timeline, stepper, demand, tick, samples, memory_bytes }
    }

    /// Fills foam's memory, so that the next frame has foam.
    ///
    /// # Errors
    /// [`BackendError`].
    pub fn warm(&mut self) -> Result<(), BackendError> {
        while self.stepper.warm_foam(self.tick)? {}
        Ok(())
    }

    /// Makes the next frame; how many bytes of it a client receives.
    ///
    /// # Errors
    /// [`BackendError`].
    pub fn make(&mut self) -> Result<usize, BackendError> {
        let frames = self.stepper.frames(self.tick, &self.demand)?.frames;
        self.tick += INTERVAL;
        // Of one unit and tick the deepest prediction comes first; others are for who can't read that one.
        let (mut bytes, mut last) = (0, None);
        for frame in &frames {
            let depth = match last {
                Some((unit, tick, depth)) if (unit, tick) == (frame.unit, frame.tick) => depth,
                _ => frame.depth,
            };
            last = Some((frame.unit, frame.tick, depth));
            bytes += if frame.depth == depth { frame.bytes.len() } else { 0 };
        }
        Ok(bytes)
    }

    /// How long frames take without foam, about, milliseconds: the quicker of two pairs, one of each pair of the lowest
    /// rate and one between.
    fn trial(&mut self, clock: &Clock) -> Result<f64, BackendError> {
        // The first make tables and memory, and have nothing to be predicted from.
        for _ in 0..4 {
            self.make()?;
        }
        let mut pair = || Ok::<_, BackendError>(0.5 * (self.time(clock)?.0 + self.time(clock)?.0));
        Ok(pair()?.min(pair()?))
    }

    /// The next frame, timed: milliseconds, and the bytes of it that a client receives.
    ///
    /// # Errors
    /// [`BackendError`].
    pub fn time(&mut self, clock: &Clock) -> Result<(f64, usize), BackendError> {
        let started = clock.now_us();
        let bytes = self.make()?;
        Ok(((clock.now_us() - started) as f64 / 1e3, bytes))
    }
}

/// Memory of fields, past frames and tables, bytes; about.
fn memory(cascades: &[Cascade], channels: usize) -> u64 {
    // Eleven fields of a transform and up to five that are made of them; each channel's counts now, at three frames of the
    // lowest rate and two between; per mode tables in f64 and f32.
    const FIELDS: usize = 16 * 4;
    const OF_A_CHANNEL: usize = 6 * 2;
    const OF_A_MODE: usize = 160;
    let of = |cascade: &Cascade| {
        let modes = (cascade.half + 1) * (2 * cascade.half + 1);
        cascade.n * cascade.n * (FIELDS + OF_A_CHANNEL * channels) + modes * OF_A_MODE
    };
    cascades.iter().map(of).sum::<usize>() as u64
}

/// Measures a scene at its settings from a tick on: the axis `serving`, with whole frames of all that the scene has, on
/// full grids, to a millimetre, 30 times a second, foam among them. Errors are of every setting, also of those of which no
/// time is taken.
///
/// # Errors
/// [`Unmeasured`].
pub fn measure(scene: &Scene, settings: &[Setting], tick: i64, measuring: &mut Measuring) -> Result<Axis, Unmeasured> {
    let mut run =
        Run { scene, tick, measuring, spare: Vec::new(), points: vec![None; settings.len()], rested: None, done: 0 };
    run.all(settings)?;
    let points = run.points.into_iter().flatten().collect();
    let about = "The settings that a server can be run at: patches of the scene's layout, on grids from coarse to fine. \
                 Errors are of the waves that a layout leaves out, and of reading between its samples; time and bytes are \
                 of whole frames with every effect of the scene, to a millimetre, 30 a second.";
    let (name, about) = (SERVING.to_owned(), about.to_owned());
    let mut axis = Axis { name, about, measure: Measure::Height, cost: Cost::Time, points };
    axis.mark_front();
    Ok(axis)
}

/// A measurement under way.
struct Run<'a, 'b> {
    scene: &'a Scene,
    tick: i64,
    measuring: &'a mut Measuring<'b>,
    /// Backends that are free again.
    spare: Vec<Box<dyn Backend>>,
    /// In the order of the settings; `None` where one has not come yet.
    points: Vec<Option<Point>>,
    /// The cheapest setting, and the median of its frames with pauses between them, milliseconds.
    rested: Option<(usize, f64)>,
    done: usize,
}

/// A setting that is measured: its place, its frames, and what they took.
struct Measured<'a> {
    place: usize,
    setting: &'a Setting,
    frames: Frames,
    /// It has a frame each so many rounds.
    every: usize,
    times: Vec<f64>,
    bytes: usize,
}

impl Run<'_, '_> {
    /// Asks whether to go on.
    fn look(&mut self) -> Result<(), Unmeasured> {
        if (self.measuring.goes_on)(self.done, self.points.len()) { Ok(()) } else { Err(Unmeasured::Stopped) }
    }

    fn all(&mut self, settings: &[Setting]) -> Result<(), Unmeasured> {
        let size = |setting: &Setting| (setting.cascades.patches_m.len(), setting.cascades.n.unwrap_or(0));
        let mut order: Vec<(usize, &Setting)> = settings.iter().enumerate().collect();
        order.sort_by_key(|(_, setting)| samples(size(setting)));
        let (mut hopeless, mut together): (Vec<(usize, usize)>, Vec<Measured>) = (Vec::new(), Vec::new());
        for (place, setting) in order {
            self.look()?;
            let (patches, n) = size(setting);
            // What is larger in every way is no faster.
            if hopeless.iter().any(|(less, coarser)| *less <= patches && *coarser <= n) {
                let errors = errors(self.scene, setting, self.tick);
                self.found(place, Point { errors, ..untimed(setting) });
                continue;
            }
            let held: usize = together.iter().map(|measured| measured.frames.samples).sum();
            if held + samples((patches, n)) > TOGETHER || together.len() >= self.measuring.most_backends {
                self.rounds(std::mem::take(&mut together))?;
            }
            let mut frames = Frames::new(self.scene, setting, self.backend()?, self.tick);
            let ms = frames.trial(self.measuring.clock)?;
            if ms > HOPELESS * self.measuring.most_ms && self.rested.is_some() {
                hopeless.push((patches, n));
                let errors = errors_at(&frames.timeline, setting.finest_m, self.tick);
                self.spare.push(frames.stepper.into_backend());
                self.found(place, Point { errors, ..untimed(setting) });
                continue;
            }
            frames.warm()?;
            if self.rested.is_none() {
                self.rested = Some((place, self.rested_ms(&mut frames)?));
            }
            let enough = |every: &usize| (ROUNDS / every) as f64 * ms <= ENOUGH_MS;
            let every = EVERY.into_iter().find(enough).unwrap_or(EVERY[EVERY.len() - 1]);
            together.push(Measured { place, setting, frames, every, times: Vec::new(), bytes: 0 });
        }
        self.rounds(together)?;
        self.add_waking();
        Ok(())
    }

    fn rested_ms(&mut self, frames: &mut Frames) -> Result<f64, Unmeasured> {
        let mut times = Vec::with_capacity(PACED);
        for _ in 0..PACED {
            self.look()?;
            std::thread::sleep(PAUSE);
            times.push(frames.time(self.measuring.clock)?.0);
        }
        Ok(Times::of(times).median_ms)
    }

    fn add_waking(&mut self) {
        let Some((place, rested_ms)) = self.rested else { return };
        let restless_ms = self.points[place].as_ref().and_then(|point| point.time).map_or(rested_ms, |t| t.median_ms);
        for time in self.points.iter_mut().flatten().filter_map(|point| point.time.as_mut()) {
            *time = time.plus((rested_ms - restless_ms).max(0.0));
        }
    }

    /// Frames of all in turn.
    fn rounds(&mut self, mut together: Vec<Measured>) -> Result<(), Unmeasured> {
        // The first with foam are not counted.
        for measured in &mut together {
            measured.frames.make()?;
        }
        for round in 0..ROUNDS {
            self.look()?;
            for measured in together.iter_mut().filter(|measured| round % measured.every == 0) {
                let (ms, bytes) = measured.frames.time(self.measuring.clock)?;
                measured.times.push(ms);
                measured.bytes += bytes;
            }
        }
        for Measured { place, setting, frames, times, bytes, .. } in together {
            self.look()?;
            let a_second = (TICKS_PER_SECOND / INTERVAL) as f64 / times.len() as f64;
            let point = Point {
                errors: errors_at(&frames.timeline, setting.finest_m, self.tick),
                bytes_per_s: Some(bytes as f64 * a_second),
                time: Some(Times::of(times)),
                memory_bytes: Some(frames.memory_bytes),
                ..untimed(setting)
            };
            self.spare.push(frames.stepper.into_backend());
            self.found(place, point);
        }
        Ok(())
    }

    fn found(&mut self, place: usize, point: Point) {
        self.points[place] = Some(point);
        self.done += 1;
    }

    fn backend(&mut self) -> Result<Box<dyn Backend>, Unmeasured> {
        self.spare.pop().map_or_else(|| (self.measuring.open)().map_err(Unmeasured::NoBackend), Ok)
    }
}

fn samples((patches, n): (usize, usize)) -> usize {
    patches * n * n
}

/// A setting of which nothing is known yet.
fn untimed(setting: &Setting) -> Point {
    Point {
        setting: setting.name.clone(),
        errors: Errors::default(),
        time: None,
        bytes_per_s: None,
        memory_bytes: None,
        front: false,
    }
}
