//! Reads the scene of a record.
//!
//! A [`Catalog`] resolves codes to laws, kinds and units. Each part is verified before its counts are used to allocate.

use super::PlanError;
use super::known::{Known, law_of};
use super::record::{
    AccountRecord, BeforeRecord, GroupRecord, ItemRecord, LayoutRecord, LedgerRecord, LiveRecord, LoadedRecord,
    LoaderRecord, ModuleRecord, OpRecord, OutputLinkRecord, ParamRecord, SceneRecord, SlowRecord, StateRecord,
    SubstepsRecord, SymbolsRecord,
};
use super::verify::{self, Wrong};
use crate::kind::{Role, Unit};
use crate::live::{DrivenParam, LiveItem, LiveModule, LiveParam, LiveTable, Loader, Source};
use crate::numeric::VerletList;
use crate::op::energy::empty_ledger;
use crate::op::layout::{Account, Layout, LedgerLayout, OutputLink, SlowGroup, Substeps};
use crate::op::layout::{AccountFns, OutputArrays};
use crate::op::{Form, Law, Op, Pass, Vectors};
use crate::scene::bind::listed;
use crate::scene::identify;
use crate::scene::symbols::Run;
use crate::scene::{About, InHand, OutputNames, Passes};
use crate::scene::{Before, Scene, Symbols};
use crate::state::{ActiveContacts, Identity, Ledger, Ramps, SlowState, State};
use crate::state::{LinkState, PortState};
use alloc::boxed::Box;
use alloc::sync::Arc;
use alloc::vec::Vec;

pub(super) fn scene(record: SceneRecord, known: &Known) -> Result<Scene, PlanError> {
    let laws = record.laws.iter().map(|code| known.law(code).ok_or_else(|| PlanError::Law(code.as_ref().into())));
    let laws = Laws(laws.collect::<Result<_, _>>()?);
    let inputs = record.inputs.into_owned();
    let mut layout = laws.layout(record.layout)?;
    let live_coefs = record.initial.state.live.len();
    verify::layout(&layout, inputs.len(), live_coefs)?;
    layout.rates.substeps = record.substeps.map(|s| laws.substeps(s)).transpose()?;
    if let (Some(group), Some(slow)) = (record.slow, &record.initial.slow) {
        let group = laws.group(group)?;
        verify::layout(&group.layout, slow.state.input.len(), slow.state.live.len())?;
        verify::group(&group, &layout, slow.state.input.len())?;
        layout.rates.slow = Some(Arc::new(group));
    }
    let [reads, forces, writes] = [record.reads, record.forces, record.writes].map(|list| laws.ops(list, listed));
    let (reads, forces, writes) = (reads?, forces?, writes?);
    let moves = laws.ops(record.moves, as_it_is)?;
    let mut initial = loaded(record.initial, &layout)?;
    let before = record.before.map(|b| before(b, &laws, &layout)).transpose()?;
    initial.scene = identify(&layout, [&reads, &forces, &writes, &moves], &initial);
    let mut live = live(record.live, known)?;
    live.scene = initial.scene;
    let scene = Scene {
        rate: record.rate,
        layout,
        passes: Passes { reads, forces, fused: record.fused, writes, moves, sorted: record.sorted },
        inputs,
        names: OutputNames {
            channel_names: record.channel_names.into_owned(),
            probe_names: record.probe_names.into_owned(),
            probe_of: record.probe_of.into_owned(),
        },
        live,
        about: About {
            gestures: record.gestures.into_owned(),
            presets: record.presets.into_owned(),
            left_out: record.left_out.into_owned(),
            title: record.title.into_owned(),
            seconds: record.seconds,
        },
        symbols: symbols(record.symbols, known)?,
        certificate: record.certificate.into_owned(),
        hand: InHand { equivalence: record.equivalence.into_owned(), couplings: record.couplings.into_owned() },
        initial,
        before,
    };
    verify::scene(&scene, known)?;
    Ok(scene)
}

fn as_it_is(form: Form) -> Form {
    form
}

