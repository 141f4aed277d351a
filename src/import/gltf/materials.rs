//! Materials, textures and samplers.

use gltf_json::material::Material as Source;
use gltf_json::texture::{Info, MagFilter, MinFilter, Sampler, WrappingMode};
use gltf_json::validation::Checked;
use gltf_json::{Index, Root};

use super::accessor::missing;
use super::images::Images;
use super::sources::Sources;
use super::{Fallible, Fault, Notices};
use crate::scene::{AlphaMode, Material, Mip, NoticeKind, Texture, TextureRef, Wrap};

/// A texture without an image: no material refers to it in the end.
const UNUSABLE: usize = usize::MAX;

/// All textures. One without an image has an image index of `usize::MAX`; [`read`] drops the references to it.
pub(super) fn textures(
    root: &Root,
    sources: &Sources,
    images: &Images,
    notices: &mut Notices,
) -> Fallible<Vec<Texture>> {
    let mut textures = Vec::new();
    for (i, texture) in root.textures.iter().enumerate() {
        let place = format!("textures[{i}]");
        let default = Sampler::default();
        let sampler = match texture.sampler {
            None => &default,
            Some(index) => root
                .samplers
                .get(index.value())
                .ok_or_else(|| missing(format!("{place}.sampler"), "sampler", index.value(), root.samplers.len()))?,
        };
        let shown = sources.of_texture.get(i).and_then(|offered| offered.first());
        let image = shown.and_then(|&image| images.numbers.get(image).copied().flatten()).unwrap_or_else(|| {
            notices.ignored(format!("{place}: it has no image that can be read, and is not shown"));
            UNUSABLE
        });
        let mut bad = false;
        let mut wrap = |mode: &Checked<WrappingMode>| match mode {
            Checked::Valid(WrappingMode::Repeat) => Wrap::Repeat,
            Checked::Valid(WrappingMode::MirroredRepeat) => Wrap::MirroredRepeat,
            Checked::Valid(WrappingMode::ClampToEdge) => Wrap::ClampToEdge,
            Checked::Invalid => {
                bad = true;
                Wrap::Repeat
            }
        };
        let wrap = [wrap(&sampler.wrap_s), wrap(&sampler.wrap_t)];
        let mag_linear = match sampler.mag_filter {
            None | Some(Checked::Valid(MagFilter::Linear)) => true,
            Some(Checked::Valid(MagFilter::Nearest)) => false,
            Some(Checked::Invalid) => {
                bad = true;
                true
            }
        };
        let (min_linear, mip) = match sampler.min_filter {
            None | Some(Checked::Valid(MinFilter::LinearMipmapLinear)) => (true, Mip::Linear),
            Some(Checked::Valid(MinFilter::Nearest)) => (false, Mip::None),
            Some(Checked::Valid(MinFilter::Linear)) => (true, Mip::None),
            Some(Checked::Valid(MinFilter::NearestMipmapNearest)) => (false, Mip::Nearest),
            Some(Checked::Valid(MinFilter::LinearMipmapNearest)) => (true, Mip::Nearest),
            Some(Checked::Valid(MinFilter::NearestMipmapLinear)) => (false, Mip::Linear),
            Some(Checked::Invalid) => {
                bad = true;
                (true, Mip::Linear)
            }
        };
        if bad {
            notices
                .repaired(format!("{place}.sampler: a filter or wrap mode that glTF does not have became the default"));
        }
        textures.push(Texture { image, wrap, mag_linear, min_linear, mip });
    }
    Ok(textures)
}

/// Drops textures without an image and renumbers the references.
pub(super) fn drop_unusable(textures: &mut Vec<Texture>, materials: &mut [Material]) {
    let mut kept = 0;
    let renumbered: Vec<Option<usize>> = textures
        .iter()
        .map(|t| {
            let usable = t.image != UNUSABLE;
            kept += usize::from(usable);
            usable.then(|| kept - 1)
        })
        .collect();
    textures.retain(|t| t.image != UNUSABLE);
    for material in materials {
        for slot in [
            &mut material.base_color_texture,
            &mut material.metallic_roughness_texture,
            &mut material.normal_texture,
            &mut material.occlusion_texture,
            &mut material.emissive_texture,
        ] {
            *slot = slot.and_then(|mut r| {
                r.texture = renumbered.get(r.texture).copied().flatten()?;
                Some(r)
            });
        }
    }
}

