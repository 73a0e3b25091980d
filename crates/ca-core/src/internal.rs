//! Exports the modules of this crate to the compiler, the engine, the views and the tests of this workspace. Anything
//! here may change at any time. A program uses the names at the root of the crate.

macro_rules! modules {
    ($($module:ident)*) => {
        $(
            #[allow(missing_docs, reason = "the module has its own text")]
            pub mod $module {
                pub use crate::$module::*;
            }
        )*
    };
}
modules! { border io kind law live mat method numeric op phi scene state tuning }
