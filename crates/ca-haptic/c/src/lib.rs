//! C interface for device processes: open, send, force, wait, close.
//!
//! A handle is a number, not a pointer, so that one that was closed twice, never opened or belongs to another thread is
//! only an error. A device belongs to the thread that opened it. Functions return a negative number on failure
//! (`ca_device_open` returns 0), and [`ca_device_error`] returns the message. A null pointer is an error where a value
//! is needed; other pointers must point to a whole structure. No panic crosses into C.
#![allow(unsafe_code)]

use ca_haptic::frame::{About, DOF, DeviceFrame, ForceFrame};
use ca_haptic::host::{DeviceClient, Site};
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::ffi::{CStr, CString, c_char};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};
use std::time::Duration;

thread_local! {
    static OPEN: RefCell<BTreeMap<u64, DeviceClient>> = const { RefCell::new(BTreeMap::new()) };
    static ERROR: RefCell<CString> = RefCell::new(CString::default());
}

/// Number of handles given out by all threads; none is used twice.
static HANDLES: AtomicU64 = AtomicU64::new(0);

/// Runs `work`; on failure stores its message and returns `otherwise`.
fn guarded<T>(otherwise: T, work: impl FnOnce() -> Result<T, String>) -> T {
    let what = match catch_unwind(AssertUnwindSafe(work)) {
        Ok(Ok(value)) => return value,
        Ok(Err(what)) => what,
        Err(_) => "a fault inside ca_device; please report it".to_owned(),
    };
    let what = CString::new(what.replace('\0', " ")).unwrap_or_default();
    // fails only in a thread that is ending
    let _ = ERROR.try_with(|e| e.replace(what));
    otherwise
}

fn with<T>(device: u64, work: impl FnOnce(&mut DeviceClient) -> Result<T, String>) -> Result<T, String> {
    OPEN.try_with(|open| {
        let mut open = open.borrow_mut();
        let client = open.get_mut(&device).ok_or("this device is not open in this thread")?;
        work(client)
    })
    .map_err(|_| "this thread is ending".to_owned())?
}

/// Fills `about` for a device of this name with `n` degrees of freedom at `rate` frames a second, one force vector per
/// `axes` of them (1 for keys, 3 for a stylus). Ranges and limits are 0 for you to fill. Returns 0, or -1 on failure.
///
/// # Safety
/// `about` is null or points to a `CaAbout`; `name` is null or ends with a zero.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ca_device_about(about: *mut About, name: *const c_char, n: u16, axes: u16, rate: u32) -> i32 {
    guarded(-1, || {
        if about.is_null() || name.is_null() {
            return Err("ca_device_about: a null pointer".into());
        }
        if n == 0 || n as usize > DOF || axes == 0 || axes > 3 || !n.is_multiple_of(axes) {
            return Err(format!(
                "ca_device_about: {n} degrees of freedom in vectors of {axes}; 1 to {DOF}, of 1, 2 or 3"
            ));
        }
        // SAFETY: not null; the caller guarantees that it ends with a zero
        let name = unsafe { CStr::from_ptr(name) }.to_str().map_err(|_| "ca_device_about: the name is not UTF-8")?;
        ca_haptic::host::services::check_name(name).map_err(|e| e.to_string())?;
        let made = About { n, axes, ..About::new(name, rate, 0) };
        // SAFETY: not null; the caller guarantees that it points to a structure of this type
        unsafe { about.write(made) };
        Ok(0)
    })
}

