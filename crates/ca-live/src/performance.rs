//! Runs a performance from its request to its report.

use crate::connections::Connections;
use crate::inputs::Inputs;
use crate::output::Output;
use crate::page::{self, PageSession};
use crate::report::Report;
use crate::request::{ControlRequest, Listener, Pace, Request, ThreadOptions};
use crate::{setup, sound};
use ca_audio::Switch;
use ca_compile::Options;
use ca_core::Scene;
use ca_haptic::coupling;
use ca_haptic::engine::{Engine, Setup};
use ca_haptic::guard::Order;
use ca_haptic::profile::Profile;
use ca_haptic::rt::{self, RtRequest};
use ca_haptic::serve::{BufferLimits, Clock, Live, RecordIntervals, Recorder, Shared, rings};
use ca_haptic::take::Header;
use ca_lab::Failure;
use ca_model::diag::Severity;
use ca_session::answer;
use ca_take::devices;
use std::sync::Arc;
use std::sync::atomic::Ordering::Relaxed;
use std::sync::mpsc::Receiver;
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Period of the recorder loop, and time limit per iteration for the inputs and again for the pages.
const TURN: Duration = Duration::from_millis(2);

/// Iterations between two cleanups after dead processes.
const SWEEP: u64 = 250;
/// Pictures per second in a take.
const PICTURES: u32 = 60;
/// Limit on the masses of a scene whose state is hashed every second.
const HASHED: usize = 10_000;
/// Longest wait of the engine for a device that provides the clock \[ns\].
const PATIENCE: u64 = 100_000_000;
/// Nice value of this thread and the file threads. It gives them twelve times the processor time of another program.
const NICE: i8 = -11;

/// A model compiled for its devices.
struct Compiled {
    options: Options,
    scene: Arc<Scene>,
    /// Devices as described, and the limits of devices without a description.
    setups: Vec<Setup>,
    unknown: Vec<Option<Profile>>,
    /// The same devices with softened couplings, and messages about these.
    played: Vec<Setup>,
    softened: Vec<String>,
}

/// Threads and connections of a performance, except the engine.
struct Parts {
    recorder: Recorder,
    connections: Connections,
    inputs: Inputs,
    sound: Switch,
    page_session: Option<PageSession>,
    asked: Option<Receiver<ControlRequest>>,
    shared: Arc<Shared>,
}

