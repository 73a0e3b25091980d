//! Properties of every law, tested by its traits and not by its name: force and energy agree, dampers only resist, a
//! contact exerts no force where it declares none, and a cheaper law equals the original.

use crate::numbers;
use ca_core::internal::op::{SolveStage, family, loaded, started};
use ca_core::{Dual, Kind, Law, Need, ParamBinding, Real, Role, TANGENTS, Table, Type};

const DT: f64 = 1.0 / 48_000.0;

/// Makes a table that pulls back, as stiffness, and resists, as friction.
fn tables(law: &Law) -> Vec<Table> {
    let points: Vec<[f64; 2]> = (-20..=20).map(|i| [0.05 * f64::from(i), 3.0 * f64::from(i)]).collect();
    let mut all = vec![Table::new(&points).unwrap()];
    all.extend(law.table.map(|make| make()));
    all
}

/// Draws parameters of a kind: random plain numbers, defaults for choices.
fn drawn(kind: &Kind, next: &mut impl FnMut() -> f64) -> Vec<Option<f64>> {
    let one = |p: &ca_core::Param, v: f64| match p.ty {
        Type::Number { min, max, .. } => Some((0.1 + v).clamp(min, max.min(1e3))),
        Type::PowerStiffness { .. } => Some(10.0 + 100.0 * v),
        Type::Points { .. } => Some(0.0),
        Type::Choice(_) | Type::Flag | Type::Count { .. } => match p.need {
            Need::Default(d) => Some(d),
            _ => None,
        },
        _ => None,
    };
    kind.params
        .iter()
        .map(|p| match p.name {
            // a multiple of a quarter
            "p" => Some(1.5),
            // small damper and threshold, so that both sides of a contact are reached
            "z" | "d" => one(p, 0.0).map(|v| 0.1 * v),
            "rho" => Some(0.5),
            _ => one(p, next()),
        })
        .collect()
}

