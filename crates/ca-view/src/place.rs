//! Places the nodes of a drawing.
//!
//! Bodies are placed first, the strings of an instrument one behind the other. Moving points follow, between masses of
//! a body, then [single masses](crate::single_masses), beside their neighbours. All stand in [frames](crate::frame), except
//! masses in space, which are drawn at their position.

use crate::bodies::{Body, Shape};
use crate::frame::{Frame, Placed, Places};
use crate::graph::{Graph, Source};
use crate::single_masses;

/// Width of a scene without any size \[m\].
const WIDTH: f64 = 0.1;
/// Width of a scene, in extents of its masses along their motion.
const FLAT: f64 = 5.0;

type Corners = [[f64; 3]; 2];

/// Returns the extent of all masses in space, if there are any.
fn space(graph: &Graph) -> Option<Corners> {
    let mut all: Option<Corners> = None;
    let mut add = |p: [f64; 3], r: f64| {
        let [low, high] = all.get_or_insert([p, p]);
        for k in 0..3 {
            low[k] = low[k].min(p[k] - r);
            high[k] = high[k].max(p[k] + r);
        }
    };
    (0..graph.len()).filter(|n| graph.is_space(*n)).for_each(|n| add(graph.rest[n], 0.0));
    graph.spheres.iter().for_each(|(n, r)| add(graph.rest[*n as usize], *r));
    // masses on a line along an axis of space
    for e in &graph.edges {
        if let Some(axis) = e.axis {
            let [a, b] = e.ends.map(|n| n as usize);
            let (line, point) = if graph.is_space(b) { (a, b) } else { (b, a) };
            let mut p = graph.rest[point];
            p[axis as usize] = graph.rest[line][0];
            add(p, 0.0);
        }
    }
    all
}

/// Returns the width of masses on a line: the extent of space, else their extent along the motion, else the motion.
fn width(graph: &Graph, space: Option<Corners>, motion: Option<f64>) -> f64 {
    let size = space.map_or(0.0, |[low, high]| (0..3).map(|k| high[k] - low[k]).fold(0.0, f64::max));
    if size > 0.0 {
        return 0.9 * size;
    }
    let line = (0..graph.len())
        .filter(|n| matches!(graph.source[*n], Source::Line(_)) && !graph.under.contains_key(&(*n as u32)));
    let (low, high) = line
        .map(|n| graph.rest[n][0])
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), h| (low.min(h), high.max(h)));
    let apart = graph.begin.max(if high > low { high - low } else { 0.0 });
    let apart = if apart > 0.0 { apart } else { motion.unwrap_or(0.0) };
    if apart > 0.0 { FLAT * apart } else { WIDTH }
}

/// Returns the place of every node \[m\], the direction of its motion (0 in space) and the upward direction.
pub fn place(graph: &Graph, bodies: &[Body], motion: Option<f64>) -> (Vec<[f64; 3]>, Vec<[f64; 3]>, [f64; 3]) {
    let n = graph.len();
    let space = space(graph);
    let (axis, sign) = graph.up;
    let main = Frame::new(axis, sign);
    let mut p = Places::new(graph, main, width(graph, space, motion));
    arrange(graph, bodies, &mut p);
    points(graph, &mut p);
    single_masses::place(graph, &mut p);
    // the first frame stands beside the masses in space
    if let Some([low, high]) = space {
        let [right, depth, up] = main.axes;
        let part = |v: [f64; 3], p: [f64; 3]| (0..3).map(|k| v[k] * p[k]).sum::<f64>();
        let middle = [0, 1, 2].map(|k| 0.5 * (low[k] + high[k]));
        let tied =
            p.placed.iter().flatten().filter(|s| s.frame > 0).map(|s| part(right, p.frames[s.frame].point(s.at)));
        let edge = tied.fold(part(right, high).max(part(right, low)), f64::max);
        let left = p.placed.iter().flatten().filter(|s| s.frame == 0).map(|s| s.at[0]).fold(f64::INFINITY, f64::min);
        let to =
            [edge + 0.3 * p.width - if left.is_finite() { left } else { 0.0 }, part(depth, middle), part(up, middle)];
        p.frames[0].origin = main.point(to);
    }
    let mut at = Vec::with_capacity(n);
    let mut axes = Vec::with_capacity(n);
    for node in 0..n {
        match (graph.source[node], p.placed[node]) {
            (Source::Space(_), _) => {
                at.push(graph.rest[node]);
                axes.push([0.0; 3]);
            }
            (_, stand) => {
                let stand = stand.unwrap_or(Placed { frame: 0, at: [0.0; 3] });
                let frame = &p.frames[stand.frame];
                at.push(frame.point(stand.at));
                axes.push(frame.axes[2]);
            }
        }
    }
    (at, axes, main.axes[2])
}

