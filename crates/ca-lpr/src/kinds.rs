//! LPR kinds, one for each law, made from the kind of the core at compile time.
//!
//! This file writes the titles, pages and examples that differ from the law. [`crate::params`] makes the parameters,
//! and the rest is copied from the kind of the law.

use crate::laws;
use crate::params::{BOW, BUT, HRZ, PAGE, count, params};
use ca_core::internal::op::LawEntry;
use ca_core::internal::phi;
use ca_core::{Kind, Param, Real, Role};

/// All kinds of this crate, in the order of the documentation.
pub const KINDS: &[&Kind] = &{
    const OWN: [&Kind; 10] =
        [&LPR, &LPR_RES, &LPR_FRO, &LPR_BUT, &LPR_CUB, &LPR_HRZ, &LPR_LNL, &LPR_PLK, &LPR_ATT, &LPR_BOW];
    let (mut all, mut i) = ([OWN[0]; OWN.len() + QUADRIPOLES.len()], 0);
    while i < all.len() {
        all[i] = if i < OWN.len() { OWN[i] } else { QUADRIPOLES[i - OWN.len()] };
        i += 1;
    }
    all
};

// A law of the core gets its LPR by one line here, `file: Phi;`. The kinds below have separate pages.
quadripoles! {
    pow: Pow;
}

/// Example with a body of two masses in space whose edge is the link; a cell sounds. `$speed` is along the edge.
macro_rules! edge {
    ($code:literal, $speed:literal, $args:literal, $gain:literal) => {
        concat!(
            "\n[air]\ndim = 3\n[air.SOL]\nnail = { x = [0, 0, 0] }\n[air.MAS]\nball = { m = \"5 g\", x = [\"12 mm\", \
             \"16 mm\", 0], v = [",
            $speed,
            "] }\n[SOL]\nwall = {}\n[CEL]\nbar = { m = \"1 g\", f = \"440 Hz\", t60 = \"1 s\" }\n[",
            $code,
            "]\nedge = { between = [\"air.nail\", \"air.ball\"], onto = [\"wall\", \"bar\"], ",
            $args,
            " }\n[SOX]\nout = { from = \"bar\", gain = ",
            $gain,
            " }\n"
        )
    };
}

/// Example with two cells and a port that is moved past them, all on lines. The link sounds on both cells.
macro_rules! drawn {
    ($code:literal, $args:literal, $gain:literal, $gesture:literal) => {
        concat!(
            "\n[CEL]\nreed = { m = \"1 g\", f = \"220 Hz\", t60 = \"1 s\" }\nbar = { m = \"1 g\", f = \"330 Hz\", t60 \
             = \"1 s\" }\n[ENX]\nhand = {}\n[SOL]\nwall = {}\n[",
            $code,
            "]\nlink = { between = [\"reed\", \"hand\"], onto = [\"wall\", \"bar\"], ",
            $args,
            " }\n[SOX]\nout = { from = \"bar\", gain = ",
            $gain,
            " }\n[gesture]\nhand = ",
            $gesture,
            "\n"
        )
    };
}

macro_rules! kind {
    ($name:ident, $code:literal, $law:ident, $of:path, $title:literal, $doc:literal, $example:expr) => {
        kind!($name, $code, $law, $of, $title, $doc, $example, {
            const PARAMS: [Param; count(&$of)] = params(&$of);
            &PARAMS
        });
    };
    ($name:ident, $code:literal, $law:ident, $of:path, $title:literal, $doc:literal, $example:expr, $params:expr) => {
        pub static $name: Kind = Kind {
            code: $code,
            title: $title,
            doc: text!($doc, PAGE),
            source: &["Rattle"],
            params: $params,
            example: $example,
            role: Role::Lia(&laws::$law),
            ..$of
        };
    };
}

