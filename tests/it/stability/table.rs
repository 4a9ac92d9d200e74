//! The table of hard cases: what goes in, what must hold, why it is hard, and what it does to other programs.

/// What must become of a case.
pub enum Must {
    /// Every number finite, heights within three significant heights, the sea moves, its frames can be sent.
    Hold,
    /// Refused, and the error names this field, the value and its bound.
    Refuse(&'static str),
}

/// A row.
pub struct Case {
    /// The hard thing.
    pub what: &'static str,
    /// Scene file, but for its name.
    pub scene: &'static str,
    pub must: Must,
    /// Why it is hard, and what happens elsewhere where that is known.
    pub why: &'static str,
}

const fn holds(what: &'static str, scene: &'static str, why: &'static str) -> Case {
    Case { what, scene, must: Must::Hold, why }
}

const fn refused(what: &'static str, scene: &'static str, field: &'static str, why: &'static str) -> Case {
    Case { what, scene, must: Must::Refuse(field), why }
}

const NO_WIND: &str = "chi = g F / U^2 and the peak are infinite: a division by zero becomes NaN in every height";
const LIGHT: &str = "the peak of the spectrum is far above any grid; Elfouhaily's alpha_m is negative below 2.7 m/s, and the \
                     spectrum with it";
const STORM: &str = "waves of 10 km, foam everywhere, counts of the wire saturate";
const PUDDLE: &str = "cosh(kd) overflows at the deep end of a table and tanh(kd) vanishes at this one; WGSL's tanh may be NaN \
                      above 88";
const NARROW: &str = "a polynomial fit of the normalisation turns negative near s = 150, and Gamma(s + 1) overflows at 171; \
                      sampled at the centres of cells, a narrow swell loses 3 % of Hs and more";
const GRID: &str = "packed transforms stop being Hermitian where the Nyquist row is not empty";
const SCALE: &str = "lengths from ripples to oceans in the same f32";
const CHOP: &str = "the surface folds over itself, its Jacobian is negative";
const LOOP: &str = "a frequency rounded down to no cycle freezes the wave; a loop of floats does not close";
const RECORD: &str = "real records have gaps, 999 for missing and frequencies that are not in order";
const NUMBERS: &str = "a NaN passes every comparison that is written the wrong way round";

const SMALL: &str = "[wind]\nspeed_mps = 9\n[cascades]\nn = 32\npatches_m = [400, 90]";

/// Every row.
pub const CASES: &[Case] = &[
    holds("wind 0 m/s", "[wind]\nspeed_mps = 0\nrange_mps = [0, 10]\n[cascades]\nn = 32", NO_WIND),
    holds("wind 0.001 m/s", "[wind]\nspeed_mps = 1e-3\nrange_mps = [0, 10]\n[cascades]\nn = 32", LIGHT),
    holds("wind 0.3 m/s", "[wind]\nspeed_mps = 0.3\nrange_mps = [0, 1]\n[cascades]\nn = 32", LIGHT),
    holds("wind 2 m/s, Elfouhaily", "[wind]\nmodel = \"elfouhaily\"\nspeed_mps = 2\n[cascades]\nn = 32", LIGHT),
    holds(
        "wind 0.001 m/s, Elfouhaily",
        "[wind]\nmodel = \"elfouhaily\"\nspeed_mps = 1e-3\nrange_mps = [0, 9]\n[cascades]\nn = 32",
        LIGHT,
    ),
    holds(
        "wind 0.001 m/s, Phillips",
        "[wind]\nmodel = \"phillips\"\nspeed_mps = 1e-3\nrange_mps = [0, 9]\n[cascades]\nn = 32",
        LIGHT,
    ),
    holds("wind 60 m/s", "[wind]\nspeed_mps = 60\nrange_mps = [0, 100]\n[cascades]\nn = 64", STORM),
    holds("wind 100 m/s", "[wind]\nspeed_mps = 100\nrange_mps = [100, 100]\n[cascades]\nn = 64", STORM),
    holds(
        "wind 100 m/s, Pierson-Moskowitz",
        "[wind]\nmodel = \"pierson-moskowitz-u10\"\nspeed_mps = 100\nrange_mps = [0, 100]\n[cascades]\nn = 64",
        STORM,
    ),
    holds(
        "a wind of 1 m/s scaled to 30 m",
        "[wind]\nspeed_mps = 1\nhs_m = 30\nrange_mps = [1, 9]\n[cascades]\nn = 32",
        STORM,
    ),
    refused("wind -1 m/s", "[wind]\nspeed_mps = -1", "wind.speed_mps", NUMBERS),
    refused("wind 101 m/s", "[wind]\nspeed_mps = 101\nrange_mps = [0, 100]", "wind.speed_mps", STORM),
    holds("fetch 0", "[wind]\nfetch_m = 0\n[cascades]\nn = 32", NO_WIND),
    holds("fetch 1 m", "[wind]\nfetch_m = 1\nrange_mps = [5, 15]\n[cascades]\nn = 32", LIGHT),
    holds(
        "fetch 1 m, Elfouhaily",
        "[wind]\nmodel = \"elfouhaily\"\nfetch_m = 1\nrange_mps = [5, 15]\n[cascades]\nn = 32",
        LIGHT,
    ),
    holds(
        "fetch 10,000 km",
        "[wind]\nfetch_m = 1e7\n[cascades]\nn = 32",
        "JONSWAP grows with fetch for ever: a calm of 2 m/s would raise waves of a metre",
    ),
    refused("fetch of infinity", "[wind]\nfetch_m = inf", "wind.fetch_m", NUMBERS),
    holds("depth 1 mm", "[water]\ndepth_m = 1e-3\n[wind]\n[cascades]\nn = 32\npatches_m = [50, 12]", PUDDLE),
    holds("depth 1 mm, automatic layout", "[water]\ndepth_m = 1e-3\n[wind]\n[cascades]\nn = 32", PUDDLE),
    holds("depth 5 cm under a swell", "[water]\ndepth_m = 0.05\n[[swell]]\n[cascades]\nn = 64", PUDDLE),
    holds("depth 11 km", "[water]\ndepth_m = 11e3\n[wind]\n[cascades]\nn = 32", PUDDLE),
    holds("depth of infinity", "[water]\ndepth_m = inf\n[wind]\n[cascades]\nn = 32", PUDDLE),
    refused("depth 0", "[water]\ndepth_m = 0", "water.depth_m", PUDDLE),
    refused("depth of NaN", "[water]\ndepth_m = nan", "water.depth_m", NUMBERS),
    holds(
        "Thompson and Vincent in a puddle",
        "[water]\ndepth_m = 1e-3\n[wind]\ndepth_correction = \"thompson-vincent\"\n[cascades]\nn = 32",
        PUDDLE,
    ),
    holds("gravity 0.1 m/s^2", "[water]\ngravity = 0.1\n[wind]\n[cascades]\nn = 32", SCALE),
    holds("gravity 100 m/s^2", "[water]\ngravity = 100\n[wind]\n[cascades]\nn = 32", SCALE),
    holds("no surface tension", "[water]\nsurface_tension = 0\n[wind]\n[cascades]\nn = 32\npatches_m = [0.5]", SCALE),
    holds("gamma 1", "[[swell]]\ngamma = 1\n[cascades]\nn = 64", NARROW),
    holds("gamma 20", "[[swell]]\ngamma = 20\n[cascades]\nn = 64", NARROW),
    refused("gamma below 1", "[wind]\ngamma = 0.99", "wind.gamma", NUMBERS),
    holds(
        "xi 1, Donelan-Banner",
        "[wind]\nswell = 1\nspreading = { form = \"donelan-banner\" }\n[cascades]\nn = 32",
        NARROW,
    ),
    holds("s 0", "[[swell]]\nspreading = { form = \"cos2s\", s = 0 }\n[cascades]\nn = 64", NARROW),
    holds("s 1000", "[[swell]]\nspreading = { form = \"cos2s\", s = 1000 }\n[cascades]\nn = 64", NARROW),
    holds(
        "gamma 7, s 75, 18 s",
        "[[swell]]\ngamma = 7\ntp_s = 18\nspreading = { form = \"cos2s\", s = 75 }\n[cascades]\nn = 64",
        NARROW,
    ),
    holds("Ochi-Hubble's lambda 0.5", "[[swell]]\nmodel = \"ochi-hubble\"\nlambda = 0.5\n[cascades]\nn = 64", NARROW),
    holds("Ochi-Hubble's lambda 20", "[[swell]]\nmodel = \"ochi-hubble\"\nlambda = 20\n[cascades]\nn = 64", NARROW),
    holds(
        "log-normal amplitudes, sigma 0",
        "[amplitudes]\ndistribution = \"log-normal\"\nsigma = 0\n[wind]\n[cascades]\nn = 32",
        NUMBERS,
    ),
    refused("s 1001", "[[swell]]\nspreading = { form = \"cos2s\", s = 1001 }", "swell[0].spreading.s", NARROW),
    holds("N 16", "[wind]\n[cascades]\nn = 16", GRID),
    holds("N 16 full to Nyquist", "[wind]\n[cascades]\nn = 16\nband_limit = 1\npatches_m = [200]", GRID),
    holds(
        "N 2048",
        "[wind]\n[cascades]\nn = 2048\nband_limit = 0.1\npatches_m = [2000]\n[effects]\nfoam = false",
        GRID,
    ),
    refused("N 8", "[cascades]\nn = 8", "cascades.n", GRID),
    refused("N 4096", "[cascades]\nn = 4096", "cascades.n", GRID),
    refused(
        "N 2048 full to Nyquist, eight times",
        "[cascades]\nn = 2048\nband_limit = 1",
        "cascades.n",
        "gigabytes of tables",
    ),
    holds("a patch of 0.1 m", "[wind]\nspeed_mps = 2\n[cascades]\nn = 64\nband_limit = 1\npatches_m = [0.1]", SCALE),
    holds(
        "ripples of 10,000 rad/m",
        "[wind]\nmodel = \"elfouhaily\"\nspeed_mps = 8\n[cascades]\nn = 512\nband_limit = 0.7\npatches_m = [0.1]\n[effects]\nfoam = false",
        SCALE,
    ),
    holds(
        "a patch of 100 km",
        "[wind]\nspeed_mps = 30\nrange_mps = [1, 30]\n[cascades]\nn = 64\npatches_m = [1e5]",
        SCALE,
    ),
    refused("a patch of 1,000 km", "[cascades]\npatches_m = [1e6]", "cascades.patches_m", SCALE),
    refused("a patch of 1 cm", "[cascades]\npatches_m = [0.01]", "cascades.patches_m", SCALE),
    holds("choppiness 0", "[wind]\n[cascades]\nn = 32\n[effects]\nchoppiness = 0", CHOP),
    holds(
        "choppiness 5 in a storm",
        "[wind]\nspeed_mps = 40\nrange_mps = [0, 40]\n[cascades]\nn = 32\n[effects]\nchoppiness = 5",
        CHOP,
    ),
    refused("choppiness 5.1", "[effects]\nchoppiness = 5.1", "effects.choppiness", CHOP),
    holds(
        "foam gained tenfold",
        "[wind]\nspeed_mps = 30\nrange_mps = [0, 40]\n[cascades]\nn = 32\n[effects]\nfoam_gain = 10",
        CHOP,
    ),
    holds(
        "foam that grows at once and hardly lasts",
        "[wind]\n[cascades]\nn = 32\n[effects]\nfoam_growth_s = 0\nfoam_decay_s = 0.1",
        CHOP,
    ),
    refused(
        "foam that outlasts its memory",
        "[effects]\nfoam_decay_s = 3.1",
        "effects.foam_decay_s",
        "foam that depends on when the server began: two servers never agree",
    ),
    holds("a loop of 1 s", "loop_s = 1\n[wind]\n[cascades]\nn = 32", LOOP),
    holds("a loop of 6 h", "loop_s = 21600\n[wind]\n[cascades]\nn = 32", LOOP),
    holds("a loop of an odd number of ticks", "loop_s = 1.0001388888888889\n[wind]\n[cascades]\nn = 32", LOOP),
    refused("a loop of half a second", "loop_s = 0.5", "loop_s", LOOP),
    refused("a loop of seven hours", "loop_s = 25200", "loop_s", LOOP),
    holds("no waves at all", "", "0 / 0 in every mean period and direction"),
    holds(
        "16 swells, a wind and a record at once",
        "[[swell]]\n[[swell]]\n[[swell]]\n[[swell]]\n[[swell]]\n[[swell]]\n[[swell]]\n[[swell]]\n[[swell]]\n[[swell]]\n[[swell]]\n[[swell]]\n[[swell]]\n[[swell]]\n[[swell]]\n[[swell]]\n[wind]\n[measured]\nstation = \"41010\"\n[cascades]\nn = 32",
        "each system costs again where they are not added first",
    ),
    refused(
        "17 swells",
        "[[swell]]\n[[swell]]\n[[swell]]\n[[swell]]\n[[swell]]\n[[swell]]\n[[swell]]\n[[swell]]\n[[swell]]\n[[swell]]\n[[swell]]\n[[swell]]\n[[swell]]\n[[swell]]\n[[swell]]\n[[swell]]\n[[swell]]",
        "swell",
        "memory of an operator's choice",
    ),
    holds("a record of calm", "[measured]\nbins = [[0.1, 0.0], [0.2, 0.0]]\n[cascades]\nn = 32", RECORD),
    holds(
        "a record of two frequencies",
        "[measured]\nbins = [[0.1, 9.0, 10, 20, 0.9, 0.8], [0.4, 1.0]]\n[cascades]\nn = 32",
        RECORD,
    ),
    holds(
        "directions that no sea can have",
        "[measured]\nbins = [[0.1, 9.0, 10, 100, 1.0, 1.0], [0.2, 1.0, 0, 0, 0.0, 1.0], [0.3, 1.0, 0, 0, 1.0, 0.0]]\n[cascades]\nn = 32",
        "maximum entropy divides by 1 - r1^2",
    ),
    holds(
        "the same by a clipped series",
        "[measured]\ndirections = \"fourier\"\nbins = [[0.1, 9.0, 10, 100, 1.0, 1.0], [0.2, 1.0, 0, 0, 0.0, 1.0]]\n[cascades]\nn = 32",
        "the series of two terms is negative in most bins of real records",
    ),
    refused(
        "frequencies that fall",
        "[measured]\nbins = [[0.2, 1.0], [0.1, 1.0]]",
        "measured.bins[1].frequency_hz",
        RECORD,
    ),
    refused(
        "two frequencies a hair apart",
        "[measured]\nbins = [[0.1, 1.0], [0.10001, 1e5]]",
        "measured.bins[1].frequency_hz",
        "a spike that falls between the points of any quadrature: Hs is then anything",
    ),
    refused("a frequency of 0", "[measured]\nbins = [[0.0, 1.0], [0.1, 1.0]]", "measured.bins[0].frequency_hz", RECORD),
    refused("a density of NaN", "[measured]\nbins = [[0.1, nan], [0.2, 1.0]]", "measured.bins[0].density", NUMBERS),
    refused("a density below 0", "[measured]\nbins = [[0.1, -1.0], [0.2, 1.0]]", "measured.bins[0].density", RECORD),
    refused("one frequency alone", "[measured]\nbins = [[0.1, 1.0]]", "measured.bins", RECORD),
    refused("r1 of 1.5", "[measured]\nbins = [[0.1, 1.0, 0, 0, 1.5, 0], [0.2, 1.0]]", "measured.bins[0].r1", RECORD),
    holds(
        "a small sea at every tick",
        SMALL,
        "f32 seconds lose a wave's phase: .06 rad after a day, all of it after a month; u64 ticks overflow in a product",
    ),
];