/// All materials of the file.
pub(super) fn read(root: &Root, textures: usize, notices: &mut Notices) -> Fallible<Vec<Material>> {
    let read = |(i, source)| Reader { place: format!("materials[{i}]"), textures, notices }.material(source);
    root.materials.iter().enumerate().map(read).collect()
}

struct Reader<'a> {
    place: String,
    textures: usize,
    notices: &'a mut Notices,
}

impl Reader<'_> {
    fn material(mut self, source: &Source) -> Fallible<Material> {
        let extensions = source.extensions.as_ref();
        let pbr = &source.pbr_metallic_roughness;
        let mut material = Material {
            name: source.name.clone().unwrap_or_default(),
            base_color: self.factors("pbrMetallicRoughness.baseColorFactor", pbr.base_color_factor.0, 1.0),
            metallic: self.factor("pbrMetallicRoughness.metallicFactor", pbr.metallic_factor.0, 1.0),
            roughness: self.factor("pbrMetallicRoughness.roughnessFactor", pbr.roughness_factor.0, 1.0),
            base_color_texture: self.texture("baseColorTexture", pbr.base_color_texture.as_ref())?,
            metallic_roughness_texture: self
                .texture("metallicRoughnessTexture", pbr.metallic_roughness_texture.as_ref())?,
            emissive: self.factors("emissiveFactor", source.emissive_factor.0, 1.0),
            emissive_texture: self.texture("emissiveTexture", source.emissive_texture.as_ref())?,
            alpha_mode: self.alpha(source),
            double_sided: source.double_sided,
            unlit: extensions.is_some_and(|e| e.unlit.is_some()),
            ..Material::default()
        };
        if let Some(normal) = &source.normal_texture {
            // The transform of these two is not among gltf-json's types.
            let others = normal.extensions.as_ref().map(|e| &e.others);
            let info =
                info(normal.index, normal.tex_coord, others).map_err(|e| self.bad_transform("normalTexture", &e))?;
            material.normal_texture = self.texture("normalTexture", Some(&info))?;
            material.normal_scale = self.finite("normalTexture.scale", normal.scale, 1.0);
        }
        if let Some(occlusion) = &source.occlusion_texture {
            let others = occlusion.extensions.as_ref().map(|e| &e.others);
            let info = info(occlusion.index, occlusion.tex_coord, others)
                .map_err(|e| self.bad_transform("occlusionTexture", &e))?;
            material.occlusion_texture = self.texture("occlusionTexture", Some(&info))?;
            material.occlusion_strength = self.factor("occlusionTexture.strength", occlusion.strength.0, 1.0);
        }
        if let Some(strength) = extensions.and_then(|e| e.emissive_strength.as_ref()) {
            let strength =
                self.factor("extensions.KHR_materials_emissive_strength", strength.emissive_strength.0, f32::MAX);
            material.emissive = material.emissive.map(|c| (c * strength).min(f32::MAX));
        }
        if let Some(old) = extensions.and_then(|e| e.pbr_specular_glossiness.as_ref()) {
            material.base_color = self.factors("extensions.diffuseFactor", old.diffuse_factor.0, 1.0);
            material.base_color_texture = self.texture("diffuseTexture", old.diffuse_texture.as_ref())?;
            material.metallic = 0.0;
            material.roughness = 1.0 - self.factor("extensions.glossinessFactor", old.glossiness_factor.0, 1.0);
            material.metallic_roughness_texture = None;
        }
        Ok(material)
    }

    fn alpha(&mut self, source: &Source) -> AlphaMode {
        use gltf_json::material::AlphaMode as Mode;
        let unused = source.alpha_cutoff.is_some() && source.alpha_mode != Checked::Valid(Mode::Mask);
        let what = "materials have an alphaCutoff but are not of the mode MASK; it does nothing";
        self.notices.count(NoticeKind::Ignored, what, unused.into(), &self.place);
        match source.alpha_mode {
            Checked::Valid(Mode::Opaque) => AlphaMode::Opaque,
            Checked::Valid(Mode::Blend) => AlphaMode::Blend,
            Checked::Valid(Mode::Mask) => {
                let cutoff = source.alpha_cutoff.map_or(0.5, |c| c.0);
                AlphaMode::Mask { cutoff: self.factor("alphaCutoff", cutoff, f32::MAX) }
            }
            Checked::Invalid => {
                self.notices.repaired(format!("{}.alphaMode: glTF has no such mode; shown as OPAQUE", self.place));
                AlphaMode::Opaque
            }
        }
    }

    /// A number in [0, `high`]; one outside is brought there and told.
    fn factor(&mut self, member: &str, value: f32, high: f32) -> f32 {
        if (0.0..=high).contains(&value) {
            return value;
        }
        let mended = if value.is_nan() { 0.0 } else { value.clamp(0.0, high) };
        self.notices.repaired(format!("{}.{member}: {value} is out of range and became {mended}", self.place));
        mended
    }

    fn factors<const N: usize>(&mut self, member: &str, values: [f32; N], high: f32) -> [f32; N] {
        values.map(|value| self.factor(member, value, high))
    }

    fn finite(&mut self, member: &str, value: f32, otherwise: f32) -> f32 {
        if value.is_finite() {
            return value;
        }
        self.notices.repaired(format!("{}.{member}: {value} is not finite and became {otherwise}", self.place));
        otherwise
    }

    fn bad_transform(&self, member: &str, error: &serde_json::Error) -> Fault {
        Fault::invalid(format!("{}.{member}.extensions.KHR_texture_transform", self.place), error.to_string())
    }

    fn texture(&mut self, member: &str, info: Option<&Info>) -> Fallible<Option<TextureRef>> {
        let Some(info) = info else { return Ok(None) };
        let place = format!("{}.{member}", self.place);
        let texture = info.index.value();
        if texture >= self.textures {
            return Err(missing(format!("{place}.index"), "texture", texture, self.textures));
        }
        let transform = info.extensions.as_ref().and_then(|e| e.texture_transform.as_ref());
        let uv_set = transform.and_then(|t| t.tex_coord).unwrap_or(info.tex_coord);
        if uv_set > 1 {
            self.notices.ignored(format!(
                "{place}: texture coordinate sets 0 and 1 are read, not {uv_set}; the texture is not shown"
            ));
            return Ok(None);
        }
        let mut uv_transform = TextureRef::IDENTITY;
        if let Some(transform) = transform {
            let ([x, y], [sx, sy]) = (transform.offset.0, transform.scale.0);
            let (sin, cos) = transform.rotation.0.sin_cos();
            // Translation · rotation · scale; a positive angle turns counter-clockwise in a v-down image.
            let rows = [[cos * sx, sin * sy, x], [-sin * sx, cos * sy, y]];
            if rows.iter().flatten().all(|c| c.is_finite()) {
                uv_transform = rows;
            } else {
                self.notices.repaired(format!("{place}: a texture transform that is not finite was dropped"));
            }
        }
        Ok(Some(TextureRef { texture, uv_set, uv_transform }))
    }
}

type Others = serde_json::Map<String, serde_json::Value>;

/// The common form of the two texture references that `gltf-json` types differently.
fn info(index: Index<gltf_json::Texture>, tex_coord: u32, others: Option<&Others>) -> Result<Info, serde_json::Error> {
    let mut extensions = gltf_json::extensions::texture::Info::default();
    if let Some(transform) = others.and_then(|o| o.get("KHR_texture_transform")) {
        extensions.texture_transform = Some(serde_json::from_value(transform.clone())?);
    }
    Ok(Info { index, tex_coord, extensions: Some(extensions), extras: None })
}
