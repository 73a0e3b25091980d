//! Makes the LPR of most laws: code, title, page and example come from the record of the law, at compile time.
//!
//! One line of [`quadripoles!`] names the [`Phi`](ca_core::Phi) of the law, because a kernel is compiled for a type; a
//! function pointer in the record would cost a call for each link and tick. The example is a ball that strikes two
//! cells on a line, with the numbers of the law's own example. If it does not sound, or a law needs a better page,
//! `kind!` of [`crate::kinds`] takes other texts.

/// Counts the bytes of all parts.
pub const fn length(parts: &[&str]) -> usize {
    let (mut n, mut i) = (0, 0);
    while i < parts.len() {
        n += parts[i].len();
        i += 1;
    }
    n
}

/// Joins the bytes of all parts.
pub const fn joined<const N: usize>(parts: &[&str]) -> [u8; N] {
    let mut all = [0; N];
    let (mut n, mut i) = (0, 0);
    while i < parts.len() {
        let (part, mut k) = (parts[i].as_bytes(), 0);
        while k < part.len() {
            all[n] = part[k];
            n += 1;
            k += 1;
        }
        i += 1;
    }
    all
}

/// Returns the index behind the first `part` in `text` from `from` on, or the length of `text` if there is none.
const fn after(text: &[u8], part: &[u8], from: usize) -> usize {
    let mut i = from;
    while i + part.len() <= text.len() {
        let mut k = 0;
        while k < part.len() && text[i + k] == part[k] {
            k += 1;
        }
        if k == part.len() {
            return i + k;
        }
        i += 1;
    }
    text.len()
}

/// Returns the parameters behind the ends of the first module of kind `code` in `example`: `k = "2 kN/m", …`.
pub const fn numbers(example: &'static str, code: &str) -> &'static str {
    let text = example.as_bytes();
    let mut section = after(text, code.as_bytes(), 0);
    // the section is in brackets: `[FELT]`
    while section < text.len() && text[section] != b']' {
        section = after(text, code.as_bytes(), section);
    }
    let from = after(text, b"], ", section);
    let to = after(text, b" }\n", from);
    if to < from + 3 {
        return "";
    }
    let (_, rest) = text.split_at(from);
    let (words, _) = rest.split_at(to - 3 - from);
    match core::str::from_utf8(words) {
        Ok(words) => words,
        Err(_) => "",
    }
}

macro_rules! text {
    ($($part:expr),* $(,)?) => {{
        const PARTS: &[&str] = &[$($part),*];
        const BYTES: [u8; $crate::quadripoles::length(PARTS)] = $crate::quadripoles::joined(PARTS);
        match core::str::from_utf8(&BYTES) {
            Ok(text) => text,
            Err(_) => "",
        }
    }};
}

/// Makes the quadripoles of laws, one line each, `file: Phi;`, and `QUADRIPOLES`, the list of their kinds.
macro_rules! quadripoles {
    ($($file:ident: $phi:ident;)*) => {
        $(
            mod $file {
                use ca_core::internal::op::{Cheaper, LawFns};
                use ca_core::internal::phi::$file as law;
                use ca_core::{Kind, Law, Param, Role};

                pub static LAW: Law = Law {
                    code: text!("LPR_", law::KIND.code),
                    cheaper: Cheaper {
                        simpler: |p| $crate::laws::quadripole((law::LAW.cheaper.simpler)(p)?),
                        variants: &[],
                    },
                    fns: LawFns { kernel: $crate::op::kernel::<f64, law::$phi, _, _>, ..law::LAW.fns },
                    ..law::LAW
                };

                pub static KIND: Kind = Kind {
                    code: text!("LPR_", law::KIND.code),
                    title: text!(law::KIND.title, " across two worlds"),
                    doc: text!(law::KIND.doc, $crate::params::PAGE),
                    source: &["Rattle"],
                    params: {
                        const PARAMS: [Param; $crate::params::count(&law::KIND)] = $crate::params::params(&law::KIND);
                        &PARAMS
                    },
                    example: text!(
                        "\n[CEL]\nreed = { m = \"1 g\", f = \"220 Hz\", t60 = \"1 s\" }\nbar = { m = \"1 g\", f = \"330 Hz\", t60 = \
                         \"1 s\" }\n[MAS]\nball = { m = \"5 g\", x = \"-1 mm\", v = \"0.8 m/s\" }\n[SOL]\nwall = {}\n[LPR_",
                        law::KIND.code,
                        "]\nlink = { between = [\"ball\", \"reed\"], onto = [\"wall\", \"bar\"], ",
                        $crate::quadripoles::numbers(law::KIND.example, law::KIND.code),
                        " }\n[SOX]\nout = { from = \"bar\", gain = 300 }\n",
                    ),
                    role: Role::Lia(&LAW),
                    ..law::KIND
                };
            }
        )*
        const QUADRIPOLES: &[&Kind] = &[$(&$file::KIND),*];

        /// Returns the functions of these laws over `R`.
        pub fn quadripoles<R: Real>() -> impl IntoIterator<Item = LawEntry<R>> {
            [$(($file::LAW.code, laws::fns::<R, phi::$file::$phi, _, _>())),*]
        }
    };
}
