//! The Python distribution `cordis-anima` will live here (`import cordis_anima as ca`): render, stream, sweep. Nothing
//! is built yet: it binds the renderer once that has settled.
#![forbid(unsafe_code)]
