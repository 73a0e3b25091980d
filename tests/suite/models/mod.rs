//! The instruments in `models/`: each reads, compiles with only the warnings its header explains, plays its own gesture
//! at a good level, and sounds as its header says, by spectrum and envelope.

mod bars;
mod bowed;
mod closed_forms;
mod keys;
mod mallet;
mod piano;
mod plates;
mod played;
mod presets;
mod proven;
mod rendering;
mod renders;
mod space;
mod strings;
mod velocities;

use bars::{iron_bar, kalimba, marimba};
use bowed::{bowed_plate, bowed_string, glass, physical_lfo};
use keys::{piano_key, piano_wire, piano24};
use piano::hammer_piano;
use plates::{gong, membrane, plate, snare, tam_tam};
use played::{rain_stick, wind};
use rendering::{file_names, load};
use space::{chimes, crystal, jack, maracas, rattle, rattle_stick, tossed_grains};
use std::collections::BTreeSet;
use strings::{
    hammered_string, harmonic_chain, hoop, natural_harmonic, pinched_string, plucked_string, prepared_string,
    slide_guitar, wave_guitar,
};

/// Makes one test per model, and the list of the models.
macro_rules! models {
    ($($name:ident),* $(,)?) => {
        const CHECKED: &[&str] = &[$(stringify!($name)),*];
        mod each {
            $(#[test] fn $name() { super::$name(); })*
        }
    };
}

models!(
    bowed_plate,
    bowed_string,
    chimes,
    crystal,
    glass,
    gong,
    hammer_piano,
    hammered_string,
    harmonic_chain,
    hoop,
    iron_bar,
    jack,
    kalimba,
    maracas,
    marimba,
    membrane,
    natural_harmonic,
    physical_lfo,
    piano24,
    piano_key,
    piano_wire,
    pinched_string,
    plate,
    plucked_string,
    prepared_string,
    rain_stick,
    rattle,
    rattle_stick,
    slide_guitar,
    snare,
    tam_tam,
    tossed_grains,
    wave_guitar,
    wind,
);

#[test]
fn every_model_is_checked_and_every_kind_is_played() {
    assert_eq!(file_names(), CHECKED, "a model without a check, or a check without a model");
    let used: BTreeSet<String> = file_names().iter().flat_map(|n| load(n).items.into_iter().map(|i| i.kind)).collect();
    let core: BTreeSet<String> = ca_model::catalog().iter().map(|k| k.code.to_string()).collect();
    let unplayed: Vec<&String> = core.difference(&used).collect();
    assert!(unplayed.is_empty(), "kinds no model plays: {unplayed:?}");
    let titles: BTreeSet<String> = file_names().iter().map(|n| load(n).title().to_string()).collect();
    assert_eq!(titles.len(), file_names().len(), "two models share a title");
}
