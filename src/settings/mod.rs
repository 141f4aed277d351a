//! Everything that a user can choose, declared once.
//!
//! One declaration gives a setting its name, type, default, range and help text; the command line, the window and the
//! documentation are made from it ([`Settings::declarations`]). A setting is addressed by its dotted path, as in
//! `--set capture.bucketed_k_buffer.k=24`, and a settings file is the same tree as TOML, with anything left out at its
//! default. Nothing is clamped: a value out of range is refused with the range.

mod axis;
mod declare;
mod illustration;
pub mod looks;

use serde::{Deserialize, Serialize};

pub use crate::math::spelling::nearest;
pub use axis::{Axis, Effect, Knob, Technique, holds, text_at};
pub use declare::{Declaration, Range};
use declare::{choice, settings};
pub use illustration::{
    AlphaSettings, AngleSettings, BaseOpacity, BetaSettings, Diffusion, EqualShareSettings, GammaSettings,
    IllustrativeSettings, LengthUnit, PrintedForm, Profile, Steps, VariationSettings,
};

use crate::transfer::TransferSource;

choice! {
    /// How fragments are captured.
    pub enum CaptureKind {
        /// Count, prefix sum, append, sort: every layer, exactly. The default.
        #[default]
        Compacted = "compacted",
        /// The k nearest layers, bucketed by part (Murray 2016).
        BucketedKBuffer = "bucketed_k_buffer",
        /// A linked list a pixel, filled in one geometry pass: every layer, exactly (Carnecky 2013).
        LinkedList = "linked_list",
    }
}

choice! {
    /// How the linked list of a pixel is sorted. Both give the same answer.
    pub enum ListSort {
        /// By a network for its length, or by heap sort.
        #[default]
        ByLength = "by_length",
        /// The paper's: the list is walked once for every layer, for the nearest that is not placed yet.
        Selection = "selection",
    }
}

choice! {
    /// The fragment key of the Bucketed k-Buffer.
    pub enum KeyFormat {
        /// 32-bit depth over the instanced-triangle number: no two fragments of a pixel are equal.
        #[default]
        Wide64 = "wide64",
        /// The paper's: 16-bit depth over 16-bit shape id. Close layers of one part merge.
        Packed32 = "packed32",
    }
}

choice! {
    /// Which depth the 16 bits of a packed key hold.
    pub enum DepthQuantization {
        /// Distance along the view over the scene's depth range.
        #[default]
        Linear = "linear",
        /// The classic z/w, which spends nearly all steps near the eye.
        ZOverW = "z_over_w",
        /// Reversed z: near over distance.
        Reversed = "reversed",
    }
}

choice! {
    /// How a normal is packed.
    pub enum NormalEncoding {
        /// Octahedral, 16 + 16 bits: worst error 0.004°.
        #[default]
        Octahedral = "octahedral",
        /// The paper's x and y with 15 bits each and 2 for the sign of z: worst error 0.53°.
        Xy15 = "xy15",
        /// Three 32-bit floats, in twice the room: the reference's.
        Full = "full",
    }
}

choice! {
    /// What becomes of fragments behind the k nearest.
    pub enum Tail {
        /// They are counted and left out, as in the paper.
        #[default]
        None = "none",
        /// They are averaged, weighted by opacity, behind the stored layers. Independent of draw order.
        Average = "average",
    }
}

choice! {
    /// How the second geometry pass finds the slot of a fragment.
    pub enum SlotSearch {
        /// Binary search in the depth-ordered row.
        #[default]
        Depth = "depth",
        /// The paper's: the bucket of the shape by hashing, then binary search in it.
        Bucket = "bucket",
    }
}

choice! {
    /// How the neighbours of a fragment are searched.
    pub enum NeighbourSearch {
        /// Only the bucket of the same part is read.
        #[default]
        Buckets = "buckets",
        /// Every fragment of the neighbouring pixel is read.
        BruteForce = "brute_force",
    }
}

