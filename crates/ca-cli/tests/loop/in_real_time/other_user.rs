//! Tests the protection from another user of the same machine. That user cannot write our files, block a command with
//! files or links, or play an armed model. These tests need root to act as another user and are skipped otherwise.

use super::request_flood;
use crate::sandbox::{RunOutput, Sandbox, until};
use crate::skipped::skipped;
use ca_haptic::host::control::Request;
use rosc::{OscBundle, OscMessage, OscPacket, OscTime, OscType, encoder};
use std::fs;
use std::net::UdpSocket;
use std::os::unix::fs::{MetadataExt, PermissionsExt};
use std::os::unix::process::CommandExt;
use std::path::Path;
use std::process::Command;

const NOBODY: u32 = 65534;

/// Runs a shell line as another user. Returns `None` without the permission.
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

/// Commands that open shared memory and end by themselves.
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

fn run(sandbox: &Sandbox, args: &[&str]) -> RunOutput {
    // fails the test if the command hangs
    sandbox.spawn(args).end()
}

#[test]
fn nothing_of_ours_can_be_opened_or_cut_by_another_user() {
    let sandbox = Sandbox::shared();
    let server = sandbox.serve("key.ca.toml", &["--quiet"]);
    let device = sandbox.key(&[]);
    sandbox.on();
    let mut files = Vec::new();
    for entry in fs::read_dir("/dev/shm").unwrap().flatten() {
        if entry.file_name().to_string_lossy().starts_with(sandbox.site.prefix()) {
            // skips a file removed since the listing
            let Ok(file) = entry.metadata() else { continue };
            let mode = file.permissions().mode() & 0o777;
            assert_eq!(mode & !0o600, 0, "{:?} has mode {mode:o}", entry.file_name());
            files.push(entry.path());
        }
    }
    assert!(files.len() > 10, "{files:?}");
    // `truncate -c` opens existing files and creates none
    let line = format!(
        "for f in {}; do echo tried; truncate -c -s 0 $f 2>/dev/null && echo $f cut; \
         cat $f >/dev/null 2>&1 && echo $f read; rm $f 2>/dev/null && echo $f removed; done; true",
        files.iter().map(|f| f.display().to_string()).collect::<Vec<_>>().join(" ")
    );
    let Some(printed) = as_nobody(&line) else { return };
    let socket = sandbox.site.root().join("control/v1");
    assert!(socket.exists());
    let line = format!("test -e {} && echo seen; true", socket.display());
    assert_eq!(as_nobody(&line).as_deref(), Some(""), "the socket is in a closed folder");
    assert_eq!(printed.lines().filter(|l| *l == "tried").count(), files.len(), "{printed}");
    // a file removed meanwhile may count as cut, but not as read or removed
    let done = |l: &&str| *l != "tried" && l.strip_suffix(" cut").is_none_or(|f| Path::new(f).exists());
    assert_eq!(printed.lines().filter(done).count(), 0, "{printed}");
    run(&sandbox, &["status"]).is(0);
    run(&sandbox, &["device", "list"]).is(0).says(&["key"]);
    run(&sandbox, &["disarm"]).is(0);
    run(&sandbox, &["stop"]).is(0);
    server.end().is(0);
    drop(device);
}

/// Name of the iceoryx2 counter after the prefix.
const COUNTER: &str = "9204dd183d1c4d8e1ff592a30766ffa6765aa8b5_node.0_10_0.global_mgmt";

#[test]
fn a_file_of_another_user_blocks_no_command_while_a_server_runs() {
    let sandbox = Sandbox::shared();
    let server = sandbox.serve("key.ca.toml", &["--quiet"]);
    let device = sandbox.key(&[]);
    sandbox.on();
    let path = format!("/dev/shm/{}squat", sandbox.site.prefix());
    if as_nobody(&format!("touch {path}; ln -s /dev/zero {path}2")).is_none() {
        return;
    }
    run(&sandbox, &["status"]).is(0);
    run(&sandbox, &["device", "list"]).is(0).says(&["key"]);
    run(&sandbox, &["device", "sim", "--profile", "key", "--name", "new", "--seconds", "0.1"]).is(0);
    run(&sandbox, &["shm", "list"]).is(0);
    run(&sandbox, &["shm", "clean"]).is(0);
    run(&sandbox, &["disarm"]).is(0);
    until("forces are off", || sandbox.state().0 == "off");
    run(&sandbox, &["arm"]).is(0);
    sandbox.on();
    run(&sandbox, &["stop"]).is(0);
    server.end();
    drop(device);
    for path in [path.clone(), path + "2"] {
        assert!(fs::symlink_metadata(&path).is_ok(), "what is not ours is not removed");
        fs::remove_file(&path).unwrap();
    }
}

