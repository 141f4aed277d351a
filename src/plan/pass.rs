//! The passes of a frame, by name and in order.

use serde::Serialize;

/// Everything that can run in a frame, in the order in which it would; data storage comes before the buckets where it does
/// not need them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Pass {
    /// Nearest surfaces by the depth test, lit at once.
    Opaque,
    /// Brings the opaque pass's colours into the image.
    ShowOpaque,
    /// Empties the k-buffer's rows.
    Clear,
    /// The k nearest keys of every pixel (Murray 2016, step 1).
    ZInsertion,
    /// Layers stored, merged, dropped.
    CountLayers,
    /// Fragments of every pixel.
    Count,
    /// Linked lists, and how long they are (Carnecky 2013, section 4.2).
    Fill,
    /// Where each pixel's layers begin.
    PrefixSum,
    /// Keys and surfaces in order of arrival.
    Append,
    /// Order by depth.
    Sort,
    /// Surfaces in that order.
    Gather,
    /// The part of every layer.
    PartLookup,
    /// Layers by part (Murray 2016, step 2).
    ZReordering,
    /// Hash table of parts (Murray 2016, step 3).
    BucketCreation,
    /// Surfaces of the stored keys (Murray 2016, step 4).
    DataStorage,
    /// Where in its surface's parametrization every layer lies.
    Parametrize,
    /// Best candidate in each direction.
    NeighbourCandidates,
    /// Reverse check.
    NeighbourLinks,
    /// What section planes cut is unknown.
    CutLinks,
    /// Curvature.
    Curvature,
    /// Light.
    Shade,
    /// How many pixels of the whole image have how many layers.
    LayerHistogram,
    /// Colour and opacity by transfer functions.
    Stylize,
    /// Where silhouettes are (Carnecky 2013, section 5.3).
    Boundary,
    /// How long surfaces are, along rows and columns of pixels.
    FeatureSize,
    /// Silhouettes, halos and base opacity spread along the surface (section 5.4).
    Diffuse,
    /// Opacity out of the three fields (Algorithm 3).
    Illustrate,
    /// Composition.
    Blend,
    /// Pixels that the selected parts cover, whatever is in front.
    OutlineMask,
    /// A line around them.
    Outline,
    /// Average of jittered frames.
    Accumulate,
}

impl Pass {
    /// All passes, in order.
    pub const ALL: [Pass; 31] = [
        Pass::Opaque,
        Pass::ShowOpaque,
        Pass::Clear,
        Pass::ZInsertion,
        Pass::CountLayers,
        Pass::Count,
        Pass::Fill,
        Pass::PrefixSum,
        Pass::Append,
        Pass::Sort,
        Pass::Gather,
        Pass::PartLookup,
        Pass::ZReordering,
        Pass::BucketCreation,
        Pass::DataStorage,
        Pass::Parametrize,
        Pass::NeighbourCandidates,
        Pass::NeighbourLinks,
        Pass::CutLinks,
        Pass::Curvature,
        Pass::Shade,
        Pass::LayerHistogram,
        Pass::Stylize,
        Pass::Boundary,
        Pass::FeatureSize,
        Pass::Diffuse,
        Pass::Illustrate,
        Pass::Blend,
        Pass::OutlineMask,
        Pass::Outline,
        Pass::Accumulate,
    ];

    /// Name as in reports.
    pub fn name(self) -> &'static str {
        match self {
            Pass::Opaque => "opaque",
            Pass::ShowOpaque => "show opaque",
            Pass::Clear => "clear",
            Pass::ZInsertion => "z insertion",
            Pass::CountLayers => "count layers",
            Pass::Count => "count",
            Pass::Fill => "fill",
            Pass::PrefixSum => "prefix sum",
            Pass::Append => "append",
            Pass::Sort => "sort",
            Pass::Gather => "gather",
            Pass::PartLookup => "part lookup",
            Pass::ZReordering => "z reordering",
            Pass::BucketCreation => "bucket creation",
            Pass::DataStorage => "data storage",
            Pass::Parametrize => "parametrize",
            Pass::NeighbourCandidates => "neighbour candidates",
            Pass::NeighbourLinks => "neighbour links",
            Pass::CutLinks => "cut links",
            Pass::Curvature => "curvature",
            Pass::Shade => "shade",
            Pass::LayerHistogram => "layer histogram",
            Pass::Stylize => "stylize",
            Pass::Boundary => "boundary",
            Pass::FeatureSize => "feature size",
            Pass::Diffuse => "diffuse",
            Pass::Illustrate => "illustrate",
            Pass::Blend => "blend",
            Pass::OutlineMask => "outline mask",
            Pass::Outline => "outline",
            Pass::Accumulate => "accumulate",
        }
    }
}