choice! {
    /// With which depth a candidate for a neighbour is compared.
    pub enum DepthTerm {
        /// The depth at which the layer's tangent plane crosses the neighbouring pixel, in pixels: thin walls stay apart (T18).
        #[default]
        Slope = "slope",
        /// The layer's own depth, as printed in Murray 2016, in radii of the part (T7).
        Printed = "printed",
        /// Carnecky 2013: the tangent plane, in radii of the part, not squared, the same both ways (T13).
        Continuity = "continuity",
        /// The same as printed: with its sign and one layer's slope, so that most links go one way (T13).
        ContinuityPrinted = "continuity_printed",
        /// Distance in the surface's own parametrization, its first texture coordinates; continuity where it has none.
        Parameters = "parameters",
    }
}

choice! {
    /// Which curvature drives the transfer functions.
    pub enum CurvatureKind {
        /// Curvature of the surface, the same from every side.
        #[default]
        Surface = "surface",
        /// The Hessian of depth, as printed (Vergne 2009): grows towards silhouettes.
        ViewCentred = "view_centred",
    }
}

choice! {
    /// The length in which curvature is measured: curvature times this length has no unit.
    pub enum CurvatureUnit {
        /// Visible height at the focal point: shapes are judged as large as they appear.
        #[default]
        View = "view",
        /// Radius of the part's bounding sphere.
        Part = "part",
        /// Radius of the scene's bounding sphere.
        Scene = "scene",
        /// One unit of the file.
        World = "world",
    }
}

choice! {
    /// How the opacity of a layer is found.
    pub enum OpacityModel {
        /// By transfer functions over curvature and depth (Murray 2016, section 5.2).
        Curvature = "curvature",
        /// The same everywhere.
        Constant = "constant",
        /// Opaque.
        Opaque = "opaque",
        /// The same accumulated opacity in every pixel, however many layers it has (Carnecky 2013, equation 5).
        Adaptive = "adaptive",
        /// By the angle between normal and sight line (Hummel 2010).
        AngleBased = "angle_based",
        /// By how fast the normal turns (Born 2010).
        NormalVariation = "normal_variation",
        /// Every layer index is seen as much as any other, over the whole image.
        EqualShare = "equal_share",
        /// Opaque silhouettes and clear halos behind them over another model (Carnecky 2013). The default.
        #[default]
        Illustrative = "illustrative",
    }
}

settings! {
    /// The Bucketed k-Buffer.
    pub struct BucketedKBufferSettings {
        /// Layers kept in each pixel.
        pub k: u32 = 16, Range::Integer(1, 64);
        /// Fragment key: wide and exact, or the paper's.
        pub key: KeyFormat = KeyFormat::Wide64, Range::Choice(KeyFormat::NAMES);
        /// Depth in the packed key. The wide key always holds 32-bit reversed depth.
        pub depth: DepthQuantization = DepthQuantization::Linear, Range::Choice(DepthQuantization::NAMES);
        /// How data storage finds the slot of a fragment. Both give the same answer.
        pub slot_search: SlotSearch = SlotSearch::Depth, Range::Choice(SlotSearch::NAMES);
        /// What becomes of the layers behind the k nearest.
        pub tail: Tail = Tail::None, Range::Choice(Tail::NAMES);
    }
}

settings! {
    /// Linked lists.
    pub struct LinkedListSettings {
        /// How lists are sorted. Both give the same answer.
        pub sort: ListSort = ListSort::ByLength, Range::Choice(ListSort::NAMES);
        /// Fragments for which room is made before their number is known; 0 for nine a pixel.
        pub capacity: u32 = 0, Range::Integer(0, 4_000_000_000);
        /// Most memory for lists and layers, MiB; what does not fit is made in bands.
        pub memory: u32 = 2048, Range::Integer(1, 1_048_576);
    }
}

settings! {
    /// Stage 1: the surface layers of every pixel.
    pub struct CaptureSettings {
        /// Capture technique.
        pub kind: CaptureKind = CaptureKind::Compacted, Range::Choice(CaptureKind::NAMES);
        /// How normals are stored.
        pub normals: NormalEncoding = NormalEncoding::Octahedral, Range::Choice(NormalEncoding::NAMES);
        /// Settings of the Bucketed k-Buffer.
        pub group bucketed_k_buffer: BucketedKBufferSettings;
        /// Settings of the linked lists.
        pub group linked_list: LinkedListSettings;
    }
}