/// Plays in real time until the length is reached or the performance is stopped. The `shared` of [`Listener::begins`],
/// `ca stop`, the page and [`Request::requests`] can stop it.
///
/// # Errors
/// Returns [`Failure::Found`] if the model has errors, [`Failure::Usage`] if the request does not fit the model, and
/// [`Failure::Failed`] if something cannot be opened. In these cases nothing was played and no file is left.
pub fn play(request: Request, listener: &Arc<dyn Listener>) -> Result<Report, Failure> {
    let Compiled { options, scene, setups, unknown, played, softened } = compile(&request, &**listener)?;
    let names = devices(&scene);
    if request.devices.pace == Pace::Device && names.is_empty() {
        return Err(Failure::Usage("--clock device: the model names none; leave the option out".into()));
    }
    if names.is_empty() && request.page.is_none() {
        listener.note("the model does not use a device; to play it in the browser, use `ca play` instead");
    }
    let session = ca_haptic::host::session_number();
    let engine = setup::engine(scene.clone(), &played, session);

    // the rings must be drained, and users answered, on a busy machine too; threads inherit the value
    let busy = RtRequest { nice: (request.thread.priority > 0).then_some(NICE), ..RtRequest::default() };
    rt::ask(busy);
    let shared = Arc::new(Shared::default());
    listener.begins(&shared);
    let capacity = BufferLimits::of(&scene);
    // a terminal may block, so devices and pages must not wait for it
    let waits = names.is_empty() && request.page.is_none();
    let mut output = Output::open(listener, waits, capacity)?;
    output.sound(request.files.sound.as_deref(), &scene, (capacity, busy))?;
    if request.sound.device.is_some() && scene.counts.channels == 0 {
        return Err(Failure::Usage(
            "--audio: nothing to play, because the model lacks an output; add one with `[SOX]`".into(),
        ));
    }
    let header = || {
        let changes = request.source.changes.clone();
        Header::new(&request.loaded.model, changes, options.clone(), &scene, played.clone(), engine.options())
    };
    output.take(request.files.take.as_deref(), header, &scene, (capacity, busy))?;
    let page_session = match &request.page {
        Some(page) => {
            let header = (!output.has_take() && names.is_empty()).then(header);
            let opening = page::Opening { request: &request, scene: &scene, options: &options, header };
            Some(PageSession::open(page, opening, listener, output.sinks())?)
        }
        None => None,
    };

    let looks = output.has_take() || page_session.is_some();
    let pictures = if looks { PICTURES } else { 0 };
    let (mut ends, gateway_ends, recorder_ends) = rings(&scene, names.len(), pictures);
    let sinks = std::mem::take(output.sinks());
    let mut recorder = Recorder::new(recorder_ends, shared.clone(), scene.clone(), &engine.ports, sinks);
    for text in softened {
        recorder.say(true, text);
    }
    let with_page = page_session.is_some();
    let below = thread(request.thread, -5);
    let (mut sound, outlet) = sound::open(&request, &scene, &mut recorder, below, &**listener)?;
    ends.audio = outlet;
    let inputs = Inputs::open(&request.inputs, &scene, with_page, sound.events())?;
    inputs.messages().into_iter().for_each(|text| recorder.say(false, text));
    if request.gesture {
        recorder.gesture(true).map_err(|why| Failure::Failed(why.to_string()))?;
    }
    let connections = Connections::open((&setups, unknown), &scene, gateway_ends, below, with_page, &**listener)?;
    if request.devices.arm {
        recorder.order(None, Order::Arm).map_err(|why| Failure::Failed(why.to_string()))?;
    }

    let clock = match request.devices.pace {
        // the clock of the sound device, or, without one, a fixed period
        Pace::Monotonic => Clock::Audio,
        Pace::Device => Clock::Device { patience: PATIENCE },
    };
    let frame_rate = scene.rate / f64::from(scene.rates.ratio);
    let each = |a_second: f64, wanted: bool| if wanted { (frame_rate / a_second).max(1.0) as u64 } else { 0 };
    let every = RecordIntervals {
        energy: each(100.0, request.energy),
        view: each(f64::from(PICTURES), looks),
        // hashing a large state would take longer than a frame
        hash: each(1.0, looks && scene.counts.n_mat <= HASHED),
    };
    let frames = request.seconds.map(|s| (s * frame_rate).round().max(1.0) as u64);
    let live = Live::new(engine, ends, shared.clone(), clock, every);
    sound.start().map_err(|e| Failure::Failed(e.to_string()))?;
    let mut parts = Parts { recorder, connections, inputs, sound, page_session, asked: request.requests, shared };
    parts.say_sound(scene.counts.channels);
    let (engine, granted) = engine_thread(live, thread(request.thread, 0), frames)?;
    output.begun();
    if let Some(page_session) = &parts.page_session {
        listener.page_opened(&page_session.address());
    }
    let mut threads = vec![("engine".to_string(), granted)];
    threads.extend(parts.connections.granted().map(|g| ("gateway".to_string(), g)));
    threads.extend(output.granted());
    for (name, granted) in &threads {
        listener.progress(&format!("{name}: {granted}"));
    }
    let keys = if parts.page_session.is_some() { "; until it sends, its keys are sliders of the page" } else { "" };
    for s in played.iter().filter(|s| !s.profile.is_unknown()) {
        let (title, force) = (&s.profile.title, s.profile.force);
        listener.progress(&format!("device `{}`: {title}, at most {force} N{keys}", s.device));
    }

    let engine = parts.attend(engine);
    // the page can finish its files only after all records have arrived
    let files = parts.page_session.map(PageSession::close);
    parts.sound.end(scene.rate);
    let traffic = parts.connections.end();
    let engine = engine.map_err(|_| Failure::Failed("the engine thread stopped unexpectedly".into()))?;
    parts.recorder.poll();
    output.leave_terminal();
    let mut summary = parts.recorder.summary(&engine, threads);
    drop(files);
    let (sound, take) = output.finish(&parts.shared, &mut summary, &**listener);
    let sound = request.files.sound.zip(sound);
    let take = request.files.take.zip(take);
    Ok(Report { name: request.loaded.name, rate: scene.rate, summary, traffic, sound, take })
}

