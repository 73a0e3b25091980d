//! `ca serve`: a model played in real time by device processes.
//!
//! Decides who does what: the engine thread computes, the gateway thread moves frames between shared memory and rings,
//! files are written by threads of their own, and this one, the recorder, does everything else that may take its time. A
//! model without devices gets no gateway and no shared memory; one without live parameters and a page gets no control; sound
//! goes to a device only where that is asked.

mod audio;
mod frontend;
mod inputs;
mod setup;
mod summary;
mod talk;
mod wav;

use crate::args::{ClockKind, ServeArgs};
use crate::outcome::{Ended, Failure, Outcome};
use crate::{load, outputs, term};
use ca_compile::Options;
use ca_haptic::coupling;
use ca_haptic::engine::Engine;
use ca_haptic::guard::Order;
use ca_haptic::rt::{self, RtRequest};
use ca_haptic::serve::{
    AsyncSink, BufferLimits, Clock, Live, Notice, RecordIntervals, Recorder, Shared, Sink, SinkStreams, rings,
};
use ca_haptic::take::{Header, TakeWriter};
use ca_io::FileError;
use ca_io::sound::{Format, WavOut};
pub(crate) use frontend::{Desk, Frontend, Opening};
pub(crate) use inputs::Inputs;
pub(crate) use setup::devices;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::Ordering::Relaxed;
use std::thread::JoinHandle;
use std::time::{Duration, Instant};
pub(crate) use wav::Wav;

/// Between two turns of the recorder, and the most that inputs, and then pages, take of one.
const TURN: Duration = Duration::from_millis(2);

/// Between two sweeps of dead processes, in turns.
const SWEEP: u64 = 250;
/// Pictures a second in a take.
const PICTURES: u32 = 60;
/// Places of the largest scene whose state is hashed every second.
const HASHED: usize = 10_000;
/// How long the engine waits for a device that sets the pace \[ns\].
const PATIENCE: u64 = 100_000_000;
/// How long a terminal that stands still is waited for at the end, and how long after a first Ctrl-C a second ends the process.
const TERMINAL: Duration = Duration::from_secs(1);
const SURE: Duration = Duration::from_millis(500);
/// Share of the cores that this thread and those which write files ask for: twelve times that of another program.
const NICE: i8 = -11;

/// Runs the command.
pub fn run(args: &ServeArgs) -> Outcome {
    session(args, None)
}