settings! {
    /// Curvature of every layer.
    pub struct CurvatureSettings {
        /// Which curvature.
        pub kind: CurvatureKind = CurvatureKind::Surface, Range::Choice(CurvatureKind::NAMES);
        /// Unit of length of the scale.
        pub unit: CurvatureUnit = CurvatureUnit::View, Range::Choice(CurvatureUnit::NAMES);
        /// Sensitivity: κ = tanh(scale · unit · (κ₁ + κ₂)).
        pub scale: f64 = 0.03, Range::Real(0.0, 1000.0);
        /// Radius over which curvature is estimated, as a fraction of the image's shorter side. 0 uses the next pixels only.
        pub radius: f64 = 0.002, Range::Real(0.0, 0.05);
        /// Angle in degrees between neighbouring normals beyond which an edge is sharp: estimation does not reach across.
        pub crease_angle: f64 = 25.0, Range::Real(0.0, 180.0);
        /// Width of rims and creases, as a fraction of the image's shorter side.
        pub line_width: f64 = 0.0015, Range::Real(0.0, 0.02);
    }
}

settings! {
    /// Stage 2: what is computed from the layers.
    pub struct FeatureSettings {
        /// How the four neighbours of a layer are searched. Both give the same answer.
        pub neighbours: NeighbourSearch = NeighbourSearch::Buckets, Range::Choice(NeighbourSearch::NAMES);
        /// With which depth a candidate is compared.
        pub depth_term: DepthTerm = DepthTerm::Slope, Range::Choice(DepthTerm::NAMES);
        /// Whether a neighbour must see the layer as its own neighbour too (Murray 2016, Figure 5).
        pub reverse_check: bool = true, Range::Switch;
        /// Curvature.
        pub group curvature: CurvatureSettings;
    }
}

/// What is left of a ghosted part's opacity, unless another share is asked for.
pub const GHOST_OPACITY: f64 = 0.06;

settings! {
    /// Stage 3: opacity and colour of every layer.
    pub struct OpacitySettings {
        /// Opacity model.
        pub model: OpacityModel = OpacityModel::Illustrative, Range::Choice(OpacityModel::NAMES);
        /// Opacity of every layer under `constant`.
        pub constant: f64 = 0.3, Range::Real(0.0, 1.0);
        /// Transfer functions under `curvature`: a name from `transfer_functions/` or a path.
        pub transfer: TransferSource = TransferSource::default(), Range::Text;
        /// Multiplies what the opacity transfer function gives.
        pub gain: f64 = 1.0, Range::Real(0.0, 8.0);
        /// Multiplies the opacity of ghosted parts, lines included.
        pub ghost: f64 = GHOST_OPACITY, Range::Real(0.0, 1.0);
        /// Opacity of all layers of a pixel together under `adaptive`.
        pub adaptive: f64 = 0.7, Range::Real(0.0, 1.0);
        /// Angle-based opacity.
        pub group angle: AngleSettings;
        /// Opacity by normal variation.
        pub group variation: VariationSettings;
        /// Equal shares.
        pub group equal_share: EqualShareSettings;
        /// Illustrative transparency.
        pub group illustrative: IllustrativeSettings;
    }
}

settings! {
    /// Light on the layers: a key, a fill and a rim light that move with the camera, and light from above and below.
    pub struct LightSettings {
        /// Brightness of everything.
        pub exposure: f64 = 1.0, Range::Real(0.0, 16.0);
        /// Brightness of the key light.
        pub key: f64 = 2.0, Range::Real(0.0, 32.0);
        /// Brightness of the fill light.
        pub fill: f64 = 0.7, Range::Real(0.0, 32.0);
        /// Brightness of the rim light.
        pub rim: f64 = 1.0, Range::Real(0.0, 32.0);
        /// Brightness of the light from all around.
        pub ambient: f64 = 1.0, Range::Real(0.0, 32.0);
    }
}

settings! {
    /// The line around what is selected.
    pub struct OutlineSettings {
        /// Colour: `#rrggbb`.
        pub color: String = "#ffb000".to_owned(), Range::Color { or_none: false };
        /// Width in pixels.
        pub width: f64 = 2.0, Range::Real(1.0, 16.0);
    }
}

