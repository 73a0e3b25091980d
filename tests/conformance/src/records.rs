//! Catalog records are complete, with an example that sounds and known names.

use crate::models::gesture;
use crate::random_parameters::{built, catalog, read as model, texts};
use ca_compile::Options;
use ca_core::{Location, Need, SOURCES, Type, tick};
use ca_model::{read, render};

#[test]
fn every_record_is_complete() {
    for kind in catalog().iter() {
        let code = kind.code;
        assert!(code.chars().all(|c| c.is_ascii_uppercase() || c == '_'), "{code}");
        assert!([kind.title, kind.equation, kind.doc, kind.example].iter().all(|t| !t.trim().is_empty()), "{code}");
        assert!(!kind.source.is_empty(), "{code} cites nothing");
        for key in kind.source {
            assert!(SOURCES.iter().any(|(k, full)| k == key && full.len() > 20), "{code} cites `{key}`");
        }
        for (i, p) in kind.params.iter().enumerate() {
            let what = format!("{code}.{}", p.name);
            assert!(p.doc.len() > 2, "{what} has no doc");
            assert_eq!(kind.param(p.name), Some(i), "{what} is there twice");
            match (p.ty, p.need) {
                (Type::Number { unit, min, max } | Type::Numbers { unit, min, max }, need) => {
                    assert!(min < max, "{what}");
                    let plain = unit.symbol.is_empty();
                    assert_eq!(plain, unit.dim == ca_core::Unit::NONE.dim, "{what}: `{}`", unit.symbol);
                    if let Need::Default(v) = need {
                        assert!(min <= v && v <= max, "{what}: {v} is not in {min} … {max}");
                    }
                }
                (Type::Count { min, max } | Type::Counts { min, max }, need) => {
                    assert!(min < max, "{what}");
                    if let Need::Default(v) = need {
                        assert!(f64::from(min) <= v && v <= f64::from(max) && v.fract() == 0.0, "{what}: {v}");
                    }
                }
                (Type::Choice(words), Need::Default(v)) => assert!((v as usize) < words.len(), "{what}"),
                (Type::PowerStiffness { exponent }, _) => assert!(kind.param(exponent).is_some(), "{what}"),
                _ => {}
            }
        }
        for set in kind.one_of.iter().flat_map(|o| o.sets).copied().flatten() {
            assert!(kind.param(set).is_some(), "{code}: `{set}` of an alternative is no parameter");
        }
    }
}

#[test]
fn every_example_sounds() {
    for kind in catalog().iter() {
        let (m, diags) = read::read(kind.example, kind.code, &catalog());
        assert!(diags.list.is_empty(), "{}", render::text(&diags, &m, false));
        assert!(m.items.iter().any(|i| i.kind == kind.code), "the example of {} is of something else", kind.code);
        let scene = built(&m, &Options::default());
        assert!(scene.findings.list.is_empty(), "{}: {}", kind.code, render::text(&scene.findings, &m, false));
        let mut s = scene.state();
        let mut peak = 0.0f64;
        for n in 0..96_000 {
            gesture(&scene, &mut s);
            tick(&scene, &mut s);
            assert!(s.output.iter().all(|v| v.is_finite()), "{} at tick {n}", kind.code);
            peak = s.output.iter().fold(peak, |m, v| m.max(v.abs()));
        }
        assert!(peak > 0.01 && peak <= 1.0, "the example of {} peaks at {peak}", kind.code);
    }
}

#[test]
fn every_link_of_the_examples_is_known_by_name() {
    for (name, text) in texts() {
        let scene = built(&model(&text), &Options { energy: true, ..Options::default() });
        let named: Vec<usize> =
            (0..scene.counts.n_lia).filter(|k| scene.audited_name(*k).is_some_and(|n| n != "?")).collect();
        // rows are padded with links from a place to itself
        let taken: Vec<usize> =
            (0..scene.counts.n_lia).filter(|k| scene.links.ends[*k][0] != scene.links.ends[*k][1]).collect();
        let links = scene.symbols.iter().filter(|s| matches!(s.location, Location::Lia(..))).count();
        assert_eq!((&named, named.len()), (&taken, links), "{name}");
    }
}
