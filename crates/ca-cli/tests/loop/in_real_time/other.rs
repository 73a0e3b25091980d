//! Another user of the same machine: it can neither write into what is ours, nor hold up a command by a file or a link of
//! its own. These tests are run by root, who can be somebody else; where they are not, they are skipped.

use crate::skipped::skipped;
use crate::stage::{Ran, Stage, until};
use std::fs;
use std::os::unix::fs::{MetadataExt, PermissionsExt};
use std::os::unix::process::CommandExt;
use std::path::Path;
use std::process::Command;

/// The user `nobody`.
const NOBODY: u32 = 65534;

/// Runs a line of a shell as another user; `None` where this user cannot.
#[track_caller]
fn as_nobody(line: &str) -> Option<String> {
    if fs::metadata("/proc/self").unwrap().uid() != 0 {
        skipped("root", "only root can be another user");
        return None;
    }
    let o = Command::new("sh").args(["-c", line]).current_dir("/").uid(NOBODY).gid(NOBODY).output().unwrap();
    assert!(o.status.success(), "{line}: {}", String::from_utf8_lossy(&o.stderr));
    Some(String::from_utf8(o.stdout).unwrap())
}

/// Every command that opens shared memory and ends by itself.
const COMMANDS: [&[&str]; 9] = [
    &["disarm"],
    &["arm"],
    &["set"],
    &["stop"],
    &["status"],
    &["device", "list"],
    &["device", "doctor"],
    &["serve", "key.ca.toml", "--seconds", "0.1"],
    &["device", "sim", "--profile", "key", "--seconds", "0.1"],
];

fn run(stage: &Stage, args: &[&str]) -> Ran {
    // ends the test where it hangs
    stage.spawn(args).end()
}

#[test]
fn nothing_of_ours_can_be_opened_or_cut_by_another_user() {
    let stage = Stage::beside();
    let server = stage.serve("key.ca.toml", &["--quiet"]);
    let device = stage.key(&[]);
    stage.on();
    let mut files = Vec::new();
    for entry in fs::read_dir("/dev/shm").unwrap().flatten() {
        if entry.file_name().to_string_lossy().starts_with(stage.site.prefix()) {
            // one that ended between the listing and now is none
            let Ok(file) = entry.metadata() else { continue };
            let mode = file.permissions().mode() & 0o777;
            assert_eq!(mode & !0o600, 0, "{:?} has mode {mode:o}", entry.file_name());
            files.push(entry.path());
        }
    }
    assert!(files.len() > 10, "{files:?}");
    // `truncate -c` opens what is there, and makes nothing
    let line = format!(
        "for f in {}; do echo tried; truncate -c -s 0 $f 2>/dev/null && echo $f cut; \
         cat $f >/dev/null 2>&1 && echo $f read; rm $f 2>/dev/null && echo $f removed; done; true",
        files.iter().map(|f| f.display().to_string()).collect::<Vec<_>>().join(" ")
    );
    let Some(printed) = as_nobody(&line) else { return };
    assert_eq!(printed.lines().filter(|l| *l == "tried").count(), files.len(), "{printed}");
    // a file that came and went by itself meanwhile could be cut (there was nothing to cut), but not read or removed
    let done = |l: &&str| *l != "tried" && l.strip_suffix(" cut").is_none_or(|f| Path::new(f).exists());
    assert_eq!(printed.lines().filter(done).count(), 0, "{printed}");
    // all of it still answers
    run(&stage, &["status"]).is(0);
    run(&stage, &["device", "list"]).is(0).says(&["key"]);
    run(&stage, &["disarm"]).is(0);
    run(&stage, &["stop"]).is(0);
    server.end().is(0);
    drop(device);
}

