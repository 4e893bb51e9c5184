//! Thinning: what a plot's pixels cannot show is not drawn, and what they can is kept.

/// Thins points in order of `x` to at most four per column of `column_width` units: the
/// first, the least, the largest and the last, in their order.
///
/// Every extremum of `y` survives, and so does the line between neighbouring columns. A point
/// that is not finite survives too, since it breaks the line.
pub fn columns(points: impl Iterator<Item = (f64, f64)>, column_width: f64) -> Vec<(f64, f64)> {
    let mut out = Vec::new();
    let mut column: Option<PlotColumn> = None;
    for (index, point) in points.enumerate() {
        if !(point.0.is_finite() && point.1.is_finite()) {
            if let Some(full) = column.take() {
                full.emit(&mut out);
            }
            out.push((f64::NAN, f64::NAN));
            continue;
        }
        let number = (point.0 / column_width).floor();
        match &mut column {
            // Both come from the same floor, so equal columns are equal to the bit.
            Some(open) if open.number.to_bits() == number.to_bits() => open.add(index, point),
            _ => {
                if let Some(full) = column.take() {
                    full.emit(&mut out);
                }
                column = Some(PlotColumn::start(number, index, point));
            }
        }
    }
    if let Some(full) = column {
        full.emit(&mut out);
    }
    out
}

type Numbered = (usize, (f64, f64));

struct PlotColumn {
    number: f64,
    first: Numbered,
    least: Numbered,
    largest: Numbered,
    last: Numbered,
}

impl PlotColumn {
    fn start(number: f64, index: usize, point: (f64, f64)) -> Self {
        let numbered = (index, point);
        Self {
            number,
            first: numbered,
            least: numbered,
            largest: numbered,
            last: numbered,
        }
    }

    fn add(&mut self, index: usize, point: (f64, f64)) {
        let numbered = (index, point);
        if point.1 < self.least.1.1 {
            self.least = numbered;
        }
        if point.1 > self.largest.1.1 {
            self.largest = numbered;
        }
        self.last = numbered;
    }

    fn emit(self, out: &mut Vec<(f64, f64)>) {
        let mut kept = [self.first, self.least, self.largest, self.last];
        kept.sort_by_key(|(index, _)| *index);
        let mut before = None;
        for (index, point) in kept {
            if before != Some(index) {
                out.push(point);
                before = Some(index);
            }
        }
    }
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
