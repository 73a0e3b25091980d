//! Builds a self-contained page with the moving picture of a played scene or a replayed take.
//!
//! The page needs no server. It holds only the picture and its synchronised sound; `ca report` shows the same picture
//! together with plots and tables.
#![forbid(unsafe_code)]

use ca_core::{Catalog, Scene};
use ca_haptic::engine::{Engine, continuing_masses};
use ca_haptic::take::{Replay, ReplayVerdict, Take};
use ca_io::FileError;
use ca_io::gesture::Gesture;
use ca_io::perform::Performance;
use ca_lab::Failure;
use ca_lab::play;
use ca_play::bundle;
use ca_report::{Block, Picture, Report, Section, Sound};
use ca_view::Film;
use std::sync::Arc;

/// Lower limit of the rate at which positions are sampled for the picture \[Hz\].
const PICTURES: f64 = 60.0;
/// Upper limit of sound samples between two such positions.
const BLOCK: u64 = 1024;

/// Converts a film to the picture of a page. Returns `None` for an empty film.
///
/// # Errors
/// Returns [`Failure::Failed`] if there is not enough memory to compress the film.
pub fn picture(film: &Film) -> Result<Option<Picture>, Failure> {
    if film.frames() == 0 {
        return Ok(None);
    }
    let (about, bytes) = film.json().map_err(|e| Failure::Failed(format!("cannot compress the picture: {e}")))?;
    let masses = &about["drawing"]["decimated"];
    let fewer = masses.is_object().then(|| format!("{} of {} masses", masses["shown"], masses["of"]));
    let slower = (film.rate() < 59.0).then(|| format!("{:.0} pictures per second", film.rate()));
    let told: Vec<String> = fewer.into_iter().chain(slower).collect();
    let told =
        if told.is_empty() { String::new() } else { format!("Reduced to keep the page small: {}.", told.join(", ")) };
    Ok(Some(Picture { about, bytes, script: bundle("picture/film.js"), note: told }))
}

/// Film of a take. If the model changes during the take, the film shows only the masses of the first version.
pub struct TakeFilm {
    /// The film.
    pub film: Film,
    first: Arc<Scene>,
    /// Version of the model that plays now, and its masses that also exist in the first version: index there, index
    /// now.
    now: Arc<Scene>,
    places: Vec<[u32; 2]>,
    /// Displacements of the masses of the first version \[m\].
    x: Vec<f64>,
}

impl TakeFilm {
    /// Creates a film of `seconds` for a take that starts with `scene`.
    pub fn new(scene: &Arc<Scene>, seconds: f64) -> TakeFilm {
        let film = Film::new(scene, seconds);
        TakeFilm { film, first: scene.clone(), now: scene.clone(), places: Vec::new(), x: Vec::new() }
    }

    /// Records the state of the engine at the end of a gesture frame. Returns true while the first version of the model
    /// plays.
    pub fn look(&mut self, engine: &Engine) -> bool {
        let first = Arc::ptr_eq(&engine.scene, &self.first);
        if first {
            self.x.clear();
            self.x.extend_from_slice(&engine.state.x);
        } else {
            if !Arc::ptr_eq(&engine.scene, &self.now) {
                self.now = engine.scene.clone();
                self.places = continuing_masses(&self.first, &self.now);
            }
            for [to, from] in &self.places {
                self.x[*to as usize] = engine.state.x[*from as usize];
            }
        }
        self.film.look(engine.state.tick as f64 * engine.scene.rates.sample_dt, &self.x);
        first
    }
}

/// Plays a scene and returns its page. `None` for `seconds` plays until the scene and its gesture end.
///
/// # Errors
/// Fails if the gesture drives nothing. Returns [`Failure::Stopped`] if `goes_on` (samples done, total samples) returns
/// false.
pub fn scene(
    scene: &Scene,
    gesture: Option<&Gesture>,
    seconds: Option<f64>,
    goes_on: &mut dyn FnMut(u64, u64) -> bool,
) -> Result<String, Failure> {
    let performance = Performance::new(scene, gesture)?;
    let length = play::Length::of(&performance, seconds);
    let (seconds, frames) = (play::seconds(&performance, seconds), length.frames);
    let (mut film, mut sound) = (Film::new(scene, seconds), Sound::new(scene.rate, &scene.names.channel_names));
    let block = ((scene.rate / PICTURES).max(1.0) as u64).min(BLOCK);
    let played = play::play(performance, length, block, &mut |p, rows, done| {
        for row in rows.chunks_exact(scene.counts.n_out.max(1)) {
            sound.push(&row[..scene.counts.channels]);
        }
        film.look(p.state.tick as f64 * scene.rates.sample_dt, &p.state.x);
        if goes_on(done, frames) { Ok(()) } else { Err(Failure::Stopped) }
    })?;
    let seconds = play::lasted(scene, &played, frames, seconds);
    page(&scene.about.title, &format!("{seconds} s, played by ca {}", env!("CARGO_PKG_VERSION")), &film, sound)
}

/// Replays a take and returns its page.
///
/// # Errors
/// Fails if the take cannot be replayed or the replay differs from the record.
pub fn take(take: &Take, catalog: &Catalog) -> Result<String, Failure> {
    let mut replay = Replay::new(take, catalog)?;
    let seconds = take.summary()?.seconds;
    let mut film = TakeFilm::new(&replay.engine.scene, seconds);
    let mut sound = Sound::new(take.header.rate, &take.header.channels);
    let verdict = replay.run(
        take,
        &mut |engine| {
            film.look(engine);
        },
        &mut |frame| {
            sound.push(frame);
            Ok(())
        },
    )?;
    judged(&verdict)?;
    page(&take.header.title, &format!("a take, {seconds:.3} s"), &film.film, sound)
}

/// Turns a failed replay into an error.
///
/// # Errors
/// Fails if the replay differs from the record, or if it stops early because records are missing.
pub fn judged(verdict: &ReplayVerdict) -> Result<(), FileError> {
    match (&verdict.difference, verdict.hole) {
        (Some(d), _) => Err(FileError::content(format!("the replay differs from the take: {d}"))),
        (None, Some(t)) => {
            let why = format!("the take cannot be replayed beyond {t:.3} s: records are missing there");
            Err(FileError::content(why))
        }
        (None, None) => Ok(()),
    }
}

fn page(title: &str, subtitle: &str, film: &Film, sound: Sound) -> Result<String, Failure> {
    let mut page = Report::new(title, subtitle);
    page.picture = picture(film)?;
    if !sound.names().is_empty() {
        page.sections.push(Section::new("Sound", vec![Block::Sound(sound)]));
    }
    Ok(page.html())
}
