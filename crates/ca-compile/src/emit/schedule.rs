//! Schedule: builds the flat arrays and the list of passes of a scene, with entries only for parts that it has.

use crate::emit::clusters::clusters;
use crate::emit::driven;
use crate::emit::gesture_rate::{self, Slow};
use crate::emit::high_pass::{blockers, of_motion, plain_first};
use crate::emit::layout_builder::LayoutBuilder;
use crate::emit::masses::{Masses, masses, weigh};
use crate::emit::methods::oversample::oversample;
use crate::emit::methods::pefrl;
use crate::emit::milib;
use crate::emit::ordering::Storage;
use crate::emit::pass_list;
use crate::emit::points::{self, Points, points};
use crate::emit::rows::document_order::DocumentOrder;
use crate::emit::rows::fold::fold;
use crate::emit::rows::fuse::{self, Passes};
use crate::emit::rows::links::{Links, own_tables};
use crate::emit::rows::space::rows;
use crate::net::{End, LiaNode, MatRole, OutNode, OutputTap, Pruned, Push};
use crate::options::{KernelClass, Options};
use crate::passes::implicit;
use alloc::boxed::Box;
use alloc::collections::BTreeSet;
use alloc::string::String;
use alloc::sync::Arc;
use alloc::vec::Vec;
use ca_core::internal::kind::PortRole;
use ca_core::internal::live::Loader;
use ca_core::internal::numeric::{Aligned, VerletList};
use ca_core::internal::op::energy::empty_ledger;
use ca_core::internal::op::layout::{
    Account, AccountFns, Counts, Enf, Enx, Layout, LedgerLayout, LinkArrays, MeasureKind, Output, OutputArrays, Places,
    PortArrays, Rates, Row, SolvedModal, Tap,
};
use ca_core::internal::op::{Op, Vectors};
use ca_core::internal::scene::symbols::SymbolsBuilder;
use ca_core::internal::scene::{
    About, Before, InHand, Order, OutputNames, Passes as ScenePasses, Start, identify, start,
};
use ca_core::internal::state::{
    ActiveContacts, Border, Cell, LinkState, PortState, Ramps, UNKNOWN, give_to, set_order,
};
use ca_core::{Certificate, InputRole, Location, Precision, Scene, State};
use ca_model::Model;
use ca_model::diag::Diags;
use ca_model::printable::printable;
use core::ops::Range;

