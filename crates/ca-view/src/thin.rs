//! Selects the nodes to draw if there are too many.
//!
//! Of nodes made together, every k-th is drawn, on a grid every √k-th in both directions, always with the last of a
//! row, so the shape stays. An end of a link that is not drawn moves to a drawn node nearby, if its item is chained
//! in order; otherwise the link is not drawn.

use crate::graph::{Graph, Item, NONE};
use ca_core::internal::kind::name::Index;

/// Largest number of drawn masses, which may be exceeded a little.
pub const MOST: usize = 20_000;

/// Returns the drawn nodes in order, and for each node the drawn one that replaces it, or [`NONE`].
pub fn thin(graph: &Graph, chained: &[bool], most: usize) -> (Vec<u32>, Vec<u32>) {
    let n = graph.len();
    if n <= most {
        return ((0..n as u32).collect(), (0..n as u32).collect());
    }
    let k = n.div_ceil(most.max(1)) as u32;
    let both = (k - 1).isqrt() + 1;
    let single = |item: &&Item| item.len == 1 && !item.between;
    let crowd = graph.items.iter().filter(single).count() > most / 10;
    let (mut kept, mut near, mut singles) = (vec![false; n], vec![NONE; n], 0);
    for (item, chained) in graph.items.iter().zip(chained) {
        if item.len == 1 {
            let shown = item.between || !crowd || singles % k == 0;
            singles += u32::from(!item.between);
            kept[item.first as usize] = shown;
            near[item.first as usize] = item.first;
            continue;
        }
        let mut corner = std::collections::HashMap::new();
        for node in item.nodes() {
            let (i, row) = (node as u32 - item.first, graph.index[node]);
            let (shown, to) = if let (Some([nx, ny]), Index::Two(i, j)) = (item.grid, row) {
                let shown = (i % both == 0 || i + 1 == nx) && (j % both == 0 || j + 1 == ny);
                let cell = [i, j].map(|v| v / both);
                if shown {
                    corner.entry(cell).or_insert(node as u32);
                }
                // hidden nodes move to the first of their cell
                (shown, corner.get(&cell).copied().unwrap_or(NONE))
            } else {
                let last = i + 1 == item.len;
                (i % k == 0 || last, if last { node as u32 } else { item.first + i / k * k })
            };
            kept[node] = shown;
            near[node] = if shown { node as u32 } else { to };
            if !*chained && !shown {
                near[node] = NONE;
            }
        }
    }
    let drawn: Vec<u32> = (0..n as u32).filter(|i| kept[*i as usize]).collect();
    for to in &mut near {
        if *to != NONE && !kept[*to as usize] {
            *to = NONE;
        }
    }
    (drawn, near)
}
