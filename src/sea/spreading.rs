//! Directional spreading D(w, theta) around the mean travel direction; every form integrates to 1 over theta.

use std::f64::consts::PI;

use crate::scene::{Spreading, SpreadingForm};

/// Largest spreading exponent: a beam of 1.8 degrees.
const MAX_S: f64 = 2000.0;

/// cos^2s(theta / 2), normalised: D in 1/rad, of the cosine of theta. `s` from 0 (even) up.
pub fn cos2s(s: f64, cos_theta: f64) -> f64 {
    let s = s.clamp(0.0, MAX_S);
    // cos^2(theta / 2) = (1 + cos theta) / 2; rounding may bring it a hair below 0.
    let squared = (0.5 + 0.5 * cos_theta).max(0.0);
    // 0^0 is 1: with s = 0 energy goes everywhere.
    let shape = if s == 0.0 { 1.0 } else { libm::exp(s * libm::log(squared)) };
    shape * cos2s_norm(s)
}

/// Gamma(s + 1) / (2 sqrt(pi) Gamma(s + 1/2)).
fn cos2s_norm(s: f64) -> f64 {
    // Stirling's series of the ratio, at s + 8 where it holds to 1e-13, brought down by Gamma(x+1) = x Gamma(x):
    // the difference of two log-gammas costs ten times as much, and this is called for every point of every cell.
    let mut down = 1.0;
    let mut x = s;
    while x < 8.0 {
        down *= (x + 0.5) / (x + 1.0);
        x += 1.0;
    }
    down * gamma_ratio(x) / (2.0 * libm::sqrt(PI))
}

/// Gamma(x + 1) / Gamma(x + 1/2) for x of 8 and more, to 1e-10 (expansion in 1/z about z = x + 1/4).
fn gamma_ratio(x: f64) -> f64 {
    let z = x + 0.25;
    let w = 1.0 / (z * z);
    libm::sqrt(z) * (1.0 + w * (1.0 / 64.0 + w * (-19.0 / 8192.0 + w * (631.0 / 524_288.0))))
}

/// Exponent s of Hasselmann et al. (1980): `x` = w / wp, `inverse_age` = U wp / g.
pub fn hasselmann_s(x: f64, inverse_age: f64) -> f64 {
    let s = if x <= 1.0 { 6.97 * power(x, 4.06) } else { 9.77 * power(x, -2.33 - 1.45 * (inverse_age - 1.17)) };
    s.clamp(0.0, MAX_S)
}

/// x^p of a positive x, to 1e-13: half the price of a correctly rounded power.
fn power(x: f64, p: f64) -> f64 {
    libm::exp(p * libm::log(x))
}

/// What swell adds to s (Horvath 2015, eq. 44): 16 tanh(wp / w) xi^2; energy narrows at low frequencies.
pub fn horvath_swell_s(x: f64, xi: f64) -> f64 {
    // Most seas have none of it, and this is called for every point of every cell.
    if xi == 0.0 { 0.0 } else { 16.0 * libm::tanh(1.0 / x) * xi * xi }
}

/// Exponent s of Mitsuyasu et al. (1975): `x` = w / wp, `inverse_age` = U wp / g.
pub fn mitsuyasu_s(x: f64, inverse_age: f64) -> f64 {
    let at_peak = 11.5 * power(inverse_age, -2.5);
    (at_peak * power(x, if x <= 1.0 { 5.0 } else { -2.5 })).clamp(0.0, MAX_S)
}

/// beta of Donelan et al. (1985), and above 1.6 of Banner (1990): `x` = w / wp.
pub fn donelan_banner_beta(x: f64) -> f64 {
    match x {
        x if x < 0.95 => 2.61 * power(x.max(0.56), 1.3),
        x if x <= 1.6 => 2.28 * power(x, -1.3),
        _ => {
            let ln = libm::log(x);
            libm::pow(10.0, -0.4 + 0.8393 * libm::exp(-0.567 * 2.0 * ln))
        }
    }
}

/// beta sech^2(beta theta), normalised over the circle.
fn sech2(beta: f64, theta: f64) -> f64 {
    let cosh = libm::cosh(beta * theta);
    0.5 * beta / libm::tanh(beta * PI) / (cosh * cosh)
}

/// cos^2 theta ahead, and `against` of it behind.
fn cos2(against: f64, cos_theta: f64) -> f64 {
    let side = if cos_theta > 0.0 { 1.0 } else { against };
    2.0 / PI * cos_theta * cos_theta * side / (1.0 + against)
}

/// The spreading of one system, ready to be evaluated.
#[derive(Clone, Debug)]
pub struct Spreader {
    settings: Spreading,
    inverse_age: f64,
    /// Horvath's xi.
    elongation: f64,
    /// Normalisation of an elongated form whose integral has no closed form, by ln x; one for each of the two forms.
    norms: [Vec<f64>; 2],
}

