//! Adds a law of interaction to a program: a spring that hardens with the fifth power.
//!
//! The law is written once here. Its kernels, its energy in the ledger, its stability in the certificate and its
//! section in the language follow from it.

use cordis_anima::ca_compile::load;
use cordis_anima::ca_core::{BETWEEN, Bound, Dim, Kind, Law, Need, POSITIVE, Param, Phi, Real, Role, Table, Unit};
use cordis_anima::{Options, catalog, tick};

/// F = k e + q e⁵.
struct Fifth;

impl Phi<2, 0> for Fifth {
    fn coefs(p: &[Option<f64>], _te: f64) -> [f64; 2] {
        [p[1].unwrap_or(0.0), p[2].unwrap_or(0.0)]
    }
    #[inline(always)]
    fn force<R: Real>(&[k, q]: &[R; 2], _: &mut [R; 0], _: &[Table<R>], e: R, _w: R) -> R {
        let square = e * e;
        (k + q * square * square) * e
    }
    fn potential<R: Real>(&[k, q]: &[R; 2], _: &[R; 0], _: &[Table<R>], e: R) -> R {
        let square = e * e;
        square * (R::of(0.5) * k + q * square * square / R::of(6.0))
    }
    fn bound(&[k, _]: &[f64; 2], _: &[Table]) -> Bound {
        Bound { k, hardens: true, ..Bound::default() }
    }
}

/// In SI base units kg m⁻⁴ s⁻².
const FIFTH: Unit = Unit { symbol: "N/m^5", dim: Dim::new(-4.0, 1.0, -2.0) };

static LAW: Law = Law::of::<Fifth, 2, 0>("FIFTH");

static KIND: Kind = Kind {
    code: "FIFTH",
    title: "spring with a fifth power",
    equation: "F = k e + q e^5",
    doc: "A spring that is soft at rest and stiff when it is stretched.",
    source: &[],
    params: &[
        BETWEEN,
        Param::number("k", Unit::STIFFNESS, POSITIVE, Need::Required, "stiffness at rest"),
        Param::number("q", FIFTH, POSITIVE, Need::Required, "stiffness of the fifth power"),
    ],
    one_of: &[],
    example: r#"
[SOL]
wall = {}
[MAS]
bob = { m = "1 g", dx0 = "2 mm" }
[FIFTH]
spring = { between = ["wall", "bob"], k = "1 kN/m", q = "5e14 N/m^5" }
[SOX]
out = { from = "bob", gain = 300 }
"#,
    role: Role::Lia(&LAW),
};

/// Returns the largest displacement \[m\] after half a second, and the residual of the energy ledger over its peak.
fn play() -> (f64, f64) {
    let kinds = catalog().with(&[&KIND]);
    let options = Options { energy: true, ..Options::default() };
    let (_, scene) = load(KIND.example, "fifth.ca.toml", &kinds, &options);
    let scene = scene.expect("it compiles").scene;
    let mut s = scene.state();
    let mut most: f64 = 0.0;
    for n in 0..48_000 {
        tick(&scene, &mut s);
        most = most.max(if n > 24_000 { s.output[0].abs() / 300.0 } else { 0.0 });
    }
    let balance = s.ledger.as_ref().expect("a ledger was asked for").balance();
    (most, balance.residual.abs() / balance.peak)
}

fn main() {
    let (most, residual) = play();
    println!("still {:.4} mm after half a second; residual of the energy ledger {residual:.1e}", most * 1e3);
}

#[test]
fn nothing_is_lost() {
    let (most, residual) = play();
    assert!((most - 2e-3).abs() < 2e-5, "{most}");
    // the explicit scheme changes the energy of a curved spring; the ledger accounts for that change
    assert!(residual < 1e-9, "{residual}");
}
