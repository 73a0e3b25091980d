//! Wrong calls from C: null pointers, bad names, handles that are closed or belong to another thread.
#![allow(unsafe_code)]

use ca_device::{
    ca_device_about, ca_device_close, ca_device_error, ca_device_force, ca_device_open, ca_device_send, ca_device_wait,
};
use ca_haptic::frame::{About, Cause, DOF, DeviceFrame, ForceFrame, VERSION};
use ca_haptic::host::Site;
use std::ffi::{CStr, CString};
use std::ptr::{null, null_mut};

fn error() -> String {
    // SAFETY: the library returns a text that ends with a zero, valid until the next failure
    unsafe { CStr::from_ptr(ca_device_error()) }.to_str().unwrap().to_owned()
}

fn about(name: &CStr, n: u16) -> (i32, About) {
    let zero: About = zeroed();
    let mut about = zero;
    // SAFETY: both pointers are valid
    let r = unsafe { ca_device_about(&raw mut about, name.as_ptr(), n, 1, 1000) };
    (r, about)
}

fn zeroed() -> About {
    // SAFETY: numbers and arrays of numbers only
    unsafe { core::mem::zeroed() }
}

#[test]
fn mistakes_are_errors_with_words() {
    let dir = tempfile::Builder::new().prefix("ca").tempdir_in("/tmp").unwrap();
    let site = Site::at(dir.path()).unwrap();
    let root = CString::new(dir.path().to_str().unwrap()).unwrap();
    let mut frame = DeviceFrame::new("key", 1);
    let mut force = [9.0; DOF];
    // SAFETY: null pointers are under test, all others are valid
    unsafe {
        assert_eq!(ca_device_about(null_mut(), c"key".as_ptr(), 1, 1, 1000), -1);
        assert_eq!(ca_device_about(&mut zeroed(), null(), 1, 1, 1000), -1);
        assert!(error().contains("null"), "{}", error());
        for (n, axes) in [(0, 1), (33, 1), (3, 0), (4, 3), (8, 4)] {
            assert_eq!(ca_device_about(&mut zeroed(), c"key".as_ptr(), n, axes, 1000), -1, "{n} {axes}");
        }
        assert_eq!(about(c"no spaces please", 1).0, -1);
        assert!(error().contains("no spaces please"), "{}", error());
        assert_eq!(about(c"\xff", 1).0, -1);
        assert_eq!(ca_device_open(root.as_ptr(), null()), 0);
        assert_eq!(ca_device_open(root.as_ptr(), &raw const *Box::new(zeroed())), 0, "no name");
        assert_eq!(ca_device_open(c"relative".as_ptr(), &about(c"key", 1).1), 0);
        assert!(error().contains("absolute"), "{}", error());
        // nothing is open
        for handle in [0, 1, u64::MAX] {
            assert_eq!(ca_device_send(handle, &raw mut frame), -1);
            assert_eq!(ca_device_force(handle, force.as_mut_ptr(), null_mut()), -1);
            assert_eq!(ca_device_wait(handle, 10), -1);
            assert_eq!(ca_device_close(handle), -1);
        }
        assert!(error().contains("not open"), "{}", error());
        assert_eq!(force, [0.0; DOF], "no force from a mistake");

        let (made, key) = about(c"key", 2);
        assert_eq!((made, key.version, key.n, key.rate, key.has_this_layout()), (0, VERSION, 2, 1000, true));
        let device = ca_device_open(root.as_ptr(), &raw const key);
        assert_ne!(device, 0, "{}", error());
        assert_eq!(ca_device_open(root.as_ptr(), &raw const key), 0, "the name is taken");
        assert!(error().contains("`key`") && error().contains(&std::process::id().to_string()), "{}", error());
        assert_eq!(ca_device_send(device, null_mut()), -1);
        assert_eq!(ca_device_force(device, null_mut(), null_mut()), -1);
        assert_eq!(ca_device_send(device, &raw mut frame), 0, "nobody there is no error");
        assert_eq!((frame.seq, frame.period_ns), (1, 1_000_000));
        force = [9.0; DOF];
        let mut last = ForceFrame::new("key", 2);
        assert_eq!(ca_device_force(device, force.as_mut_ptr(), &raw mut last), Cause::Disconnect as i32);
        assert_eq!((force, last.seq), ([0.0; DOF], 0));
        assert_eq!(ca_device_wait(device, 1000), 0);
        // belongs to another thread
        std::thread::spawn(move || assert_eq!(ca_device_close(device), -1)).join().unwrap();
        assert_eq!((ca_device_close(device), ca_device_close(device)), (0, -1));
        // the name is free again
        let again = ca_device_open(root.as_ptr(), &raw const key);
        assert!(again > device, "a handle is never used twice");
        assert_eq!(ca_device_close(again), 0);
    }
    ca_haptic::host::stale_shm::clean(&site);
}
