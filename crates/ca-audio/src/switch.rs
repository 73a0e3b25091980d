//! Changes the sound output while the model plays, on request or when a device disappears.
//!
//! The performance never waits for a sound device: a new thread opens each device, and the engine switches to it once
//! it is open. When a device disappears, a message says so, and another device or the page plays. The wanted device is
//! tried every two seconds until it returns. Without any output the engine continues at the last rate of the device;
//! its sound returns when the device calls again.

use crate::{AudioError, AudioRequest, EventReader, OpenOutput, Opened};
use ca_haptic::serve::Recorder;
use ca_haptic::serve::audio::{Outlet, Patch, outlet};
use std::collections::VecDeque;
use std::sync::atomic::Ordering::Relaxed;
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use std::time::{Duration, Instant};

/// Name of the page of `ca play`.
pub const PAGE: &str = "page";
/// Time without a call after which a device counts as gone; a busy machine may pause for less.
const GONE: Duration = Duration::from_secs(1);
/// Time between attempts to reopen a device.
const AGAIN: Duration = Duration::from_secs(2);

/// Called with the MIDI port and the host of a new output.
pub type OnChange<'a> = dyn FnMut(Option<EventReader>, &'static str) + 'a;

/// Outputs that a [`Switch`] may choose.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SwitchOptions {
    /// True if a page can play.
    pub page: bool,
    /// True if an output can be chosen.
    pub open: bool,
    /// True if a new thread searches for sound devices, in addition to servers.
    pub devices: bool,
}

#[derive(Clone, Copy, PartialEq)]
enum OpenReason {
    /// Chosen by `ca audio` or the page.
    Asked,
    /// Another device has gone.
    Instead,
    /// The wanted device had gone.
    Back,
}

struct Opening {
    name: String,
    why: OpenReason,
    opened: Receiver<Result<Opened, AudioError>>,
}

/// Sound output of a performance.
pub struct Switch {
    wants: AudioRequest,
    page: bool,
    open: bool,
    patch: Patch,
    playing: Option<OpenOutput>,
    /// Names of the present and the wanted output; empty for none.
    now: String,
    wanted: String,
    opening: Option<Opening>,
    /// Alternatives still to try.
    instead: VecDeque<String>,
    /// Time of the last call of the device, if there was one; whether the device is gone.
    heard: Option<Instant>,
    lost: bool,
    again: Instant,
    choices: Option<Receiver<Vec<String>>>,
}

impl Switch {
    /// Takes an open output with its name, or none; also returns the engine's end of the sound.
    pub fn new(
        wants: AudioRequest,
        found: Option<(String, Opened)>,
        options: SwitchOptions,
        recorder: &mut Recorder,
    ) -> (Switch, Outlet) {
        let SwitchOptions { page, open, devices } = options;
        let (mut follow, mut playing) = (None, None);
        let now = match found {
            Some((name, (plays, engine, watch))) => {
                recorder.set_audio(Some(watch));
                (follow, playing) = (Some(engine), Some(plays));
                name
            }
            None => if page { PAGE } else { "" }.into(),
        };
        let (outlet, patch) = outlet(follow);
        let mut switch = Switch {
            wants,
            page,
            open,
            patch,
            playing,
            wanted: now.clone(),
            now,
            opening: None,
            instead: VecDeque::new(),
            heard: None,
            lost: false,
            again: Instant::now(),
            choices: None,
        };
        if open {
            if devices {
                switch.choices = choices(page);
            }
            recorder.outputs().choices = named(page);
            switch.update_outputs(recorder);
        }
        (switch, outlet)
    }

    /// Returns the MIDI port of the server, once.
    pub fn events(&mut self) -> Option<EventReader> {
        self.playing.as_mut()?.events()
    }

    /// Starts the output.
    ///
    /// # Errors
    /// If the output does not start.
    pub fn start(&mut self) -> Result<(), AudioError> {
        self.playing.as_mut().map_or(Ok(()), OpenOutput::start)
    }

