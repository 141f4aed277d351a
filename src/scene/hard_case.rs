//! Hard cases as data: a scene and view that make a trap happen, what is measured, and what the figure must not exceed.
//!
//! A technique declares its cases in `cases.rs` beside its code; `tradeoff::hard_cases` lists and runs them all. Nothing
//! here depends on how a picture is drawn: settings are text (`path=value`, separated by spaces), checked by a test.
//!
//! Every figure is an error: 0 is best, and a case passes at or below its bound. A case can also name a *contrast*, which
//! must break the bound, else the case would prove nothing: the method as printed in the paper, or an error planted into
//! ours.

use glam::DVec3;

use crate::math::{Bounds, Camera};

/// A hard case.
#[derive(Clone, Copy, Debug)]
pub struct HardCase {
    /// What to call it on the command line: the trap's number and a few words.
    pub name: &'static str,
    /// The number of the trap in the notes on the papers, as in `T1`; empty for what the notes have no number for.
    pub trap: &'static str,
    /// Why it is hard: one paragraph.
    pub why: &'static str,
    /// What is drawn.
    pub scene: Source,
    /// From where.
    pub camera: CaseCamera,
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Our method.
    pub ours: Method,
    /// A method that fails, if there is one.
    pub contrast: Option<Contrast>,
    /// What is measured.
    pub measure: Measure,
    /// The largest figure with which ours passes, in the unit of the measure.
    pub bound: f64,
}