/// Places the bodies: rows one behind the other, and flat bodies behind them, side by side. Several banks of cells
/// without links between them are notes of one instrument and stand side by side, each extending into the depth.
fn arrange(graph: &Graph, bodies: &[Body], p: &mut Places) {
    let w = p.width;
    let of = body_of(graph, bodies);
    let mut tied: Vec<Option<u32>> = vec![None; bodies.len()];
    for line in p.tied.keys() {
        if let Some(body) = of[*line as usize].checked_sub(1) {
            tied[body as usize].get_or_insert(*line);
        }
    }
    let free = |shape| bodies.iter().zip(&tied).filter(move |(b, t)| b.shape == shape && t.is_none()).count();
    let (rows, cells, flat) = (free(Shape::Row), free(Shape::Cells), free(Shape::Plane));
    let joined = graph.edges.iter().any(|e| {
        let [a, b] = e.ends.map(|n| of[n as usize]);
        a != b && a > 0 && b > 0
    });
    let columns = cells > 1 && !joined;
    let longest = bodies.iter().filter(|b| b.shape == Shape::Row).map(|b| b.long).max().unwrap_or(1);
    let gap = f64::min(0.16, 1.5 / (rows + cells).max(1) as f64) * w;
    let beside = (flat.saturating_sub(1).isqrt() + 1).max(1);
    let size = if beside > 1 { 1.6 / beside as f64 } else { 1.0 } * w;
    let long = |b: &Body| match b.shape {
        Shape::Row => w * (b.long as f64 / longest as f64).max(0.35),
        Shape::Cells if columns => f64::min(0.07 * (b.long - 1) as f64, 0.6) * w,
        Shape::Cells => f64::min(0.125 * (b.long - 1) as f64, 1.0) * w,
        Shape::Plane => size,
    };
    // centre of the n-th of `of` side by side
    let column = |n: usize, of: usize, apart: f64| apart * (n as f64 - 0.5 * (of as f64 - 1.0));
    let (mut depth, mut placed) = (0.0, Vec::new());
    let standing: Vec<&Body> =
        bodies.iter().zip(&tied).filter(|(b, t)| t.is_none() && b.shape == Shape::Cells).map(|(b, _)| b).collect();
    if columns {
        let apart = f64::min(0.25 * w, w / (cells - 1) as f64);
        let deepest = standing.iter().map(|b| long(b)).fold(0.0, f64::max);
        placed.extend(standing.iter().enumerate().map(|(i, b)| (*b, [column(i, cells, apart), 0.5 * deepest], true)));
        depth += deepest + gap;
    }
    for (body, tied) in bodies.iter().zip(&tied) {
        if let Some(line) = tied {
            tie(graph, p, body, long(body), *line);
        } else if body.shape == Shape::Row || body.shape == Shape::Cells && !columns {
            placed.push((body, [0.0, depth], false));
            depth += gap;
        }
    }
    let flats: Vec<&Body> =
        bodies.iter().zip(&tied).filter(|(b, t)| t.is_none() && b.shape == Shape::Plane).map(|(b, _)| b).collect();
    for shelf in flats.chunks(beside) {
        let deepest = shelf.iter().map(|b| b.sides[1] * size).fold(0.0, f64::max);
        let middle = |i: usize| [column(i, shelf.len(), 1.15 * size), depth + 0.5 * deepest];
        placed.extend(shelf.iter().enumerate().map(|(i, b)| (*b, middle(i), false)));
        depth += deepest + gap;
    }
    let back = (depth - gap).max(0.0);
    for (body, middle, turned) in placed {
        stand(graph, p, body, long(body), [middle[0], middle[1] - 0.5 * back], 0, turned);
    }
    p.front = -0.5 * back;
}

/// Returns the body of each node, counted from 1; 0 for none.
fn body_of(graph: &Graph, bodies: &[Body]) -> Vec<u32> {
    let mut of = vec![0u32; graph.len()];
    for (i, body) in bodies.iter().enumerate() {
        body.nodes.iter().for_each(|n| of[*n as usize] = i as u32 + 1);
    }
    of
}

/// Places a body in a frame around `middle`.
fn stand(graph: &Graph, p: &mut Places, body: &Body, long: f64, middle: [f64; 2], frame: usize, turned: bool) {
    for (n, at) in body.nodes.iter().zip(&body.at) {
        let (n, at) = (*n as usize, if turned { [at[1], at[0]] } else { *at });
        let at = [middle[0] + long * at[0], middle[1] + long * at[1], graph.rest[n][0]];
        p.placed[n] = Some(Placed { frame, at });
    }
    if let (Shape::Row, Some(first), Some(last)) = (body.shape, body.nodes.first(), body.nodes.last()) {
        let apart = long / (body.long as f64 - 1.0).max(4.0);
        p.beyond[*first as usize] = -apart;
        p.beyond[*last as usize] = apart;
    }
}

/// Places a body so that its mass `line`, which is linked to a mass in space, stands there and moves along that axis.
fn tie(graph: &Graph, p: &mut Places, body: &Body, long: f64, line: u32) {
    let Some((axis, middle)) = p.tied.get(&line).copied() else { return };
    let here = body.nodes.iter().position(|n| *n == line).map_or([0.0; 2], |i| body.at[i]);
    let mut new = Frame::new(axis as usize, 1.0);
    new.origin = new.across(middle);
    // another body tied to the same mass stands beside it
    let others = p.frames.iter().skip(1).filter(|f| (f.axes, f.origin) == (new.axes, new.origin)).count();
    p.frames.push(new);
    let middle = [1.2 * p.width * others as f64 - here[0] * long, -here[1] * long];
    stand(graph, p, body, long, middle, p.frames.len() - 1, false);
}

fn points(graph: &Graph, p: &mut Places) {
    for (node, under) in &graph.under {
        let mut at = [0.0; 3];
        let mut frame = None;
        for (n, weight) in under {
            if let Some(stand) = p.placed[*n as usize] {
                frame = Some(stand.frame);
                (0..3).for_each(|k| at[k] += weight * stand.at[k]);
            }
        }
        if let Some(frame) = frame {
            p.placed[*node as usize] = Some(Placed { frame, at });
        }
    }
}