/// Plays in real time; in a page where there is one.
pub(crate) fn session(args: &ServeArgs, page: Option<&dyn Frontend>) -> Outcome {
    written(args)?;
    let loaded = load::load(&args.source)?;
    let mut options = Options {
        rate: args.source.rate,
        energy: args.energy,
        clouds: loaded.clouds.clone(),
        whole: page.is_some_and(Frontend::whole),
        ..Options::default()
    };
    let compiled = load::scene(&loaded, &options)?;
    load::warn(&loaded, &compiled);
    let (setups, unknown) = setup::setups(args, &compiled.scene)?;
    let met = coupling::meet(compiled, &setups, &mut options, |options| load::scene(&loaded, options));
    let (softened, played) = (met.said(), met.setups(&setups));
    let scene = Arc::new(met.compiled.scene);
    let names = devices(&scene);
    if args.clock == ClockKind::Device && names.is_empty() {
        return Err(Failure::Usage("--clock device: the model has no device".into()));
    }
    if names.is_empty() && page.is_none() {
        term::note("the model has no device: nobody can play it from one; `ca play` lets you touch it in the browser");
    }
    let session = ca_haptic::host::session();
    let engine = setup::engine(scene.clone(), &played, session);

    // on a busy machine the rings must be fetched from, and people heard, all the same; threads inherit it
    let busy = RtRequest { nice: (args.priority > 0).then_some(NICE), ..RtRequest::default() };
    rt::ask(busy);
    let room = BufferLimits::of(&scene);
    let mut sinks: Vec<Box<dyn Sink>> = Vec::new();
    let shared = Arc::new(Shared::default());
    // before there is a file that would be left behind
    listen(&shared);
    let words = Words { quiet: args.quiet };
    // a terminal may stand still: neither a hand nor a page waits for it
    let words = if names.is_empty() && page.is_none() {
        sinks.push(Box::new(words));
        None
    } else {
        Some(aside(&mut sinks, "ca terminal", words, room, RtRequest::default())?)
    };
    let wav = match &args.output {
        Some(path) if scene.counts.channels > 0 => {
            load::check_wav_path(path)?;
            let out = WavOut::create(path, scene.rate, scene.counts.channels, Format::F32)?;
            Some(aside(&mut sinks, "ca sound", wav::Wav::new(out, scene.counts.channels), room, busy)?)
        }
        Some(_) => return Err(Failure::Usage("-o: the model has no output, so there is no sound to write".into())),
        None => None,
    };
    if args.audio.is_some() && scene.counts.channels == 0 {
        return Err(Failure::Usage("--audio: the model has no output, so there is no sound to play".into()));
    }
    // before `take`, so that its file is closed when it is removed
    let mut unplayed = Unplayed(None);
    let header = || {
        let changes = args.source.changes().collect();
        Header::new(&loaded.model, changes, options.clone(), &scene, played.clone(), engine.options())
    };
    let take = match &args.log {
        Some(path) => {
            let header = header();
            let writer = TakeWriter::create(path, &header, &scene)?;
            unplayed.0 = Some(path.clone());
            Some(aside(&mut sinks, "ca take", writer, room, busy)?)
        }
        None => None,
    };

    let mut desk = match page {
        Some(page) => {
            let header = (take.is_none() && names.is_empty()).then(header);
            let opening = Opening { name: &loaded.name, scene: &scene, options: &options, header };
            Some(page.open(opening, &mut sinks)?)
        }
        None => None,
    };

    let looks = take.is_some() || desk.is_some();
    let pictures = if looks { PICTURES } else { 0 };
    let (mut ends, gateway_ends, recorder_ends) = rings(&scene, names.len(), pictures);
    let mut recorder = Recorder::new(recorder_ends, shared.clone(), scene.clone(), &engine.ports, sinks);
    for text in softened {
        recorder.say(true, text);
    }
    let (mut sound, outlet) = audio::Switch::open(args, &scene, &mut recorder, page.is_some(), rt_request(args, -5))?;
    ends.audio = outlet;
    let events = sound.events();
    let mut inputs = Inputs::open(args, &scene, page.is_some(), events)?;
    inputs.said().into_iter().for_each(|text| recorder.say(false, text));
    if args.gesture {
        recorder.gesture(true).map_err(|why| Failure::Failed(why.to_string()))?;
    }
    let mut talk = talk::Talk::open(&setups, unknown, &scene, gateway_ends, rt_request(args, -5), page.is_some())?;
    if args.arm {
        recorder.order(None, Order::Arm).map_err(|why| Failure::Failed(why.to_string()))?;
    }

    let clock = match args.clock {
        // the clock of the sound device, if there is one
        ClockKind::Monotonic => Clock::Audio,
        ClockKind::Device => Clock::Device { patience: PATIENCE },
    };
    let frame_rate = scene.rate / f64::from(scene.rates.ratio);
    let each = |a_second: f64, wanted: bool| if wanted { (frame_rate / a_second).max(1.0) as u64 } else { 0 };
    let every = RecordIntervals {
        energy: each(100.0, args.energy),
        view: each(f64::from(PICTURES), looks),
        // of a large state it would take longer than a frame has
        hash: each(1.0, looks && scene.counts.n_mat <= HASHED),
    };
    let frames = args.seconds.map(|s| (s * frame_rate).round().max(1.0) as u64);
    let live = Live::new(engine, ends, shared.clone(), clock, every);
    sound.start()?;
    match recorder.heard() {
        Some((device, ms)) => recorder.say(false, format!("sound: {device}, {ms:.1} ms after the model")),
        None if page.is_some() && scene.counts.channels > 0 => {
            recorder.say(false, "sound: by the page, which says how late".into());
        }
        None => {}
    }
    if let Some((desk, host)) = desk.as_mut().zip(sound.host()) {
        desk.sounds_by(host);
    }
    let (thread, granted) = engine_thread(live, rt_request(args, 0), frames)?;
    unplayed.0 = None;
    let _announced = desk.as_ref().zip(page).map(|(desk, page)| page.announce(&desk.address()));
    let mut threads = vec![("engine".to_string(), granted)];
    threads.extend(talk.granted().map(|g| ("gateway".to_string(), g)));
    threads.extend(wav.as_ref().map(|w| ("sound file".to_string(), w.granted().to_string())));
    threads.extend(take.as_ref().map(|t| ("take".to_string(), t.granted().to_string())));
    if !args.quiet {
        for (name, granted) in &threads {
            term::note(&format!("{name}: {granted}"));
        }
        for s in played.iter().filter(|s| !s.profile.is_unknown()) {
            term::note(&format!("device `{}`: {}, at most {} N", s.device, s.profile.title, s.profile.force));
        }
    }

    let engine = attend(thread, &mut recorder, &mut talk, &mut inputs, desk.as_mut(), &mut sound, &shared);
    // what it keeps is finished once all has come
    let keep = desk.map(Desk::close);
    sound.end(scene.rate);
    let traffic = talk.end();
    let engine = engine.map_err(|_| Failure::Failed("the engine thread ended by itself".into()))?;
    recorder.poll();
    if let Some(words) = words {
        words.leave(TERMINAL);
    }
    let mut summary = recorder.summary(&engine, threads);
    drop(keep);
    // of the take: what the rings had no room for, and what waited for it too long
    let on_its_way = take.as_ref().map_or([0; 3], AsyncSink::lost);
    let lost = std::array::from_fn(|k| shared.lost()[k] + on_its_way[k]);
    let mut broken = |e: FileError| {
        term::error(&e.to_string());
        summary.broken.push(e.to_string());
    };
    let written = wav.map(|w| w.end().and_then(|w| w.map(wav::Wav::finish).transpose()));
    let written = written.and_then(|w| w.map_err(&mut broken).ok().flatten());
    let finished = take.map(|t| t.end().and_then(|t| t.map(|t| t.finish(lost)).transpose()));
    let finished = finished.and_then(|t| t.map_err(&mut broken).ok().flatten());
    if let Some(lost) = finished.as_ref().map(|t| t.lost).filter(|n| *n > 0) {
        term::warning(&format!("the take has holes: {lost} records or samples found no room"));
    }
    let files = summary::Files {
        sound: args.output.as_deref().zip(written.as_ref()),
        take: args.log.as_deref().zip(finished.as_ref()),
    };
    if args.json {
        println!("{:#}", summary::value(&summary, &loaded.name, &files, traffic));
    } else if !args.quiet {
        summary::text(&summary, &loaded.name, &files, traffic, scene.rate)?;
    }
    Ok(if summary.is_faithful() { Ended::Well } else { Ended::Degraded })
}