kind!(
    LPR,
    "LPR",
    REF,
    phi::ref_::KIND,
    "spring and damper across two worlds",
    "An edge of a body in space that makes a world on a line sound: the link of the rattle. Springs in the world on a \
     line must hold the two ends, to each other or to the ground. The compliance of that world adds to the compliance \
     of the edge.",
    edge!("LPR", "\"60 mm/s\", \"80 mm/s\", 0", "k = \"5 kN/m\", z = \"0.1 N s/m\"", "3000")
);
kind!(
    LPR_RES,
    "LPR_RES",
    RES,
    phi::res::KIND,
    "spring across two worlds",
    "An edge without losses.",
    edge!("LPR_RES", "\"60 mm/s\", \"80 mm/s\", 0", "k = \"5 kN/m\"", "3000")
);
kind!(
    LPR_FRO,
    "LPR_FRO",
    FRO,
    phi::fro::KIND,
    "damper across two worlds",
    "A damper whose force acts in both worlds.",
    edge!("LPR_FRO", "\"0.6 m/s\", \"0.8 m/s\", 0", "z = \"0.3 N s/m\"", "3000")
);
kind!(
    LPR_BUT,
    "LPR_BUT",
    CONTACT_BUT,
    phi::but::KIND,
    "buffer across two worlds",
    "A contact in space that makes a world on a line sound.",
    edge!("LPR_BUT", "\"-0.6 m/s\", \"-0.8 m/s\", 0", "k = \"20 kN/m\", z = \"0.5 N s/m\", d = \"10 mm\"", "1000"),
    BUT
);
kind!(
    LPR_CUB,
    "LPR_CUB",
    CUB,
    phi::cub::KIND,
    "hardening spring across two worlds",
    "An edge that becomes stiffer as it is stretched.",
    edge!("LPR_CUB", "\"60 mm/s\", \"80 mm/s\", 0", "k = \"2 kN/m\", k3 = \"1e10 N/m^3\", z = \"0.1 N s/m\"", "3000")
);
kind!(
    LPR_HRZ,
    "LPR_HRZ",
    CONTACT_HRZ,
    phi::hrz::KIND,
    "Hertz contact across two worlds",
    "A contact of rounded bodies in space that makes a world on a line sound.",
    edge!("LPR_HRZ", "\"-0.6 m/s\", \"-0.8 m/s\", 0", "k = \"1e6 N/m^1.5\", h = \"0.2 s/m\", d = \"10 mm\"", "1000"),
    HRZ
);
kind!(
    LPR_LNL,
    "LPR_LNL",
    LNL,
    phi::lnl::KIND,
    "interaction by table across two worlds",
    "A law given by points.",
    edge!(
        "LPR_LNL",
        "\"60 mm/s\", \"80 mm/s\", 0",
        "spring = [[\"-2 mm\", \"-9 N\"], [\"-0.1 mm\", \"-0.2 N\"], [\"0.1 mm\", \"0.2 N\"], [\"2 mm\", \"9 N\"]], \
         friction = [[\"-1 m/s\", \"-0.1 N\"], [\"1 m/s\", \"0.1 N\"]]",
        "3000"
    )
);
kind!(
    LPR_PLK,
    "LPR_PLK",
    PLK,
    phi::plk::KIND,
    "pluck across two worlds",
    "One plectrum that plucks in two worlds.",
    drawn!(
        "LPR_PLK",
        "k = \"2 kN/m\", z = \"0.05 N s/m\", d = \"1 mm\"",
        "500",
        "[[0, 0], [0.3, \"3 mm\"], [0.6, \"3 mm\"], [1, \"-3 mm\"]]"
    )
);
kind!(
    LPR_ATT,
    "LPR_ATT",
    ATT,
    phi::att::KIND,
    "attractor across two worlds",
    "One detent that acts in two worlds.",
    drawn!("LPR_ATT", "k = \"2 kN/m\", d = \"2 mm\", z = \"0.02 N s/m\"", "500", "[[0, 0], [0.3, \"8 mm\"]]")
);
kind!(
    LPR_BOW,
    "LPR_BOW",
    BOW,
    phi::bow::KIND,
    "bow friction across two worlds",
    "One bow that acts in two worlds: the friction depends on the sum of their relative speeds.",
    drawn!("LPR_BOW", "f = \"0.3 N\", v0 = \"50 mm/s\"", "2000", "[[0, 0], [1, \"0.2 m\"]]"),
    BOW
);
