//! The moving instrument on a page by itself, without a server: of a scene that is played, or of a take that is played again.
//!
//! Decides that a page has the picture and the sound it is in step with, no more: `ca report` has the rest around the same picture.
#![forbid(unsafe_code)]

use ca_core::{Catalog, Scene};
use ca_haptic::engine::{Engine, carried};
use ca_haptic::take::{Replay, ReplayVerdict, Take};
use ca_io::FileError;
use ca_io::gesture::Gesture;
use ca_io::perform::Performance;
use ca_lab::Failure;
use ca_lab::play;
use ca_play::film_script;
use ca_report::{Block, Picture, Report, Section, Sound};
use ca_view::Film;
use std::sync::Arc;

/// Looks a second, at least.
const PICTURES: f64 = 60.0;
/// Samples between two looks, at most.
const BLOCK: u64 = 1024;

/// What a page is told of a film; none where nothing is drawn.
///
/// # Errors
/// Where there is no memory to make it small.
pub fn picture(film: &Film) -> Result<Option<Picture>, Failure> {
    if film.frames() == 0 {
        return Ok(None);
    }
    let (about, bytes) = film.json().map_err(|e| Failure::Failed(format!("the picture: {e}")))?;
    let masses = &about["drawing"]["decimated"];
    let fewer = masses.is_object().then(|| format!("{} of {} masses", masses["shown"], masses["of"]));
    let slower = (film.rate() < 59.0).then(|| format!("{:.0} pictures a second", film.rate()));
    let told: Vec<String> = fewer.into_iter().chain(slower).collect();
    let told =
        if told.is_empty() { String::new() } else { format!("So that the page stays small: {}.", told.join(", ")) };
    Ok(Some(Picture { about, bytes, script: film_script(), told }))
}

/// The film of a take. Where its model changed in the middle, of the masses that were there from the start.
pub struct TakeFilm {
    /// the film
    pub film: Film,
    first: Arc<Scene>,
    /// the version that plays, and where the masses of the first are in it: places there, and here
    now: Arc<Scene>,
    places: Vec<[u32; 2]>,
    /// displacements of the first version \[m\]
    x: Vec<f64>,
}

impl TakeFilm {
    /// For so many seconds of a take that begins with `scene`.
    pub fn new(scene: &Arc<Scene>, seconds: f64) -> TakeFilm {
        let film = Film::new(scene, seconds);
        TakeFilm { film, first: scene.clone(), now: scene.clone(), places: Vec::new(), x: Vec::new() }
    }

    /// The engine at the end of a gesture frame. Whether the first version plays.
    pub fn look(&mut self, engine: &Engine) -> bool {
        let first = Arc::ptr_eq(&engine.scene, &self.first);
        if first {
            self.x.clear();
            self.x.extend_from_slice(&engine.state.x);
        } else {
            if !Arc::ptr_eq(&engine.scene, &self.now) {
                self.now = engine.scene.clone();
                self.places = carried(&self.first, &self.now);
            }
            for [to, from] in &self.places {
                self.x[*to as usize] = engine.state.x[*from as usize];
            }
        }
        self.film.look(engine.state.tick as f64 * engine.scene.rates.sample_dt, &self.x);
        first
    }
}

/// The page of a scene that is played for so many seconds, or as long as it lasts.
///
/// # Errors
/// Where a gesture drives nothing; and what `goes_on` (ticks done, and all) says by [`Failure::Stopped`], where it is false.
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

/// The page of a take, played again.
///
/// # Errors
/// Where it cannot be played again, or is not as it was.
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

/// Why a replay is none.
///
/// # Errors
/// Where it is not as it was, or ends early for want of records.
pub fn judged(verdict: &ReplayVerdict) -> Result<(), FileError> {
    match (&verdict.difference, verdict.hole) {
        (Some(d), _) => Err(FileError::content(format!("played again, it is not as it was: {d}"))),
        (None, Some(t)) => {
            let why = format!("it cannot be played again from {t:.3} s on: records are missing there");
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