/// Laws of a record, in its order.
struct Laws(Vec<&'static Law>);

impl Laws {
    fn get(&self, place: u32) -> Result<&'static Law, Wrong> {
        self.0.get(place as usize).copied().ok_or(Wrong("a pass names a law beyond the list of laws"))
    }

    /// Makes passes with their kernels; `form` selects the form of their links.
    fn ops(&self, list: Vec<OpRecord>, form: fn(Form) -> Form) -> Result<Vec<Op>, Wrong> {
        list.into_iter().map(|op| self.op(op, form)).collect()
    }

    fn op(&self, record: OpRecord, by: fn(Form) -> Form) -> Result<Op, Wrong> {
        let OpRecord { pass, law, form, ports, n, first, mat, coef, mem, tap } = record;
        let law = law.map(|law| self.get(law)).transpose()?;
        if law.is_some() != (pass == Pass::Links) {
            return Err(Wrong("a law is missing in a pass of links, or is in another pass"));
        }
        let kernel = law.map_or_else(|| pass.kernel(), |law| (law.fns.kernel)(by(form)));
        let fns = law.map(|law| law.fns);
        Ok(Op { kernel, pass, law, fns, form, ports, n, first, mat, coef, mem, tap })
    }

    fn layout(&self, record: LayoutRecord) -> Result<Layout, Wrong> {
        let output_links = record.output_links.into_iter().map(|link| {
            let OutputLinkRecord { law, ends, e0, coef, step, coefs, tap } = link;
            let law = self.get(law)?;
            Ok(OutputLink { law, force: law.fns.force, ends, e0, coef, step, coefs, tap })
        });
        let arrays = record.arrays.into_owned();
        Ok(Layout {
            out: OutputArrays { links: output_links.collect::<Result<_, Wrong>>()?, ..arrays.out },
            ledger: record.ledger.map(|ledger| self.ledger(ledger)).transpose()?,
            vectors: Vectors::detect(),
            ..arrays
        })
    }

    fn ledger(&self, record: LedgerRecord) -> Result<LedgerLayout, Wrong> {
        let accounts = record.accounts.into_iter().map(|account| {
            let AccountRecord { op, n, ports, first, coef, mem, tap, law, linear, live, rows } = account;
            let law = self.get(law)?;
            let (energies, idle) = (law.fns.energies, law.fns.idle);
            Ok(Account {
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
                fns: AccountFns { energies, idle },
                rows,
            })
        });
        let accounts = accounts.collect::<Result<_, Wrong>>()?;
        Ok(LedgerLayout { accounts, weight: record.weight, live: record.live })
    }

    fn substeps(&self, record: SubstepsRecord) -> Result<Substeps, Wrong> {
        let SubstepsRecord { times, tick, inputs } = record;
        Ok(Substeps { times, tick: self.ops(tick, as_it_is)?.into(), inputs: inputs.into_owned() })
    }

    fn group(&self, record: GroupRecord) -> Result<SlowGroup, Wrong> {
        Ok(SlowGroup {
            layout: self.layout(record.layout)?,
            reads: self.ops(record.reads, listed)?,
            forces: self.ops(record.forces, listed)?,
            after: self.ops(record.after, listed)?,
            moves: self.ops(record.moves, as_it_is)?,
            ports: record.ports.into_owned(),
            coupled: record.coupled,
            compensated: record.compensated,
            shown: record.shown.into_owned(),
            links: record.links,
            masses: record.masses,
            response: record.response.into_owned(),
        })
    }
}

fn before(record: BeforeRecord, laws: &Laws, layout: &Layout) -> Result<Before, Wrong> {
    let BeforeRecord { start, loaded: state, forces } = record;
    Ok(Before { start, state: loaded(state, layout)?, forces: laws.ops(forces, listed)? })
}

fn loaded(record: LoadedRecord, layout: &Layout) -> Result<State, Wrong> {
    let mut state = flat(record.state, layout)?;
    match (record.slow, &layout.rates.slow) {
        (None, None) => {}
        (Some(record), Some(group)) => {
            let SlowRecord { scene, state: own, ports, unknown } = record;
            let own = State { scene, ..flat(own, &group.layout)? };
            let fresh = SlowState::new(own, group.ports.len(), group.coupled, group.compensated);
            if (ports.len(), unknown.len()) != (fresh.ports.len(), fresh.unknown.len()) {
                return Err(Wrong("the state of the group at the gesture rate differs in shape from its layout"));
            }
            let (ports, unknown) = (ports.into_owned(), unknown.into_owned());
            state.slow = Some(Box::new(SlowState { ports, unknown, ..fresh }));
        }
        _ => return Err(Wrong("the layout or the state of a group at the gesture rate is missing")),
    }
    Ok(state)
}