/// Builds the scene, with its groups at the gesture rate if there are any. Returns `None` if there is an error.
pub fn schedule(
    model: &Model,
    net: &Pruned,
    storage: &Storage,
    options: &Options,
    certificate: Certificate,
    slow: Option<&Slow>,
    diags: &mut Diags,
) -> Option<Scene> {
    let order = &storage.order[..];
    let builder = LayoutBuilder::new(net, order);
    let (batches, sorted) = builder.batches(options.kernel);
    let sorted = sorted || storage.sorted || slow.is_some_and(|slow| slow.scene.passes.sorted);
    let mut written = DocumentOrder::new(&batches);
    let mut batches = builder.chained(options, batches);
    let settled = builder.settled(order, options, &batches);
    let order = settled.as_deref().unwrap_or(order);
    let (listed, mut builder) = (builder, LayoutBuilder::new(net, order));
    let mut masses = masses(&mut builder);
    let n_mat = masses.x.len();
    let mut classes = builder.classes(order, n_mat);
    fuse::mark(&builder, options, &mut classes, &mut batches);
    pass_list::fill_classes(&mut classes);
    let mut batches = builder.joined(options, batches);
    // Slots are final from here on.
    let moved = settled.is_some().then(|| listed.moved(&builder));
    let folded = fold(&mut builder, &mut masses, &mut classes, &mut batches);
    let last = |slot: u32| folded.get(slot as usize).copied().unwrap_or(slot);
    written.slots = moved.map_or_else(|| folded.clone(), |moved| moved.into_iter().map(last).collect());
    let batches = builder.fanned(options, batches);
    let Masses { x, v, rest } = masses;
    let n_mat = x.len();
    let (enx, tgr) = (ports(&builder, PortRole::Enx), ports(&builder, PortRole::Tgr));
    let late = enx.iter().chain(&tgr).filter(|p| p.implicit && options.is_since(6));
    let ahead: Vec<u32> = late.map(|p| p.mat).collect();
    let pushes = |on_line: bool| net.pushes.iter().filter(move |p| net.pushes_line(p) == on_line);
    let pushed = |p: &Push| Some(Enf { input: p.input, mat: builder.alive(p.end, p.axis)? });
    let in_space: Vec<Enf> = pushes(false).filter_map(pushed).collect();
    let on_line: Vec<Enf> = pushes(true).filter_map(pushed).collect();
    // This order makes the coefficients contiguous.
    let (weight, weighed) = weigh(&mut builder);
    let first_of_links = builder.coef.len();
    let links = builder.links(batches, options, diags, model);
    written.coefs(n_mat, first_of_links..builder.coef.len(), &links);
    let Points { nodes, moving: moving_points, modal, shares, aimed } = points(&mut builder);
    let solved_modal = points::solved(&mut builder, n_mat, links.tap, (&modal, &shares));
    let (gains, outputs) = outputs(&mut builder, &links)?;
    let implicit = builder.implicit(n_mat, &links, model, diags);
    // Passes before the links shift all of them in the list of forces; passes after them shift only the late links. The
    // same order as in `pass_list::forces`.
    let waves = builder.waves(links.mem);
    let lead = [!in_space.is_empty(), !weighed.is_empty(), !waves.delays.is_empty()].into_iter().filter(|b| *b).count();
    let solved = implicit.as_ref().map_or([false; 2], |(a, _)| [!a.places.is_empty(), !a.pairs.is_empty()]);
    let behind = [!on_line.is_empty(), !moving_points.is_empty(), !modal.is_empty()];
    let solved = [solved[0], solved[1], !solved_modal.list.is_empty()];
    let back = behind.into_iter().chain(solved).filter(|b| *b).count();
    let (in_space, enf) = (in_space.len(), [in_space, on_line].concat());
    let place = |op: usize| op + lead + if op >= links.late { back } else { 0 };
    let slow = slow.map(|slow| (slow, slow.group(&builder), slow.reach(&builder)));
    let copies = slow.iter().flat_map(|(_, group, _)| group.ports.iter().map(|p| p.at));
    let ported: BTreeSet<u32> = enx.iter().chain(&tgr).map(|p| p.mat).chain(copies).collect();
    let ledger = options.energy.then(|| {
        let mut live = builder.live.clone();
        live.sort_unstable();
        let turns = |coefs: Range<usize>| {
            let next = live.get(live.partition_point(|c| (*c as usize) < coefs.start));
            next.is_some_and(|c| coefs.contains(&(*c as usize)))
        };
        let moving: BTreeSet<u32> = moving_points.iter().filter(|_| aimed).map(|p| p.mat).collect();
        let accounts = accounts(&links, n_mat, |p| ported.contains(&p), place);
        let of_ends = |ends: &[[u32; 2]], first: usize, n: usize| {
            !moving.is_empty() && ends[first..first + n].iter().flatten().any(|p| moving.contains(p))
        };
        let live = |a: &Account| {
            let second = a.ports.onto.is_some_and(|o| of_ends(&links.onto, o.1, a.n));
            turns(a.coef..a.coef + a.n * a.law.coefs) || of_ends(&links.ends, a.first, a.n) || second
        };
        let accounts = accounts.into_iter().map(|a| Account { live: live(&a), ..a }).collect();
        LedgerLayout { accounts, weight, live: turns(0..3 * n_mat) || turns(weight..weight + weighed.len()) }
    });
    let mut symbols = symbols(&builder, &links, place);
    let (moves, own) = pass_list::moves(&classes, n_mat, waves.delays.len());
    let unfused = slow.as_ref().filter(|(_, group, _)| group.compensated).map(|_| moves.clone());
    let mut live = builder.live_table(implicit.as_ref());
    let whole = live.implicit.as_ref().map_or(u32::MAX, |a| a.first);
    let (coef, live_places) = (builder.coef, builder.live);
    let mut layout = Layout {
        rates: Rates {
            sample_dt: 1.0 / net.rate,
            ratio: net.ratio,
            frame: net.ratio * net.oversample,
            slow: None,
            substeps: None,
        },
        counts: Counts {
            n_mat,
            n_lia: links.ends.len(),
            n_coef: coef.len(),
            n_mem: links.mem + waves.len,
            n_touch: links.touch,
            n_tap: links.tap + solved_modal.list.len() * SolvedModal::TAPS,
            channels: net.channels.len(),
            n_out: net.outs.iter().map(|o| o.channel as usize + 1).max().unwrap_or(0).max(net.channels.len()),
        },
        links: LinkArrays {
            ends: links.ends,
            onto: links.onto,
            reach: links.reach,
            rows: Vec::new(),
            pair_sets: links.pair_sets,
            e0: links.e0,
            clusters: Vec::new(),
        },
        out: OutputArrays {
            output_rows: Vec::new(),
            links: links.outputs.into_iter().map(|(_, h)| h).collect(),
            outputs,
            of_motion: of_motion(net),
            blockers: blockers(model, net, diags),
            lowpass: if net.channels.is_empty() { Vec::new() } else { net.lowpass.clone() },
        },
        places: Places {
            rest,
            nodes,
            moving_points,
            modal,
            shares,
            solved_modal: solved_modal.list,
            modal_couplings: solved_modal.groups,
            couplings: solved_modal.couplings,
        },
        tables: net.tables.iter().cloned().chain(own_tables(net).into_iter().map(|(_, t)| t)).collect(),
        ports: PortArrays {
            enx,
            enf,
            tgr,
            ahead,
            driven: driven::tables(net, &mut live, diags),
            crossing: net.crossing,
        },
        waves,
        weighed,
        implicit: implicit.map(|a| a.0),
        ledger,
        vectors: Vectors::detect(),
    };
    layout.links.rows = rows(&links.forces, &layout.links.ends, &layout.links.reach, &layout.places.rest);
    if options.is_since(8) && layout.places.modal_couplings.is_empty() {
        layout.links.clusters = clusters(&links.forces, &layout.links, &coef[2 * n_mat..3 * n_mat]);
    }
    let mut reads = pass_list::reads(&layout, live_places.len(), aimed);
    let sweeps = options.is_since(7);
    let mut forces = pass_list::forces(&layout, links.forces, links.late, weight, in_space, sweeps);
    if let Some((_, group, _)) = &slow {
        gesture_rate::passes(group, &mut reads, &mut forces);
    }
    layout.out.output_rows = pass_list::output_rows(&layout);
    let mut writes = pass_list::writes(&layout, gains);
    let mut moves = if net.is_composed() { pefrl::moves(&layout, &forces, own) } else { moves };
    // The start sums forces in the order of this list.
    let listed = forces.clone();
    let accounts = layout.ledger.as_mut().map_or(&mut [][..], |l| &mut l.accounts);
    let mut passes = Passes { forces: &mut forces, moves: &mut moves, symbols: &mut symbols, accounts };
    let fused = fuse::fuse(&mut passes);
    if options.kernel == KernelClass::Fast {
        moves = pass_list::merged(moves);
    }
    let summed = &forces[..forces.len() - fused];
    let tick = slow.as_ref().map(|_| match unfused {
        Some(unfused) => gesture_rate::Tick::proportional(&listed, unfused),
        None => gesture_rate::Tick { forces: summed.to_vec(), moves: moves.clone() },
    });
    oversample(net, &mut layout, &mut reads, summed, &mut writes, &mut moves);
    milib::check(model, net, &layout, &listed, diags);
    let order = match () {
        () if net.is_composed() => Order::Exact,
        () if implicit::is_fourth(net) => Order::Fourth,
        () => Order::Second,
    };
    let begin = Start { order, sticks: options.is_since(5) };
    let mut loaded = loaded(net, &layout, &x, &v, &coef, (live_places, whole));
    let order_of_document = written.orders(loaded.coef.len());
    set_order(&mut loaded, order_of_document);
    if let Some(((slow, mut group, reach), tick)) = slow.zip(tick) {
        let own = slow.state(&group);
        let blank = gesture_rate::blank(&loaded, own.clone());
        group.response = gesture_rate::response(&layout, &group, &tick, &blank, &reach);
        loaded.slow = Some(Box::new(own));
        layout.rates.slow = Some(Arc::new(group));
    }
    let as_milib = net.as_milib && !diags.has_errors();
    let by_hand = layout.ports.enx.iter().chain(&layout.ports.tgr).any(|p| p.implicit);
    let kept = !as_milib && (by_hand || net.precision == Precision::Single);
    let before = kept.then(|| Before { start: begin, state: loaded.clone(), forces: listed.clone() });
    let mut initial =
        if as_milib { milib::first(&layout, &listed, begin, loaded) } else { start(&layout, &listed, begin, loaded) };
    live.scene = identify(&layout, [&reads, &forces, &writes, &moves], &initial);
    give_to(&mut initial, live.scene);
    let (probe_names, probe_of) = probes(net);
    Some(Scene {
        rate: net.rate,
        layout,
        passes: ScenePasses { reads, forces, fused, writes, moves, sorted },
        inputs: net.inputs.clone(),
        names: OutputNames { probe_names, probe_of, channel_names: net.channels.clone() },
        live,
        about: About {
            gestures: net.gestures.clone(),
            presets: net.presets.clone(),
            left_out: net.left_out.clone(),
            title: printable(model.title()),
            seconds: net.seconds,
        },
        symbols: symbols.build(),
        certificate,
        hand: InHand { equivalence: net.equivalence.clone(), couplings: options.couplings.clone() },
        initial,
        before,
    })
}

