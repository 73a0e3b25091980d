//! Changes the output of the sound while the model plays: by choice, and when a device goes away.
//!
//! The performance never waits for a sound device: a new thread opens each device, and the engine takes over open ones. When a
//! device goes away, a message says so and another one plays, or the page; the wanted device is tried every two seconds until it
//! is back. Without another output the engine goes on at the last rate of the device, and is heard again when the device asks.

use super::super::frontend::Desk;
use super::super::inputs::Inputs;
use crate::args::{ClockKind, ServeArgs};
use crate::outcome::Failure;
use ca_audio::{AudioError, AudioRequest, EventReader, Opened, Playing};
use ca_core::Scene;
use ca_haptic::rt::RtRequest;
use ca_haptic::serve::Recorder;
use ca_haptic::serve::audio::{Outlet, Patch, outlet};
use std::collections::VecDeque;
use std::sync::Arc;
use std::sync::atomic::Ordering::Relaxed;
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use std::time::{Duration, Instant};

/// The page of `ca play`.
pub(super) const PAGE: &str = "page";
/// A device without a call for this time is gone; a busy machine may stand still for less.
const GONE: Duration = Duration::from_secs(1);
/// Between two tries whether it is back.
const AGAIN: Duration = Duration::from_secs(2);

/// Why a device is opened.
#[derive(Clone, Copy, PartialEq)]
enum Why {
    /// by `ca audio` or the page
    Asked,
    /// another one is gone
    Instead,
    /// it was gone
    Back,
}

/// A device that is being opened.
struct Opening {
    name: String,
    why: Why,
    opened: Receiver<Result<Opened, AudioError>>,
}

/// The output of the sound.
pub(in super::super) struct Switch {
    wants: AudioRequest,
    /// there is a page that can play
    page: bool,
    /// something can be chosen
    open: bool,
    patch: Patch,
    playing: Option<Playing>,
    /// names of what plays and of what is to; empty for nothing
    now: String,
    wanted: String,
    opening: Option<Opening>,
    /// what else is tried
    instead: VecDeque<String>,
    /// when the device last asked, if it did at all; and whether it is gone
    heard: Option<Instant>,
    lost: bool,
    again: Instant,
    choices: Option<Receiver<Vec<String>>>,
}

