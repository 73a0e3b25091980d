//! Functions of the WebAssembly modules.
//!
//! JavaScript asks `ca_room` for memory, writes a request there, and calls a function with the length of the request.
//! A function that returns bytes returns their length, and `ca_at` returns their place. They stay valid until the next
//! call. A request that has a JSON object and bytes begins with the length of the object, a little-endian `u32`. Only the
//! module that measures has imports: a clock, and a function for its progress.
#![allow(unsafe_code)]

use std::cell::RefCell;

#[derive(Default)]
struct Exchange {
    request: Vec<u8>,
    answer: Vec<u8>,
}

thread_local! {
    static EXCHANGE: RefCell<Exchange> = RefCell::default();
}

/// Makes room for a request and returns its place.
#[unsafe(no_mangle)]
pub extern "C" fn ca_room(len: usize) -> *mut u8 {
    EXCHANGE.with_borrow_mut(|e| {
        e.request.clear();
        e.request.resize(len, 0);
        e.request.as_mut_ptr()
    })
}

/// Returns the place of the last answer.
#[unsafe(no_mangle)]
pub extern "C" fn ca_at() -> *const u8 {
    EXCHANGE.with_borrow(|e| e.answer.as_ptr())
}

fn request() -> Vec<u8> {
    EXCHANGE.with_borrow_mut(|e| std::mem::take(&mut e.request))
}

fn put(answer: Vec<u8>) -> usize {
    EXCHANGE.with_borrow_mut(|e| {
        e.answer = answer;
        e.answer.len()
    })
}

/// Splits a request into its object and its bytes.
fn parts(request: &[u8]) -> Option<(&[u8], &[u8])> {
    let (len, rest) = request.split_first_chunk::<4>()?;
    rest.split_at_checked(u32::from_le_bytes(*len) as usize)
}

#[cfg(any(feature = "compiler", feature = "accuracy"))]
fn put_parts(object: &serde_json::Value, bytes: &[u8]) -> usize {
    let object = object.to_string();
    let mut all = (object.len() as u32).to_le_bytes().to_vec();
    all.extend_from_slice(object.as_bytes());
    all.extend_from_slice(bytes);
    put(all)
}

#[cfg(feature = "compiler")]
mod compiler {
    use super::{parts, put_parts, request};

    /// Answers a request to the compiler. Request and answer are an object and bytes.
    #[unsafe(no_mangle)]
    pub extern "C" fn ca_answer() -> usize {
        let request = request();
        let (object, bytes) = parts(&request).unwrap_or_default();
        let (object, bytes) = crate::compiler::answer(object, bytes);
        put_parts(&object, &bytes)
    }
}

#[cfg(all(feature = "accuracy", not(feature = "compiler"), target_family = "wasm"))]
mod accuracy {
    use super::{parts, put_parts, request};
    use crate::accuracy::CLOCK_STEP;
    use ca_accuracy::timing::Clock;
    use std::time::Duration;

    #[link(wasm_import_module = "ca")]
    unsafe extern "C" {
        /// Time since a fixed moment \[ms\].
        safe fn now() -> f64;
        /// Receives the numbers of finished steps and of all steps; 0 ends the measurement.
        safe fn progress(done: f64, of: f64) -> u32;
    }

    /// Measures a model. Request and answer are an object and bytes.
    #[unsafe(no_mangle)]
    pub extern "C" fn ca_answer() -> usize {
        let request = request();
        let clock = Clock { now: || Duration::from_secs_f64(1e-3 * now().max(0.0)), step: CLOCK_STEP };
        let asked = parts(&request).unwrap_or_default().0;
        let (object, bytes) =
            crate::accuracy::answer(asked, clock, &mut |done, of| progress(done as f64, of as f64) != 0);
        put_parts(&object, &bytes)
    }
}

#[cfg(feature = "engine")]
mod engine {
    use super::{parts, put, request};
    use crate::engine::{Facts, Shape, WebEngine};
    use std::cell::{Cell, RefCell};

    thread_local! {
        static ENGINE: RefCell<Option<WebEngine>> = const { RefCell::new(None) };
        static SOUND: Cell<*const f32> = const { Cell::new(std::ptr::null()) };
    }

    fn with<T>(otherwise: T, work: impl FnOnce(&mut WebEngine) -> T) -> T {
        ENGINE.with_borrow_mut(|engine| engine.as_mut().map_or(otherwise, work))
    }

    /// The facts and the plan of a request.
    fn plan(request: &[u8]) -> Option<(Facts, &[u8])> {
        let (facts, plan) = parts(request)?;
        Some((serde_json::from_slice(facts).ok()?, plan))
    }

    /// Opens an instrument. Returns the length of the error; 0 without one.
    #[unsafe(no_mangle)]
    pub extern "C" fn ca_open() -> usize {
        let request = request();
        let opened = match plan(&request) {
            Some((facts, plan)) => WebEngine::open(plan, &facts),
            None => Err("the request has another form".into()),
        };
        match opened {
            Ok(engine) => {
                ENGINE.set(Some(engine));
                0
            }
            Err(why) => put(why.into_bytes()),
        }
    }

    /// Answers a request of the page.
    #[unsafe(no_mangle)]
    pub extern "C" fn ca_request() {
        let request = request();
        with((), |engine| engine.request(&request));
    }

    /// Receives a plan from the compiler.
    #[unsafe(no_mangle)]
    pub extern "C" fn ca_compiled() {
        let request = request();
        with((), |engine| match plan(&request) {
            Some((facts, plan)) => engine.compiled(plan, &facts),
            None => engine.refused("the compiled model has another form"),
        });
    }

    /// Receives a refusal of the compiler.
    #[unsafe(no_mangle)]
    pub extern "C" fn ca_refused() {
        let why = request();
        with((), |engine| engine.refused(&String::from_utf8_lossy(&why)));
    }

    /// Compiles the model again.
    #[unsafe(no_mangle)]
    pub extern "C" fn ca_changed() {
        with((), WebEngine::changed);
    }

    /// Plays gesture frames. Returns the number of samples, which begin at [`ca_sound_at`].
    #[unsafe(no_mangle)]
    pub extern "C" fn ca_play(frames: u32) -> usize {
        with(0, |engine| {
            let sound = engine.play(frames);
            SOUND.set(sound.as_ptr());
            sound.len()
        })
    }

    /// Returns the place of the samples that [`ca_play`] made: `f32`, interleaved.
    #[unsafe(no_mangle)]
    pub extern "C" fn ca_sound_at() -> *const f32 {
        SOUND.get()
    }

    /// Takes the oldest message to the page. Returns its length; 0 without one.
    #[unsafe(no_mangle)]
    pub extern "C" fn ca_next() -> usize {
        with(None, WebEngine::next_message).map_or(0, put)
    }

    fn shape() -> Shape {
        with(Shape { rate: 0.0, channels: 0, frame: 0 }, |engine| engine.shape())
    }

    /// Sound rate \[Hz\].
    #[unsafe(no_mangle)]
    pub extern "C" fn ca_rate() -> f64 {
        shape().rate
    }

    /// Channels.
    #[unsafe(no_mangle)]
    pub extern "C" fn ca_channels() -> u32 {
        shape().channels as u32
    }

    /// Samples of a gesture frame, in each channel.
    #[unsafe(no_mangle)]
    pub extern "C" fn ca_frame() -> u32 {
        shape().frame
    }
}