/// Refuses outputs that would be written over each other, or over what is read.
fn written(args: &ServeArgs) -> Result<(), Failure> {
    let file = |given: &'_ String| PathBuf::from(given.split_once('=').map_or(given.as_str(), |(_, file)| file));
    let [profiles, calibrations] = [&args.profile, &args.calibration].map(|l| l.iter().map(file).collect::<Vec<_>>());
    let mut inputs = vec![("the model", Path::new(&args.source.model))];
    inputs.extend(profiles.iter().map(|p| ("a profile", &**p)));
    inputs.extend(calibrations.iter().map(|p| ("a calibration", &**p)));
    inputs.extend(args.midi.iter().chain(&args.osc_token).map(|p| ("an input", &**p)));
    let sound = args.output.iter().map(|p| ("-o", &**p));
    outputs::apart(&sound.chain(args.log.iter().map(|p| ("--log", &**p))).collect::<Vec<_>>(), &inputs)
}

/// Ctrl-C and SIGTERM end the session; once more, half a second later, the process, should something stand still. A handler
/// can be set once in a process; where that fails, they end it as they would anyway.
fn listen(shared: &Arc<Shared>) {
    let (stop, mut first) = (shared.clone(), None);
    let _ = ctrlc::set_handler(move || {
        stop.stop.store(true, Relaxed);
        if first.get_or_insert_with(Instant::now).elapsed() > SURE {
            std::process::exit(130);
        }
    });
}

