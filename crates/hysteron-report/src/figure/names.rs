//! Names beside points, placed so that they cover neither each other nor a point.

use super::Panel;
use super::layout::{PlacedPanel, Rect, SMALL};
use super::palette::SOFT;
use super::text::{number, width};
use crate::escape::escape;

/// Height of a line of text, and the half-width of a mark with air about it \[px\].
const LINE: f64 = 13.0;
const MARK: f64 = 6.0;
/// Distances from a point to its name that are tried, the nearest first \[px\].
const DISTANCES: [f64; 7] = [7.0, 16.0, 28.0, 42.0, 58.0, 76.0, 96.0];
/// Directions that are tried at each distance: right, left, above, below, and between.
const DIRECTIONS: [(f64, f64); 12] = [
    (1.0, 0.0),
    (-1.0, 0.0),
    (0.0, -1.0),
    (0.0, 1.0),
    (0.8, -0.6),
    (0.8, 0.6),
    (-0.8, -0.6),
    (-0.8, 0.6),
    (0.4, -0.9),
    (0.4, 0.9),
    (-0.4, -0.9),
    (-0.4, 0.9),
];

/// Whether a panel names points; its axes then stay as they are.
pub(crate) fn has_names(panel: &Panel) -> bool {
    !panel.names.is_empty()
}

fn overlap(a: &Rect, b: &Rect) -> f64 {
    let along = |a: f64, la: f64, b: f64, lb: f64| ((a + la).min(b + lb) - a.max(b)).max(0.0);
    along(a.x, a.w, b.x, b.w) * along(a.y, a.h, b.y, b.h)
}

/// Box of a name `w` px wide, relative to its point.
fn beside((x, y): (f64, f64), w: f64, distance: f64, (dx, dy): (f64, f64)) -> Rect {
    let (px, py) = (x + dx * distance, y + dy * distance);
    let left = if dx > 0.3 {
        px
    } else if dx < -0.3 {
        px - w
    } else {
        px - w / 2.0
    };
    Rect { x: left, y: py + (dy - 1.0) * LINE / 2.0, w, h: LINE }
}

/// Draws the names of a panel's points, with a line to the point where they stand apart from it.
pub(crate) fn draw(out: &mut String, panel: &Panel, placed: &PlacedPanel) {
    let frame = placed.frame;
    let points: Vec<(f64, f64)> = panel
        .names
        .iter()
        .map(|name| {
            let (x, y) = (placed.x.fraction(name.x), placed.y.fraction(name.y));
            (frame.x + x * frame.w, frame.y + frame.h - y * frame.h)
        })
        .collect();
    let drawn = |p: &(f64, f64)| p.0.is_finite() && p.1.is_finite();
    let mut taken: Vec<Rect> = points
        .iter()
        .filter(|p| drawn(p))
        .map(|p| Rect { x: p.0 - MARK, y: p.1 - MARK, w: 2.0 * MARK, h: 2.0 * MARK })
        .collect();
    for (name, &point) in panel.names.iter().zip(&points).filter(|(_, p)| drawn(p)) {
        let w = width(&name.text, SMALL);
        let inside = |r: &Rect| {
            let (right, bottom) = (frame.x + frame.w, frame.y + frame.h);
            r.x >= frame.x + 2.0
                && r.x + r.w <= right - 2.0
                && r.y >= frame.y + 2.0
                && r.y + r.h <= bottom - 2.0
        };
        let places = DISTANCES.iter().flat_map(|&distance| {
            DIRECTIONS.iter().map(move |&direction| (distance, beside(point, w, distance, direction)))
        });
        let covered = |r: &Rect| taken.iter().map(|t| overlap(r, t)).sum::<f64>();
        let mut best: Option<(f64, f64, Rect)> = None;
        for (distance, place) in places.filter(|(_, r)| inside(r)) {
            let cost = covered(&place);
            if best.as_ref().is_none_or(|(least, _, _)| cost < *least) {
                best = Some((cost, distance, place));
            }
            if cost == 0.0 {
                break;
            }
        }
        let Some((_, distance, place)) = best else { continue };
        if distance > DISTANCES[0] {
            let (x, y) =
                (point.0.clamp(place.x, place.x + place.w), point.1.clamp(place.y, place.y + place.h));
            let [px, py, x, y] = [point.0, point.1, x, y].map(number);
            put!(
                out,
                "<path class=\"leader\" d=\"M{px} {py}L{x} {y}\" stroke=\"{}\" stroke-width=\".8\" \
                 fill=\"none\"/>",
                SOFT.light
            );
        }
        let (x, y, text) = (number(place.x), number(place.y + LINE - 3.0), escape(&name.text));
        // A margin in the colour of the paper keeps it readable on a curve.
        put!(
            out,
            "<text class=\"t halo\" x=\"{x}\" y=\"{y}\" stroke=\"#fff\" stroke-width=\"3\" \
             stroke-linejoin=\"round\" paint-order=\"stroke\">{text}</text>"
        );
        taken.push(place);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_stands_beside_its_point_on_the_side_asked_for() {
        let right = beside((10.0, 20.0), 30.0, 7.0, (1.0, 0.0));
        assert_eq!((right.x, right.y), (17.0, 20.0 - LINE / 2.0));
        let left = beside((10.0, 20.0), 30.0, 7.0, (-1.0, 0.0));
        assert_eq!(left.x + left.w, 3.0);
        let above = beside((10.0, 20.0), 30.0, 7.0, (0.0, -1.0));
        assert_eq!((above.x, above.y + above.h), (-5.0, 13.0));
        let below = beside((10.0, 20.0), 30.0, 7.0, (0.0, 1.0));
        assert_eq!(below.y, 27.0);
    }

    #[test]
    fn boxes_overlap_by_their_common_area() {
        let unit = Rect { x: 0.0, y: 0.0, w: 2.0, h: 2.0 };
        assert_eq!(overlap(&unit, &Rect { x: 1.0, y: 1.0, w: 5.0, h: 5.0 }), 1.0);
        assert_eq!(overlap(&unit, &Rect { x: 2.0, y: 0.0, w: 1.0, h: 1.0 }), 0.0);
    }
}
