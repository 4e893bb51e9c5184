//! A colour map in which equal steps look equal, also in grey and to colour-blind eyes.

/// Nine points of the viridis map, from its dark end to its light one, evenly spaced.
///
/// # Source
///
/// viridis, S. van der Walt and N. Smith, released under CC0.
const VIRIDIS: [[f64; 3]; 9] = [
    [68.0, 1.0, 84.0],
    [71.0, 45.0, 123.0],
    [59.0, 82.0, 139.0],
    [44.0, 114.0, 142.0],
    [33.0, 145.0, 140.0],
    [40.0, 174.0, 128.0],
    [94.0, 201.0, 98.0],
    [173.0, 220.0, 48.0],
    [253.0, 231.0, 37.0],
];

/// Returns the colour at `share` of the way, straight between the points; a share outside
/// 0..=1 takes the nearer end.
pub(super) fn viridis(share: f64) -> [u8; 3] {
    let place = if share.is_nan() {
        0.0
    } else {
        share.clamp(0.0, 1.0) * 8.0
    };
    let index = (place as usize).min(7);
    let part = place - index as f64;
    let (from, to) = (VIRIDIS[index], VIRIDIS[index + 1]);
    std::array::from_fn(|channel| {
        (from[channel] + part * (to[channel] - from[channel])).round() as u8
    })
}