/// Values of w / wp between which a normalisation is smooth: Donelan & Banner's pieces, and where tables end.
const KNOTS: [f64; 5] = [0.08, 0.56, 0.95, 1.6, 33.0];
/// Nodes between two knots, evenly in the logarithm.
const NODES: usize = 40;

/// Place of `x` in a table of normalisations, in nodes. Beyond its ends both factors hardly change.
fn place(x: f64) -> f64 {
    let x = x.clamp(KNOTS[0], KNOTS[4]);
    let piece = KNOTS[1..4].iter().filter(|knot| x >= **knot).count();
    let (low, high) = (libm::log(KNOTS[piece]), libm::log(KNOTS[piece + 1]));
    (piece as f64 + (libm::log(x) - low) / (high - low)) * NODES as f64
}

/// The inverse of [`place`] at a node.
fn node_x(node: usize) -> f64 {
    let piece = (node / NODES).min(KNOTS.len() - 2);
    let (low, high) = (libm::log(KNOTS[piece]), libm::log(KNOTS[piece + 1]));
    libm::exp(low + (high - low) * (node - piece * NODES) as f64 / NODES as f64)
}

impl Spreader {
    /// Prepares a spreading. `inverse_age` is U wp / g; `elongation` Horvath's xi.
    pub fn new(settings: Spreading, inverse_age: f64, elongation: f64) -> Self {
        let mut spreader = Self { settings, inverse_age, elongation, norms: [Vec::new(), Vec::new()] };
        if elongation > 0.0 {
            for (i, form) in [settings.form, settings.with].into_iter().enumerate() {
                if spreader.s(form, 1.0).is_none() && (i == 0 || settings.blend > 0.0) {
                    spreader.norms[i] =
                        (0..=NODES * (KNOTS.len() - 1)).map(|node| spreader.norm(form, node_x(node))).collect();
                }
            }
        }
        spreader
    }

    /// D(theta) at `x` = w / wp, 1/rad, of the cosine of theta.
    pub fn density(&self, x: f64, cos_theta: f64) -> f64 {
        let Spreading { form, with, blend, .. } = self.settings;
        let mut sum = 0.0;
        if blend < 1.0 {
            sum += (1.0 - blend) * self.form(0, form, x, cos_theta);
        }
        if blend > 0.0 {
            sum += blend * self.form(1, with, x, cos_theta);
        }
        sum
    }

    fn form(&self, index: usize, form: SpreadingForm, x: f64, cos_theta: f64) -> f64 {
        let elongation = horvath_swell_s(x, self.elongation);
        if let Some(s) = self.s(form, x) {
            return cos2s(s + elongation, cos_theta);
        }
        let plain = self.plain(form, x, cos_theta);
        let norms = &self.norms[index];
        if norms.is_empty() || plain == 0.0 {
            return plain;
        }
        let at = place(x);
        let low = (at as usize).min(norms.len() - 2);
        let norm = norms[low] + (norms[low + 1] - norms[low]) * (at - low as f64);
        plain * squeeze(elongation, cos_theta) * norm
    }

    /// The exponent of the forms that are cos^2s.
    fn s(&self, form: SpreadingForm, x: f64) -> Option<f64> {
        match form {
            SpreadingForm::Uniform => Some(0.0),
            SpreadingForm::Cos2s => Some(self.settings.s),
            SpreadingForm::Mitsuyasu => Some(mitsuyasu_s(x, self.inverse_age)),
            SpreadingForm::Hasselmann => Some(hasselmann_s(x, self.inverse_age)),
            SpreadingForm::Cos2 | SpreadingForm::DonelanBanner => None,
        }
    }

    /// The forms that are not, without elongation.
    fn plain(&self, form: SpreadingForm, x: f64, cos_theta: f64) -> f64 {
        match form {
            SpreadingForm::DonelanBanner => sech2(donelan_banner_beta(x), libm::acos(cos_theta.clamp(-1.0, 1.0))),
            _ => cos2(self.settings.against_wind, cos_theta),
        }
    }

    /// What brings the integral of an elongated form to 1.
    fn norm(&self, form: SpreadingForm, x: f64) -> f64 {
        const STEPS: u32 = 120;
        let elongation = horvath_swell_s(x, self.elongation);
        let at = |i: u32| {
            let cos = libm::cos((f64::from(i) + 0.5) * PI / f64::from(STEPS));
            self.plain(form, x, cos) * squeeze(elongation, cos)
        };
        let integral = 2.0 * PI / f64::from(STEPS) * (0..STEPS).map(at).sum::<f64>();
        1.0 / integral
    }
}

/// cos^2s of half the angle, not normalised.
fn squeeze(s: f64, cos_theta: f64) -> f64 {
    libm::pow((0.5 + 0.5 * cos_theta).max(0.0), s)
}
