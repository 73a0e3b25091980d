//! Makes the record of a scene.

use super::record::{
    AccountRecord, BeforeRecord, DrivenRecord, GroupRecord, ItemRecord, LayoutRecord, LedgerRecord, List, LiveRecord,
    LoadedRecord, LoaderRecord, ModuleRecord, OpRecord, OutputLinkRecord, ParamRecord, RunRecord, SceneRecord,
    SlowRecord, StateRecord, SubstepsRecord, SymbolsRecord,
};
use crate::live::{LiveItem, LiveParam, LiveTable, Loader, Source};
use crate::op::layout::AccountFns;
use crate::op::layout::{Account, Layout, LedgerLayout, OutputLink, SlowGroup, Substeps};
use crate::op::{Law, Op};
use crate::scene::{About, InHand, OutputNames, Passes};
use crate::scene::{Before, Scene, Symbols};
use crate::state::{LinkState, PortState};
use crate::state::{Ramps, SlowState, State};
use alloc::borrow::Cow;
use alloc::collections::BTreeMap;
use alloc::sync::Arc;
use alloc::vec::Vec;

pub(super) fn scene(scene: &Scene) -> SceneRecord<'_> {
    let mut laws = Codes::default();
    let Scene {
        rate,
        layout,
        passes: Passes { reads, forces, fused, writes, moves, sorted },
        inputs,
        names: OutputNames { channel_names, probe_names, probe_of },
        live: plan,
        about: About { gestures, presets, left_out, title, seconds },
        symbols: names,
        certificate,
        hand: InHand { equivalence, couplings },
        initial,
        before,
    } = scene;
    SceneRecord {
        rate: *rate,
        layout: laws.layout(layout),
        substeps: layout.rates.substeps.as_ref().map(|s| laws.substeps(s)),
        slow: layout.rates.slow.as_deref().map(|group| laws.group(group)),
        reads: laws.ops(reads),
        forces: laws.ops(forces),
        fused: *fused,
        writes: laws.ops(writes),
        moves: laws.ops(moves),
        inputs: inputs.into(),
        channel_names: channel_names.into(),
        probe_names: probe_names.into(),
        probe_of: probe_of.into(),
        live: live(plan),
        gestures: gestures.into(),
        presets: presets.into(),
        symbols: symbols(names),
        certificate: Cow::Borrowed(certificate),
        equivalence: Cow::Borrowed(equivalence),
        couplings: couplings.into(),
        left_out: left_out.into(),
        sorted: *sorted,
        title: title.into(),
        seconds: *seconds,
        initial: loaded(initial),
        before: before.as_ref().map(|b| laws.before(b)),
        // last, when all laws are known
        laws: laws.0.into_iter().map(Cow::Borrowed).collect(),
    }
}

#[derive(Default)]
struct Codes(Vec<&'static str>);

impl Codes {
    fn place(&mut self, law: &Law) -> u32 {
        let known = self.0.iter().position(|code| *code == law.code);
        known.unwrap_or_else(|| {
            self.0.push(law.code);
            self.0.len() - 1
        }) as u32
    }

    fn ops(&mut self, list: &[Op]) -> Vec<OpRecord> {
        list.iter().map(|op| self.op(op)).collect()
    }

    fn op(&mut self, op: &Op) -> OpRecord {
        let &Op { kernel: _, pass, law, fns: _, form, ports, n, first, mat, coef, mem, tap } = op;
        OpRecord { pass, law: law.map(|law| self.place(law)), form, ports, n, first, mat, coef, mem, tap }
    }

    fn layout<'a>(&mut self, layout: &'a Layout) -> LayoutRecord<'a> {
        let output_links = layout.out.links.iter().map(|link| {
            let &OutputLink { law, force: _, ends, e0, coef, step, coefs, tap } = link;
            OutputLinkRecord { law: self.place(law), ends, e0, coef, step, coefs, tap }
        });
        LayoutRecord {
            output_links: output_links.collect(),
            ledger: layout.ledger.as_ref().map(|plan| self.ledger(plan)),
            arrays: Cow::Borrowed(layout),
        }
    }

    fn ledger(&mut self, plan: &LedgerLayout) -> LedgerRecord {
        let accounts = plan.accounts.iter().map(|account| {
            let &Account {
                op,
                n,
                ports,
                first,
                coef,
                mem,
                tap,
                law,
                linear,
                live,
                fns: AccountFns { energies: _, idle: _ },
                rows,
            } = account;
            AccountRecord { op, n, ports, first, coef, mem, tap, law: self.place(law), linear, live, rows }
        });
        LedgerRecord { accounts: accounts.collect(), weight: plan.weight, live: plan.live }
    }

    fn substeps<'a>(&mut self, substeps: &'a Substeps) -> SubstepsRecord<'a> {
        let Substeps { times, tick, inputs } = substeps;
        SubstepsRecord { times: *times, tick: self.ops(tick), inputs: inputs.into() }
    }

    fn group<'a>(&mut self, group: &'a SlowGroup) -> GroupRecord<'a> {
        let SlowGroup {
            layout,
            reads,
            forces,
            after,
            moves,
            ports,
            coupled,
            compensated,
            shown,
            links,
            masses,
            response,
        } = group;
        GroupRecord {
            layout: self.layout(layout),
            reads: self.ops(reads),
            forces: self.ops(forces),
            after: self.ops(after),
            moves: self.ops(moves),
            ports: ports.into(),
            coupled: *coupled,
            compensated: *compensated,
            shown: shown.into(),
            links: *links,
            masses: *masses,
            response: Cow::Borrowed(response),
        }
    }

    fn before<'a>(&mut self, before: &'a Before) -> BeforeRecord<'a> {
        let Before { start, state, forces } = before;
        BeforeRecord { start: *start, loaded: loaded(state), forces: self.ops(forces) }
    }
}