settings! {
    /// The picture.
    pub struct ImageSettings {
        /// Background: `none` for transparent, or `#rrggbb`.
        pub background: String = "#262b33".to_owned(), Range::Color { or_none: true };
        /// Frames averaged for one picture, each shifted by a fraction of a pixel.
        pub samples: u32 = 1, Range::Integer(1, 1024);
    }
}

settings! {
    /// Everything that a user can choose about a picture, except what is looked at and from where.
    pub struct Settings {
        /// Stage 1.
        pub group capture: CaptureSettings;
        /// Stage 2.
        pub group features: FeatureSettings;
        /// Stage 3.
        pub group opacity: OpacitySettings;
        /// Light.
        pub group light: LightSettings;
        /// The line around what is selected.
        pub group outline: OutlineSettings;
        /// The picture.
        pub group image: ImageSettings;
    }
}

/// Why settings were refused.
#[derive(Debug, thiserror::Error)]
pub enum SettingsError {
    /// No setting has this path.
    #[error("no setting is called '{path}'{}", nearest.as_ref().map(|n| format!("; did you mean '{n}'?")).unwrap_or_default())]
    Unknown {
        /// The path that was given.
        path: String,
        /// The closest existing path.
        nearest: Option<String>,
    },
    /// The value is outside the declared range or of the wrong type.
    #[error("{path} = {value}: expected {expected}")]
    Value {
        /// Path of the setting.
        path: String,
        /// The value that was given.
        value: String,
        /// What the declaration allows.
        expected: String,
    },
    /// A settings file is not valid TOML or does not have the tree of the settings.
    #[error("settings: {0}")]
    Syntax(String),
}

impl OpacitySettings {
    /// The model that gives each layer its opacity, before illustrative transparency acts on it.
    pub fn base_model(&self) -> OpacityModel {
        match self.model {
            OpacityModel::Illustrative => self.illustrative.base.model(),
            model => model,
        }
    }

    /// Makes the transfer functions count: as the base of illustrative transparency if that is the model, or as the model.
    pub fn follow_transfer(&mut self) {
        match self.model {
            OpacityModel::Illustrative => self.illustrative.base = BaseOpacity::Curvature,
            _ => self.model = OpacityModel::Curvature,
        }
    }
}

impl Settings {
    /// All settings: path, range, default and help, in the order of the stages.
    pub fn declarations() -> Vec<Declaration> {
        let mut all = Vec::new();
        Settings::declare("", &mut all);
        all
    }

    /// Reads a settings file: TOML with the tree of this struct, anything left out at its default.
    ///
    /// # Errors
    /// [`SettingsError`] for bad syntax, unknown names and values out of range.
    pub fn from_toml(text: &str) -> Result<Settings, SettingsError> {
        let table: toml::Table =
            toml::from_str(text).map_err(|e| SettingsError::Syntax(e.to_string().trim().to_owned()))?;
        let mut settings = Settings::default();
        settings.merge(&table)?;
        Ok(settings)
    }

    /// The defaults, with values from `path=value` pairs separated by spaces.
    ///
    /// # Errors
    /// [`SettingsError`] for unknown names and values out of range.
    pub fn from_pairs(pairs: &str) -> Result<Settings, SettingsError> {
        let mut settings = Settings::default();
        for pair in pairs.split_whitespace() {
            let (path, value) = pair.split_once('=').unwrap_or((pair, ""));
            settings.set(path, value)?;
        }
        Ok(settings)
    }

    /// Writes the whole tree as TOML.
    ///
    /// # Errors
    /// [`SettingsError::Syntax`] if a value has no TOML form; no setting does today.
    pub fn to_toml(&self) -> Result<String, SettingsError> {
        toml::to_string_pretty(self).map_err(|e| SettingsError::Syntax(e.to_string()))
    }

    /// Takes over every value that `table` has, and checks it.
    ///
    /// # Errors
    /// [`SettingsError`] for unknown names and values out of range; `self` is unchanged then.
    pub fn merge(&mut self, table: &toml::Table) -> Result<(), SettingsError> {
        let mut next = self.clone();
        declare::for_each_leaf(table, &Settings::declarations(), &mut |path, value| {
            next = next.with(path, value.clone())?;
            Ok(())
        })?;
        *self = next;
        Ok(())
    }

