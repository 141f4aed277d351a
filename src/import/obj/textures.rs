//! The images that materials name, and those that are made of them: opacity joined to colour, roughness to metalness, heights
//! turned into normals. All lie in the model's folder.

use std::collections::{BTreeSet, HashMap};
use std::path::Path;
use std::sync::Arc;

use glam::Vec3;
use rayon::prelude::*;

use super::mtl::Map;
use crate::import::images::{Lost, decode, dimensions};
use crate::import::{Cancel, Fallible, Fault, ImportOptions, Notices, uri};
use crate::scene::{Image, Mip, NoticeKind, Texture, TextureRef, Wrap};

/// Whether a colour's texture has opacity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Alpha {
    Opaque,
    FromMap,
}

/// Images and textures in the making.
pub(super) struct Textures {
    images: Vec<Arc<Image>>,
    textures: Vec<Texture>,
    /// From a file's name as written to its image.
    files: HashMap<String, usize>,
    /// From what an image was made of to the image.
    made: HashMap<String, usize>,
    /// From image and clamping to texture.
    known: HashMap<(usize, bool), usize>,
    pixels: u64,
    most_pixels: u64,
}

impl Textures {
    /// Reads and decodes the files. One that cannot be had is told and left out.
    pub(super) fn read(
        files: BTreeSet<String>,
        folder: Option<&Path>,
        options: &ImportOptions,
        notices: &mut Notices,
    ) -> Fallible<Textures> {
        let mut textures = Textures {
            images: Vec::new(),
            textures: Vec::new(),
            files: HashMap::new(),
            made: HashMap::new(),
            known: HashMap::new(),
            pixels: 0,
            most_pixels: options.limits.image_pixels,
        };
        let mut encoded = Vec::new();
        let mut bytes_left = options.limits.bytes;
        for file in files {
            options.cancel.go_on()?;
            let found = find(&file, folder, bytes_left, &options.cancel, notices);
            bytes_left -= found.as_ref().map_or(0, |bytes| bytes.len() as u64);
            let sized = found.and_then(|bytes| {
                let (width, height) = dimensions(&bytes, &format!("texture {file:?}"), &options.limits)?;
                Ok((bytes, u64::from(width) * u64::from(height)))
            });
            match sized {
                Ok((bytes, pixels)) => {
                    textures.room(pixels, &file)?;
                    encoded.push((file, bytes));
                }
                Err(fault) => left_out(fault, notices)?,
            }
        }
        let decoded: Vec<Fallible<(Image, Lost)>> = encoded
            .par_iter()
            .map(|(file, bytes)| {
                options.cancel.go_on()?;
                decode(bytes, &format!("texture {file:?}"), &options.limits)
            })
            .collect();
        for ((file, _), result) in encoded.into_iter().zip(decoded) {
            match result {
                Ok((mut image, lost)) => {
                    let what = "images of 16 bits a channel were reduced to 8";
                    notices.count(NoticeKind::Approximated, what, lost.deep.into(), &file);
                    let what = "images bring a colour profile, which is not applied";
                    notices.count(NoticeKind::Ignored, what, lost.profile.into(), &file);
                    image.name = file.clone();
                    textures.images.push(Arc::new(image));
                    textures.files.insert(file, textures.images.len() - 1);
                }
                Err(fault) => left_out(fault, notices)?,
            }
        }
        Ok(textures)
    }

    /// Textures and images that materials use.
    pub(super) fn into_parts(mut self) -> (Vec<Texture>, Vec<Arc<Image>>) {
        // Those that only went into others are not needed.
        let mut kept = Vec::new();
        let mut moved: HashMap<usize, usize> = HashMap::new();
        for texture in &mut self.textures {
            texture.image = *moved.entry(texture.image).or_insert_with(|| {
                kept.push(self.images[texture.image].clone());
                kept.len() - 1
            });
        }
        (self.textures, kept)
    }

    fn room(&mut self, pixels: u64, place: &str) -> Fallible<()> {
        self.pixels = self.pixels.saturating_add(pixels);
        if self.pixels > self.most_pixels {
            return Err(Fault::limit(place, "pixels of images", self.pixels, self.most_pixels));
        }
        Ok(())
    }

    fn image(&self, map: &Map) -> Option<(usize, Arc<Image>)> {
        let &index = self.files.get(&map.file)?;
        Some((index, self.images[index].clone()))
    }

