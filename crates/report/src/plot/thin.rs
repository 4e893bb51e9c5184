//! Thinning: a plot omits the points that its pixels cannot show.

use super::canvas::Point;

/// Thins points in order of `x` to at most four per column of `column_width` units: the
/// first, the least, the largest and the last, in their order.
///
/// Every extremum of `y` survives, and so does the line between neighbouring columns. A point
/// that is not finite survives too, since it breaks the line.
pub fn columns(points: impl Iterator<Item = Point>, column_width: f64) -> Vec<Point> {
    let points: Vec<Point> = points.collect();
    // Both come from the same floor, so equal columns are equal to the bit.
    let column = |point: &Point| (point.x / column_width).floor().to_bits();
    let mut out = Vec::new();
    for run in points.chunk_by(|a, b| a.is_finite() && b.is_finite() && column(a) == column(b)) {
        if !run[0].is_finite() {
            out.push(Point::new(f64::NAN, f64::NAN));
            continue;
        }
        let (mut least, mut largest) = (0, 0);
        for (index, point) in run.iter().enumerate() {
            if point.y < run[least].y {
                least = index;
            }
            if point.y > run[largest].y {
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
/// `y`, its first or its last point. Where more than `points_max` points are left the distance
/// doubles until they fit.
pub fn curve(points: &[Point], distance: f64, points_max: usize) -> Vec<Point> {
    let finite: Vec<Point> = points
        .iter()
        .copied()
        .filter(|point| point.is_finite())
        .collect();
    let Some(last) = finite.len().checked_sub(1) else {
        return Vec::new();
    };
    let mut forced = [0, last, 0, 0, 0, 0];
    for (index, point) in finite.iter().enumerate() {
        for (slot, better) in [
            (2, point.x < finite[forced[2]].x),
            (3, point.x > finite[forced[3]].x),
            (4, point.y < finite[forced[4]].y),
            (5, point.y > finite[forced[5]].y),
        ] {
            if better {
                forced[slot] = index;
            }
        }
    }
    let mut distance = distance;
    loop {
        let mut out: Vec<Point> = Vec::new();
        for (index, &point) in finite.iter().enumerate() {
            let far = out.last().is_none_or(|before| {
                (point.x - before.x).abs().max((point.y - before.y).abs()) >= distance
            });
            if far || forced.contains(&index) {
                out.push(point);
            }
        }
        if out.len() <= points_max.max(forced.len()) || !distance.is_finite() {
            return out;
        }
        distance *= 2.0;
    }
}