#[test]
fn a_prefix_that_another_user_knows_is_replaced() {
    let sandbox = Sandbox::shared();
    let root = sandbox.path("r");
    let ca = |args: &[&str]| {
        let mut c = sandbox.command(env!("CARGO_BIN_EXE_ca"), args);
        c.env("CA_SHM_ROOT", &root);
        sandbox.start(c).end()
    };
    let prefix = || ca(&["shm", "list", "--json"]).is(0).json()["prefix"].as_str().unwrap().to_owned();
    // the first file opened by iceoryx2 (if empty, it would wait forever), the line of a device, and other files
    for (name, make) in [
        (COUNTER, "umask 0; : > $f"),
        (COUNTER, "umask 0; printf '\\000\\000\\012\\000\\000\\000\\000\\000\\000\\000' > $f"),
        ("112437a14a36c452eeea7e2aefc2af954fc5a3f2_1.dynamic", "umask 0; : > $f"),
        (COUNTER, "ln -s /dev/zero $f"),
    ] {
        ca(&["device", "sim", "--profile", "key", "--seconds", "0.1"]).is(0);
        let before = prefix();
        ca(&["shm", "clean"]).is(0);
        let path = format!("/dev/shm/{before}{name}");
        if as_nobody(&format!("f={path}; {make}")).is_none() {
            return;
        }
        for args in COMMANDS {
            let r = ca(args);
            let text = format!("{}{}", r.out, r.err);
            let absent = r.code == Some(1) && text.contains("no server is running");
            assert!(matches!(r.code, Some(0 | 3)) || absent, "{args:?}: {:?}\n{text}", r.code);
        }
        assert_ne!(prefix(), before);
        fs::remove_file(&path).unwrap();
    }
    ca(&["shm", "clean"]).is(0);
}

/// Forces can be switched off even without a usable `/dev/shm`.
#[test]
fn what_is_asked_of_a_server_needs_no_shared_memory() {
    let sandbox = Sandbox::shared();
    let server = sandbox.serve("key.ca.toml", &["--quiet"]);
    let line = "mount -t tmpfs -o size=4k,ro tmpfs /dev/shm || { echo unable; exit 0; }; \
                $CA status && $CA disarm && $CA arm && $CA stop; echo code $?";
    let mut c = sandbox.command("unshare", &["-m", "sh", "-c", line]);
    c.env("CA", env!("CARGO_BIN_EXE_ca"));
    let r = sandbox.start(c).end();
    if r.code != Some(0) || r.out.contains("unable") {
        skipped("unshare", &format!("no separate /dev/shm: {}", r.err));
        return;
    }
    r.says(&["code 0"]);
    let ran = server.end();
    assert!(matches!(ran.code, Some(0 | 3)), "{}{}", ran.out, ran.err);
}

/// A process killed while it creates a service leaves one that cannot be opened.
#[test]
fn what_a_killed_process_had_begun_is_no_obstacle() {
    let sandbox = Sandbox::shared();
    // the name of a service is a hash, so it is copied from a complete server
    run(&sandbox, &["serve", "key.ca.toml", "--seconds", "0.1"]).served(301);
    let server = sandbox.serve("key.ca.toml", &["--quiet"]);
    let services = sandbox.site.root().join("services");
    until("it serves", || fs::read_dir(&services).is_ok_and(|all| all.flatten().count() >= 4));
    let names: Vec<_> = fs::read_dir(&services).unwrap().flatten().map(|e| e.path()).collect();
    server.kill();
    run(&sandbox, &["device", "list"]).is(0);
    for path in &names {
        let _ = fs::remove_file(path);
        fs::write(path, []).unwrap();
        fs::set_permissions(path, fs::Permissions::from_mode(0o600)).unwrap();
        run(&sandbox, &["serve", "key.ca.toml", "--seconds", "0.1"]).served(301);
    }
    assert!(names.len() >= 4, "{names:?}");
}

