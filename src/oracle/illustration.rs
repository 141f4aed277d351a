//! Illustrative transparency (Carnecky 2013, section 5): the fields α, β, γ of every fragment, their boundary conditions,
//! diffusion, profiles, and the opacity that they make.
//!
//! The paper's forms that fail are here too, by [`PrintedForm`], so that how they fail can be shown in numbers: the Laplacian
//! with λ = 1 (T12), max-propagation that overwrites what is fixed (T16), bare index steps (T19).
//!
//! # Choices
//! - Missing neighbours make silhouettes where [`super::ends`] finds the surface's end, unknown ones do not (T10); through
//!   neither anything flows.
//! - A fragment that ends and lies under another end is a silhouette: the first of the paper's rules wins.
//! - α has no fixed fragments: no rule of the paper makes one.
//! - A power with p = 0 is 0 at u = 0 and 1 elsewhere, its limit.

use super::ends::Surfaces;
use super::feature_size;
use super::neighbours::{Direction, Link};
use super::store::StoreData;
use crate::settings::{Diffusion, IllustrativeSettings, PrintedForm, Profile};

/// The fields of all fragments.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Fields {
    /// α, β, γ.
    pub values: Vec<[f64; 3]>,
    /// Whether β and γ are fixed.
    pub fixed: Vec<[bool; 2]>,
}

/// Who is whose neighbour: the fragment in each direction, if there is one.
pub fn adjacency(store: &StoreData, links: &[[Link; 4]]) -> Vec<[Option<usize>; 4]> {
    let (width, height) = (store.width.max(1) as usize, store.height as usize);
    let pixel_of = store.pixel_of_fragment();
    let neighbour = |i: usize, d: Direction| match links[i][d as usize] {
        Link::To(layer) => d.step(pixel_of[i], width, height).map(|q| store.offsets[q] + layer as usize),
        Link::Missing | Link::Unknown => None,
    };
    (0..store.len()).map(|i| Direction::ALL.map(|d| neighbour(i, d))).collect()
}

/// Who is whose neighbour, and how much flows between them.
#[derive(Clone, Debug, Default)]
pub struct Graph {
    /// The fragment in each direction, if there is one.
    pub around: Vec<[Option<usize>; 4]>,
    /// The conductance of each link, from 0 to 1, the same from both sides.
    pub conductance: Vec<[f64; 4]>,
}

impl Graph {
    /// Everything flows everywhere alike, as in the paper.
    pub fn isotropic(around: Vec<[Option<usize>; 4]>) -> Graph {
        Graph { conductance: vec![[1.0; 4]; around.len()], around }
    }

    /// As the settings ask: by local feature size, or isotropic.
    pub fn of(surfaces: &Surfaces<'_>, settings: &IllustrativeSettings) -> Graph {
        let around = adjacency(surfaces.store, surfaces.links);
        let conductance = feature_size::conductances(&around, surfaces, settings.feature_size);
        Graph { around, conductance }
    }
}

/// Sections 5.2 and 5.3: α from `base`, silhouettes and halos from where surfaces end.
pub fn boundary(surfaces: &Surfaces<'_>, base: &[f64]) -> Fields {
    let mut fields = Fields::default();
    for (i, &pixel) in surfaces.store.pixel_of_fragment().iter().enumerate() {
        let is_end = surfaces.is_end(i);
        let (mut under, mut beside) = (false, false);
        for d in Direction::ALL {
            let found = surfaces.occlusion(pixel, i - surfaces.store.offsets[pixel], d);
            (under, beside) = (under | found.0, beside | found.1);
        }
        let one = |is: bool| f64::from(u8::from(is));
        fields.values.push([base[i].clamp(0.0, 1.0), one(is_end), one(beside)]);
        fields.fixed.push([is_end || under, beside]);
    }
    fields
}

/// Step number `step` of diffusion, from 0. What spreads by `max` loses λ over a link's conductance; heat flows by its square,
/// so that both reach as many times as far as the conductance says.
pub fn step(graph: &Graph, fields: &Fields, settings: &IllustrativeSettings, step: u32) -> Fields {
    let s = settings;
    let how =
        [(s.alpha.diffusion, s.alpha.lambda), (s.beta.diffusion, s.beta.lambda), (s.gamma.diffusion, s.gamma.lambda)];
    let heats = step < s.steps().heat;
    let next = |i: usize, c: usize| {
        let u = fields.values[i][c];
        let is_fixed = c > 0 && fields.fixed[i][c - 1];
        let links = || graph.around[i].iter().zip(graph.conductance[i]).filter_map(|(j, g)| Some(((*j)?, g)));
        let (diffusion, lambda) = how[c];
        match diffusion {
            Diffusion::Heat if heats && !is_fixed => {
                let rate = if s.printed == PrintedForm::Laplacian { 1.0 } else { lambda / 4.0 };
                u + rate * links().map(|(j, g)| g * g * (fields.values[j][c] - u)).sum::<f64>()
            }
            Diffusion::Max if !is_fixed || s.printed == PrintedForm::Propagation => {
                links().map(|(j, g)| fields.values[j][c] - lambda / g).fold(u, f64::max)
            }
            _ => u,
        }
    };
    Fields {
        values: (0..graph.around.len()).map(|i| [0, 1, 2].map(|c| next(i, c))).collect(),
        fixed: fields.fixed.clone(),
    }
}

/// All steps that the settings ask for, none left out.
pub fn diffuse(graph: &Graph, fields: &Fields, settings: &IllustrativeSettings) -> Fields {
    (0..settings.steps().most).fold(fields.clone(), |fields, k| step(graph, &fields, settings, k))
}

/// Equations 10 and 11.
pub fn profiled(profile: Profile, u: f64, p: f64) -> f64 {
    let u = u.clamp(0.0, 1.0);
    match profile {
        Profile::None => u,
        Profile::Power if u <= 0.0 => 0.0,
        Profile::Power => u.powf(p),
        Profile::Bell => {
            let v = (1.0 - u) * (1.0 - u);
            if p < 1e-9 { 1.0 - v } else { (-p * v).exp() * (-p * (1.0 - v)).exp_m1() / (-p).exp_m1() }
        }
    }
}

/// The opacity α̂ of every fragment (Algorithm 3, line 4).
pub fn opacities(fields: &Fields, settings: &IllustrativeSettings) -> Vec<f64> {
    let (b, g) = (&settings.beta, &settings.gamma);
    let opacity = |&[alpha, beta, gamma]: &[f64; 3]| {
        let beta = b.strength * profiled(b.profile, beta, b.p);
        let gamma = g.strength * profiled(g.profile, gamma, g.p);
        ((1.0 - gamma) * (alpha + (1.0 - alpha) * beta)).clamp(0.0, 1.0)
    };
    fields.values.iter().map(opacity).collect()
}

/// Shares of a pixel's fragments in its colour, and what is left for the background. `passes` is what each lets through: its
/// own 1 − α̂, or 1 − α as printed in line 6 (T14).
pub fn shares(opacities: &[f64], passes: &[f64]) -> (Vec<f64>, f64) {
    let mut transmitted = 1.0;
    let shares = opacities
        .iter()
        .zip(passes)
        .map(|(opacity, passes)| {
            let share = transmitted * opacity;
            transmitted *= passes;
            share
        })
        .collect();
    (shares, transmitted)
}

#[cfg(test)]
#[path = "illustration_tests.rs"]
mod tests;
