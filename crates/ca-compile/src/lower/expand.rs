//! Expands the output of a generator to modules with names, kinds and parameter sources.

use crate::net::waveguides::WaveguideNode;
use crate::net::{End, Family, LiaNode, MatNode, MatRole, Measure, Resolved};
use alloc::sync::Arc;
use alloc::vec::Vec;
use ca_core::internal::kind::builder::{Builder, Built};
use ca_core::internal::kind::name::Part;
use ca_core::internal::live::Source;
use ca_core::{Kind, Name, Role};

/// The most recent lists of sources: most modules of a generator share one.
#[derive(Default)]
struct Shared(Vec<Arc<[Source]>>);

impl Shared {
    fn list(&mut self, values: &[Source]) -> Arc<[Source]> {
        if let Some(known) = self.0.iter().find(|s| s[..] == *values) {
            return known.clone();
        }
        let new: Arc<[Source]> = Arc::from(values);
        self.0.truncate(7);
        self.0.insert(0, new.clone());
        new
    }
}

/// Adds the modules of item `item` to the network. A later pass chooses the cheapest law of each link, as for links
/// written one by one.
pub fn expand(net: &mut Resolved, item: u32, built: &Builder<'_>, (dim, rest): (u8, [f64; 3]), group: Option<u32>) {
    let name = net.items[item as usize].name.clone();
    let base = net.mats.len() as u32;
    let mut shared = Shared::default();
    let mut family = Family { size: built.size, ..Family::default() };
    net.mats.reserve(built.mats.len());
    net.lias.reserve(built.links.len());
    family.masses.reserve(built.mats.len());
    // Values of the previous module: most modules repeat them.
    let mut last: Option<(Built, Arc<[Source]>)> = None;
    for (i, (what, index)) in built.mats.iter().enumerate() {
        let id = base + i as u32;
        let (kind, slots): (&'static Kind, &[(usize, u32)]) = match what {
            Built::Mass(m, z) if built.nothing(*z) => (&ca_core::internal::mat::MAS, &[(0, *m)]),
            Built::Mass(m, z) => (&ca_core::internal::mat::CEL, &[(0, *m), (2, *z)]),
            Built::Cell(m, f, t60) => (&ca_core::internal::mat::CEL, &[(0, *m), (3, *f), (4, *t60)]),
            Built::Fixed | Built::Anchor => (&ca_core::internal::mat::SOL, &[]),
        };
        let name = if *what == Built::Anchor {
            family.anchors.push(id);
            Name::new(&name, Part::End, (family.anchors.len() - 1).into())
        } else {
            family.masses.push(id);
            Name::new(&name, Part::Own, *index)
        };
        let Role::Mat(spec) = kind.role else { continue };
        let values = match &last {
            Some((of, values)) if of == what => values.clone(),
            _ => {
                let mut values = alloc::vec![Source::Absent; kind.params.len()];
                for (param, slot) in slots {
                    values[*param] = Source::Slot(*slot);
                }
                shared.list(&values)
            }
        };
        last = Some((*what, values.clone()));
        net.mats.push(MatNode {
            name,
            code: kind.code,
            role: MatRole::Mat(spec),
            values,
            axes: dim,
            rest: built.places.get(i).map_or(rest, |p| core::array::from_fn(|k| rest[k] + p[k])),
            dx0: [0.0; 3],
            v: built.speeds.get(i).copied().unwrap_or([0.0; 3]),
            group,
            item,
        });
    }
    let Role::Lia(law) = ca_core::internal::phi::REF.role else { return };
    let of_links = net.lias.len() as u32;
    family.links = (of_links..of_links + built.links.len() as u32).collect();
    for (i, l) in built.links.iter().enumerate() {
        net.lias.push(LiaNode {
            name: Name::new(&name, Part::Link, i.into()),
            kind: &ca_core::internal::phi::REF,
            law,
            values: shared.list(&[Source::Absent, Source::Slot(l.k), Source::Slot(l.z), Source::Absent]),
            ends: l.ends.map(|e| End::Mat(base + e)),
            measure: if dim == 1 { Measure::Line([0, 0]) } else { Measure::Radial },
            onto: None,
            sets: None,
            l0: l.l0,
            soften: 0.0,
            item,
        });
    }
    net.lines.extend(built.line.clone().map(|asked| WaveguideNode { item, first: base, spec: asked, tuned: None }));
    family.nodes = built.nodes.iter().map(|n| base + n).collect();
    net.families.insert(&name, family);
}
