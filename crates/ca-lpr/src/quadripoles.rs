//! The LPR of a law that needs no words of its own: code, title, page and example made from the record of the law.
//!
//! Decides that a law of the core gets its quadripole by one line of [`quadripoles!`]: what differs from law to law is its
//! [`Phi`](ca_core::Phi), since a kernel is made for a type, and a function pointer of the record would cost a call
//! for each link and tick. All else is text that is put together at compile time. The example is a ball that meets two
//! cells on a line, by the numbers that the law's own example has; where it does not sound, or a law deserves a better
//! page, `kind!` of [`crate::kinds`] takes words of its own.

/// How many bytes these texts have.
pub const fn length(parts: &[&str]) -> usize {
    let (mut n, mut i) = (0, 0);
    while i < parts.len() {
        n += parts[i].len();
        i += 1;
    }
    n
}

/// Their bytes.
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

/// Where `part` ends in `text`, from `from` on; the end of the text where it is not.
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

/// What the first module of the kind `code` in `example` says behind its ends: `k = "2 kN/m", …`.
pub const fn numbers(example: &'static str, code: &str) -> &'static str {
    let text = example.as_bytes();
    let mut section = after(text, code.as_bytes(), 0);
    // the code stands in brackets: `[FELT]`
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

/// Texts joined at compile time.
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

/// The quadripoles of laws, a line each: `file: Phi;`. Makes `QUADRIPOLES`, the list of their kinds.
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

        /// Their functions over `R`.
        pub fn quadripoles<R: Real>() -> impl IntoIterator<Item = LawEntry<R>> {
            [$(($file::LAW.code, laws::fns::<R, phi::$file::$phi, _, _>())),*]
        }
    };
}
