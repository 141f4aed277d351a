//! Material files, and how a material of Phong's day becomes a metallic-roughness one.
//!
//! | MTL | here |
//! |---|---|
//! | `Kd`, `map_Kd` | base colour, from sRGB; 0.8 where `Kd` is missing. Black under a texture is taken for white |
//! | `Ks` with a black `Kd` and no `map_Kd` | a metal of that colour: Phong's way to say so |
//! | `Ns` | roughness (2 / (Ns + 2))^¼, which gives the highlight of the microfacet model the same width; 1 where `Ks` is black, 0.5 where there is no `Ns` |
//! | `Pr`, `map_Pr`; `Pm`, `map_Pm` | roughness; metalness (they count more than the two above) |
//! | `Ke`, `map_Ke` | emitted light |
//! | `d`, else 1 − `Tr`; `map_d` | opacity; what would be wholly invisible is shown opaque, since writers confuse the two |
//! | `norm`, `map_Kn`, `map_Bump`, `bump` | normal map; a height map becomes one |
//! | `-s`, `-o`, `-bm`, `-clamp`, `-imfchan` | scale, offset, strength, clamping, channel of a map |
//!
//! Everything else (`Ka`, `Ni`, `Tf`, `illum`, `map_Ks`, `refl`, sheen, clear coat …) has no counterpart; which of them a file
//! uses is told in one sentence.

use std::collections::hash_map::Entry;
use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::path::Path;
use std::sync::Arc;

use super::statements::Model;
use super::textures::{Alpha, Textures};
use crate::import::text::{first_word, lines, name, number, words};
use crate::import::triangles::{linear_color, plain_material};
use crate::import::{Fallible, Fault, ImportOptions, Notices, uri};
use crate::scene::{AlphaMode, Image, Material, NoticeKind, Texture};

/// The materials of a file, in the order of [`Model::materials`], with what they refer to.
pub(super) struct Looks {
    pub(super) materials: Vec<Material>,
    pub(super) textures: Vec<Texture>,
    pub(super) images: Vec<Arc<Image>>,
}

/// What a map is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Slot {
    Color,
    Opacity,
    Emission,
    Roughness,
    Metalness,
    Normal,
    Bump,
}

/// A map: a file and how it is used.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Map {
    pub(super) file: String,
    pub(super) scale: [f32; 2],
    pub(super) offset: [f32; 2],
    pub(super) strength: f32,
    pub(super) clamp: bool,
    /// From `-imfchan`: `m` for the alpha channel, `l` for luminance.
    pub(super) channel: Option<u8>,
}

/// A material as written.
#[derive(Debug, Default)]
pub(super) struct Source {
    diffuse: Option<[f32; 3]>,
    specular: Option<[f32; 3]>,
    emission: Option<[f32; 3]>,
    exponent: Option<f32>,
    opacity: Option<f32>,
    transparency: Option<f32>,
    roughness: Option<f32>,
    metalness: Option<f32>,
    pub(super) maps: BTreeMap<Slot, Map>,
}

/// Reads the material files that `model` names and converts the materials that it uses.
pub(super) fn read(
    model: &Model,
    folder: Option<&Path>,
    options: &ImportOptions,
    notices: &mut Notices,
) -> Fallible<Looks> {
    let mut sources: HashMap<String, Source> = HashMap::new();
    let mut read = BTreeSet::new();
    for library in &model.libraries {
        for (file, bytes) in library_files(library, folder, options, notices)? {
            if read.insert(file) {
                parse(&bytes, &mut sources, notices);
            }
        }
    }
    let used = model.materials.iter().filter_map(|m| sources.get(m));
    let files = used.flat_map(|s| s.maps.values()).map(|m| m.file.clone());
    let mut textures = Textures::read(files.collect(), folder, options, notices)?;
    let mut materials = Vec::new();
    let mut missing = Vec::new();
    for name in &model.materials {
        let material = match sources.get(name) {
            Some(source) => convert(source, name, &mut textures, notices)?,
            None => {
                missing.extend((!name.is_empty()).then_some(name.as_str()));
                plain_material()
            }
        };
        materials.push(Material { name: name.clone(), ..material });
    }
    if !missing.is_empty() {
        let more = if missing.len() > 5 { ", …" } else { "" };
        let listed = missing.iter().take(5).map(|m| format!("'{m}'")).collect::<Vec<_>>().join(", ");
        notices.ignored(format!("no material file defines {listed}{more} ({} materials): shown grey", missing.len()));
    }
    let (textures, images) = textures.into_parts();
    Ok(Looks { materials, textures, images })
}

