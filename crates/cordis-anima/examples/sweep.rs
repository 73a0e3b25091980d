//! Varies one parameter on all cores: the loudness of a string against the stiffness of the hammer. Each value has a
//! scene, compiled from the same model; threads could also share one scene.

use cordis_anima::{Error, Loaded, Options, render};
use std::thread;

const STRING: &str = r#"
[STRING]
low = { n = 20, f = "110 Hz", t60 = "2 s", m = "1 g" }
[MAS]
hammer = { m = "5 g", x = "-1 mm", v = "1 m/s" }
[BUT]
strike = { between = ["hammer", "low[3]"], k = "1 kN/m", z = "0.2 N s/m" }
[SOX]
out = { from = "low[1]", gain = 100 }
"#;

/// Returns the root mean square of half a second, with a hammer of this stiffness \[N/m\].
fn loudness(k: f64) -> Result<f64, Error> {
    let mut loaded = Loaded::read(STRING, "string.ca.toml");
    loaded.model.put("strike.k", k.into());
    let scene = loaded.compile(&Options::default())?.scene;
    let sound = render(&scene, Some(0.5))?.sound;
    Ok((sound.iter().map(|x| x * x).sum::<f64>() / sound.len() as f64).sqrt())
}

/// Returns the loudness at each stiffness.
fn sweep(all: &[f64]) -> Result<Vec<f64>, Error> {
    let cores = thread::available_parallelism().map_or(1, usize::from);
    thread::scope(|s| {
        let share = all.len().div_ceil(cores).max(1);
        let parts: Vec<_> =
            all.chunks(share).map(|part| s.spawn(|| part.iter().map(|k| loudness(*k)).collect())).collect();
        let done: Vec<Result<Vec<f64>, Error>> = parts.into_iter().map(|p| p.join().expect("no panic")).collect();
        done.into_iter().collect::<Result<Vec<_>, _>>().map(|parts| parts.concat())
    })
}

fn main() -> Result<(), Error> {
    let stiffness: Vec<f64> = (0..8).map(|i| 1e3 * 2f64.powi(i)).collect();
    for (k, rms) in stiffness.iter().zip(sweep(&stiffness)?) {
        println!("{k:>8} N/m  {rms:.4}");
    }
    Ok(())
}

#[test]
fn threads_change_no_bit() {
    let stiffness = [1e3, 4e3, 16e3, 64e3];
    let alone: Vec<f64> = stiffness.iter().map(|k| loudness(*k).expect("it compiles")).collect();
    let found = sweep(&stiffness).expect("they compile");
    assert_eq!(found, alone);
    assert!(found.iter().all(|rms| *rms > 1e-3) && found[0] != found[3], "{found:?}");
    assert!(matches!(loudness(-1.0), Err(Error::Model(_))));
}