#[test]
fn a_file_of_ours_that_was_cut_is_made_anew() {
    let sandbox = Sandbox::shared();
    run(&sandbox, &["device", "list"]).is(0);
    for name in [COUNTER, "1_1.dynamic"] {
        let path = format!("/dev/shm/{}{name}", sandbox.site.prefix());
        fs::write(&path, []).unwrap();
        run(&sandbox, &["device", "list"]).is(0);
        run(&sandbox, &["status"]).is(1).says(&["no server is running"]);
        run(&sandbox, &["serve", "key.ca.toml", "--seconds", "0.1"]).served(301);
        assert!(fs::metadata(&path).map_or(true, |m| m.len() > 0), "{path}");
    }
    // a file left open to all users by an older release is closed
    let path = format!("/dev/shm/{}{COUNTER}", sandbox.site.prefix());
    fs::set_permissions(&path, fs::Permissions::from_mode(0o666)).unwrap();
    let before = fs::metadata(&path).unwrap().ino();
    run(&sandbox, &["device", "list"]).is(0);
    let after = fs::metadata(&path).unwrap();
    assert_eq!(after.permissions().mode() & 0o777, 0o600);
    assert_ne!(after.ino(), before, "whoever has the old one open has nothing");
}

#[test]
fn a_folder_by_way_of_another_users_link_is_refused() {
    let sandbox = Sandbox::shared();
    let mine = sandbox.path("mine");
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
            let mut c = sandbox.command(env!("CARGO_BIN_EXE_ca"), args);
            c.env("CA_SHM_ROOT", root);
            let r = sandbox.start(c).end();
            let text = format!("{}{}", r.out, r.err);
            assert!(matches!(r.code, Some(1 | 2)), "{root:?} {args:?}: {:?}\n{text}", r.code);
            assert!(text.contains("a symbolic link owned by user 65534"), "{args:?}: {text}");
        }
    }
    assert!(fs::read_dir(&mine).unwrap().next().is_none(), "nothing was made in there");
    // a link owned by the user is accepted
    let own = open.path().join("own");
    std::os::unix::fs::symlink(&mine, &own).unwrap();
    let mut c = sandbox.command(env!("CARGO_BIN_EXE_ca"), &["shm", "list"]);
    c.env("CA_SHM_ROOT", &own);
    sandbox.start(c).end().is(0);
    // a folder that any user can replace
    fs::set_permissions(open.path(), fs::Permissions::from_mode(0o777)).unwrap();
    let mut c = sandbox.command(env!("CARGO_BIN_EXE_ca"), &["shm", "list"]);
    c.env("CA_SHM_ROOT", open.path().join("s"));
    sandbox.start(c).end().is(2).says(&["chmod +t"]);
}

