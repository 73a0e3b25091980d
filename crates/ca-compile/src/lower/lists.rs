//! Reads values of more than one number: positions, directions, nodes, points of a table, and files.

use crate::findings::quoted;
use crate::lower::values::Values;
use alloc::format;
use alloc::string::String;
use alloc::vec::Vec;
use ca_core::Unit;
use ca_core::internal::kind::builder::Arg;
use ca_model::diag::Diag;
use ca_model::quantity::Plain;
use ca_model::{Entry, Value};

impl Values<'_> {
    /// Reads a whole number.
    pub(super) fn count(&mut self, e: &Entry, (min, max): (u32, u32), what: &str) -> Option<f64> {
        let v = self.constant(e, Unit::NONE, (f64::from(min), f64::from(max)), what)?;
        if v != libm::floor(v) {
            let d = Diag::error("E006", format!("{what} must be a whole number: {}", Plain(v))).at(e.span, "not whole");
            let near = libm::round(v).max(f64::from(min));
            self.diags.push(d.help(format!("the nearest is {near}")).fix(e.span, format!("{near}")));
            return None;
        }
        Some(v)
    }

    /// Reads a position or a velocity: one number or a list. Its length is checked later, by the axes of the group.
    pub fn position(&mut self, e: &Entry, unit: Unit, what: &str) -> Option<Arg> {
        let Value::List(list) = &e.value else {
            return self.constant(e, unit, ca_core::ANY, what).map(Arg::Num);
        };
        let read: Vec<_> = list.iter().map(|x| self.constant(x, unit, ca_core::ANY, what)).collect();
        read.into_iter().collect::<Option<Vec<f64>>>().map(Arg::List)
    }

    /// Reads a list of positions in space into one flat list.
    pub(super) fn positions(&mut self, e: &Entry, unit: Unit, what: &str) -> Option<Vec<f64>> {
        let help = format!("write e.g. `[[0, 0, 0], [{}, 0, 0]]`", quoted(unit));
        let Value::List(list) = &e.value else {
            return self.wrong_type(what, "a list of points", &e.value, e.span, &help);
        };
        let mut all = Vec::with_capacity(3 * list.len());
        for p in list {
            match self.position(p, unit, what)? {
                Arg::List(l) if l.len() == 3 => all.extend(l),
                _ => {
                    let d = Diag::error("E006", format!("{what}: a point in space has three numbers"));
                    self.diags.push(d.at(p.span, "does not fit").help(help));
                    return None;
                }
            }
        }
        if all.is_empty() {
            self.diags.push(Diag::error("E006", format!("{what} is an empty list")).at(e.span, "no point").help(help));
        }
        (!all.is_empty()).then_some(all)
    }

    /// Returns the contents of a file, with a note about omitted points and faces.
    pub(super) fn file(&mut self, e: &Entry, what: &str) -> Option<Arg> {
        let Value::Text(name) = &e.value else {
            return self.wrong_type(what, "the name of a file", &e.value, e.span, "write e.g. `\"bell.ply\"`");
        };
        let unread = |what: String| Diag::error("E031", what).at(e.span, "cannot be read");
        match self.clouds.get(name).cloned() {
            Some(Ok(cloud)) => {
                let count = |n: usize, one: &str, many: &str| match n {
                    0 => None,
                    1 => Some(format!("1 {one}")),
                    n => Some(format!("{n} {many}")),
                };
                let left = [
                    count(
                        cloud.merged,
                        "point coincides with another and was merged with it",
                        "points coincide with others and were merged with them",
                    ),
                    count(cloud.flat, "face without area was left out", "faces without area were left out"),
                ];
                let left = left.into_iter().flatten().collect::<Vec<_>>().join("; ");
                if !left.is_empty() {
                    let d = Diag::note("N202", format!("{what}: {left}")).at(e.span, "not all of it is used");
                    self.diags.push(d.help(
                        "this is normal if the drawing has seams; otherwise correct the file in the program that \
                             made it",
                    ));
                }
                Some(Arg::Cloud(cloud))
            }
            Some(Err(why)) => {
                self.diags.push(unread(format!("{what}: {}", why.what)).help(why.help));
                None
            }
            None => {
                let help = "save the model in the folder of this file; a program that calls the compiler must pass the \
                            contents of files";
                self.diags.push(unread(format!("{what}: file `{name}` is not available")).help(help));
                None
            }
        }
    }

    /// Reads a direction as a unit vector.
    pub(super) fn direction(&mut self, e: &Entry, what: &str) -> Option<Arg> {
        const HELP: &str = "write `\"x\"`, `\"y\"`, `\"z\"`, or a list of two or three numbers such as `[0, 0.6, 0.8]`";
        let n = match &e.value {
            Value::Text(t) => crate::lower::space::AXES.iter().position(|a| a == t).map(|k| {
                let mut n = [0.0; 3];
                n[k] = 1.0;
                n
            }),
            Value::List(list) if matches!(list.len(), 2 | 3) => {
                let mut n = [0.0; 3];
                for (n, x) in n.iter_mut().zip(list) {
                    *n = self.constant(x, Unit::NONE, (-1e100, 1e100), what)?;
                }
                let l = libm::sqrt(n.iter().map(|v| v * v).sum::<f64>());
                (l > 0.0 && l.is_finite()).then(|| n.map(|v| v / l))
            }
            _ => None,
        };
        if n.is_none() {
            let d = Diag::error("E006", format!("{what} is not a direction")).at(e.span, "not a direction");
            self.diags.push(d.help(HELP));
        }
        n.map(|n| Arg::List(n.to_vec()))
    }

    /// Reads a list of nodes into one flat list.
    pub(super) fn nodes(&mut self, e: &Entry, what: &str) -> Option<Vec<f64>> {
        let whole = |v: &Entry| match v.value {
            Value::Num(n) if n == libm::floor(n) && n.abs() < 1e6 => Some(n),
            _ => None,
        };
        let node = |p: &Entry| match &p.value {
            Value::List(pair) if pair.len() == 2 => Some([whole(&pair[0])?, whole(&pair[1])?]),
            _ => None,
        };
        let Value::List(list) = &e.value else {
            return self.wrong_type(what, "a list of nodes", &e.value, e.span, "write e.g. `[[0, 0], [-1, -1]]`");
        };
        if let Some(bad) = list.iter().find(|p| node(p).is_none()) {
            let d = Diag::error("E006", format!("{what}: a node is two whole numbers")).at(bad.span, "not a node");
            self.diags.push(d.help("write e.g. `[[0, 0], [-1, -1]]`; −1 is the last"));
            return None;
        }
        Some(list.iter().filter_map(node).flatten().collect())
    }

    /// Reads a list of points; each column has its unit.
    pub fn points(&mut self, e: &Entry, x: Unit, y: Unit, what: &str) -> Option<Vec<[f64; 2]>> {
        let Value::List(list) = &e.value else {
            let help = format!("write `[[{}, {}], …]`", quoted(x), quoted(y));
            return self.wrong_type(what, "a list of points", &e.value, e.span, &help);
        };
        let mut points = Vec::with_capacity(list.len());
        let mut good = true;
        for p in list {
            match &p.value {
                Value::List(pair) if pair.len() == 2 => {
                    let a = self.constant(&pair[0], x, ca_core::ANY, what);
                    let b = self.constant(&pair[1], y, ca_core::ANY, what);
                    match (a, b) {
                        (Some(a), Some(b)) => points.push([a, b]),
                        _ => good = false,
                    }
                }
                _ => {
                    // Only the first bad point is reported: a list of plain numbers is wrong everywhere.
                    if good {
                        let d =
                            Diag::error("E019", format!("{what}: a point has two numbers")).at(p.span, "not a pair");
                        self.diags.push(d.help(format!("write `[[{}, {}], …]`", quoted(x), quoted(y))));
                    }
                    good = false;
                }
            }
        }
        good.then_some(points)
    }
}
