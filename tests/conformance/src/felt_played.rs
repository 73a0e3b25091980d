//! Plays a contact with memory: [`felt`](crate::felt).

use crate::play::{apart, mat, within};
use crate::random_parameters::{built, read};
use ca_compile::Options;
use ca_core::tick;
use ca_model::Model;

/// A ball that a spring returns to a felt many times, on a line or in space along `x`.
fn bounces(space: bool) -> Model {
    let at = |v: f64| if space { format!("[{v}, 0, 0]") } else { format!("{v}") };
    let dim = if space { 3 } else { 1 };
    read(&format!(
        "[room]\ndim = {dim}\n[room.SOL]\nwall = {{}}\nfar = {{ x = {} }}\n[room.MAS]\nball = {{ m = 0.01, x = {}, v = {} }}\n\
         [FELT]\nblow = {{ between = [\"room.wall\", \"room.ball\"], k = 2e4, q = 1e4, b = 1e-4, d = 0.1, r = 0.3 }}\n\
         [RES]\nback = {{ between = [\"room.ball\", \"room.far\"], k = 100, l0 = 0.104 }}\n",
        at(0.2),
        at(0.104),
        at(-0.4),
    ))
}

/// The memory of a contact is cleared when its ends are too far apart to touch, so each blow begins anew.
#[test]
fn what_a_contact_remembers_ends_with_the_contact_in_space_too() {
    let run = |space: bool| {
        let scene = built(&bounces(space), &Options { energy: true, ..Options::default() });
        let (mut s, ball) = (scene.state(), mat(&scene, "room.ball"));
        let (mut path, mut blows) = (Vec::new(), 0);
        for _ in 0..20_000 {
            let pressed = s.links.mem[0] > 0.0;
            tick(&scene, &mut s);
            blows += u32::from(!pressed && s.links.mem[0] > 0.0);
            path.push(s.x[ball]);
        }
        assert!(blows >= 3, "{blows} blows");
        let b = s.ledger.as_ref().expect("asked for").balance();
        within("the accounts of the blows", b.residual.abs() / b.peak, 1e-12);
        path
    };
    within("in space as on a line", apart(&run(true), &run(false)), 1e-12);
}

/// The finding about a contact pressed at load states its force, with an empty memory.
#[test]
fn a_contact_with_memory_that_is_pressed_at_load_is_named_with_its_force() {
    let text = "[MAS]\nlow = { m = 1 }\nhigh = { m = 1, x = -1e-3 }\n[FELT]\npress = { between = [\"low\", \"high\"], \
                k = 2000 }\n[SOX]\nout = { from = \"low\" }\n";
    let scene = built(&read(text), &Options::default());
    let found: Vec<_> = scene.findings.list.iter().map(|d| d.title.as_str()).collect();
    assert_eq!(found, ["`press` already presses at load, with a force of 2 N"]);
    assert_eq!(scene.state().links.mem, [1e-3, 0.0]);
}

/// Between two sets in space it remains one link per pair, because each pair has its own memory.
#[test]
fn a_set_of_contacts_with_memory_is_its_pairs() {
    let grains: Vec<_> = (0..6).map(|i| format!("g{i} = {{ m = 1, x = [{}, 0, 0] }}\n", 0.01 * f64::from(i))).collect();
    let grains = grains.concat();
    let names = (0..6).map(|i| format!("\"r.g{i}\"")).collect::<Vec<_>>().join(", ");
    let text = format!(
        "[r]\ndim = 3\n[r.MAS]\n{grains}[FELT]\nall = {{ between = [[{names}], [{names}]], pairs = \"all\", k = 10, \
         d = 0.011 }}\n[SOX]\nout = {{ from = \"r.g0\", along = \"x\" }}\n"
    );
    let scene = built(&read(&text), &Options::default());
    assert_eq!((scene.counts.n_lia, scene.counts.n_mem), (15, 30));
}