/// The file of a take that nothing was played into yet: where serving is refused before it begins, it goes again.
struct Unplayed(Option<PathBuf>);

impl Drop for Unplayed {
    fn drop(&mut self) {
        if let Some(path) = &self.0 {
            let _ = std::fs::remove_file(path);
        }
    }
}

/// Gives the recorder a sink that is written by a thread of its own.
fn aside<T: Sink + Send + 'static>(
    sinks: &mut Vec<Box<dyn Sink>>,
    name: &str,
    sink: T,
    room: BufferLimits,
    request: RtRequest,
) -> Result<AsyncSink<T>, Failure> {
    let (line, aside) = AsyncSink::start(name, sink, room, request)?;
    sinks.push(Box::new(line));
    Ok(aside)
}

/// What a thread asks for; `lower` than the engine.
fn rt_request(args: &ServeArgs, lower: i32) -> RtRequest {
    let priority = (args.priority > 0).then(|| (i32::from(args.priority) + lower).clamp(1, 99) as u8);
    RtRequest { priority, cpu: args.cpu.filter(|_| lower == 0), lock: !args.no_lock && lower == 0, nice: None }
}

/// Starts the engine on its thread; what the system granted is known before the first frame.
fn engine_thread(live: Live, request: RtRequest, frames: Option<u64>) -> Result<(JoinHandle<Engine>, String), Failure> {
    let (tell, reported) = std::sync::mpsc::channel();
    let thread = std::thread::Builder::new()
        .name("ca engine".into())
        .spawn(move || {
            let _ = tell.send(rt::ask(request).to_string());
            live.run(frames)
        })
        .map_err(|e| Failure::Failed(format!("no thread for the engine: {e}")))?;
    Ok((thread, reported.recv().unwrap_or_default()))
}

/// The recorder, until the engine ends or somebody stops it.
fn attend(
    thread: JoinHandle<Engine>,
    recorder: &mut Recorder,
    talk: &mut talk::Talk,
    inputs: &mut Inputs,
    mut desk: Option<&mut Box<dyn Desk>>,
    sound: &mut audio::Switch,
    shared: &Arc<Shared>,
) -> std::thread::Result<Engine> {
    let mut turns = 0_u64;
    while !thread.is_finished() {
        let desk_of = desk.as_deref_mut().map(|d| &mut **d as &mut dyn Desk);
        sound.turn(recorder, inputs, desk_of);
        recorder.poll();
        let sweep = turns.is_multiple_of(SWEEP);
        let asked = match &mut desk {
            Some(desk) => talk.turn(recorder, sweep, Some(&mut |name, value| desk.change(name, value))),
            None => talk.turn(recorder, sweep, None),
        };
        // what asks without end has to wait; whoever disarms has not
        let end = Instant::now() + TURN;
        inputs.turn(recorder, end);
        let end = Instant::now() + TURN;
        let page = desk.as_mut().is_some_and(|d| d.turn(recorder, inputs, talk.setups(), (shared, end)));
        if asked || page {
            shared.stop.store(true, Relaxed);
        }
        turns += 1;
        std::thread::sleep(TURN);
    }
    thread.join()
}

/// What people should know, on the terminal; on a thread of its own, since a terminal may stand still for as long as
/// somebody likes.
struct Words {
    quiet: bool,
}

impl Sink for Words {
    fn streams(&self) -> SinkStreams {
        SinkStreams::WORDS
    }

    fn said(&mut self, h: &Notice) -> Result<(), FileError> {
        if h.bad {
            term::warning(&h.text);
        } else if !self.quiet {
            term::note(&h.text);
        }
        Ok(())
    }
}