/// Returns the ports of one role that move a MAT, axis by axis.
fn ports(builder: &LayoutBuilder, role: PortRole) -> Vec<Enx> {
    let mut all = Vec::new();
    // Links that are solved with the coming motion, and their ends.
    let late = builder.net.lias.iter().filter(|l| l.law.implicit || !l.law.stage.is_explicit());
    let held = late.flat_map(LiaNode::all_ends).filter_map(|e| if let End::Mat(m) = e { Some(m) } else { None });
    let held: BTreeSet<u32> = held.map(|m| builder.slot[m as usize]).collect();
    let implicit = |at: &u32| held.contains(at);
    for (m, at) in builder.net.mats.iter().zip(&builder.slot).filter(|(_, at)| **at != u32::MAX) {
        let MatRole::Port(r, inputs) = m.role else { continue };
        for (k, input) in inputs.iter().enumerate().filter(|_| r == role) {
            all.extend(input.map(|input| Enx { input, mat: at + k as u32, rest: m.rest[k], implicit: implicit(at) }));
        }
    }
    all
}

/// Returns the index of the first gain, and the outputs. Returns `None` if an output reads something that was left out.
fn outputs(builder: &mut LayoutBuilder, links: &Links) -> Option<(usize, Vec<Output>)> {
    let first = builder.coef.len();
    let mut all = Vec::new();
    for o in plain_first(builder.net) {
        let tap = match o.tap {
            OutputTap::Position(e) => Tap::Position(builder.alive(e, o.axis)?),
            OutputTap::ForceOn(e) => Tap::ForceOn(builder.alive(e, o.axis)?),
            OutputTap::ForceOf(l) => {
                let (op, k) = links.where_is[l as usize];
                let again = links.outputs.iter().find(|(of, _)| *of == l);
                let kept = || (links.forces[op as usize].tap + k as usize) as u32;
                Tap::ForceOf(again.map_or_else(kept, |(_, h)| h.tap))
            }
        };
        all.push(Output { channel: o.channel, tap });
        builder.coef.push(0.0);
        let to = builder.coef.len() - 1;
        match (o.item, o.gain) {
            (Some(item), gain) => builder.load(Loader::Times(o.share), item, &[gain], &[to]),
            (None, gain) => builder.coef[to] = o.share * gain.get(&[]).unwrap_or(1.0),
        }
    }
    Some((first, all))
}

