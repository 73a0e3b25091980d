//! A device process that sends arbitrary frames at its own pace: frames with one or more errors, and periods of valid
//! frames so that forces come on in between.

use super::helper_process::{HelperProcess, Job};
use super::iceoryx_client::RawSite;
use ca_haptic::frame::{DOF, DeviceFrame, status};
use ca_haptic::host::Site;
use ca_haptic::rt::now_ns;
use std::io::Write as _;
use std::time::Duration;

/// Frames per byte of its record.
const EACH: u64 = 1000;
/// Frames per period.
const SPELL: u64 = 15_000;

pub struct RandomDevice(HelperProcess);

impl RandomDevice {
    /// Sends `all` frames as `device`, with periods of arbitrary frames, and then valid frames until it ends.
    pub fn of(site: &Site, device: &str, all: u64) -> RandomDevice {
        RandomDevice(HelperProcess::start(site, "random_device::anything", device, all))
    }

    pub fn sent(&self) -> u64 {
        self.0.written() as u64 * EACH
    }

    pub fn is_running(&mut self) -> bool {
        self.0.is_running()
    }

    pub fn end(self) {
        self.0.end();
    }
}

/// xorshift
fn rng(seed: &mut u64) -> u64 {
    *seed ^= *seed << 13;
    *seed ^= *seed >> 7;
    *seed ^= *seed << 17;
    *seed
}

/// Changes a frame in up to three ways.
fn spoiled(good: &DeviceFrame, seed: &mut u64) -> DeviceFrame {
    let mut f = *good;
    for _ in 0..rng(seed) % 4 {
        let (what, with) = (rng(seed) % 16, rng(seed));
        let any = f64::from_bits(with);
        match what {
            0 => f.magic ^= with as u32,
            1 => f.layout ^= with,
            2 => f.device[0] ^= with as u8,
            3 => f.session = with % 4,
            4 => f.seq = with,
            5 => f.seq = f.seq.saturating_sub(with % 100),
            6 => f.ack = with,
            7 => f.n = with as u16,
            8 => f.pos = [any; DOF],
            9 => f.pos[0] = [f64::NAN, f64::INFINITY, f64::MAX, -1e9, 0.05, -0.0][with as usize % 6],
            10 => f.vel = [any; DOF],
            11 => f.status = with as u32,
            12 => f.cause = with as u16,
            13 => f.t_device_ns = with,
            14 => f.period_ns = with as u32,
            _ => f.pos[0] += 1e-4 * (any.to_bits() as i8 as f64),
        }
    }
    f
}

#[test]
#[ignore = "a part of other tests"]
fn anything() {
    let Some(job) = Job::asked() else { return };
    let (place, name) = (RawSite::new(&job.site), job.device.as_str());
    let line = place.writer::<DeviceFrame>(name, "in", 0);
    let (mut good, mut seed) = (DeviceFrame::new(name, 1), 0x9e37_79b9_7f4a_7c15_u64);
    (good.session, good.period_ns) = (1, 333_333);
    good.status |= status::SIMULATED;
    let mut record = job.ready();
    for n in 1.. {
        if job.is_over() {
            return;
        }
        good.seq += 1;
        (good.t_host_ns, good.t_device_ns) = (now_ns(), n * 100_000);
        let calm = n > job.more || (n / SPELL) % 2 == 1;
        let frame = if calm { good } else { spoiled(&good, &mut seed) };
        line.send_copy(frame).unwrap();
        if n % EACH == 0 {
            record.write_all(&[0]).unwrap();
        }
        // the queue holds four frames; the gateway polls every 50 us
        if n % 2 == 0 {
            std::thread::sleep(Duration::from_micros(60));
        }
    }
}
