//! Energy account of the hands: one table from the forces sent to the devices to the heat of every link.
//!
//! All rows are in joules at the hand, so that energy given by a finger compares with energy felt by it. Joules of the
//! model are multiplied by the common scale of the equivalence. Energy at a key with another scale is first converted
//! to joules of the model there. Links are summed by their name in the file, because twelve keys have twelve copies of
//! each. The residual is the energy that no row explains.

use ca_core::equivalence::Gains;
use ca_core::{Ledger, Scene};
use ca_haptic::engine::{Engine, Port};

/// Rows of the account \[J\].
#[derive(Clone, Debug)]
pub struct Account {
    /// Energy sources: hands, guard and device, rate boundary, other ports, and changes.
    pub sources: Vec<(String, f64)>,
    /// Energy sinks: losses in links and masses, stored energy, and the error of the scheme.
    pub sinks: Vec<(String, f64)>,
    /// Peak of the energy stored and lost so far.
    pub peak: f64,
}

impl Account {
    /// Reads the account of an engine. Returns `None` if the engine runs without the energy ledger.
    pub fn of(engine: &Engine) -> Option<Account> {
        let scene = &engine.scene;
        let ledger = engine.state.ledger.as_ref()?;
        let scale = scene.hand.equivalence.of("").energy();
        let hand = |f: fn(&Port, usize) -> f64| -> f64 { engine.ports.iter().map(|p| at_hand(p, scale, f)).sum() };
        let given = hand(|p, k| p.chain.ledger.hand_work[k]);
        let removed = hand(|p, k| p.chain.ledger.removed(k));
        let b = ledger.balance();
        let received: f64 = ledger.hands.iter().map(|e| e.received).sum();
        // uses the ledger of the scene: a hand without force feedback gives nothing, but its model still receives
        // energy
        let leak = scale * received - hand(|p, k| p.chain.ledger.model_work[k]);
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

    /// Energy that no row explains \[J\].
    pub fn residual(&self) -> f64 {
        let sum = |rows: &[(String, f64)]| rows.iter().map(|r| r.1).sum::<f64>();
        sum(&self.sources) - sum(&self.sinks)
    }
}

/// Sums `f` over the used degrees of freedom of a device, in joules at the hand at the common scale.
fn at_hand(port: &Port, scale: f64, f: fn(&Port, usize) -> f64) -> f64 {
    let mut seen = 0_u32;
    let mut sum = 0.0;
    for l in &port.links {
        // two ports at one degree of freedom belong to one hand
        if seen >> l.dof & 1 == 0 {
            sum += f(port, l.dof) * scale / Gains::energy(l.gains);
        }
        seen |= 1 << l.dof;
    }
    sum
}

/// Returns the name of a link in its file: without its own index, and with `[*]` for the index of an instance.
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

/// Heat of the links, summed by their name in the file, largest first.
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