    fn reference(&mut self, image: usize, map: &Map) -> TextureRef {
        let wrap = if map.clamp { Wrap::ClampToEdge } else { Wrap::Repeat };
        let texture = *self.known.entry((image, map.clamp)).or_insert_with(|| {
            self.textures.push(Texture {
                image,
                wrap: [wrap; 2],
                mag_linear: true,
                min_linear: true,
                mip: Mip::Linear,
            });
            self.textures.len() - 1
        });
        // In MTL v' = s·v + o with v up; here v is 1 − v.
        let ([su, sv], [ou, ov]) = (map.scale, map.offset);
        let uv_transform = [[su, 0.0, ou], [0.0, sv, 1.0 - sv - ov]];
        TextureRef { texture, uv_set: 0, uv_transform }
    }

    /// An image made of others, once for each `key`.
    fn make(&mut self, key: String, size: [u32; 2], pixel: impl Fn(u32, u32) -> [u8; 4] + Sync) -> Fallible<usize> {
        if let Some(&known) = self.made.get(&key) {
            return Ok(known);
        }
        let [width, height] = size;
        self.room(u64::from(width) * u64::from(height), &key)?;
        let mut rgba = vec![0; 4 * width as usize * height as usize];
        rgba.par_chunks_exact_mut(4 * width as usize).enumerate().for_each(|(y, row)| {
            for (x, out) in row.chunks_exact_mut(4).enumerate() {
                out.copy_from_slice(&pixel(x as u32, y as u32));
            }
        });
        self.images.push(Arc::new(Image { name: key.clone(), width, height, rgba }));
        self.made.insert(key, self.images.len() - 1);
        Ok(self.images.len() - 1)
    }

    /// A map as it is.
    pub(super) fn plain(&mut self, map: &Map) -> Option<TextureRef> {
        let (image, _) = self.image(map)?;
        Some(self.reference(image, map))
    }

    /// Colour with opacity in its alpha, each of which may be missing.
    pub(super) fn colored(
        &mut self,
        color: Option<&Map>,
        opacity: Option<&Map>,
    ) -> Fallible<Option<(TextureRef, Alpha)>> {
        let found = color.and_then(|map| Some((map, self.image(map)?)));
        let Some((opacity, (_, mask))) = opacity.and_then(|map| Some((map, self.image(map)?))) else {
            return Ok(found.map(|(map, (image, _))| (self.reference(image, map), Alpha::Opaque)));
        };
        // A mask is the alpha of an image that has some, else its brightness.
        let by_alpha = match opacity.channel {
            Some(b'm') => true,
            Some(b'l') => false,
            _ => mask.rgba.chunks_exact(4).any(|p| p[3] != 255),
        };
        let alpha = |at: [u8; 4]| if by_alpha { at[3] } else { luminance(at) };
        let (map, image) = match found {
            None => {
                let key = format!("opacity of {}", opacity.file);
                let pixel = |x, y| [255, 255, 255, alpha(texel(&mask, x, y))];
                (opacity, self.make(key, [mask.width, mask.height], pixel)?)
            }
            Some((map, (_, color))) => {
                let key = format!("{} with the opacity of {}", map.file, opacity.file);
                let size = [color.width.max(mask.width), color.height.max(mask.height)];
                let pixel = |x, y| {
                    let [r, g, b, _] = stretched(&color, size, x, y);
                    [r, g, b, alpha(stretched(&mask, size, x, y))]
                };
                (map, self.make(key, size, pixel)?)
            }
        };
        Ok(Some((self.reference(image, map), Alpha::FromMap)))
    }

    /// Roughness in green, metalness in blue; what has no map is 1 there.
    pub(super) fn rough_and_metallic(
        &mut self,
        rough: Option<&Map>,
        metallic: Option<&Map>,
    ) -> Fallible<Option<TextureRef>> {
        let rough = rough.and_then(|map| Some((map, self.image(map)?.1)));
        let metallic = metallic.and_then(|map| Some((map, self.image(map)?.1)));
        let Some(map) = rough.as_ref().or(metallic.as_ref()).map(|(map, _)| *map) else { return Ok(None) };
        let images = [&rough, &metallic].map(|one| one.as_ref().map(|(_, image)| image));
        let size = images.into_iter().flatten().fold([1, 1], |[w, h], i| [i.width.max(w), i.height.max(h)]);
        let names = [&rough, &metallic].map(|one| one.as_ref().map_or("nothing", |(map, _)| map.file.as_str()));
        let key = format!("roughness of {} and metalness of {}", names[0], names[1]);
        let value = |image: Option<&Arc<Image>>, x, y| image.map_or(255, |i| luminance(stretched(i, size, x, y)));
        let pixel = |x, y| [255, value(images[0], x, y), value(images[1], x, y), 255];
        let image = self.make(key, size, pixel)?;
        Ok(Some(self.reference(image, map)))
    }