/// Returns the accounts of the energy ledger, one per pass of links with its `index` among the forces. `ported` marks
/// slots moved by ports.
fn accounts(links: &Links, n_mat: usize, ported: impl Fn(u32) -> bool, index: impl Fn(usize) -> usize) -> Vec<Account> {
    let account = |(i, op): (usize, &Op)| {
        let law = op.law?;
        let Op { n, ports, first, coef, mem, tap, .. } = *op;
        let (energies, idle) = (law.fns.energies, law.fns.idle);
        let on_a_line = ports.measure == MeasureKind::Line && ports.onto.is_none() && ports.pair_set.is_none();
        let rows = if on_a_line { Row::two(&links.ends[first..first + n], n_mat) } else { <[Row; 2]>::default() };
        // A distance is not linear in positions: the identity then holds only with the scheme error of the link.
        let radial = ports.measure == MeasureKind::Radial || ports.onto.is_some_and(|o| o.0 == MeasureKind::Radial);
        // An implicit link is not exact if its port then moves otherwise.
        let strays = law.implicit && links.ends[first..first + n].iter().flatten().any(|p| ported(*p));
        let linear = law.linear && !radial && !strays;
        Some(Account {
            op: index(i),
            n,
            ports,
            first,
            coef,
            mem,
            tap,
            law,
            linear,
            live: false,
            rows,
            fns: AccountFns { energies, idle },
        })
    };
    links.forces.iter().enumerate().filter_map(account).collect()
}

