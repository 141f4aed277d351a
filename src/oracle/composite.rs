//! Blends the layers of every pixel: premultiplied, in linear light, the background behind everything (T26).
//!
//! Front to back as the GPU does it, and back to front as the paper does; in exact arithmetic both are the same sum of
//! colours times weights, `wᵢ = αᵢ ∏_{j<i} (1 − αⱼ)`.

use super::store::StoreData;

/// A picture: linear, premultiplied rgba by pixel.
pub type LinearImage = Vec<[f64; 4]>;

/// Share of each layer (nearest first) in its pixel; what is missing to 1 is the background's.
pub fn weights(alphas: &[f64]) -> Vec<f64> {
    let mut transmitted = 1.0;
    alphas
        .iter()
        .map(|alpha| {
            let weight = transmitted * alpha;
            transmitted *= 1.0 - alpha;
            weight
        })
        .collect()
}

/// Blends front to back. `colors` are linear rgb and straight alpha by fragment, `background` linear rgb, or none for a
/// transparent picture.
pub fn front_to_back(store: &StoreData, colors: &[[f64; 4]], background: Option<[f64; 3]>) -> LinearImage {
    (0..store.counts.len())
        .map(|pixel| {
            let mut sum = [0.0; 4];
            let mut transmitted = 1.0;
            for i in store.range(pixel) {
                let [r, g, b, a] = colors[i];
                for (sum, c) in sum.iter_mut().zip([r * a, g * a, b * a, a]) {
                    *sum += transmitted * c;
                }
                transmitted *= 1.0 - a;
            }
            if let Some([r, g, b]) = background {
                for (sum, c) in sum.iter_mut().zip([r, g, b, 1.0]) {
                    *sum += transmitted * c;
                }
            }
            sum
        })
        .collect()
}

/// Blends back to front, each layer over what is behind it.
pub fn back_to_front(store: &StoreData, colors: &[[f64; 4]], background: Option<[f64; 3]>) -> LinearImage {
    (0..store.counts.len())
        .map(|pixel| {
            let mut sum = background.map_or([0.0; 4], |[r, g, b]| [r, g, b, 1.0]);
            for i in store.range(pixel).rev() {
                let [r, g, b, a] = colors[i];
                let over = [r * a, g * a, b * a, a];
                sum = std::array::from_fn(|c| over[c] + (1.0 - a) * sum[c]);
            }
            sum
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pixels(counts: &[u32]) -> StoreData {
        let mut store = StoreData { width: counts.len() as u32, height: 1, ..StoreData::default() };
        for &count in counts {
            store.offsets.push(store.depth.len());
            store.counts.push(count);
            store.overflowed.push(false);
            store.depth.resize(store.depth.len() + count as usize, 1.0);
        }
        store
    }

    #[test]
    fn two_layers_by_hand() {
        let colors = [[1.0, 0.0, 0.0, 0.5], [0.0, 1.0, 0.0, 0.25]];
        let store = pixels(&[2]);
        assert_eq!(front_to_back(&store, &colors, None), [[0.5, 0.125, 0.0, 0.625]]);
        assert_eq!(front_to_back(&store, &colors, Some([0.0, 0.0, 1.0])), [[0.5, 0.125, 0.375, 1.0]]);
        assert_eq!(back_to_front(&store, &colors, Some([0.0, 0.0, 1.0])), [[0.5, 0.125, 0.375, 1.0]]);
        assert_eq!(weights(&[0.5, 0.25]), [0.5, 0.125]);
    }

    #[test]
    fn an_opaque_layer_hides_what_is_behind_it() {
        let colors = [[0.2, 0.3, 0.4, 1.0], [9.0, 9.0, 9.0, 1.0]];
        assert_eq!(front_to_back(&pixels(&[2]), &colors, Some([1.0; 3])), [[0.2, 0.3, 0.4, 1.0]]);
    }

    #[test]
    fn both_orders_agree_and_weights_sum_to_the_coverage() {
        let counts = [0, 1, 7, 32];
        let store = pixels(&counts);
        let colors: Vec<[f64; 4]> = (0..40)
            .map(|i| {
                let t = f64::from(i) * 0.61803 % 1.0;
                [t, 1.0 - t, t * t, 0.02 + 0.9 * (t * 7.0 % 1.0)]
            })
            .collect();
        for background in [None, Some([0.3, 0.6, 0.9])] {
            let (a, b) = (front_to_back(&store, &colors, background), back_to_front(&store, &colors, background));
            for (a, b) in a.iter().flatten().zip(b.iter().flatten()) {
                assert!((a - b).abs() < 1e-14);
            }
        }
        let alphas: Vec<f64> = colors[8..40].iter().map(|c| c[3]).collect();
        let sum: f64 = weights(&alphas).iter().sum();
        assert!((sum - front_to_back(&store, &colors, None)[3][3]).abs() < 1e-12);
        // 32 faint layers do not vanish.
        assert!(weights(&[0.001; 32]).iter().sum::<f64>() > 0.031);
    }

    #[test]
    fn no_layers_leave_the_background() {
        assert_eq!(front_to_back(&pixels(&[0]), &[], Some([0.1, 0.2, 0.3])), [[0.1, 0.2, 0.3, 1.0]]);
        assert_eq!(back_to_front(&pixels(&[0]), &[], None), [[0.0; 4]]);
        assert!(front_to_back(&StoreData::default(), &[], None).is_empty());
    }
}
