//! Names of parts: by path in the hierarchy where they are written to a file, by anything that is clear where a person
//! types them.
//!
//! A part's path is the names of its node's ancestors and its own, with `/` between them, as in `housing/bolt`. Paths are
//! unique: the second part of a path has `#2` behind it, in scene order. A node without a name is called by its number.

use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};

use crate::math::spelling::edit_distance;
use crate::scene::Scene;

/// Levels of a path that are written, counted from the part: a file may nest nodes as deep as it likes.
const MOST_LEVELS: usize = 64;
/// Parts among which the nearest name is searched.
const MOST_COMPARED: usize = 10_000;
/// Paths that an error lists.
const MOST_LISTED: usize = 6;

/// Why a name says no part.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PartNameError {
    /// No part and no group is called so.
    #[error("no part is called '{name}'{}", nearest.as_ref().map(|n| format!("; did you mean '{n}'?")).unwrap_or_default())]
    Unknown {
        /// What was asked for.
        name: String,
        /// The path that is nearest to it.
        nearest: Option<String>,
    },
    /// Several are.
    #[error("'{name}' is the name of {count}: {}{}; give a path", paths.join(", "), if *count > paths.len() { ", …" } else { "" })]
    Ambiguous {
        /// What was asked for.
        name: String,
        /// How many parts or groups are called so.
        count: usize,
        /// The first of their paths.
        paths: Vec<String>,
    },
}

/// The paths of a scene's parts.
#[derive(Clone, Debug)]
pub struct PartNames {
    /// Name of every part.
    names: Vec<String>,
    /// Path of every part, unique.
    paths: Vec<String>,
    by_path: HashMap<String, u32>,
}

impl PartNames {
    /// The names of a finished scene's parts.
    pub fn new(scene: &Scene) -> PartNames {
        let plain: Vec<String> = scene.parts.iter().map(|p| path_of(scene, p.node, &p.name)).collect();
        let first: HashSet<&str> = plain.iter().map(String::as_str).collect();
        let mut by_path: HashMap<String, u32> = HashMap::with_capacity(plain.len());
        let mut next: HashMap<&str, u32> = HashMap::new();
        let mut paths = Vec::with_capacity(plain.len());
        for (part, path) in plain.iter().enumerate() {
            let mut unique = path.clone();
            while by_path.contains_key(&unique) || (unique != *path && first.contains(unique.as_str())) {
                let number = next.entry(path).or_insert(1);
                *number += 1;
                unique = format!("{path}#{number}");
            }
            by_path.insert(unique.clone(), part as u32);
            paths.push(unique);
        }
        PartNames { names: scene.parts.iter().map(|p| p.name.clone()).collect(), paths, by_path }
    }

    /// The path of a part; `None` if there is no such part.
    pub fn path(&self, part: u32) -> Option<&str> {
        self.paths.get(part as usize).map(String::as_str)
    }

    /// The part with exactly this path.
    ///
    /// # Errors
    /// [`PartNameError::Unknown`] names the nearest.
    pub fn part(&self, path: &str) -> Result<u32, PartNameError> {
        self.by_path.get(path).copied().ok_or_else(|| self.unknown(path))
    }

    /// The parts that a person means: a path, a group's path (all parts below it), or the end of a path that only one part
    /// or one group has, down to a bare name.
    ///
    /// # Errors
    /// [`PartNameError`] for a name that nothing has, or several have.
    pub fn find(&self, name: &str) -> Result<BTreeSet<u32>, PartNameError> {
        if let Some(&part) = self.by_path.get(name) {
            return Ok(BTreeSet::from([part]));
        }
        let whole = |path: &str| path == name;
        let ends =
            |path: &str| path.strip_suffix(name).is_some_and(|before| before.is_empty() || before.ends_with('/'));
        let groups = |is_meant: &dyn Fn(&str) -> bool| {
            let mut found: HashMap<&str, BTreeSet<u32>> = HashMap::new();
            for (part, path) in self.paths.iter().enumerate() {
                let levels = path.match_indices('/').map(|(at, _)| &path[..at]);
                for group in levels.filter(|group| is_meant(group)) {
                    found.entry(group).or_default().insert(part as u32);
                }
            }
            found
        };
        if let Some(parts) = groups(&whole).remove(name) {
            return Ok(parts);
        }
        let named = |part: &usize| self.names[*part] == name || ends(&self.paths[*part]);
        let parts: Vec<usize> = (0..self.paths.len()).filter(named).collect();
        let ambiguous = |mut paths: Vec<String>| {
            paths.sort();
            let count = paths.len();
            paths.truncate(MOST_LISTED);
            PartNameError::Ambiguous { name: name.to_owned(), count, paths }
        };
        match parts[..] {
            [part] => return Ok(BTreeSet::from([part as u32])),
            [] => {}
            _ => return Err(ambiguous(parts.into_iter().map(|p| self.paths[p].clone()).collect())),
        }
        let mut found = groups(&ends);
        match found.len() {
            0 => Err(self.unknown(name)),
            1 => Ok(found.drain().flat_map(|(_, parts)| parts).collect()),
            _ => Err(ambiguous(found.into_keys().map(str::to_owned).collect())),
        }
    }