/// Returns the modules by name: MATs that stay, then links with the `index` of their pass among the forces.
fn symbols(builder: &LayoutBuilder, links: &Links, index: impl Fn(usize) -> usize) -> SymbolsBuilder {
    let net = builder.net;
    let mats = net.mats.iter().zip(&builder.slot).filter(|(_, at)| **at != u32::MAX);
    let mut all = SymbolsBuilder::with_capacity(mats.clone().count(), net.lias.len());
    mats.for_each(|(m, at)| all.push(&m.name, m.code, m.axes, Location::Mat(*at)));
    for (l, (op, k)) in net.lias.iter().zip(&links.where_is) {
        all.push(&l.name, l.law.code, 1, Location::Lia(index(*op as usize) as u32, *k));
    }
    all
}

/// Returns the state as written: the position and speed of each mass.
fn loaded(net: &Pruned, layout: &Layout, x: &[f64], v: &[f64], coef: &[f64], (live, whole): (Vec<u32>, u32)) -> State {
    let input: Vec<f64> = net.inputs.iter().map(|i| if i.role == InputRole::Force { 0.0 } else { i.rest }).collect();
    let mut s = State::default();
    s.x = Aligned::from(x);
    s.d = v.iter().map(|v| v * net.tick_dt).collect();
    s.f = Aligned::zeros(layout.counts.n_mat);
    s.links = LinkState {
        mem: alloc::vec![0.0; layout.counts.n_mem],
        lengths: layout.links.reach.iter().map(|_| UNKNOWN).collect(),
        tap: Aligned::zeros(layout.counts.n_tap),
        near: layout.links.pair_sets.iter().map(|c| VerletList::new(c.members.len(), c.rows, c.columns)).collect(),
        cells: alloc::vec![Cell::default(); layout.places.moving_points.len()],
        implicit: alloc::vec![0.0; layout.implicit.as_ref().map_or(0, |a| 2 * a.places.len())],
        touches: ActiveContacts::in_clusters(&layout.links.clusters, layout.counts.n_touch, layout.counts.n_mat),
    };
    s.ports = PortState {
        last_input: input.clone(),
        border: alloc::vec![Border::default(); layout.ports.tgr.len()],
        late: alloc::vec![0.0; layout.ports.tgr.len() * layout.ports.crossing.latency as usize],
        blocked: alloc::vec![[0.0; 2]; layout.out.blockers.len()],
        under_way: alloc::vec![[0.0; 2]; layout.ports.ahead.len()],
        turns: alloc::vec![0.0; if layout.ports.ahead.is_empty() { 0 } else { layout.counts.n_mat }],
        glide: layout.rates.substeps.iter().flat_map(|f| &f.inputs).map(|i| [input[*i as usize]; 2]).collect(),
        lowpass: alloc::vec![0.0; layout.counts.channels * 2 * (2 * layout.out.lowpass.len()).saturating_sub(1)],
        refused: 0,
    };
    s.output = alloc::vec![0.0; layout.counts.n_out];
    s.slow = None;
    s.ramps = Ramps::new(live, whole);
    s.ledger = layout.ledger.as_ref().map(|_| Box::new(empty_ledger(layout)));
    s.input = input;
    s.coef = Aligned::from(coef);
    s
}

/// Returns names and request numbers of the probes, one for each output after the channels.
fn probes(net: &Pruned) -> (Vec<String>, Vec<u32>) {
    let mut all: Vec<&OutNode> = net.outs.iter().filter(|o| o.item.is_none()).collect();
    all.dedup_by_key(|o| o.channel);
    all.into_iter().map(|o| (o.name.clone(), o.request)).unzip()
}
