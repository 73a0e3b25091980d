//! Selectors: every form, printing, errors with their place.

use ca_model::select::{At, Coord, Index, Part, is_name, is_word, parse};
use proptest::prelude::*;

#[test]
fn every_form_is_read_and_printed_back() {
    let cases = [
        ("hammer", "hammer", Part::Mass, Index::None),
        ("ball.a", "ball.a", Part::Mass, Index::None),
        ("low[8]", "low", Part::Mass, Index::One(8)),
        ("low[-1]", "low", Part::Mass, Index::One(-1)),
        ("low[*]", "low", Part::Mass, Index::All),
        ("low[2..5]", "low", Part::Mass, Index::Range(2, 5)),
        ("plate[3,4]", "plate", Part::Mass, Index::Two(3, 4)),
        ("low.link[3]", "low", Part::Link, Index::One(3)),
        ("ball.low.link[*]", "ball.low", Part::Link, Index::All),
        ("low.end[0]", "low", Part::End, Index::One(0)),
        ("ball.link", "ball.link", Part::Mass, Index::None),
    ];
    for (text, name, part, index) in cases {
        let s = parse(text).unwrap_or_else(|e| panic!("{text}: {e}"));
        assert_eq!((s.name.as_str(), s.part, s.index, &s.at), (name, part, index, &None), "{text}");
        assert_eq!(s.to_string(), text);
    }
    assert_eq!(parse(" plate [ 3 , -4 ] ").unwrap().to_string(), "plate[3,-4]");
}

#[test]
fn moving_points() {
    let num = Coord::Num;
    let name = |n: &str| Coord::Name(n.into());
    let cases = [
        ("low@0.31", vec![num(0.31)]),
        ("plate@0.3,0.4", vec![num(0.3), num(0.4)]),
        ("low@place", vec![name("place")]),
        ("plate@u,v", vec![name("u"), name("v")]),
        ("plate@0.5,hand.y", vec![num(0.5), name("hand.y")]),
    ];
    for (text, coords) in cases {
        let s = parse(text).unwrap();
        assert_eq!(s.at, Some(At(coords)), "{text}");
        assert_eq!(s.to_string(), text);
    }
}

#[test]
fn errors_say_what_and_where() {
    let cases = [
        ("", 0, "a name is missing"),
        ("[3]", 0, "a name is missing"),
        ("8low", 0, "a name must start with a letter or `_`"),
        ("my mass", 2, "` ` is not part of a name"),
        ("a-b", 1, "`-` is not part of a name"),
        ("ball.", 5, "a name must not end with a dot"),
        ("ball..a", 5, "`.` is not part of a name"),
        ("été", 0, "`é` is not part of a name"),
        ("low[3", 5, "`]` is missing"),
        ("low3]", 4, "`]` without `[`"),
        ("low[3]x", 6, "unexpected text after `]`"),
        ("low[]", 4, "a number is missing"),
        ("low[2..]", 7, "a number is missing"),
        ("low[a]", 4, "`a` is not an index: write a whole number, `*` or a range such as `2..5`"),
        ("plate[1, b]", 9, "`b` is not an index: write a whole number, `*` or a range such as `2..5`"),
        (
            "low[99999999999999999999]",
            4,
            "`99999999999999999999` is not an index: write a whole number, `*` or a range such as `2..5`",
        ),
        ("low[3]@0.5", 6, "a moving point cannot have an index: write only the place, as in `low@0.31`"),
        ("low@", 4, "a place is missing after `@`: a number from 0 to 1 or a name"),
        ("plate@1,2,3", 10, "a moving point must have one or two coordinates"),
        ("low@0.3x", 4, "`0.3x` is neither a number nor a name"),
    ];
    for (text, at, message) in cases {
        let e = parse(text).expect_err(text);
        assert_eq!((e.message.as_str(), e.at), (message, at), "{text}");
    }
}

#[test]
fn names() {
    assert!(is_word("_a1") && is_word("MAS") && !is_word("a.b") && !is_word("") && !is_word("1a") && !is_word("a-b"));
    assert!(is_name("ball.a") && !is_name(".a") && !is_name("a.") && !is_name("é"));
}

proptest! {
    #[test]
    fn what_is_read_prints_to_the_same(text in "[a-c_.]{0,4}(\\.link|\\.end)?(\\[[-0-9*., ]{0,5}\\])?(@[-0-9.,ae]{0,6})?") {
        if let Ok(s) = parse(&text) {
            prop_assert_eq!(parse(&s.to_string()), Ok(s));
        }
    }

    #[test]
    fn any_text_is_read_or_refused(bytes in prop::collection::vec(any::<u8>(), 0..30)) {
        let text = String::from_utf8_lossy(&bytes);
        for t in [text.clone().into_owned(), format!("a{text}"), format!("a[{text}"), format!("a@{text}")] {
            if let Err(e) = parse(&t) {
                prop_assert!(t.is_char_boundary(e.at), "{t:?} {e:?}");
            }
        }
    }
}