/// The files that one `mtllib` names: one whose name may have spaces, or several.
fn library_files(
    library: &[u8],
    folder: Option<&Path>,
    options: &ImportOptions,
    notices: &mut Notices,
) -> Fallible<Vec<(String, Vec<u8>)>> {
    let open = |file: &str| uri::file(file, "mtllib", folder, options.limits.bytes, &|_| options.cancel.go_on());
    let whole = name(library);
    let several: Vec<String> = words(library).map(name).collect();
    let mut found = Vec::new();
    match open(&whole) {
        Ok(bytes) => found.push((whole, bytes)),
        Err(fault) if several.len() < 2 => untold(fault, notices)?,
        Err(_) => {
            for file in several {
                match open(&file) {
                    Ok(bytes) => found.push((file, bytes)),
                    Err(fault) => untold(fault, notices)?,
                }
            }
        }
    }
    Ok(found)
}

/// A file without which the model is still worth seeing.
fn untold(fault: Fault, notices: &mut Notices) -> Fallible<()> {
    let said = match fault {
        Fault::Io { place, source } => format!("{place}: {source}"),
        Fault::Invalid { place, cause } => format!("{place}: {cause}"),
        other => return Err(other),
    };
    notices.ignored(format!("{said}; its materials are shown grey"));
    Ok(())
}

/// Adds the materials of a file. Of two with one name the first counts.
fn parse(bytes: &[u8], sources: &mut HashMap<String, Source>, notices: &mut Notices) {
    let mut current: Option<(String, Source)> = None;
    let mut others: BTreeSet<String> = BTreeSet::new();
    let (mut bad, mut outside) = (0, 0);
    let mut keep = |material: Option<(String, Source)>, notices: &mut Notices| {
        let Some((name, source)) = material else { return };
        match sources.entry(name) {
            Entry::Occupied(first) => {
                let what = "materials are defined twice; the first definition counts";
                notices.count(NoticeKind::Ignored, what, 1, first.key());
            }
            Entry::Vacant(free) => {
                free.insert(source);
            }
        }
    };
    for (_, line) in lines(bytes) {
        let Some((word, rest)) = first_word(line).filter(|(word, _)| !word.starts_with(b"#")) else { continue };
        if word.eq_ignore_ascii_case(b"newmtl") {
            keep(current.replace((name(rest), Source::default())), notices);
            continue;
        }
        let Some((_, source)) = &mut current else {
            outside += 1;
            continue;
        };
        match source.statement(word, rest) {
            Outcome::Taken => {}
            Outcome::Bad => bad += 1,
            Outcome::Unknown if others.len() < 20 => {
                others.insert(name(word));
            }
            Outcome::Unknown => {}
        }
    }
    keep(current, notices);
    notices.count(NoticeKind::Repaired, "statements of materials make no sense and were skipped", bad, "mtllib");
    notices.count(NoticeKind::Ignored, "statements stand before any 'newmtl'", outside, "mtllib");
    if !others.is_empty() {
        let listed = others.into_iter().collect::<Vec<_>>().join(", ");
        notices.ignored(format!("materials: {listed} have no counterpart in metallic-roughness materials"));
    }
}

enum Outcome {
    Taken,
    Bad,
    Unknown,
}