fn loaded(state: &State) -> LoadedRecord<'_> {
    let slow = state.slow.as_deref().map(|slow| {
        let SlowState { state, ports, unknown, free: _ } = slow;
        SlowRecord { scene: state.scene, state: flat(state), ports: ports.into(), unknown: unknown.into() }
    });
    LoadedRecord { state: flat(state), slow }
}

/// Makes the record of a state at load without its group, and without the parts that loading creates.
fn flat(state: &State) -> StateRecord<'_> {
    let State {
        scene: _,
        x,
        d,
        f,
        coef,
        links: LinkState { mem, lengths, tap, cells, near: _, implicit, touches: _ },
        input,
        ports: PortState { last_input, border, late, blocked, glide, under_way, turns, lowpass, refused: _ },
        output,
        slow: _,
        ramps,
        written: [slots, coefs],
        ledger,
        tick: _,
    } = state;
    let [x, d, f, coef, lengths, tap] = [x, d, f, coef, lengths, tap].map(|all| Cow::Borrowed(&all[..]));
    let Ramps { index, instant: whole, .. } = ramps;
    StateRecord {
        x,
        d,
        f,
        coef,
        mem: mem.into(),
        lengths,
        tap,
        input: input.into(),
        last_input: last_input.into(),
        output: output.into(),
        cells: cells.into(),
        border: border.into(),
        late: late.into(),
        blocked: blocked.into(),
        glide: glide.into(),
        under_way: under_way.into(),
        turns: turns.into(),
        lowpass: lowpass.into(),
        implicit: implicit.into(),
        live: index.into(),
        whole: *whole,
        written: [slots, coefs].map(|order| Cow::Borrowed(&order[..])),
        kick: ledger.as_deref().map(|ledger| (&ledger.start_force).into()),
    }
}

fn live(plan: &LiveTable) -> LiveRecord<'_> {
    let LiveTable { scene: _, params, coefs, driven, driven_coefs, items, implicit } = plan;
    let mut values = Values::default();
    let items = items.iter().map(|item| values.item(item)).collect();
    let driven = driven.iter().map(|d| DrivenRecord { param: param(&d.param), port: (&d.port).into(), span: d.span });
    LiveRecord {
        params: params.iter().map(param).collect(),
        coefs: coefs.into(),
        driven: driven.collect(),
        driven_coefs: driven_coefs.into(),
        values: values.lists,
        items,
        implicit: implicit.as_ref().map(Cow::Borrowed),
    }
}

fn param(param: &LiveParam) -> ParamRecord<'_> {
    let LiveParam { name, unit, min, max, value, doc } = param;
    let (symbol, dim) = (unit.symbol.into(), unit.dim);
    ParamRecord { name: name.into(), symbol, dim, min: *min, max: *max, value: *value, doc: doc.into() }
}

/// Lists of values, shared by modules.
#[derive(Default)]
struct Values<'a> {
    lists: Vec<List<'a, Source>>,
    /// index of each list by its address
    places: BTreeMap<*const Source, u32>,
}

impl<'a> Values<'a> {
    fn item(&mut self, item: &'a LiveItem) -> ItemRecord<'a> {
        let LiveItem { kind, dim, scheme, args, follows, generator, modules } = item;
        let modules = modules.iter().map(|module| ModuleRecord {
            loader: match module.loader {
                Loader::Mat(spec, medium) => LoaderRecord::Mat(spec.code.into(), medium),
                Loader::Lia(law) => LoaderRecord::Lia(law.code.into()),
                Loader::Times(by) => LoaderRecord::Times(by),
            },
            values: self.place(&module.values),
            to: (&module.to).into(),
        });
        ItemRecord {
            modules: modules.collect(),
            kind: kind.code.into(),
            dim: *dim,
            scheme: *scheme,
            args: args.into(),
            follows: follows.into(),
            derives: generator.is_some(),
        }
    }

    fn place(&mut self, values: &'a Arc<[Source]>) -> u32 {
        *self.places.entry(values.as_ptr()).or_insert_with(|| {
            self.lists.push(Cow::Borrowed(&values[..]));
            self.lists.len() as u32 - 1
        })
    }
}

fn symbols(symbols: &Symbols) -> SymbolsRecord<'_> {
    let Symbols { runs, mats, lias } = symbols;
    let runs = runs.iter().map(|run| RunRecord {
        name: Cow::Borrowed(&run.name),
        code: run.code.into(),
        axes: run.axes,
        first: run.first,
    });
    SymbolsRecord { runs: runs.collect(), mats: mats.into(), lias: lias.into() }
}
