//! Tests of separate parts: the factor of implicit links, the Verlet list, tables, tuning.

use crate::numbers;
use ca_core::Table;
use ca_core::internal::numeric::VerletList;
use ca_core::internal::numeric::ldl::Pattern;
use ca_core::internal::tuning::{Method, Scheme, retune};
use std::collections::BTreeSet;

#[test]
fn a_factor_solves_what_elimination_solves() {
    let mut next = numbers(3);
    for n in [1_usize, 2, 7, 40] {
        // a connected pattern with some additional couplings
        let mut ties: Vec<(u32, u32, f64)> = (1..n).map(|i| ((i - 1) as u32, i as u32, -(0.1 + next()))).collect();
        for _ in 0..n / 3 {
            let (i, j) = ((next() * n as f64) as u32, (next() * n as f64) as u32);
            if i.abs_diff(j) > 1 {
                ties.push((i.min(j), i.max(j), -next()));
            }
        }
        let sums: Vec<f64> = (0..n).map(|_| 0.5 + next()).collect();
        let right: Vec<f64> = (0..n).map(|_| next() - 0.5).collect();
        // the matrix itself: couplings off the diagonal, and on it what gives the row sums
        let mut a = vec![vec![0.0; n]; n];
        for (i, j, v) in &ties {
            a[*i as usize][*j as usize] += v;
            a[*j as usize][*i as usize] += v;
        }
        for i in 0..n {
            let beside: f64 = a[i].iter().sum();
            a[i][i] = sums[i] - beside;
        }
        let wanted = eliminated(a, right.clone());
        let p = Pattern::new(n, ties.iter().map(|t| (t.0, t.1)), usize::MAX).unwrap();
        let mut at = vec![0_u32; n];
        p.order.iter().zip(0..).for_each(|(i, k)| at[*i as usize] = k);
        let mut v: Vec<f64> = p.order.iter().map(|i| sums[*i as usize]).collect();
        let beside = ties.iter().map(|(i, j, v)| (at[*i as usize], at[*j as usize], *v));
        assert!(p.factor(&mut v, &mut Vec::new(), beside));
        assert_eq!(v.len(), p.numbers());
        let mut x: Vec<f64> = p.order.iter().map(|i| right[*i as usize]).collect();
        p.solve(&v, &mut x);
        for (k, i) in p.order.iter().enumerate() {
            assert!((x[k] - wanted[*i as usize]).abs() < 1e-12, "row {i} of {n}: {} and {}", x[k], wanted[*i as usize]);
        }
    }
}

/// Rows are eliminated by fewest remaining neighbours, then lowest index, and their neighbours become coupled.
#[test]
fn a_factor_has_the_order_and_the_entries_of_plain_elimination() {
    let mut next = numbers(5);
    for (n, ties) in [(1, 0), (6, 2), (30, 25), (30, 60), (30, 400), (60, 90)] {
        let mut place = || (next() * n as f64) as u32;
        let pairs: Vec<(u32, u32)> = (0..ties).map(|_| (place(), place())).collect();
        let mut near = vec![BTreeSet::new(); n];
        for (i, j) in pairs.iter().filter(|(i, j)| i != j) {
            near[*i as usize].insert(*j);
            near[*j as usize].insert(*i);
        }
        let (mut left, mut order, mut entries): (Vec<u32>, Vec<u32>, Vec<BTreeSet<u32>>) = Default::default();
        left.extend(0..n as u32);
        while let Some(i) = left.iter().copied().min_by_key(|i| (near[*i as usize].len(), *i)) {
            left.retain(|j| *j != i);
            let around = near[i as usize].clone();
            for j in &around {
                near[*j as usize].extend(around.iter().filter(|o| *o != j));
                near[*j as usize].remove(&i);
            }
            order.push(i);
            entries.push(around);
        }
        let p = Pattern::new(n, pairs.into_iter(), usize::MAX).unwrap();
        assert_eq!(p.order, order, "{n} rows, {ties} ties");
        for (k, wanted) in entries.iter().enumerate() {
            let rows = &p.rows[p.columns[k] as usize..p.columns[k + 1] as usize];
            assert!(rows.is_sorted_by(|a, b| a < b));
            let is: BTreeSet<u32> = rows.iter().map(|r| p.order[*r as usize]).collect();
            assert_eq!(is, *wanted, "row {k} of {n}, {ties} ties");
        }
    }
}

/// Solves by Gaussian elimination with the largest pivot.
fn eliminated(mut a: Vec<Vec<f64>>, mut b: Vec<f64>) -> Vec<f64> {
    let n = b.len();
    for k in 0..n {
        let best = (k..n).max_by(|i, j| a[*i][k].abs().total_cmp(&a[*j][k].abs())).unwrap();
        a.swap(k, best);
        b.swap(k, best);
        for i in k + 1..n {
            let share = a[i][k] / a[k][k];
            let (above, below) = a.split_at_mut(i);
            below[0].iter_mut().zip(&above[k]).skip(k).for_each(|(to, from)| *to -= share * from);
            b[i] -= share * b[k];
        }
    }
    for k in (0..n).rev() {
        let known: f64 = (k + 1..n).map(|j| a[k][j] * b[j]).sum();
        b[k] = (b[k] - known) / a[k][k];
    }
    b
}