impl Switch {
    /// Opens the output of `--audio`, or with a `page` a server that runs. Gives the engine's end too, if an output can be chosen.
    pub(in super::super) fn open(
        args: &ServeArgs,
        scene: &Arc<Scene>,
        recorder: &mut Recorder,
        page: bool,
        request: RtRequest,
    ) -> Result<(Switch, Option<Outlet>), Failure> {
        let wants = super::request(args, scene, page, request);
        let found = super::open(args, &wants, page)?;
        let (mut follow, mut playing) = (None, None);
        let now = match found {
            Some((name, (plays, engine, watch))) => {
                recorder.hears(Some(watch));
                (follow, playing) = (Some(engine), Some(plays));
                name
            }
            None => if page { PAGE } else { "" }.into(),
        };
        let (outlet, patch) = outlet(follow);
        let open = scene.counts.channels > 0 && args.clock == ClockKind::Monotonic;
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
            if page || args.audio.is_some() {
                switch.choices = super::choices(page);
            }
            recorder.outputs().choices = super::servers(page);
            switch.says(recorder);
        }
        Ok((switch, (open || args.audio.is_some()).then_some(outlet)))
    }

    /// The MIDI port of the server, once.
    pub(in super::super) fn events(&mut self) -> Option<EventReader> {
        self.playing.as_mut()?.events()
    }

    /// From now on it asks.
    pub(in super::super) fn start(&mut self) -> Result<(), Failure> {
        Ok(self.playing.as_mut().map_or(Ok(()), Playing::start)?)
    }

    /// The host of the output, if it is not the page.
    pub(in super::super) fn host(&self) -> Option<&'static str> {
        self.playing.as_ref().map(Playing::host)
    }

    /// One turn: what devices complain of, what is asked, what is gone and what is back.
    pub(in super::super) fn turn(
        &mut self,
        recorder: &mut Recorder,
        inputs: &mut Inputs,
        mut desk: Option<&mut dyn Desk>,
    ) {
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
        if let Some(name) = recorder.outputs().asked.take() {
            self.asked(&name, recorder, inputs, &mut desk);
        }
        self.look(recorder);
        self.take(recorder, inputs, &mut desk);
        if self.opening.is_some() {
            return;
        }
        if let Some(name) = self.instead.pop_front() {
            self.begin(&name, Why::Instead);
        } else if self.lost && self.page {
            self.by_page(recorder, inputs, &mut desk);
        } else if (self.lost || self.now != self.wanted) && Instant::now() >= self.again {
            self.again = Instant::now() + AGAIN;
            let wanted = self.wanted.clone();
            self.begin(&wanted, Why::Back);
        }
    }

    fn asked(&mut self, name: &str, recorder: &mut Recorder, inputs: &mut Inputs, desk: &mut Option<&mut dyn Desk>) {
        (self.opening, self.instead) = (None, VecDeque::new());
        if name == PAGE && !self.page {
            recorder.outputs().refused = Some("`ca serve` does not have a page; `ca play` does".into());
        } else if name == PAGE {
            self.wanted = PAGE.into();
            self.by_page(recorder, inputs, desk);
        } else if name == self.now && !self.lost {
            self.wanted = name.into();
        } else {
            return self.begin(name, Why::Asked);
        }
        self.says(recorder);
    }

    /// Opens a device on a new thread.
    fn begin(&mut self, name: &str, why: Why) {
        let (tell, opened) = channel();
        let (wants, of) = (self.wants.clone(), name.to_owned());
        let thread = std::thread::Builder::new().name("ca opens sound".into()).spawn(move || {
            let playing = ca_audio::open(&of, &wants).and_then(|mut o| o.0.start().map(|()| o));
            let _ = tell.send(playing);
        });
        self.opening = thread.is_ok().then(|| Opening { name: name.into(), why, opened });
    }

    /// Looks if the device is gone.
    fn look(&mut self, recorder: &mut Recorder) {
        let Some(playing) = &self.playing else { return };
        if playing.counts().alive.load(Relaxed) {
            (self.heard, self.lost) = (Some(Instant::now()), false);
            return;
        }
        let silent = self.heard.is_some_and(|at| at.elapsed() > GONE);
        if !self.lost && (silent || self.heard.is_some() && playing.is_over()) {
            (self.lost, self.again) = (true, Instant::now() + AGAIN);
            let others = if self.page {
                "; another device plays, or the page"
            } else {
                "; another device plays, if there is one"
            };
            recorder.say(true, format!("sound: {} is gone{others}, until it is back", playing.name()));
            if self.opening.is_none() {
                self.instead = super::servers(false).into_iter().filter(|n| *n != self.now).collect();
            }
        }
    }

    /// Takes up what is open.
    fn take(&mut self, recorder: &mut Recorder, inputs: &mut Inputs, desk: &mut Option<&mut dyn Desk>) {
        let Some(opening) = &self.opening else { return };
        let opened = match opening.opened.try_recv() {
            Err(TryRecvError::Empty) => return,
            Err(TryRecvError::Disconnected) => Err(AudioError::Failed("no thread opens it".into())),
            Ok(opened) => opened,
        };
        let Some(Opening { name, why, .. }) = self.opening.take() else { return };
        match opened {
            Ok((mut playing, follow, watch)) => {
                if !self.patch.put(Some(follow)) {
                    return;
                }
                recorder.hears(Some(watch));
                inputs.served(playing.events());
                if let Some(desk) = desk {
                    desk.sounds_by(playing.host());
                }
                self.leave(Some(playing));
                self.now = name;
                if why == Why::Asked {
                    self.wanted.clone_from(&self.now);
                }
                let back = if why == Why::Back { "it is back; " } else { "" };
                if let Some((device, ms)) = recorder.heard() {
                    recorder.say(false, format!("sound: {back}{device}, {ms:.1} ms after the model"));
                }
            }
            Err(e) if why == Why::Asked => {
                let text = format!("{name}: {e}");
                recorder.say(true, format!("sound: {text}"));
                recorder.outputs().refused = Some(text);
            }
            // what is not there yet is tried again
            Err(_) => {}
        }
        self.says(recorder);
    }

    /// The page plays.
    fn by_page(&mut self, recorder: &mut Recorder, inputs: &mut Inputs, desk: &mut Option<&mut dyn Desk>) {
        if !self.patch.put(None) {
            return;
        }
        recorder.hears(None);
        inputs.served(None);
        if let Some(desk) = desk {
            desk.sounds_by(PAGE);
        }
        self.leave(None);
        self.now = PAGE.into();
        recorder.say(false, "sound: by the page, which says how late".into());
        self.says(recorder);
    }

    /// Another plays, or none; the one before is closed beside the performance, since a server may take its time.
    fn leave(&mut self, next: Option<Playing>) {
        let lost = std::mem::take(&mut self.lost);
        (self.heard, self.instead) = (None, VecDeque::new());
        if let Some(before) = std::mem::replace(&mut self.playing, next) {
            let _ = std::thread::Builder::new().name("ca closes sound".into()).spawn(move || before.close(lost));
        }
    }

    /// Writes down the output, for `ca audio` and the page.
    fn says(&self, recorder: &mut Recorder) {
        let heard = recorder.heard().map(|(device, ms)| format!("{device}, {ms:.1} ms after the model"));
        let plays = heard.unwrap_or_else(|| if self.now == PAGE { "by the page".into() } else { String::new() });
        let o = recorder.outputs();
        (o.plays, o.wanted, o.busy) = (plays, self.wanted.clone(), self.opening.is_some());
    }

    /// Lets what the engine left be heard.
    pub(in super::super) fn end(self, rate: f64) {
        match self.playing {
            Some(playing) if self.lost => playing.close(true),
            Some(playing) => playing.end(rate),
            None => {}
        }
    }
}