impl Source {
    fn statement(&mut self, word: &[u8], rest: &[u8]) -> Outcome {
        let lower = word.to_ascii_lowercase();
        let slot = match lower.as_slice() {
            b"map_kd" => Some(Slot::Color),
            b"map_d" | b"map_opacity" => Some(Slot::Opacity),
            b"map_ke" | b"map_emissive" => Some(Slot::Emission),
            b"map_pr" => Some(Slot::Roughness),
            b"map_pm" => Some(Slot::Metalness),
            b"norm" | b"map_kn" => Some(Slot::Normal),
            b"map_bump" | b"bump" => Some(Slot::Bump),
            _ => None,
        };
        if let Some(slot) = slot {
            return match Map::parse(rest) {
                Some(map) => {
                    self.maps.insert(slot, map);
                    Outcome::Taken
                }
                None => Outcome::Bad,
            };
        }
        let taken = match lower.as_slice() {
            b"kd" => color(rest).map(|c| self.diffuse = Some(c)),
            b"ks" => color(rest).map(|c| self.specular = Some(c)),
            b"ke" => color(rest).map(|c| self.emission = Some(c)),
            b"ns" => value(rest).map(|v| self.exponent = Some(v)),
            // `d -halo 0.5`: opaque where it is seen from the side.
            b"d" => value(rest.strip_prefix(b"-halo").unwrap_or(rest)).map(|v| self.opacity = Some(v)),
            b"tr" => value(rest).map(|v| self.transparency = Some(v)),
            b"pr" => value(rest).map(|v| self.roughness = Some(v)),
            b"pm" => value(rest).map(|v| self.metalness = Some(v)),
            _ => return Outcome::Unknown,
        };
        if taken.is_some() { Outcome::Taken } else { Outcome::Bad }
    }
}

fn value(rest: &[u8]) -> Option<f32> {
    let value = number(words(rest).next()?)? as f32;
    value.is_finite().then_some(value)
}

/// `r g b`, or one number for all three.
fn color(rest: &[u8]) -> Option<[f32; 3]> {
    let mut values = words(rest).map_while(number).map(|c| c as f32);
    let red = values.next()?;
    let (green, blue) = (values.next().unwrap_or(red), values.next().unwrap_or(red));
    [red, green, blue].iter().all(|c| c.is_finite()).then_some([red, green, blue])
}

/// No scale, offset or strength of a texture is larger.
const LARGEST: f64 = 1e9;

impl Map {
    /// Options, then a file name, which may have spaces.
    pub(super) fn parse(rest: &[u8]) -> Option<Map> {
        let mut map =
            Map { file: String::new(), scale: [1.0; 2], offset: [0.0; 2], strength: 1.0, clamp: false, channel: None };
        let mut rest = rest;
        while let Some((option, after)) = first_word(rest).filter(|(word, _)| word.starts_with(b"-")) {
            rest = after;
            let mut take = |most: usize| {
                let mut values = Vec::new();
                while let Some((word, after)) = first_word(rest).filter(|_| values.len() < most) {
                    // A name may begin with a digit: the last word is never an option's value.
                    let sound = |v: &f64| v.abs() <= LARGEST && !after.is_empty();
                    let Some(value) = number(word).filter(sound) else { break };
                    values.push(value as f32);
                    rest = after;
                }
                values
            };
            match option.to_ascii_lowercase().as_slice() {
                b"-s" => pair(&take(3)).into_iter().for_each(|s| map.scale = s),
                b"-o" => pair(&take(3)).into_iter().for_each(|o| map.offset = o),
                b"-t" => drop(take(3)),
                b"-mm" => drop(take(2)),
                b"-bm" => take(1).into_iter().for_each(|b| map.strength = b),
                b"-boost" | b"-texres" => drop(take(1)),
                b"-clamp" | b"-blendu" | b"-blendv" | b"-cc" | b"-imfchan" | b"-type" | b"-colorspace" => {
                    let (word, after) = first_word(rest)?;
                    rest = after;
                    if option.eq_ignore_ascii_case(b"-clamp") {
                        map.clamp = word.eq_ignore_ascii_case(b"on");
                    } else if option.eq_ignore_ascii_case(b"-imfchan") {
                        map.channel = word.first().map(u8::to_ascii_lowercase);
                    }
                }
                _ => return None,
            }
        }
        map.file = name(rest.strip_prefix(b"\"").and_then(|r| r.strip_suffix(b"\"")).unwrap_or(rest));
        (!map.file.is_empty()).then_some(map)
    }
}