fn compile(request: &Request, listener: &dyn Listener) -> Result<Compiled, Failure> {
    let loaded = &request.loaded;
    let mut options = Options {
        rate: request.source.rate,
        energy: request.energy,
        clouds: loaded.clouds.clone(),
        whole: request.page.as_ref().is_some_and(|p| !p.lean),
        ..Options::default()
    };
    let compiled = loaded.compile(&options)?;
    let mut warnings = compiled.findings.clone();
    warnings.list.retain(|d| d.severity == Severity::Warning);
    if !warnings.list.is_empty() {
        listener.findings(&warnings, &loaded.model);
    }
    let (setups, unknown) = setup::setups(&request.devices, &compiled.scene, listener)?;
    let met = coupling::couple(compiled, &setups, &mut options, |options| loaded.compile(options));
    let (softened, played) = (met.messages(), met.setups(&setups));
    let scene = Arc::new(met.compiled.scene);
    Ok(Compiled { options, scene, setups, unknown, played, softened })
}

/// Returns the scheduling request of a thread, with its priority changed by `lower` relative to the engine.
fn thread(options: ThreadOptions, lower: i32) -> RtRequest {
    let priority = (options.priority > 0).then(|| (i32::from(options.priority) + lower).clamp(1, 99) as u8);
    let of_engine = lower == 0;
    RtRequest { priority, cpu: options.cpu.filter(|_| of_engine), lock: options.lock && of_engine, nice: None }
}

/// Starts the engine on its thread. Also returns the scheduling granted by the system, known before the first frame.
fn engine_thread(live: Live, request: RtRequest, frames: Option<u64>) -> Result<(JoinHandle<Engine>, String), Failure> {
    let (tell, reported) = std::sync::mpsc::channel();
    let thread = std::thread::Builder::new()
        .name("ca engine".into())
        .spawn(move || {
            let _ = tell.send(rt::ask(request).to_string());
            live.run(frames)
        })
        .map_err(|e| Failure::Failed(format!("cannot start the engine thread: {e}")))?;
    Ok((thread, reported.recv().unwrap_or_default()))
}

impl Parts {
    /// Reports the output that plays the sound.
    fn say_sound(&mut self, channels: usize) {
        match self.recorder.audio_output() {
            Some((device, ms)) => self.recorder.say(false, format!("sound: {device}, {ms:.1} ms latency")),
            None if self.page_session.is_some() && channels > 0 => {
                self.recorder.say(false, "sound: by the page, which shows its latency".into());
            }
            None => {}
        }
        if let Some((page_session, host)) = self.page_session.as_mut().zip(self.sound.host()) {
            page_session.sounds_by(host);
        }
    }

    /// Runs the recorder until the engine ends.
    fn attend(&mut self, thread: JoinHandle<Engine>) -> std::thread::Result<Engine> {
        let mut turns = 0_u64;
        while !thread.is_finished() {
            let (inputs, page_session) = (&mut self.inputs, &mut self.page_session);
            self.sound.poll(&mut self.recorder, &mut |events, host| {
                inputs.served(events);
                if let Some(page_session) = page_session {
                    page_session.sounds_by(host);
                }
            });
            self.recorder.poll();
            if self.poll(turns.is_multiple_of(SWEEP)) {
                self.shared.stop.store(true, Relaxed);
            }
            turns += 1;
            std::thread::sleep(TURN);
        }
        thread.join()
    }

    /// Handles all inputs once. Returns true if one of them requests a stop.
    fn poll(&mut self, sweep: bool) -> bool {
        let (recorder, page_session) = (&mut self.recorder, &mut self.page_session);
        let mut leave = match page_session {
            Some(page_session) => {
                self.connections.poll(recorder, sweep, Some(&mut |name, value| page_session.change(name, value)))
            }
            None => self.connections.poll(recorder, sweep, None),
        };
        while let Some((request, reply)) = self.asked.as_ref().and_then(|asked| asked.try_recv().ok()) {
            let mut change =
                page_session.as_mut().map(|page_session| |name: &str, value: &str| page_session.change(name, value));
            let change = change.as_mut().map(|change| change as ca_session::Change<'_>);
            let _ = reply.send(answer(recorder, &crate::ModelLanguage, request, &mut leave, change));
        }
        // an endless stream of requests has to wait, since orders to disarm were handled above
        let end = Instant::now() + TURN;
        self.inputs.poll(recorder, end);
        let end = Instant::now() + TURN;
        let setups = self.connections.setups();
        leave |= page_session.as_mut().is_some_and(|d| d.poll(recorder, &mut self.inputs, setups, (&self.shared, end)));
        leave
    }
}