#[test]
fn a_small_dev_shm_is_an_error_and_no_signal() {
    let sandbox = Sandbox::shared();
    for kb in [16, 64, 256, 448, 704, 1024, 4096] {
        // both sides share one memory; a process killed by a signal has a code of 128 or more
        let line = format!(
            "mount -t tmpfs -o size={kb}k tmpfs /dev/shm || {{ echo unable; exit 0; }}; \
             $CA serve key.ca.toml --arm --seconds 2 --no-lock --priority 0 --quiet & p=$!; sleep 0.5; \
             $CA status >/dev/null; echo status $?; \
             $CA device sim --profile key --seconds 0.5 --priority 0 >/dev/null; echo sim $?; \
             wait $p; echo serve $?"
        );
        let mut c = sandbox.command("unshare", &["-m", "sh", "-c", &line]);
        c.env("CA", env!("CARGO_BIN_EXE_ca"));
        let r = sandbox.start(c).end();
        if r.code != Some(0) || r.out.contains("unable") {
            skipped("unshare", &format!("no separate /dev/shm: {}", r.err));
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

const LIVE: &str = r#"
[param]
k = { value = 500, unit = "N/m", live = true, min = 100, max = 5000 }
[TGR]
key = { device = "key", dof = 0 }
[SOL]
wall = { x = "0.9 mm" }
[RES]
spring = { between = ["key", "wall"], k = "k", l0 = 0 }
[SOX]
out = { from = "key" }
"#;

/// Sends a packet as another user and returns the answer.
#[track_caller]
fn sent_by_nobody(port: u16, packet: &OscPacket) -> Option<String> {
    let bytes = encoder::encode(packet).unwrap();
    let bytes = bytes.iter().fold(String::new(), |text, b| text + &format!("\\x{b:02x}"));
    let line = format!(
        "exec 3<>/dev/udp/127.0.0.1/{port}; printf '{bytes}' >&3; timeout 20 head -c 1 <&3 >/dev/null && echo answered"
    );
    as_nobody(&format!("bash -c \"{line}\""))
}

fn set(addr: &str, k: f32) -> OscPacket {
    OscPacket::Message(OscMessage { addr: addr.into(), args: vec![OscType::Float(k)] })
}

#[test]
fn osc_of_another_user_moves_no_hand() {
    let sandbox = Sandbox::shared();
    sandbox.put("live.ca.toml", LIVE);
    let server = sandbox.serve("live.ca.toml", &["--osc", "0", "--arm"]);
    let device = sandbox.key(&[]);
    sandbox.on();
    let port = request_flood::port(&server);
    let k = || sandbox.ask(&Request::Status).unwrap().fields["params"][0]["value"].as_f64().unwrap();
    let token = sandbox.read("c/osc-token");
    let mode = fs::metadata(sandbox.path("c/osc-token")).unwrap().permissions().mode();
    assert_eq!((mode & 0o777, token.trim().len()), (0o600, 33));
    let wrong = format!("/{}/param/k", "0".repeat(33));
    let bundle = OscPacket::Bundle(OscBundle {
        timetag: OscTime { seconds: 0, fractional: 1 },
        content: vec![set(&format!("/{}/param/k", token.trim()), 5000.0), set("/param/k", 5000.0)],
    });
    for packet in [set("/param/k", 5000.0), set(&wrong, 5000.0), bundle] {
        let Some(said) = sent_by_nobody(port, &packet) else { return };
        assert_eq!(said.trim(), "answered", "it is refused");
        assert_eq!(k(), 500.0);
    }
    let line = UdpSocket::bind("127.0.0.1:0").unwrap();
    let packet = encoder::encode(&set(&format!("/{}/param/k", token.trim()), 700.0)).unwrap();
    line.send_to(&packet, ("127.0.0.1", port)).unwrap();
    until("the owner sets it", || k() == 700.0);
    run(&sandbox, &["stop"]).is(0);
    server.end();
    drop(device);
}

#[test]
fn a_token_that_others_can_read_is_refused() {
    let sandbox = Sandbox::shared();
    for (text, mode, why) in
        [("0123456789abcdef", 0o644, "chmod 600"), ("short", 0o600, "16 to 128"), ("", 0o600, "16")]
    {
        sandbox.put("token", text);
        fs::set_permissions(sandbox.path("token"), fs::Permissions::from_mode(mode)).unwrap();
        let args = ["serve", "key.ca.toml", "--osc", "0", "--osc-token", "token", "--seconds", "0.1"];
        run(&sandbox, &args).is(1).says(&["`token`", why]);
    }
}

#[test]
fn files_are_closed_to_other_users_whatever_the_umask() {
    let sandbox = Sandbox::shared();
    sandbox.put("k.sweep.toml", "model = \"key.ca.toml\"\nseconds = 0.1\n[vary]\n\"spring.k\" = [500, 600]\n");
    let ran =
        sandbox.sh("umask 0; ca sweep k.sweep.toml -o swept > log; ca render key.ca.toml -o a.wav --seconds 0.1 --probe key=p.csv -q; ca new n.ca.toml; \
         ca serve key.ca.toml --seconds 0.1 --log t.mcap -o s.wav -q || test $? = 3; ca log recover t.mcap -o r.mcap; \
         ca device sim --profile key --seconds 0.1 --force-log f.csv; \
         printf x > old.wav; chmod 666 old.wav; ca render key.ca.toml -o old.wav --seconds 0.1 -q");
    let ran = ran.is(0);
    for (name, mode) in [
        ("a.wav", 0o644),
        ("p.csv", 0o644),
        ("n.ca.toml", 0o644),
        ("s.wav", 0o644),
        ("f.csv", 0o644),
        ("old.wav", 0o644),
        ("t.mcap", 0o600),
        ("r.mcap", 0o600),
        ("swept", 0o755),
        ("swept/runs-000000", 0o755),
    ] {
        let about = fs::metadata(sandbox.path(name)).unwrap_or_else(|e| panic!("{name}: {e}\n{}", ran.err));
        assert_eq!(about.permissions().mode() & 0o777, mode, "{name}");
    }
}