#[test]
fn a_file_of_another_user_under_our_name_is_an_error_of_every_command() {
    let stage = Stage::beside();
    // what iceoryx2 opens first (empty: it would wait for ever), a line not yet open, and anything else
    let counter = "9204dd183d1c4d8e1ff592a30766ffa6765aa8b5_node.0_10_0.global_mgmt";
    for (name, make) in [
        (counter, "umask 0; : > $f"),
        (counter, "umask 0; printf '\\000\\000\\012\\000\\000\\000\\000\\000\\000\\000' > $f"),
        ("112437a14a36c452eeea7e2aefc2af954fc5a3f2_1.dynamic", "umask 0; : > $f"),
        (counter, "ln -s /dev/zero $f"),
    ] {
        let path = format!("/dev/shm/{}{name}", stage.site.prefix());
        if as_nobody(&format!("f={path}; {make}")).is_none() {
            return;
        }
        for args in COMMANDS {
            let r = run(&stage, args);
            let text = format!("{}{}", r.out, r.err);
            assert!(matches!(r.code, Some(1 | 2)), "{args:?}: {:?}\n{text}", r.code);
            assert!(
                text.contains(&path) && text.contains("user 65534") && text.contains("CA_SHM_ROOT"),
                "{args:?}: {text}"
            );
        }
        // what is not ours is shown, and not ours to remove without asking the system
        run(&stage, &["shm", "list"]).is(0).says(&[&path]);
        fs::remove_file(&path).unwrap();
    }
    run(&stage, &["device", "sim", "--profile", "key", "--seconds", "0.1"]).is(0);
}

/// A process that is killed while it makes a service leaves one that nobody may open.
#[test]
fn what_a_killed_process_had_begun_is_no_obstacle() {
    let stage = Stage::beside();
    // the name of a service is the hash of what it is called: as one of a server that was whole
    run(&stage, &["serve", "key.ca.toml", "--seconds", "0.1"]).served(301);
    let server = stage.serve("key.ca.toml", &["--quiet"]);
    let services = stage.site.root().join("services");
    until("it serves", || fs::read_dir(&services).is_ok_and(|all| all.flatten().count() >= 4));
    let names: Vec<_> = fs::read_dir(&services).unwrap().flatten().map(|e| e.path()).collect();
    server.kill();
    run(&stage, &["device", "list"]).is(0);
    for path in &names {
        let _ = fs::remove_file(path);
        fs::write(path, []).unwrap();
        fs::set_permissions(path, fs::Permissions::from_mode(0o600)).unwrap();
        run(&stage, &["serve", "key.ca.toml", "--seconds", "0.1"]).served(301);
    }
    assert!(names.len() >= 4, "{names:?}");
}

#[test]
fn a_file_of_ours_that_was_cut_is_made_anew() {
    let stage = Stage::beside();
    run(&stage, &["device", "list"]).is(0);
    for name in ["9204dd183d1c4d8e1ff592a30766ffa6765aa8b5_node.0_10_0.global_mgmt", "1_1.dynamic"] {
        let path = format!("/dev/shm/{}{name}", stage.site.prefix());
        fs::write(&path, []).unwrap();
        run(&stage, &["device", "list"]).is(0);
        run(&stage, &["status"]).is(1).says(&["no server runs"]);
        run(&stage, &["serve", "key.ca.toml", "--seconds", "0.1"]).served(301);
        assert!(fs::metadata(&path).map_or(true, |m| m.len() > 0), "{path}");
    }
    // one that an older release made for everybody is closed
    let path =
        format!("/dev/shm/{}9204dd183d1c4d8e1ff592a30766ffa6765aa8b5_node.0_10_0.global_mgmt", stage.site.prefix());
    fs::set_permissions(&path, fs::Permissions::from_mode(0o666)).unwrap();
    let before = fs::metadata(&path).unwrap().ino();
    run(&stage, &["device", "list"]).is(0);
    let after = fs::metadata(&path).unwrap();
    assert_eq!(after.permissions().mode() & 0o777, 0o600);
    assert_ne!(after.ino(), before, "whoever has the old one open has nothing");
}

