//! What a caller hears while a file is read, and how it is called off.

use std::sync::{Arc, Mutex};

use super::compression::{draco_hill, packed_hill};
use super::*;
use crate::import::{Cancel, ImportOptions, Phase, Progress, load_bytes_with};

#[test]
fn phases_come_in_order_with_shares() {
    for file in [draco_hill(4, None), packed_hill(4, "EXT_meshopt_compression", 0)] {
        let heard = Arc::new(Mutex::new(Vec::new()));
        let told = heard.clone();
        let progress = Progress::to(move |phase, share| told.lock().unwrap().push((phase, share)));
        load_bytes_with(&file.bytes(), "test", None, &ImportOptions { progress, ..ImportOptions::default() }).unwrap();
        let heard = heard.lock().unwrap();
        assert!(heard.windows(2).all(|w| w[0].0 <= w[1].0), "{heard:?}");
        for phase in [Phase::Parsing, Phase::Images, Phase::Geometry, Phase::Finishing] {
            let shares: Vec<f32> = heard.iter().filter(|h| h.0 == phase).map(|h| h.1).collect();
            assert_eq!(shares.first(), Some(&0.0), "{phase:?}: {heard:?}");
            assert!(shares.iter().all(|share| (0.0..=1.0).contains(share)), "{phase:?}: {heard:?}");
        }
        assert!(heard.contains(&(Phase::Geometry, 1.0)), "{heard:?}");
    }
}

#[test]
fn an_import_ends_soon_after_it_is_called_off() {
    for at in [Phase::Parsing, Phase::Images, Phase::Geometry] {
        let cancel = Cancel::default();
        let caller = cancel.clone();
        let progress = Progress::to(move |phase, _| {
            if phase == at {
                caller.cancel();
            }
        });
        let options = ImportOptions { progress, cancel, ..ImportOptions::default() };
        let error = load_bytes_with(&draco_hill(4, None).bytes(), "test", None, &options).unwrap_err();
        assert!(matches!(error, ImportError::Cancelled { .. }), "{at:?}: {error}");
    }
}

#[test]
fn one_bad_stream_among_many_is_named() {
    let mut file = packed_hill(4, "EXT_meshopt_compression", 0);
    let good = file.json["bufferViews"][0].clone();
    let views = file.json["bufferViews"].as_array_mut().unwrap();
    views.extend(std::iter::repeat_n(good, 200));
    views[100]["extensions"]["EXT_meshopt_compression"]["byteLength"] = 20.into();
    file.refused("bufferViews[100].extensions.EXT_meshopt_compression");
}
