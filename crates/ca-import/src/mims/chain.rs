//! Finds strings and chains: rows of masses in which each is linked to the next.
//!
//! A row is a maximal path of masses with at most two links of its class. A mass with three such links ends three rows
//! and belongs to none, since a row through it would have to choose two of three. Rows of fewer than [`SHORTEST`]
//! masses are easier to read as they are. A row is a STRING if a ground holds each end by the same law, otherwise a
//! CHAIN, and the links at its ends stay. A ground that several strings share is copied to each. It does not move, so
//! only an output of its force could show the difference; then the ground stays.

use super::generator_plan::{Generator, GeneratorPlan};
use super::graph::{Graph, Law, LawKey, key, medium};
use super::names::{Names, stem};
use super::part::Arg;
use alloc::collections::{BTreeMap, BTreeSet};
use alloc::format;
use alloc::vec::Vec;

/// Smallest number of masses in a row that is written as a generator.
const SHORTEST: usize = 4;

/// Links of one law between masses of one inertia.
#[derive(Default)]
struct Class {
    links: Vec<usize>,
    m: Option<Arg>,
    law: Option<Law>,
}

pub(super) fn chains(graph: &Graph<'_>, names: &mut Names, plan: &mut GeneratorPlan) {
    let mut classes: BTreeMap<((u8, u64), LawKey), Class> = BTreeMap::new();
    for (i, part) in graph.parts.iter().enumerate() {
        let (Some(law), [a, b]) = (graph.law(i), &part.ends[..]) else { continue };
        let (Some(m), Some(m_b)) = (graph.mass(*a), graph.mass(*b)) else { continue };
        if m == m_b && !plan.gone[i] {
            let class = classes.entry((m.key(), key(law))).or_default();
            class.links.push(i);
            (class.m, class.law) = (Some(m), Some(law));
        }
    }
    let mut classes: Vec<Class> = classes.into_values().collect();
    classes.sort_by_key(|c| core::cmp::Reverse(c.links.len()));
    for class in classes {
        let (Some(m), Some(law)) = (class.m, class.law) else { continue };
        for path in paths(graph, &class.links, plan) {
            write(graph, &path, m, law, names, plan);
        }
    }
}

struct Path {
    masses: Vec<usize>,
    links: Vec<usize>,
}

fn paths(graph: &Graph<'_>, links: &[usize], plan: &GeneratorPlan) -> Vec<Path> {
    let mut near: BTreeMap<usize, Vec<(usize, usize)>> = BTreeMap::new();
    let mut pairs = BTreeSet::new();
    for &link in links {
        let [a, b] = graph.parts[link].ends[..] else { continue };
        if !plan.gone[a] && !plan.gone[b] && pairs.insert((a.min(b), a.max(b))) {
            near.entry(a).or_default().push((b, link));
            near.entry(b).or_default().push((a, link));
        }
    }
    let member: BTreeSet<usize> = near.iter().filter(|(_, n)| n.len() <= 2).map(|(a, _)| *a).collect();
    let inner = |a: &usize| near[a].iter().filter(|(b, _)| member.contains(b)).count();
    let ends = member.iter().filter(|a| inner(a) < 2);
    let rings = member.iter().filter(|a| inner(a) == 2);
    let mut seen = BTreeSet::new();
    let mut found = Vec::new();
    for &start in ends.chain(rings) {
        if !seen.insert(start) {
            continue;
        }
        let mut path = Path { masses: Vec::from([start]), links: Vec::new() };
        let mut at = start;
        while let Some(&(next, link)) = near[&at].iter().find(|(b, _)| member.contains(b) && !seen.contains(b)) {
            seen.insert(next);
            path.masses.push(next);
            path.links.push(link);
            at = next;
        }
        if path.masses.len() >= SHORTEST {
            found.push(path);
        }
    }
    found
}

fn write(graph: &Graph<'_>, path: &Path, m: Arg, law: Law, names: &mut Names, plan: &mut GeneratorPlan) {
    let (Some(&first), Some(&last)) = (path.masses.first(), path.masses.last()) else { return };
    let labels: Vec<&str> = path.masses.iter().map(|&p| graph.parts[p].name.as_str()).collect();
    let mut base = stem(&labels);
    if base.is_empty() {
        base.push_str("chain");
    }
    let held = ground_link(graph, first, law, plan)
        .and_then(|a| ground_link(graph, last, law, plan).map(|b| [(first, a), (last, b)]));
    let name = names.unique(&base);
    for (i, &mass) in path.masses.iter().enumerate() {
        plan.names.insert(mass, format!("{name}[{i}]"));
    }
    let at = path.masses.iter().copied().min().unwrap_or(first);
    for (i, (mass, link)) in held.into_iter().flatten().enumerate() {
        let ground = graph.other_end(link, mass);
        plan.names.entry(ground).or_insert_with(|| format!("{name}.end[{i}]"));
        plan.gone[link] = true;
        plan.gone[ground] = true;
    }
    for &part in path.masses.iter().chain(&path.links) {
        plan.gone[part] = true;
    }
    let mut args = Vec::from([("n", Arg::Num(path.masses.len() as f64))]);
    args.extend(medium(m, law));
    if held.is_some() {
        args.push(("ends", Arg::Word("fixed")));
    }
    let kind = if held.is_some() { "STRING" } else { "CHAIN" };
    plan.generators.push(Generator { kind, name, args, fixed: Vec::new(), at, members: (first, last) });
}

/// Finds a link of this law from `mass` to a ground at 0 that can become the end of a string.
fn ground_link(graph: &Graph<'_>, mass: usize, law: Law, plan: &GeneratorPlan) -> Option<usize> {
    let own =
        |ground: usize| graph.is_ground(ground) && (graph.links[ground].len() == 1 || !graph.weighed.contains(&ground));
    let fits = |link: usize| !plan.gone[link] && graph.law(link) == Some(law) && own(graph.other_end(link, mass));
    graph.links[mass].iter().copied().find(|&link| fits(link))
}