fn pair(values: &[f32]) -> Option<[f32; 2]> {
    match *values {
        [] => None,
        [u] => Some([u, 1.0]),
        [u, v, ..] => Some([u, v]),
    }
}

/// The table above.
fn convert(source: &Source, name: &str, textures: &mut Textures, notices: &mut Notices) -> Fallible<Material> {
    let maps = &source.maps;
    let black = |c: Option<[f32; 3]>| c.is_some_and(|c| c.iter().all(|v| *v <= 0.0));
    let mut diffuse = source.diffuse.unwrap_or(if maps.contains_key(&Slot::Color) { [1.0; 3] } else { [0.8; 3] });
    if maps.contains_key(&Slot::Color) && black(source.diffuse) {
        diffuse = [1.0; 3];
        notices.repaired(format!("material '{name}': black under a texture is taken for white"));
    }
    let shiny = source.specular.filter(|c| c.iter().any(|v| *v > 0.0));
    let metal = shiny.filter(|_| !maps.contains_key(&Slot::Color) && black(source.diffuse));
    let specular_roughness = match (shiny, source.exponent) {
        (None, _) => 1.0,
        (Some(_), None) => 0.5,
        (Some(_), Some(exponent)) => (2.0 / (exponent.max(0.0) + 2.0)).powf(0.25),
    };
    let mut alpha = source.opacity.or(source.transparency.map(|t| 1.0 - t)).unwrap_or(1.0).clamp(0.0, 1.0);
    if alpha == 0.0 {
        notices.repaired(format!("material '{name}' is wholly transparent, which is taken for opaque"));
        alpha = 1.0;
    }
    let [r, g, b] = metal.unwrap_or(diffuse);
    let [er, eg, eb] = match source.emission {
        None if maps.contains_key(&Slot::Emission) => [1.0; 3],
        emission if black(emission) && maps.contains_key(&Slot::Emission) => [1.0; 3],
        emission => emission.unwrap_or([0.0; 3]),
    };
    // Above 1 a colour is light, not an encoded colour.
    let emitted = |c: f32| if c > 1.0 { c } else { linear_color([c; 4])[0] };
    let emissive = [er, eg, eb].map(emitted);
    let mut material = Material {
        base_color: linear_color([r, g, b, alpha]),
        metallic: source.metalness.unwrap_or(if metal.is_some() { 1.0 } else { 0.0 }).clamp(0.0, 1.0),
        roughness: source.roughness.unwrap_or(specular_roughness).clamp(0.0, 1.0),
        emissive,
        alpha_mode: if alpha < 1.0 { AlphaMode::Blend } else { AlphaMode::Opaque },
        double_sided: true,
        ..Material::default()
    };
    let opacity = maps.get(&Slot::Opacity);
    match textures.colored(maps.get(&Slot::Color), opacity)? {
        Some((texture, Alpha::FromMap)) => {
            material.base_color_texture = Some(texture);
            material.alpha_mode = AlphaMode::Blend;
        }
        Some((texture, Alpha::Opaque)) => material.base_color_texture = Some(texture),
        None => {}
    }
    if let Some(map) = maps.get(&Slot::Emission) {
        material.emissive_texture = textures.plain(map);
    }
    let (rough, metallic) = (maps.get(&Slot::Roughness), maps.get(&Slot::Metalness));
    if let Some(texture) = textures.rough_and_metallic(rough, metallic)? {
        material.metallic_roughness_texture = Some(texture);
        // A map without its factor is meant as it is.
        material.roughness = if rough.is_some() { source.roughness.unwrap_or(1.0) } else { material.roughness };
        material.metallic = if metallic.is_some() { source.metalness.unwrap_or(1.0) } else { material.metallic };
    }
    let (normal, bump) = (maps.get(&Slot::Normal), maps.get(&Slot::Bump));
    if let Some((texture, scale)) = textures.normal(normal, bump, notices)? {
        material.normal_texture = Some(texture);
        material.normal_scale = scale;
    }
    Ok(material)
}
