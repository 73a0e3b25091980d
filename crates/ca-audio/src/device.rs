//! Sound directly to a sound device of the system.
//!
//! A device must play the scene as it is, or it is refused; nothing is resampled here. The callback only takes samples
//! from a ring and reads the clock. The recorder reports errors of the device.

use super::{OpenOutput, Output as Any};
use crate::AudioError;
use ca_core::Scene;
use ca_haptic::rt::now_ns;
use ca_haptic::serve::audio::{DeviceClock, PlaybackDevice, Watch, link};
use ca_model::suggest::ticked;
use cpal::traits::{DeviceTrait as _, HostTrait as _, StreamTrait as _};
use cpal::{
    BufferSize, Device, ErrorKind, HostId, SampleFormat, StreamConfig, SupportedBufferSize, SupportedStreamConfigRange,
};
use std::sync::atomic::Ordering::Relaxed;
use std::sync::mpsc::channel;

/// Default number of frames per call, for a device that leaves the choice.
const BUFFER: u32 = 256;

pub(super) fn open(
    wanted: &str,
    buffer: Option<u32>,
    scene: &Scene,
) -> Result<(OpenOutput, DeviceClock, Watch), AudioError> {
    let (host, device) = find(wanted)?;
    let name = device.to_string();
    let (config, buffer) = fit(&device, scene, buffer)?;
    let wide = config.channels as usize;
    let who = PlaybackDevice {
        host: host.name().into(),
        device: name.clone(),
        rate: config.sample_rate,
        channels: config.channels,
    };
    let (follow, mut player, watch) = link(scene.counts.channels, scene.rates.ratio, who, buffer);
    let (tell, words) = channel();
    let (counts, called, xruns) = (watch.counts.clone(), watch.counts.clone(), watch.counts.clone());
    let failed = |e: cpal::Error| AudioError::Failed(format!("cannot play on `{name}`: {e}"));
    let stream = device
        .build_output_stream::<f32, _, _>(
            config,
            move |out, info| {
                let at = now_ns();
                let t = info.timestamp();
                let delay = t.playback.checked_duration_since(t.callback).unwrap_or_default();
                called.delay.store(delay.as_nanos() as u64, Relaxed);
                player.fill(out, wide, at);
            },
            move |e| {
                if e.kind() == ErrorKind::Xrun {
                    xruns.xruns.fetch_add(1, Relaxed);
                } else {
                    let _ = tell.send(e.to_string());
                }
            },
            None,
        )
        .map_err(failed)?;
    let output = Any::Device(Output { stream });
    Ok((OpenOutput { output, counts, words, name, host: host.name(), events: None }, follow, watch))
}

pub(super) struct Output {
    stream: cpal::Stream,
}

impl Output {
    pub(super) fn start(&self) -> Result<(), cpal::Error> {
        self.stream.play()
    }
}

/// Finds a host by name, or a device by name or id; the default device of the default host for an empty name.
fn find(wanted: &str) -> Result<(HostId, Device), AudioError> {
    if wanted.is_empty() {
        let host = cpal::default_host();
        let none = || AudioError::Failed(format!("no default sound device; {}", there_is()));
        let device = host.default_output_device().filter(cpal::traits::DeviceTrait::supports_output);
        return Ok((host.id(), device.ok_or_else(none)?));
    }
    if let Ok(id) = wanted.parse::<HostId>() {
        let host = cpal::host_from_id(id).map_err(|e| AudioError::Failed(e.to_string()))?;
        let none =
            || AudioError::Failed("this sound system does not have an output device; choose another output".into());
        return Ok((id, host.default_output_device().ok_or_else(none)?));
    }
    let is = |d: &Device| {
        let id = d.id().ok();
        d.to_string() == wanted || id.is_some_and(|i| i.id() == wanted || i.to_string() == wanted)
    };
    let none = || AudioError::Failed(format!("no sound device `{wanted}`; {}", there_is()));
    all().into_iter().find(|(_, d)| is(d)).ok_or_else(none)
}