/// Visits every law of the catalog with random parameters, its coefficients, and the tables it reads.
fn each(mut visit: impl FnMut(&Kind, &'static Law, &[Option<f64>], &[f64], &[Table])) {
    let mut next = numbers(7);
    let mut met = 0;
    for kind in ca_core::internal::phi::KINDS {
        let Role::Lia(law) = kind.role else { continue };
        let tables = tables(law);
        for _ in 0..20 {
            let mut values = drawn(kind, &mut next);
            // the index of the law's table follows the last parameter
            values.extend(law.table.map(|_| Some(1.0)));
            let c = loaded(law, &values, DT);
            assert!(c.iter().all(|c| c.is_finite() || c.is_nan()), "{}: {c:?}", kind.code);
            visit(kind, law, &values, &c, &tables);
        }
        met += 1;
    }
    assert!(met >= 10, "{met} laws");
}

#[test]
fn force_is_the_slope_of_the_stored_energy() {
    let mut checked = 0;
    each(|kind, law, _, c, tables| {
        // the elongation alone does not determine the potential of a law with memory
        if law.mem > 0 {
            return;
        }
        let h = 1e-6;
        for i in -40..40 {
            let e = 0.011 * f64::from(i) + 0.0037;
            let stored = |e: f64| (law.fns.energies.stored)(c, &[], tables, e, e);
            let slope = (stored(e + h) - stored(e - h)) / (2.0 * h);
            let force = (law.fns.force)(c, &mut [], tables, e, 0.0);
            let scale = force.abs().max(slope.abs()).max(1.0);
            assert!((force - slope).abs() < 1e-4 * scale, "{} at {e}: force {force}, slope {slope}", kind.code);
            checked += 1;
        }
    });
    assert!(checked > 8_000, "{checked}");
}

#[test]
fn what_hangs_on_motion_only_resists() {
    each(|kind, law, _, c, tables| {
        for (i, w) in (-20..20).flat_map(|i| [-1e-4, -1e-6, 1e-6, 1e-4].map(|w| (i, w))) {
            let e = 0.021 * f64::from(i) + 0.0037;
            let mut mem = started(law, c, e);
            let still = (law.fns.force)(c, &mut mem.clone(), tables, e, 0.0);
            let moving = (law.fns.force)(c, &mut mem, tables, e, w);
            // F > 0 pulls together, and w > 0 moves apart
            assert!((moving - still) * w >= 0.0, "{} at {e}, {w}: {still} to {moving}", kind.code);
        }
    });
}

#[test]
fn a_contact_is_silent_where_it_says_so() {
    let mut contacts = 0;
    each(|kind, law, _, c, tables| {
        let (from, to) = (law.fns.idle)(c);
        if !law.contact {
            assert!(from > to, "{} is no contact and idles from {from} to {to}", kind.code);
            return;
        }
        contacts += 1;
        for i in -50..50 {
            let e = 0.01 * f64::from(i) + 0.0013;
            let force = (law.fns.force)(c, &mut [], tables, e, 1e-5);
            assert_eq!(force != 0.0, !(from..=to).contains(&e), "{} at {e}: {force} N", kind.code);
        }
    });
    assert!(contacts >= 40, "{contacts}");
}

#[test]
fn slopes_are_within_the_bound() {
    each(|kind, law, _, c, tables| {
        let b = (law.at_load.bound)(c, tables);
        if b.hardens || law.mem > 0 {
            return;
        }
        let h = 1e-7;
        for i in -40..40 {
            let e = 0.011 * f64::from(i) + 0.0037;
            let at = |e: f64, w: f64| (law.fns.force)(c, &mut [], tables, e, w);
            let (k, z) = ((at(e + h, 0.0) - at(e - h, 0.0)) / (2.0 * h), at(e, h) / h - at(e, 0.0) / h);
            let tolerance = 1e-4 * (1.0 + b.k.abs() + b.z.abs());
            assert!(k <= b.k + tolerance, "{} at {e}: k {k} above {}", kind.code, b.k);
            assert!(z <= b.z + tolerance || !b.linear, "{} at {e}: z {z} above {}", kind.code, b.z);
        }
    });
}

#[test]
fn a_cheaper_law_is_the_same_law() {
    let mut cheaper = 0;
    each(|kind, law, values, _, tables| {
        // set each number in turn to zero
        for k in 0..kind.params.len() {
            if !matches!(kind.params[k].ty, Type::Number { .. }) {
                continue;
            }
            let mut values = values.to_vec();
            values[k] = Some(0.0);
            let fixed: Vec<ParamBinding> =
                values.iter().map(|v| v.map_or(ParamBinding::Absent, ParamBinding::At)).collect();
            let Some(simple) = (law.cheaper.simpler)(&fixed) else { continue };
            let (c, s) = (loaded(law, &values, DT), loaded(simple, &values, DT));
            for i in -10..10 {
                let (e, w) = (0.02 * f64::from(i) + 0.003, 1e-5 * f64::from(i % 3));
                let was = (law.fns.force)(&c, &mut started(law, &c, e), tables, e, w);
                let is = (simple.fns.force)(&s, &mut started(simple, &s, e), tables, e, w);
                assert!((was - is).abs() <= 1e-12 * was.abs(), "{} as {}: {was} and {is}", kind.code, simple.code);
            }
            cheaper += 1;
        }
    });
    assert!(cheaper >= 20, "{cheaper}");
}

/// The functions of each law, and of each law that replaces it by a choice, a missing table or a shared mass, can be
/// bound by code, and their force equals the force of the law.
#[test]
fn functions_of_every_law_are_found_by_its_code() {
    let laws = ca_core::internal::phi::laws::<f64>();
    let mut met = std::collections::BTreeSet::new();
    let mut check = |law: &Law| {
        let fns = laws.get(law).unwrap_or_else(|| panic!("no functions of `{}`", law.code));
        let c = vec![0.25; law.coefs];
        let force = |f: ca_core::internal::law::Force| f(&c, &mut vec![0.0; law.mem], &[], -0.125, 0.5).to_bits();
        assert_eq!(force(fns.force), force(law.fns.force), "{}", law.code);
        met.insert(law.code);
    };
    for kind in ca_core::internal::phi::KINDS {
        let Role::Lia(law) = kind.role else { continue };
        for (a, b) in (0..16).map(|i| (i / 4, i % 4)) {
            let mut words = [a, b].into_iter().cycle();
            let choice = |p: &ca_core::Param| match p.ty {
                Type::Choice(w) if p.name == "curve" || p.name == "method" => {
                    ParamBinding::At(f64::from(words.next().unwrap_or(0).min(w.len() as u32 - 1)))
                }
                Type::Points { .. } if (a + b) % 2 == 0 && p.name == "spring" => ParamBinding::Live,
                Type::Points { .. } if a > 1 => ParamBinding::Live,
                _ => ParamBinding::Absent,
            };
            let p: Vec<ParamBinding> = kind.params.iter().map(choice).collect();
            let family = family(law);
            let mut check = |law: &'static Law| {
                assert!(family.iter().any(|known| core::ptr::eq(*known, law)), "{} of {}", law.code, kind.code);
                check(law);
            };
            let mut law = law;
            check(law);
            while let Some(simpler) = (law.cheaper.simpler)(&p) {
                law = simpler;
                check(law);
            }
            while let SolveStage::Single(other) = law.stage {
                [other.line, other.space].into_iter().flatten().for_each(&mut check);
                let Some(shared) = other.space else { break };
                law = shared;
            }
        }
    }
    check(&ca_core::internal::phi::implicit::LAW);
    assert!(met.len() > 30, "{met:?}");
}

/// A law can use any function of `libm`, over every number type of a tick.
#[test]
fn a_function_of_libm_has_its_value_and_its_derivatives() {
    fn log1p<R: Real>(e: R) -> R {
        let x = e.wide();
        e.chain(libm::log1p(x), 1.0 / (1.0 + x))
    }
    let tangents: [f64; TANGENTS] = std::array::from_fn(|k| k as f64 - 2.0);
    let of = log1p(Dual::new(0.25, tangents));
    assert_eq!((of.value(), log1p(0.25)), (libm::log1p(0.25), libm::log1p(0.25)));
    assert_eq!(*of.tangents(), tangents.map(|t| 1.0 / 1.25 * t));
    assert_eq!(log1p(0.25_f32), libm::log1p(0.25) as f32);
}