/// Where the geometry of a case comes from.
#[derive(Clone, Copy, Debug)]
pub enum Source {
    /// A built-in scene.
    Builtin(&'static str),
    /// A built-in scene, written as a GLB and imported.
    ThroughFile(&'static str),
    /// A GLB made in memory, imported.
    Bytes(fn() -> Vec<u8>),
    /// A built-in scene, cut open by a plane (normal, offset) without a cap.
    Cut(&'static str, DVec3, f64),
}

/// How a case is looked at.
#[derive(Clone, Copy, Debug)]
pub enum CaseCamera {
    /// The whole scene from a direction.
    Framed {
        /// Viewing direction.
        direction: DVec3,
        /// How much of the image the box around the scene fills; beyond 1 some of it lies outside.
        zoom: f64,
        /// Parallel projection.
        orthographic: bool,
    },
    /// From a place, in scene space.
    Placed(Camera),
}

impl CaseCamera {
    /// Perspective from +z, the whole scene in the image.
    pub const FRONT: CaseCamera = CaseCamera::Framed { direction: DVec3::NEG_Z, zoom: 0.9, orthographic: false };
    /// The same in parallel projection.
    pub const FRONT_PARALLEL: CaseCamera =
        CaseCamera::Framed { direction: DVec3::NEG_Z, zoom: 0.9, orthographic: true };
    /// Perspective from +z into the middle of the scene: its edges are beyond the image. In an image of even width and odd
    /// height a square's diagonal keeps clear of the centres of pixels.
    pub const INTO: CaseCamera = CaseCamera::Framed { direction: DVec3::NEG_Z, zoom: 3.0, orthographic: false };
    /// Perspective from a corner, some of the scene beyond the image.
    pub const CORNER: CaseCamera =
        CaseCamera::Framed { direction: DVec3::new(-0.37, -0.41, -0.83), zoom: 1.9, orthographic: false };

    /// The camera for a scene in an image of `size`.
    pub fn of(&self, bounds: &Bounds, size: [u32; 2]) -> Camera {
        match *self {
            CaseCamera::Framed { direction, zoom, orthographic } => {
                let aspect = f64::from(size[0]) / f64::from(size[1].max(1));
                Camera::framing(bounds, direction, DVec3::Y, aspect, zoom, orthographic, 0.6)
            }
            CaseCamera::Placed(camera) => camera,
        }
    }
}

/// How a picture is drawn.
#[derive(Clone, Copy, Debug)]
pub struct Method {
    /// A few words for the table.
    pub label: &'static str,
    /// Settings that are not at their default: `path=value`, separated by spaces.
    pub settings: &'static str,
    /// A change of the shaders.
    pub shader: Option<ShaderChange>,
    /// Other geometry than the case's.
    pub scene: Option<Source>,
}

impl Method {
    /// A method by its settings alone.
    pub const fn of(label: &'static str, settings: &'static str) -> Method {
        Method { label, settings, shader: None, scene: None }
    }

    /// The same over changed shaders: in `module` (below `shaders/`, without its ending) `from` becomes `to`.
    #[must_use]
    pub const fn changed(mut self, module: &'static str, from: &'static str, to: &'static str) -> Method {
        self.shader = Some(ShaderChange { module, from, to });
        self
    }

    /// The same over other geometry.
    #[must_use]
    pub const fn over(mut self, scene: Source) -> Method {
        self.scene = Some(scene);
        self
    }
}

/// A change of one shader module.
#[derive(Clone, Copy, Debug)]
pub struct ShaderChange {
    /// The module, without `.wgsl`.
    pub module: &'static str,
    /// Text that it has.
    pub from: &'static str,
    /// What stands there instead.
    pub to: &'static str,
}

/// A method that fails where ours does not.
#[derive(Clone, Copy, Debug)]
pub enum Contrast {
    /// As printed in the paper, or as the usual way is.
    Printed(Method),
    /// Ours with an error in it: shows that the case can fail where nothing was printed that does.
    Planted(Method),
}

impl Contrast {
    /// How it is drawn.
    pub fn method(&self) -> &Method {
        match self {
            Contrast::Printed(method) | Contrast::Planted(method) => method,
        }
    }
}

/// What is measured. *Exact* is what the `f64` oracle finds; samples that it calls ambiguous count neither way.
#[derive(Clone, Copy, Debug)]
pub enum Measure {
    /// Share of the exact fragments that no stored layer stands for, and of layers that stand for none.
    FragmentsLost,
    /// Share of fragments that are missing, invented, out of order, or off in part, side, depth, normal or material.
    LayersWrong,
    /// Share of neighbouring layers whose exact depths are in the opposite order, by part.
    OutOfOrder,
    /// Share of rasterized fragments that are neither stored nor counted as merged or dropped, as the books have it.
    Unaccounted,
    /// Largest angle between a stored and the exact normal.
    NormalError,
    /// Share of links that are not those that the oracle finds in the same store.
    LinksWrong,
    /// Share of links that are *missing*, and hence a rim, where whole lists in an unchanged and uncut picture do not say so.
    FalseRims,
    /// Share of links that differ from those of another scene with the same fragments.
    LinksUnlike(Source),
    /// Share of fragments whose κ differs by more than 0.01 from that in another scene with the same fragments.
    KappaUnlike(Source),
    /// Median error of κ₁ + κ₂ on a sphere of radius 1 where normal and sight line have this cosine.
    SphereCurvature(f64),
    /// Spread (90th less 10th percentile) of κ₁ + κ₂ over a cylinder of radius 1, where it is 1 everywhere.
    CurvatureSpread,
    /// κ₁ + κ₂ below which 99 % of a cylinder of radius 1 lie, where it is 1 everywhere.
    CurvaturePeak,
    /// Share of attempts to draw that are not refused with a reason.
    NotRefused,
    /// Largest difference of κ from the oracle's over the same store and links.
    KappaError,
    /// Largest error of a stored base colour, sRGB.
    ColorError,
    /// Largest error of lit colour from the oracle's light on the same store, sRGB.
    LightError,
    /// Largest error of stylized colour (sRGB) and opacity from the oracle's over the same store, light and κ.
    StyleError,
    /// Largest error of the picture, linear, from the `f64` composition of the same layers.
    BlendError,
    /// Mean error of the picture, linear, from the oracle's own picture, from the scene to the colour.
    PictureError,
    /// Share of pixels of which any bit differs from the picture of the exact capture.
    UnlikeExact,
    /// Share of pixels of which any bit differs between this many orders of drawing.
    OrderDependence(u32),
    /// Share of pixels that differ by more than 1/255 from the picture of another scene.
    PictureUnlike(Source),
    /// Share of links whose neighbour is linked elsewhere, or not at all.
    LinksOneWay,
    /// Largest error of a field of illustrative transparency from the oracle's over the same links and base opacity.
    FieldError,
    /// Largest error of illustrative opacity from what the oracle makes of the same fields.
    FieldOpacityError,
    /// Share of layers at which a halo begins or a highlight is stopped, in a picture in which nothing ends.
    Halos,
    /// Share of layers at which a halo begins, a highlight is stopped or a silhouette is seen, though no contour of any part passes
    /// within two pixels.
    HalosOffContours,
    /// Random scenes, as tiles of pictures, of which any stage differs from the oracle.
    RandomScenes,
}

impl Measure {
    /// What is counted, in a few words.
    pub fn what(&self) -> &'static str {
        match self {
            Measure::FragmentsLost => "fragments lost",
            Measure::LayersWrong => "layers wrong",
            Measure::OutOfOrder => "layers out of order",
            Measure::Unaccounted => "fragments unaccounted for",
            Measure::NormalError => "worst normal",
            Measure::LinksWrong => "neighbours wrong",
            Measure::FalseRims => "false rims",
            Measure::LinksUnlike(_) => "neighbours changed",
            Measure::KappaUnlike(_) => "curvature changed",
            Measure::SphereCurvature(_) => "curvature off",
            Measure::CurvatureSpread => "spread of curvature",
            Measure::CurvaturePeak => "peak of curvature",
            Measure::NotRefused => "not refused",
            Measure::KappaError => "worst κ",
            Measure::ColorError => "worst stored colour",
            Measure::LightError => "worst lit colour",
            Measure::StyleError => "worst styled colour",
            Measure::BlendError => "worst blended colour",
            Measure::PictureError => "mean error of the picture",
            Measure::UnlikeExact => "pixels unlike exact",
            Measure::OrderDependence(_) => "pixels by draw order",
            Measure::PictureUnlike(_) => "pixels changed",
            Measure::LinksOneWay => "links one way",
            Measure::FieldError => "worst field",
            Measure::FieldOpacityError => "worst opacity",
            Measure::Halos | Measure::HalosOffContours => "false halos",
            Measure::RandomScenes => "random scenes wrong",
        }
    }

    /// Unit of the figure, as written after it; empty for a plain number.
    pub fn unit(&self) -> &'static str {
        match self {
            Measure::FragmentsLost
            | Measure::LayersWrong
            | Measure::OutOfOrder
            | Measure::Unaccounted
            | Measure::LinksWrong
            | Measure::FalseRims
            | Measure::LinksUnlike(_)
            | Measure::KappaUnlike(_)
            | Measure::SphereCurvature(_)
            | Measure::UnlikeExact
            | Measure::NotRefused
            | Measure::OrderDependence(_)
            | Measure::LinksOneWay
            | Measure::Halos
            | Measure::HalosOffContours
            | Measure::PictureUnlike(_) => " %",
            Measure::NormalError => "°",
            Measure::ColorError
            | Measure::LightError
            | Measure::StyleError
            | Measure::BlendError
            | Measure::FieldOpacityError
            | Measure::PictureError => "/255",
            Measure::CurvatureSpread
            | Measure::CurvaturePeak
            | Measure::KappaError
            | Measure::FieldError
            | Measure::RandomScenes => "",
        }
    }
}