    /// A normal map and its scale. What is called a bump map is one if it looks like one, else its heights give the normals.
    pub(super) fn normal(
        &mut self,
        normal: Option<&Map>,
        bump: Option<&Map>,
        notices: &mut Notices,
    ) -> Fallible<Option<(TextureRef, f32)>> {
        if let Some((map, (image, _))) = normal.and_then(|map| Some((map, self.image(map)?))) {
            return Ok(Some((self.reference(image, map), 1.0)));
        }
        let Some((map, (index, heights))) = bump.and_then(|map| Some((map, self.image(map)?))) else {
            return Ok(None);
        };
        if looks_like_normals(&heights) {
            return Ok(Some((self.reference(index, map), map.strength)));
        }
        notices.approximated(format!("texture {:?}: heights became a normal map", map.file));
        let size = [heights.width, heights.height];
        let image = self.make(format!("normals of {}", map.file), size, |x, y| {
            let height = |dx: u32, dy: u32| {
                let (x, y) = ((x + dx) % heights.width, (y + dy) % heights.height);
                f32::from(luminance(texel(&heights, x, y))) / 255.0
            };
            let (left, up) = (heights.width - 1, heights.height - 1);
            // A full step of brightness over a texel is a slope of HEIGHT.
            let across = HEIGHT * 0.5 * (height(1, 0) - height(left, 0));
            let down = HEIGHT * 0.5 * (height(0, 1) - height(0, up));
            let n = Vec3::new(-across, down, 1.0).normalize();
            let byte = |c: f32| ((c * 0.5 + 0.5) * 255.0).round() as u8;
            [byte(n.x), byte(n.y), byte(n.z), 255]
        })?;
        Ok(Some((self.reference(image, map), map.strength)))
    }
}

/// What a bump map of full contrast means is left to the program; four texels deep looks like other programs' pictures.
const HEIGHT: f32 = 4.0;

/// The bytes of a texture: where the file says, else, if that is another machine's path, by its name in the folder.
fn find(file: &str, folder: Option<&Path>, limit: u64, cancel: &Cancel, notices: &mut Notices) -> Fallible<Vec<u8>> {
    let place = "texture";
    let first = match uri::file(file, place, folder, limit, &|_| cancel.go_on()) {
        Ok(bytes) => return Ok(bytes),
        Err(fault) => fault,
    };
    let name = file.rsplit(['/', '\\']).next().unwrap_or_default();
    // Windows does not mind capitals.
    let listed = folder.and_then(|f| std::fs::read_dir(f).ok()).into_iter().flatten().flatten();
    let same = |found: &str| found.eq_ignore_ascii_case(name);
    let found = listed.filter_map(|e| e.file_name().into_string().ok()).filter(|n| same(n)).min();
    let Some(bytes) = found.as_ref().and_then(|found| uri::file(found, place, folder, limit, &|_| cancel.go_on()).ok())
    else {
        return Err(first);
    };
    notices.repaired(format!("texture {file:?} was found as {:?}", found.unwrap_or_default()));
    Ok(bytes)
}

/// A texture without which the model is still worth seeing.
fn left_out(fault: Fault, notices: &mut Notices) -> Fallible<()> {
    let said = match fault {
        Fault::Io { place, source } => format!("{place}: {source}"),
        Fault::Invalid { place, cause } => format!("{place} {cause}"),
        other => return Err(other),
    };
    notices.ignored(format!("{said}; it is not shown"));
    Ok(())
}

fn texel(image: &Image, x: u32, y: u32) -> [u8; 4] {
    let at = 4 * (y as usize * image.width as usize + x as usize);
    image.rgba.get(at..at + 4).and_then(|p| p.try_into().ok()).unwrap_or_default()
}

/// The texel of an image that is stretched to `size`.
fn stretched(image: &Image, size: [u32; 2], x: u32, y: u32) -> [u8; 4] {
    let scaled = |v: u32, from: u32, to: u32| (u64::from(v) * u64::from(to) / u64::from(from.max(1))) as u32;
    texel(image, scaled(x, size[0], image.width), scaled(y, size[1], image.height))
}

fn luminance([r, g, b, _]: [u8; 4]) -> u8 {
    ((2126 * u32::from(r) + 7152 * u32::from(g) + 722 * u32::from(b) + 5000) / 10_000) as u8
}

/// Whether an image is a tangent-space normal map: on average its texels point out of the surface.
fn looks_like_normals(image: &Image) -> bool {
    let count = (image.rgba.len() / 4).max(1) as f64;
    let mut sums = [0.0; 3];
    for p in image.rgba.chunks_exact(4) {
        (0..3).for_each(|c| sums[c] += f64::from(p[c]) / 255.0);
    }
    let [r, g, b] = sums.map(|s| s / count);
    (r - 0.5).abs() < 0.1 && (g - 0.5).abs() < 0.1 && b > 0.75
}