fn all() -> Vec<(HostId, Device)> {
    let hosts = cpal::available_hosts().into_iter().filter_map(|id| Some((id, cpal::host_from_id(id).ok()?)));
    hosts.flat_map(|(id, host)| host.output_devices().into_iter().flatten().map(move |d| (id, d))).collect()
}

pub(super) fn names() -> Vec<String> {
    all().iter().filter_map(|(_, d)| Some(d.id().ok()?.to_string())).collect()
}

fn there_is() -> String {
    let mut names = names();
    if super::jack::is_there() {
        names.push("jack".into());
    }
    if super::pulse::is_there() {
        names.push("pulse".into());
    }
    if names.is_empty() {
        return "start a JACK or PulseAudio server and use `--audio jack` or `--audio pulse`".into();
    }
    format!("available: {}", ticked(names.iter().map(String::as_str)))
}

/// Returns the configuration in which a device plays a scene as it is, and the frames per call.
fn fit(device: &Device, scene: &Scene, buffer: Option<u32>) -> Result<(StreamConfig, u32), AudioError> {
    let refused = |why: String| AudioError::Failed(format!("`{device}` {why}"));
    let configs: Vec<_> = device
        .supported_output_configs()
        .map_err(|e| refused(format!("does not report its sample formats: {e}")))?
        .filter(|c| c.sample_format() == SampleFormat::F32)
        .collect();
    let Some(most) = configs.iter().map(SupportedStreamConfigRange::channels).max() else {
        let why = "does not accept 32-bit float samples; choose a device that converts them, e.g. ALSA's `default`";
        return Err(refused(why.into()));
    };
    if scene.counts.channels > most as usize {
        let why =
            format!("has {most} channels, but the model has {} outputs; combine some of them", scene.counts.channels);
        return Err(refused(why));
    }
    let wide = configs.iter().filter(|c| c.channels() as usize >= scene.counts.channels);
    let plays = |lo: u32, hi: u32| (f64::from(lo)..=f64::from(hi)).contains(&scene.rate) && scene.rate.fract() == 0.0;
    let at_rate = wide.clone().filter(|c| plays(c.min_sample_rate(), c.max_sample_rate()));
    // one channel goes to both sides
    let wanted = if scene.counts.channels == 1 { 2 } else { scene.counts.channels };
    let near = |c: &&SupportedStreamConfigRange| (c.channels() as usize).abs_diff(wanted);
    let Some(config) = at_rate.min_by_key(near) else {
        let mut rates: Vec<_> = wide.map(|c| (c.min_sample_rate(), c.max_sample_rate())).collect();
        rates.sort_unstable();
        rates.dedup();
        let said = |(lo, hi): &(u32, u32)| if lo == hi { format!("{lo}") } else { format!("{lo} to {hi}") };
        let all: Vec<String> = rates.iter().map(said).collect();
        let one = rates.first().map_or(48_000, |r| r.1);
        let why = format!("plays at {} Hz, not at {} Hz; use `--rate {one}Hz`", all.join(", "), scene.rate);
        return Err(refused(why));
    };
    let (min, max) = match *config.buffer_size() {
        SupportedBufferSize::Range { min, max } => (min.max(1), max.max(1)),
        SupportedBufferSize::Unknown => (1, u32::MAX),
    };
    let frames = match buffer {
        Some(n) if (min..=max).contains(&n) => n,
        Some(n) if min == max => {
            let why = format!("uses buffers of {min} frames, not {n}; its server sets the size (`jackd -p {n}`)");
            return Err(refused(why));
        }
        Some(n) => return Err(refused(format!("accepts buffers of {min} to {max} frames, not {n}"))),
        None => BUFFER.clamp(min, max.max(min)),
    };
    let (channels, sample_rate) = (config.channels(), scene.rate as u32);
    Ok((StreamConfig { channels, sample_rate, buffer_size: BufferSize::Fixed(frames) }, frames))
}
