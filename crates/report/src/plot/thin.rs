//! Thinning: what a plot's pixels cannot show is not drawn, and what they can is kept.

/// Thins points in order of `x` to at most four per column of `column_width` units: the
/// first, the least, the largest and the last, in their order.
///
/// Every extremum of `y` survives, and so does the line between neighbouring columns. A point
/// that is not finite survives too, since it breaks the line.
pub fn columns(points: impl Iterator<Item = (f64, f64)>, column_width: f64) -> Vec<(f64, f64)> {
    let points: Vec<(f64, f64)> = points.collect();
    let is_finite = |point: &(f64, f64)| point.0.is_finite() && point.1.is_finite();
    // Both come from the same floor, so equal columns are equal to the bit.
    let column = |point: &(f64, f64)| (point.0 / column_width).floor().to_bits();
    let mut out = Vec::new();
    for run in points.chunk_by(|a, b| is_finite(a) && is_finite(b) && column(a) == column(b)) {
        if !is_finite(&run[0]) {
            out.push((f64::NAN, f64::NAN));
            continue;
        }
        let (mut least, mut largest) = (0, 0);
        for (index, point) in run.iter().enumerate() {
            if point.1 < run[least].1 {
                least = index;
            }
            if point.1 > run[largest].1 {
                largest = index;
            }
        }
        let mut kept = vec![0, least, largest, run.len() - 1];
        kept.sort_unstable();
        kept.dedup();
        out.extend(kept.into_iter().map(|index| run[index]));
    }
    out
}

/// Thins a curve that may turn back in both directions: a point nearer than `distance` units
/// to the one kept before it is dropped, unless it is an extremum of the whole curve in `x` or
/// `y`, its first or its last point. Where more than `most` points are left the distance
/// doubles until they fit.
pub fn curve(points: &[(f64, f64)], distance: f64, most: usize) -> Vec<(f64, f64)> {
    let finite: Vec<(f64, f64)> = points
        .iter()
        .copied()
        .filter(|point| point.0.is_finite() && point.1.is_finite())
        .collect();
    let Some(last) = finite.len().checked_sub(1) else {
        return Vec::new();
    };
    let mut forced = [0, last, 0, 0, 0, 0];
    for (index, point) in finite.iter().enumerate() {
        for (slot, better) in [
            (2, point.0 < finite[forced[2]].0),
            (3, point.0 > finite[forced[3]].0),
            (4, point.1 < finite[forced[4]].1),
            (5, point.1 > finite[forced[5]].1),
        ] {
            if better {
                forced[slot] = index;
            }
        }
    }
    let mut distance = distance;
    loop {
        let mut out: Vec<(f64, f64)> = Vec::new();
        for (index, &point) in finite.iter().enumerate() {
            let far = out.last().is_none_or(|before| {
                (point.0 - before.0).abs().max((point.1 - before.1).abs()) >= distance
            });
            if far || forced.contains(&index) {
                out.push(point);
            }
        }
        if out.len() <= most.max(forced.len()) || !distance.is_finite() {
            return out;
        }
        distance *= 2.0;
    }
}