    /// Few names that together mean exactly these parts: of a group where all below it are meant, else paths. Each is found
    /// again by [`PartNames::find`].
    pub fn said(&self, parts: &BTreeSet<u32>) -> Vec<String> {
        let mut groups: BTreeMap<(usize, &str), BTreeSet<u32>> = BTreeMap::new();
        for (part, path) in self.paths.iter().enumerate() {
            for (at, _) in path.match_indices('/') {
                groups.entry((at, &path[..at])).or_default().insert(part as u32);
            }
        }
        let mut left = parts.clone();
        let mut names = Vec::new();
        // The largest groups have the shortest names. A part that is called like a group hides it.
        for ((_, group), below) in groups {
            if below.len() > 1 && below.is_subset(&left) && !self.by_path.contains_key(group) {
                left.retain(|part| !below.contains(part));
                names.push(group.to_owned());
            }
        }
        names.extend(left.iter().filter_map(|&part| self.path(part)).map(str::to_owned));
        names
    }

    fn unknown(&self, name: &str) -> PartNameError {
        let candidates = self.paths.iter().zip(&self.names).take(MOST_COMPARED);
        let distance = |(path, own): &(&String, &String)| edit_distance(name, path).min(edit_distance(name, own));
        let nearest = candidates.min_by_key(distance).map(|(path, _)| path.clone());
        PartNameError::Unknown { name: name.to_owned(), nearest }
    }
}

fn path_of(scene: &Scene, node: usize, name: &str) -> String {
    let mut levels = vec![name.to_owned()];
    let mut at = scene.nodes[node].parent;
    while let Some(parent) = at {
        if levels.len() == MOST_LEVELS {
            levels.push("…".to_owned());
            break;
        }
        let own = &scene.nodes[parent].name;
        levels.push(if own.is_empty() { format!("node {parent}") } else { own.clone() });
        at = scene.nodes[parent].parent;
    }
    levels.reverse();
    levels.join("/")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::session::tests::scene_of;

    fn names(paths: &[&str]) -> PartNames {
        PartNames::new(&scene_of(paths))
    }

    fn found(names: &PartNames, name: &str) -> Vec<u32> {
        names.find(name).unwrap_or_else(|e| panic!("{e}")).into_iter().collect()
    }

    #[test]
    fn paths_are_unique_whatever_the_names() {
        let names = names(&["housing/bolt", "housing/bolt", "housing/bolt#2", "housing/bolt", "shaft", ""]);
        let paths: Vec<&str> = (0..6).map(|p| names.path(p).unwrap()).collect();
        // The part that is really called so keeps its path.
        assert_eq!(paths, ["housing/bolt", "housing/bolt#3", "housing/bolt#2", "housing/bolt#4", "shaft", "part 5"]);
        for (part, path) in paths.iter().enumerate() {
            assert_eq!(names.part(path), Ok(part as u32));
        }
        assert_eq!(names.path(6), None);
    }

    #[test]
    fn parts_are_found_by_what_is_clear() {
        let names = names(&["gear/planet/wheel", "gear/planet/pin", "gear/sun/wheel", "gear/ring", "housing"]);
        assert_eq!(found(&names, "gear/planet/wheel"), [0]);
        assert_eq!(found(&names, "planet/wheel"), [0]);
        assert_eq!(found(&names, "pin"), [1]);
        assert_eq!(found(&names, "housing"), [4]);
        assert_eq!(found(&names, "gear"), [0, 1, 2, 3]);
        assert_eq!(found(&names, "gear/planet"), [0, 1]);
        assert_eq!(found(&names, "planet"), [0, 1]);
        let e = names.find("wheel").unwrap_err().to_string();
        assert_eq!(e, "'wheel' is the name of 2: gear/planet/wheel, gear/sun/wheel; give a path");
        let e = names.find("housin").unwrap_err().to_string();
        assert_eq!(e, "no part is called 'housin'; did you mean 'housing'?");
        let e = names.find("heel").unwrap_err().to_string();
        assert!(e.contains("did you mean 'gear/planet/wheel'"), "{e}");
        assert_eq!(names.part("wheel"), names.find("whel").map(|_| 0).map_err(|_| names.unknown("wheel")));
    }

    #[test]
    fn what_is_said_of_parts_means_them_again() {
        let paths =
            ["gear/planet/wheel", "gear/planet/pin", "gear/sun/wheel", "gear/ring", "housing", "gear", "a//b", "a//c"];
        let names = names(&paths);
        let said = |parts: &[u32]| names.said(&parts.iter().copied().collect());
        assert_eq!(said(&[0, 1]), ["gear/planet"]);
        assert_eq!(said(&[0, 1, 2, 4]), ["gear/planet", "gear/sun/wheel", "housing"]);
        // 'gear' is a part besides, so the group of that name cannot be meant.
        assert_eq!(said(&[0, 1, 2, 3]), ["gear/planet", "gear/sun/wheel", "gear/ring"]);
        for set in 0..1_u32 << paths.len() {
            let parts: BTreeSet<u32> = (0..paths.len() as u32).filter(|p| set >> p & 1 == 1).collect();
            let again = names.said(&parts).iter().flat_map(|name| names.find(name).unwrap()).collect::<BTreeSet<u32>>();
            assert_eq!(again, parts, "{:?}", names.said(&parts));
        }
    }

    #[test]
    fn a_deep_chain_has_short_paths() {
        let deep = vec!["n"; 5000].join("/");
        let names = names(&[&deep]);
        let path = names.path(0).unwrap();
        assert!(path.starts_with("…/n/") && path.matches('/').count() == MOST_LEVELS, "{path}");
        assert_eq!(found(&names, path), [0]);
    }
}