    /// Sets one value by its path from text, as in `--set path=value`.
    ///
    /// # Errors
    /// [`SettingsError`] if the path is unknown or the value is not allowed.
    pub fn set(&mut self, path: &str, text: &str) -> Result<(), SettingsError> {
        let declaration = declare::find(path, &Settings::declarations())?;
        let value = declaration.parse(text)?;
        *self = self.with(path, value)?;
        Ok(())
    }

    /// The value at a path, as TOML.
    pub fn get(&self, path: &str) -> Option<toml::Value> {
        let tree = toml::Value::try_from(self).ok()?;
        path.split('.').try_fold(&tree, |at, key| at.get(key)).cloned()
    }

    fn with(&self, path: &str, value: toml::Value) -> Result<Settings, SettingsError> {
        let declaration = declare::find(path, &Settings::declarations())?;
        let value = declaration.check(value)?;
        let syntax = |e: &dyn std::fmt::Display| SettingsError::Syntax(format!("{path}: {e}"));
        let mut tree = toml::Value::try_from(self).map_err(|e| syntax(&e))?;
        let mut at = &mut tree;
        for key in path.split('.') {
            at = at.get_mut(key).ok_or_else(|| SettingsError::Unknown { path: path.to_owned(), nearest: None })?;
        }
        *at = value;
        tree.try_into().map_err(|e: toml::de::Error| syntax(&e))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_default_is_in_its_range_and_round_trips() {
        let settings = Settings::default();
        for declaration in Settings::declarations() {
            let value = settings.get(&declaration.path).expect(&declaration.path);
            declaration.check(value.clone()).expect(&declaration.path);
            assert_eq!(value.to_string(), declaration.default.to_string(), "{}", declaration.path);
            assert!(!declaration.help.is_empty(), "{}", declaration.path);
            let mut other = settings.clone();
            other.set(&declaration.path, &declaration.another()).expect(&declaration.path);
            assert_ne!(other, settings, "{}", declaration.path);
        }
        assert_eq!(Settings::from_toml(&settings.to_toml().unwrap()).unwrap(), settings);
    }

    #[test]
    fn out_of_range_and_unknown_are_refused_by_name() {
        let mut settings = Settings::default();
        settings.set("capture.bucketed_k_buffer.k", "64").unwrap();
        let e = settings.set("capture.bucketed_k_buffer.k", "65").unwrap_err().to_string();
        assert!(e.contains("capture.bucketed_k_buffer.k") && e.contains("1 to 64"), "{e}");
        let e = settings.set("capture.bucketed_k_bufer.k", "3").unwrap_err().to_string();
        assert!(e.contains("did you mean 'capture.bucketed_k_buffer.k'"), "{e}");
        let e = settings.set("opacity.model", "glass").unwrap_err().to_string();
        assert!(e.contains("curvature, constant, opaque"), "{e}");
        let e = settings.set("opacity.constant", "NaN").unwrap_err().to_string();
        assert!(e.contains("opacity.constant"), "{e}");
        assert_eq!(settings.capture.bucketed_k_buffer.k, 64);
    }

    #[test]
    fn what_is_no_colour_is_refused_by_path_and_value() {
        let mut settings = Settings::default();
        for (path, bad) in [("image.background", "blue"), ("image.background", "#12345"), ("outline.color", "none")] {
            let said = settings.set(path, bad).unwrap_err().to_string();
            assert!(said.contains(path) && said.contains(bad) && said.contains("#rrggbb"), "{said}");
            let said = Settings::from_toml(&format!("{path} = '{bad}'")).unwrap_err().to_string();
            assert!(said.contains(path) && said.contains(bad), "{said}");
        }
        assert_eq!(settings, Settings::default());
        settings.set("image.background", "none").unwrap();
        settings.set("outline.color", "#0A0b0c").unwrap();
    }

    #[test]
    fn integers_are_accepted_where_reals_are_meant() {
        let mut settings = Settings::default();
        settings.set("opacity.constant", "1").unwrap();
        assert_eq!(settings.opacity.constant, 1.0);
        assert_eq!(Settings::from_toml("opacity.constant = 1").unwrap().opacity.constant, 1.0);
    }
}
