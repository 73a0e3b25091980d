//! Describes the stability of a scene.

use crate::load::ticked;
use ca_core::internal::scene::growth::Growth;
use ca_core::{Certificate, Unit};
use ca_model::quantity::{rounded, short, show};

/// Maximum number of modules named in a line.
const NAMED: usize = 3;

/// Describes the certificate in one line.
pub fn stability(c: &Certificate) -> String {
    let linear = if c.worst.is_empty() {
        String::new()
    } else {
        format!("; linear part: bound {} of 4, nearest `{}`", short(c.bound), c.worst)
    };
    let margin = if c.margin().is_finite() { format!("margin {}", short(c.margin())) } else { "no limit".into() };
    let silent = match &c.not_judged[..] {
        [] => String::new(),
        list if list.len() <= NAMED => {
            format!("; not judged, no output depends on it: {}", ticked(list.iter().map(String::as_str)))
        }
        list => {
            let first = ticked(list[..NAMED].iter().map(String::as_str));
            format!("; not judged, no output depends on it: {first} and {} more", list.len() - NAMED)
        }
    };
    let by = if c.rules.decides.is_empty() { String::new() } else { format!(", decided by `{}`", c.rules.decides) };
    format!("{}{by}, {margin}{linear}{silent}", c.level)
}

/// Describes the stiffest explicit contact, and how often energy grew in such contacts, if it grew in any run.
pub fn contacting(c: &Certificate) -> Option<String> {
    (c.rules.contact > 0.0).then(|| {
        let growth = Growth::near(c.rules.contact);
        let played = if growth.grew > 0 { format!("; {growth}") } else { String::new() };
        let (name, stiffness) = (&c.rules.stiffest, short(c.rules.contact));
        format!("`{name}` is the stiffest: kT²/m {stiffness}; an impact may add energy at any value{played}")
    })
}

/// Names the links that are judged only at rest.
pub fn opened(c: &Certificate) -> Option<String> {
    let names = ticked(c.rules.open.iter().map(String::as_str));
    (!c.rules.open.is_empty())
        .then(|| format!("{names}: stiffness grows with elongation, whose limit is unknown; judged at rest only"))
}

/// Describes the ripple of energy of a linearised scene.
pub fn rippling(ripple: f64) -> String {
    format!("undisturbed, the energy of small motions rises by at most {} % and does not drift", short(100.0 * ripple))
}

/// Names a contact that stiffens with depth, and the depth beyond which it is too steep.
pub fn deepening((name, depth): &(String, f64)) -> String {
    let depth = show(rounded(*depth, 3), Unit::METRE);
    format!("`{name}` stiffens with depth: slope·T²/m is 1 at {depth}")
}