/// Makes a state at load without its group.
fn flat(record: StateRecord, layout: &Layout) -> Result<State, Wrong> {
    verify::state(&record, layout)?;
    let kick = record.kick.map(|kick| Box::new(Ledger { start_force: kick.into_owned(), ..empty_ledger(layout) }));
    let [x, d, f, coef, lengths, tap] =
        [&record.x, &record.d, &record.f, &record.coef, &record.lengths, &record.tap].map(|all| all[..].into());
    Ok(State {
        scene: Identity::default(),
        x,
        d,
        f,
        coef,
        links: LinkState {
            mem: record.mem.into_owned(),
            lengths,
            tap,
            cells: record.cells.into_owned(),
            near: layout.links.pair_sets.iter().map(|c| VerletList::new(c.members.len(), c.rows, c.columns)).collect(),
            implicit: record.implicit.into_owned(),
            touches: ActiveContacts::in_clusters(&layout.links.clusters, layout.counts.n_touch, layout.counts.n_mat),
        },
        input: record.input.into_owned(),
        ports: PortState {
            last_input: record.last_input.into_owned(),
            border: record.border.into_owned(),
            late: record.late.into_owned(),
            blocked: record.blocked.into_owned(),
            glide: record.glide.into_owned(),
            under_way: record.under_way.into_owned(),
            turns: record.turns.into_owned(),
            lowpass: record.lowpass.into_owned(),
            refused: 0,
        },
        output: record.output.into_owned(),
        slow: None,
        ramps: Ramps::new(record.live.into_owned(), record.whole),
        written: record.written.map(|order| Arc::from(&order[..])),
        ledger: kick,
        tick: 0,
    })
}

fn live(record: LiveRecord, known: &Known) -> Result<LiveTable, PlanError> {
    let values: Vec<Arc<[Source]>> = record.values.into_iter().map(|list| Arc::from(&list[..])).collect();
    let driven = record
        .driven
        .into_iter()
        .map(|d| Ok(DrivenParam { param: param(d.param, known)?, port: d.port.into_owned(), span: d.span }));
    Ok(LiveTable {
        scene: Identity::default(),
        params: record.params.into_iter().map(|p| param(p, known)).collect::<Result<_, _>>()?,
        coefs: record.coefs.into_owned(),
        driven: driven.collect::<Result<_, PlanError>>()?,
        driven_coefs: record.driven_coefs.into_owned(),
        items: record.items.into_iter().map(|i| item(i, &values, known)).collect::<Result<_, _>>()?,
        implicit: record.implicit.map(alloc::borrow::Cow::into_owned),
    })
}

fn param(record: ParamRecord, known: &Known) -> Result<LiveParam, PlanError> {
    let ParamRecord { name, symbol, dim, min, max, value, doc } = record;
    let symbol = known.symbol(&symbol).ok_or_else(|| PlanError::Unit(symbol.as_ref().into()))?;
    let unit = Unit { symbol, dim };
    Ok(LiveParam { name: name.into_owned(), unit, min, max, value, doc: doc.into_owned() })
}

fn item(record: ItemRecord, values: &[Arc<[Source]>], known: &Known) -> Result<LiveItem, PlanError> {
    let kind = known.kind(&record.kind).ok_or_else(|| PlanError::Kind(record.kind.as_ref().into()))?;
    let generator = if let Role::Generator(generator) = kind.role { Some(generator) } else { None };
    if record.derives && generator.is_none() {
        return Err(Wrong("a live item derives its numbers, but its kind does not").into());
    }
    let module = |module: ModuleRecord| {
        let loader = match module.loader {
            LoaderRecord::Mat(code, medium) => {
                Loader::Mat(known.mat(&code).ok_or_else(|| PlanError::Kind(code.into_owned()))?.1, medium)
            }
            LoaderRecord::Lia(code) => {
                Loader::Lia(law_of(kind, &code).ok_or_else(|| PlanError::Law(code.into_owned()))?)
            }
            LoaderRecord::Times(by) => Loader::Times(by),
        };
        let values = values.get(module.values as usize).cloned();
        let values = values.ok_or(Wrong("a live module has values beyond the list of values"))?;
        Ok(LiveModule { loader, values, to: module.to.into_owned() })
    };
    Ok(LiveItem {
        kind,
        dim: record.dim,
        scheme: record.scheme,
        args: record.args.into_owned(),
        follows: record.follows.into_owned(),
        generator: generator.filter(|_| record.derives),
        modules: record.modules.into_iter().map(module).collect::<Result<_, PlanError>>()?,
    })
}

fn symbols(record: SymbolsRecord, known: &Known) -> Result<Symbols, PlanError> {
    let runs = record.runs.into_iter().map(|run| {
        let code = known.code(&run.code).ok_or_else(|| PlanError::Kind(run.code.as_ref().into()))?;
        Ok(Run { name: run.name.into_owned(), code, axes: run.axes, first: run.first })
    });
    let (mats, lias) = (record.mats.into_owned(), record.lias.into_owned());
    Ok(Symbols { runs: runs.collect::<Result<_, PlanError>>()?, mats, lias })
}
