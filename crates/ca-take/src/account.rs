//! Where the energy of the hands went: one table, from the forces on the wire to the heat of every link.
//!
//! Decides on joules of the hand, so that what a finger gave is what a finger feels: joules of the model times the one
//! scale of the equivalence. What crossed at a key of another scale is first made joules of the model there. Links are
//! summed by their name in the file, since twelve keys have twelve of each. What no row explains is the residual.

use ca_core::equivalence::Gains;
use ca_core::{Ledger, Scene};
use ca_haptic::engine::{Engine, Port};

/// The rows \[J\], and what they do not explain.
#[derive(Clone, Debug)]
pub struct Account {
    /// what came in: given by the hands, added by guard and device, made by the border, from other ports, by changes
    pub sources: Vec<(String, f64)>,
    /// where it is: lost in links and masses, stored, taken by the scheme
    pub sinks: Vec<(String, f64)>,
    /// largest energy stored and lost so far
    pub peak: f64,
}

impl Account {
    /// Of an engine that keeps the energy ledger; `None` where it does not.
    pub fn of(engine: &Engine) -> Option<Account> {
        let scene = &engine.scene;
        let ledger = engine.state.ledger.as_ref()?;
        let scale = scene.hand.equivalence.of("").energy();
        let hand = |f: fn(&Port, usize) -> f64| -> f64 { engine.ports.iter().map(|p| at_hand(p, scale, f)).sum() };
        let given = hand(|p, k| p.chain.ledger.given[k]);
        let removed = hand(|p, k| p.chain.ledger.removed(k));
        let b = ledger.balance();
        let received: f64 = ledger.hands.iter().map(|e| e.received).sum();
        // by the ledger of the scene: a hand that is sent no force gives nothing to a model that receives all the same
        let leak = scale * received - hand(|p, k| p.chain.ledger.asked[k]);
        let sources = vec![
            ("given by the hands".into(), given),
            ("added by guard and device".into(), removed),
            ("made by the border".into(), leak),
            ("received at other ports".into(), scale * (b.work - received)),
            ("brought by changes".into(), scale * b.changed),
        ];
        let mut sinks: Vec<(String, f64)> = lost(scene, ledger).into_iter().map(|(n, j)| (n, scale * j)).collect();
        sinks.push(("lost in masses".into(), scale * ledger.lost_mats));
        sinks.push(("stored, more than at load".into(), scale * (b.h - b.h0)));
        sinks.push(("taken by the scheme".into(), -scale * b.scheme_error));
        Some(Account { sources, sinks, peak: scale * b.peak })
    }

    /// What no row explains \[J\].
    pub fn residual(&self) -> f64 {
        let sum = |rows: &[(String, f64)]| rows.iter().map(|r| r.1).sum::<f64>();
        sum(&self.sources) - sum(&self.sinks)
    }
}

/// The sum over the degrees of freedom of a device that move something, as joules of the hand at the common scale.
fn at_hand(port: &Port, scale: f64, f: fn(&Port, usize) -> f64) -> f64 {
    let mut seen = 0_u32;
    let mut sum = 0.0;
    for l in &port.links {
        // two ports of one degree of freedom are one hand
        if seen >> l.dof & 1 == 0 {
            sum += f(port, l.dof) * scale / Gains::energy(l.gains);
        }
        seen |= 1 << l.dof;
    }
    sum
}

/// The line of the file that a link comes from: without its own index, those of instances as `[*]`.
fn line(name: &str) -> String {
    let own = name.rfind('[').filter(|i| !name[*i..].contains('.')).unwrap_or(name.len());
    let mut parts = name[..own].split('[');
    let mut line = parts.next().unwrap_or("?").to_owned();
    for part in parts {
        line += "[*]";
        line += part.split_once(']').map_or(part, |p| p.1);
    }
    line
}

/// Heat of links, by their name in the file, most first.
fn lost(scene: &Scene, ledger: &Ledger) -> Vec<(String, f64)> {
    let mut list: Vec<(String, f64)> = Vec::new();
    let mut links: Vec<_> = ca_core::internal::scene::audited_links(scene).collect();
    links.sort_by_key(|(i, _)| *i);
    for (i, name) in links {
        let name = format!("lost in `{}`", line(&name.to_string()));
        match list.iter_mut().find(|r| r.0 == name) {
            Some(row) => row.1 += ledger.lost[i],
            None => list.push((name, ledger.lost[i])),
        }
    }
    list.sort_by(|a, b| b.1.total_cmp(&a.1));
    list
}

#[cfg(test)]
mod tests {
    #[test]
    fn links_of_all_instances_are_one_line() {
        for (name, line) in [
            ("hair", "hair"),
            ("low[3]", "low"),
            ("key[11].strike", "key[*].strike"),
            ("key[0].s.one.bend[4]", "key[*].s.one.bend"),
            ("a[1].b[2].c[3]", "a[*].b[*].c"),
        ] {
            assert_eq!(super::line(name), line);
        }
    }
}