#[test]
fn a_matrix_that_is_not_positive_has_no_factor() {
    let p = Pattern::new(2, [(0, 1)].into_iter(), usize::MAX).unwrap();
    let mut v = vec![-1.0, 0.5];
    assert!(!p.factor(&mut v, &mut Vec::new(), [(0, 1, -0.1)].into_iter()));
    assert!(Pattern::new(30, (0..30).flat_map(|i| (0..i).map(move |j| (i, j))), 10).is_none(), "too many entries");
}

#[test]
fn a_verlet_list_misses_no_pair() {
    let mut next = numbers(11);
    let (n, radius) = (60, 0.25);
    let mut x: Vec<[f64; 3]> = (0..n).map(|_| std::array::from_fn(|_| next())).collect();
    let v: Vec<[f64; 3]> = (0..n).map(|_| std::array::from_fn(|_| 1e-3 * (next() - 0.5))).collect();
    let mut list = VerletList::new(n, n, 0);
    let mut met = 0;
    for _ in 0..400 {
        for (x, v) in x.iter_mut().zip(&v) {
            (0..3).for_each(|k| x[k] += v[k]);
        }
        list.place(|k| [x[k], [0.0; 3]]);
        list.renew(radius, |k| v[k].iter().map(|v| v * v).sum());
        let mut seen = BTreeSet::new();
        list.each(radius, |i, j| assert!(seen.insert((i, j)), "{i} and {j} twice"));
        for (i, j) in (0..n).flat_map(|i| (i + 1..n).map(move |j| (i, j))) {
            let square: f64 = (0..3).map(|k| (x[i][k] - x[j][k]).powi(2)).sum();
            assert!(square >= radius * radius || seen.contains(&(i, j)), "{i} and {j} are {} apart", square.sqrt());
            met += usize::from(square < radius * radius);
        }
    }
    assert!(met > 1_000, "{met} pairs were near");
}

#[test]
fn a_table_is_straight_between_and_constant_beyond() {
    let t = Table::new(&[[-1.0, 2.0], [0.0, 0.0], [3.0, 6.0]]).unwrap();
    for (x, y, slope) in [(-5.0, 2.0, 0.0), (-0.5, 1.0, -2.0), (1.5, 3.0, 2.0), (9.0, 6.0, 0.0)] {
        assert_eq!((t.at(x), t.slope(x)), (y, slope), "at {x}");
        // the derivative of the integral is the value
        let h = 1e-3;
        let rise = (t.integral(x + h) - t.integral(x - h)) / (2.0 * h);
        assert!((rise - y).abs() < 1e-9, "at {x}: {rise}");
    }
    // a small integral keeps its digits beside large ones, whether 0 is a point or within a segment
    for points in [&[[-2.0, -1.4e4], [-1.0, -1.4e4], [0.0, 0.0], [0.5, 1.4e4]][..], &[[-2.0, -2.8e4], [0.5, 7e3]]] {
        let t = Table::new(points).unwrap();
        for x in [1e-4, -1e-4, 1e-9, -1e-9] {
            let of = 0.5 * t.slope(x) * x * x;
            // the rounding of values of 3e4
            let tolerance = 1e-12 * of + 4e-12 * x.abs();
            assert!((t.integral(x) - of).abs() < tolerance, "{points:?} at {x}: {} and {of}", t.integral(x));
        }
    }
    for bad in [&[[0.0, 1.0]][..], &[[0.0, 1.0], [0.0, 2.0]], &[[1.0, 0.0], [0.0, 0.0]], &[[0.0, f64::NAN], [1.0, 0.0]]]
    {
        assert!(Table::new(bad).is_none(), "{bad:?}");
    }
}

/// The poles of each scheme are at the values given by `tuned` (docs/numerics.md §1.5).
#[test]
fn a_tuned_mode_has_its_pole() {
    let dt = 1.0 / 48_000.0;
    for (f, t60) in [(30.0, 4.0), (440.0, 1.0), (5_000.0, 0.2), (11_000.0, f64::INFINITY)] {
        let (r, phi) = (libm::pow(10.0, -3.0 * dt / t60), 2.0 * std::f64::consts::PI * f * dt);
        for theta in [None, Some(0.0), Some(1.0 / 12.0), Some(0.25)] {
            let method = if theta.is_some() { Method::Implicit } else { Method::Ca };
            let scheme = Scheme::of(method, theta);
            let (a, b) = scheme.tuned(f, t60, dt).unwrap();
            // (1 + b/2 + θa) w² − (2 − a(1 − 2θ)) w + (1 − b/2 + θa) at w = r e^(iφ); the explicit damper is backward
            let [p2, p1, p0] = match theta {
                Some(t) => [1.0 + 0.5 * b + t * a, -(2.0 - a * (1.0 - 2.0 * t)), 1.0 - 0.5 * b + t * a],
                None => [1.0, -(2.0 - a - b), 1.0 - b],
            };
            let re = p2 * r * r * libm::cos(2.0 * phi) + p1 * r * libm::cos(phi) + p0;
            let im = p2 * r * r * libm::sin(2.0 * phi) + p1 * r * libm::sin(phi);
            assert!(re.abs() < 1e-12 && im.abs() < 1e-12, "{f} Hz, θ {theta:?}: {re}, {im}");
        }
    }
    assert_eq!(retune(440.0, 1.0, dt), Scheme::Explicit.tuned(440.0, 1.0, dt).unwrap());
    assert_eq!((Method::of(2.0), Method::of(None), Method::of(9.0)), (Method::Implicit, Method::Ca, Method::Pefrl));
}