    /// Returns the host of the output, unless it is the page.
    pub fn host(&self) -> Option<&'static str> {
        self.playing.as_ref().map(OpenOutput::host)
    }

    /// Processes messages of devices, requested outputs, and devices that disappeared or returned. Calls `changed` for
    /// a new output.
    pub fn poll(&mut self, recorder: &mut Recorder, changed: &mut OnChange) {
        if let Some(playing) = &self.playing {
            for text in playing.complaints() {
                recorder.say(true, format!("{}: {text}", playing.name()));
            }
        }
        if !self.open {
            return;
        }
        if let Some(all) = self.choices.as_ref().and_then(|c| c.try_recv().ok()) {
            recorder.outputs().choices = all;
        }
        if let Some(name) = recorder.outputs().pending.take() {
            self.open_requested(&name, recorder, changed);
        }
        self.look(recorder);
        self.take(recorder, changed);
        if self.opening.is_some() {
            return;
        }
        if let Some(name) = self.instead.pop_front() {
            self.begin(&name, OpenReason::Instead);
        } else if self.lost && self.page {
            self.by_page(recorder, changed);
        } else if (self.lost || self.now != self.wanted) && Instant::now() >= self.again {
            self.again = Instant::now() + AGAIN;
            let wanted = self.wanted.clone();
            self.begin(&wanted, OpenReason::Back);
        }
    }

    fn open_requested(&mut self, name: &str, recorder: &mut Recorder, changed: &mut OnChange) {
        (self.opening, self.instead) = (None, VecDeque::new());
        if name == PAGE && !self.page {
            recorder.outputs().refused = Some("`ca serve` does not have a page; use `ca play`".into());
        } else if name == PAGE {
            self.wanted = PAGE.into();
            self.by_page(recorder, changed);
        } else if name == self.now && !self.lost {
            self.wanted = name.into();
        } else {
            return self.begin(name, OpenReason::Asked);
        }
        self.update_outputs(recorder);
    }

    fn begin(&mut self, name: &str, why: OpenReason) {
        let (tell, opened) = channel();
        let (wants, of) = (self.wants.clone(), name.to_owned());
        let thread = std::thread::Builder::new().name("ca opens sound".into()).spawn(move || {
            let playing = crate::open(&of, &wants).and_then(|mut o| o.0.start().map(|()| o));
            let _ = tell.send(playing);
        });
        self.opening = thread.is_ok().then(|| Opening { name: name.into(), why, opened });
    }

    /// Checks if the device is gone, and then lists the other outputs to try.
    fn look(&mut self, recorder: &mut Recorder) {
        let Some(playing) = &self.playing else { return };
        if playing.counts().alive.load(Relaxed) {
            (self.heard, self.lost) = (Some(Instant::now()), false);
            return;
        }
        let silent = self.heard.is_some_and(|at| at.elapsed() > GONE);
        if !self.lost && (silent || self.heard.is_some() && playing.is_over()) {
            (self.lost, self.again) = (true, Instant::now() + AGAIN);
            let others = if self.page { "another device or the page" } else { "another device, if there is one," };
            recorder.say(true, format!("sound: lost {}; using {others} until it is back", playing.name()));
            if self.opening.is_none() {
                self.instead = named(false).into_iter().filter(|n| *n != self.now).collect();
            }
        }
    }

    /// Switches to a device that has been opened.
    fn take(&mut self, recorder: &mut Recorder, changed: &mut OnChange) {
        let Some(opening) = &self.opening else { return };
        let opened = match opening.opened.try_recv() {
            Err(TryRecvError::Empty) => return,
            Err(TryRecvError::Disconnected) => Err(AudioError::Failed("cannot start a thread to open it".into())),
            Ok(opened) => opened,
        };
        let Some(Opening { name, why, .. }) = self.opening.take() else { return };
        match opened {
            Ok((mut playing, follow, watch)) => {
                if !self.patch.put(Some(follow)) {
                    return;
                }
                recorder.set_audio(Some(watch));
                changed(playing.events(), playing.host());
                self.leave(Some(playing));
                self.now = name;
                if why == OpenReason::Asked {
                    self.wanted.clone_from(&self.now);
                }
                let back = if why == OpenReason::Back { "it is back; " } else { "" };
                if let Some((device, ms)) = recorder.audio_output() {
                    recorder.say(false, format!("sound: {back}{device}, {ms:.1} ms latency"));
                }
            }
            Err(e) if why == OpenReason::Asked => {
                let text = format!("{name}: {e}");
                recorder.say(true, format!("sound: {text}"));
                recorder.outputs().refused = Some(text);
            }
            // a missing device is tried again later
            Err(_) => {}
        }
        self.update_outputs(recorder);
    }

    fn by_page(&mut self, recorder: &mut Recorder, changed: &mut OnChange) {
        if !self.patch.put(None) {
            return;
        }
        recorder.set_audio(None);
        changed(None, PAGE);
        self.leave(None);
        self.now = PAGE.into();
        recorder.say(false, "sound: by the page, which shows its latency".into());
        self.update_outputs(recorder);
    }

    /// Replaces the output. The old one is closed on another thread, because a server may be slow.
    fn leave(&mut self, next: Option<OpenOutput>) {
        let lost = std::mem::take(&mut self.lost);
        (self.heard, self.instead) = (None, VecDeque::new());
        if let Some(before) = std::mem::replace(&mut self.playing, next) {
            let _ = std::thread::Builder::new().name("ca closes sound".into()).spawn(move || before.close(lost));
        }
    }

    /// Updates the output shown by `ca audio` and the page.
    fn update_outputs(&self, recorder: &mut Recorder) {
        let heard = recorder.audio_output().map(|(device, ms)| format!("{device}, {ms:.1} ms latency"));
        let plays = heard.unwrap_or_else(|| if self.now == PAGE { "by the page".into() } else { String::new() });
        let o = recorder.outputs();
        (o.plays, o.wanted, o.busy) = (plays, self.wanted.clone(), self.opening.is_some());
    }

    /// Plays the samples left in the ring of the engine, then closes the output.
    pub fn end(self, rate: f64) {
        match self.playing {
            Some(playing) if self.lost => playing.close(true),
            Some(playing) => playing.end(rate),
            None => {}
        }
    }
}

/// Returns the outputs that can be chosen without searching for devices.
fn named(page: bool) -> Vec<String> {
    page.then_some(PAGE).into_iter().chain(crate::servers()).map(Into::into).collect()
}

/// Returns those and all sound devices, found by a new thread; `None` in a build without devices.
fn choices(page: bool) -> Option<Receiver<Vec<String>>> {
    if !cfg!(feature = "devices") {
        return None;
    }
    let (tell, all) = channel();
    let look = move || {
        let page = page.then(|| PAGE.to_owned());
        let _ = tell.send(page.into_iter().chain(crate::names()).collect());
    };
    std::thread::Builder::new().name("ca looks for sound".into()).spawn(look).ok().map(|_| all)
}