#[test]
fn a_folder_by_way_of_another_users_link_is_refused() {
    let stage = Stage::beside();
    let mine = stage.path("mine");
    fs::create_dir(&mine).unwrap();
    fs::set_permissions(&mine, fs::Permissions::from_mode(0o700)).unwrap();
    let open = tempfile::Builder::new().prefix("cao").tempdir_in("/tmp").unwrap();
    fs::set_permissions(open.path(), fs::Permissions::from_mode(0o1777)).unwrap();
    let (link, folder) = (open.path().join("l"), open.path().join("d"));
    let line = format!("ln -s {} {}; ln -s / {}", mine.display(), link.display(), folder.display());
    if as_nobody(&line).is_none() {
        return;
    }
    let through = folder.join(mine.strip_prefix("/").unwrap());
    let fresh = link.join("new");
    for root in [&link, &through, &fresh] {
        for args in COMMANDS.iter().chain([&["shm", "list"][..], &["shm", "clean"]].iter()) {
            let mut c = stage.command(env!("CARGO_BIN_EXE_ca"), args);
            c.env("CA_SHM_ROOT", root);
            let r = stage.start(c).end();
            let text = format!("{}{}", r.out, r.err);
            assert!(matches!(r.code, Some(1 | 2)), "{root:?} {args:?}: {:?}\n{text}", r.code);
            assert!(text.contains("a symbolic link of user 65534"), "{args:?}: {text}");
        }
    }
    assert!(fs::read_dir(&mine).unwrap().next().is_none(), "nothing was made in there");
    // one's own link is one's own choice
    let own = open.path().join("own");
    std::os::unix::fs::symlink(&mine, &own).unwrap();
    let mut c = stage.command(env!("CARGO_BIN_EXE_ca"), &["shm", "list"]);
    c.env("CA_SHM_ROOT", &own);
    stage.start(c).end().is(0);
    // a folder that anybody can replace
    fs::set_permissions(open.path(), fs::Permissions::from_mode(0o777)).unwrap();
    let mut c = stage.command(env!("CARGO_BIN_EXE_ca"), &["shm", "list"]);
    c.env("CA_SHM_ROOT", open.path().join("s"));
    stage.start(c).end().is(2).says(&["chmod +t"]);
}

#[test]
fn a_small_dev_shm_is_an_error_and_no_signal() {
    let stage = Stage::beside();
    for kb in [16, 64, 256, 448, 704, 1024, 4096] {
        // both sides in one room; the codes of what ends by a signal are 128 and more
        let line = format!(
            "mount -t tmpfs -o size={kb}k tmpfs /dev/shm || {{ echo unable; exit 0; }}; \
             $CA serve key.ca.toml --arm --seconds 2 --no-lock --priority 0 --quiet & p=$!; sleep 0.5; \
             $CA status >/dev/null; echo status $?; \
             $CA device sim --profile key --seconds 0.5 --priority 0 >/dev/null; echo sim $?; \
             wait $p; echo serve $?"
        );
        let mut c = stage.command("unshare", &["-m", "sh", "-c", &line]);
        c.env("CA", env!("CARGO_BIN_EXE_ca"));
        let r = stage.start(c).end();
        if r.code != Some(0) || r.out.contains("unable") {
            skipped("unshare", &format!("no room of its own for shared memory: {}", r.err));
            return;
        }
        let code = |who: &str| -> i32 {
            let line = r.out.lines().find_map(|l| l.strip_prefix(who)).unwrap_or_else(|| panic!("{}", r.out));
            line.trim().parse().unwrap()
        };
        let codes = [code("status"), code("sim"), code("serve")];
        assert!(codes.iter().all(|c| *c < 128), "{kb} kB: {codes:?}\n{}", r.err);
        if kb <= 64 {
            assert!(codes[1] != 0 && codes[2] != 0, "{kb} kB: {codes:?}\n{}", r.err);
            assert!(r.err.contains("kB free") && r.err.contains("--shm-size"), "{}", r.err);
        }
        if kb >= 4096 {
            assert_eq!((codes[1], codes[2] == 0 || codes[2] == 3), (0, true), "{kb} kB: {}", r.err);
        }
    }
}