/// Opens a device in the folder `root`, or in the user's (`CA_SHM_ROOT`, `/tmp/ca-<uid>`) if `root` is null, with or
/// without an engine running. Returns a handle, or 0 on failure.
///
/// # Safety
/// `root` is null or ends with a zero; `about` is null or points to a `CaAbout`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ca_device_open(root: *const c_char, about: *const About) -> u64 {
    guarded(0, || {
        if about.is_null() {
            return Err("ca_device_open: `about` is null".into());
        }
        // SAFETY: not null; the caller guarantees that it points to a structure of this type
        let about = unsafe { about.read() };
        let site = if root.is_null() {
            Site::of_user()
        } else {
            // SAFETY: not null; the caller guarantees that it ends with a zero
            let root = unsafe { CStr::from_ptr(root) }.to_str().map_err(|_| "ca_device_open: `root` is not UTF-8")?;
            Site::at(Path::new(root))
        };
        let site = site.map_err(|e| e.to_string())?;
        let client = DeviceClient::open(&site, about).map_err(|e| e.to_string())?;
        OPEN.try_with(|open| {
            let handle = HANDLES.fetch_add(1, Relaxed) + 1;
            open.borrow_mut().insert(handle, client);
            handle
        })
        .map_err(|_| "this thread is ending".into())
    })
}

/// Sends a frame. You set positions, velocities, status and buttons; the library fills in header, device, session,
/// number, acknowledgement and time. Returns the number of readers (0 without an engine), or -1 on failure.
///
/// # Safety
/// `frame` is null or points to a `CaDeviceFrame`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ca_device_send(device: u64, frame: *mut DeviceFrame) -> i32 {
    guarded(-1, || {
        if frame.is_null() {
            return Err("ca_device_send: `frame` is null".into());
        }
        with(device, |client| {
            // SAFETY: not null; the caller guarantees that it points to a structure of this type
            let mut sent = unsafe { frame.read() };
            let readers = client.send(&mut sent).map_err(|e| e.to_string())?;
            // SAFETY: as above
            unsafe { frame.write(sent) };
            Ok(i32::try_from(readers).unwrap_or(i32::MAX))
        })
    })
}

/// Writes the force for the motors to `force`, `CA_DOF` numbers \[N\]: zeros after the time to live of the last frame,
/// when off or at fault. `frame`, if not null, gets the newest frame, for display. Returns the reason for zero force (a
/// cause, see `CaForceFrame`), 0 if there is a force, or -1 on failure, with zero force.
///
/// # Safety
/// `force` is null or points to `CA_DOF` doubles; `frame` is null or points to a `CaForceFrame`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ca_device_force(device: u64, force: *mut f64, frame: *mut ForceFrame) -> i32 {
    guarded(-1, || {
        if force.is_null() {
            return Err("ca_device_force: `force` is null".into());
        }
        let force = force.cast::<[f64; DOF]>();
        // SAFETY: not null; the caller guarantees that it points to CA_DOF doubles
        unsafe { force.write([0.0; DOF]) };
        with(device, |client| {
            let give = client.safe_force();
            // SAFETY: as above
            unsafe { force.write(give) };
            if let (false, Some(last)) = (frame.is_null(), client.watchdog().last()) {
                // SAFETY: not null; the caller guarantees that it points to a structure of this type
                unsafe { frame.write(*last) };
            }
            // cause for the force above, not for one that came meanwhile
            Ok(i32::from(client.watchdog().cause(ca_haptic::rt::now_ns()) as u16))
        })
    })
}

/// Sleeps until a force frame comes, at most this long \[µs\]. Returns 1 if one came, 0 if not, or -1 on failure.
#[unsafe(no_mangle)]
pub extern "C" fn ca_device_wait(device: u64, timeout_us: u32) -> i32 {
    guarded(-1, || with(device, |client| Ok(i32::from(client.wait(Duration::from_micros(u64::from(timeout_us)))))))
}

/// Closes a device. Returns 0, or -1 if it is not open in this thread.
#[unsafe(no_mangle)]
pub extern "C" fn ca_device_close(device: u64) -> i32 {
    guarded(-1, || {
        let client =
            OPEN.try_with(|open| open.borrow_mut().remove(&device)).map_err(|_| "this thread is ending".to_owned())?;
        client.map(|_| 0).ok_or_else(|| "this device is not open in this thread".into())
    })
}

/// Returns the message of the last failure in this thread; it is valid until the next one.
#[unsafe(no_mangle)]
pub extern "C" fn ca_device_error() -> *const c_char {
    ERROR.try_with(|e| e.borrow().as_ptr()).unwrap_or(c"this thread is ending".as_ptr())
}
