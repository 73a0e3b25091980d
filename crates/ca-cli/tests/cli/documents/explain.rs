//! Tests `ca explain`: every code has a page, and a report refers to it once.

use crate::sandbox::Sandbox;
use ca_model::diag::CODES;

#[test]
fn every_code_explains_itself() {
    let sandbox = Sandbox::new();
    for (code, title) in CODES {
        let page = sandbox.ca(&["explain", code]).is(0);
        let mut lines = page.out.lines();
        assert_eq!(lines.next(), Some(format!("{code} {title}").as_str()));
        // the page shows a report as a terminal block, after the model that causes it
        let said = ["error", "warning", "note"].map(|w| format!("\n    {w}[{code}]: "));
        let at = said.iter().find_map(|s| page.out.find(s)).unwrap_or_else(|| panic!("no report\n{}", page.out));
        assert!(page.out[..at].contains("\n    "), "{}", page.out);
        assert!(!page.out.contains("```") && !page.out.contains("\n## "), "{}", page.out);
        assert_eq!(sandbox.ca(&["explain", &code.to_lowercase()]).is(0).out, page.out);
        let json = sandbox.ca(&["explain", code, "--json"]).is(0).json();
        assert_eq!((json["code"].as_str(), json["title"].as_str()), (Some(*code), Some(*title)));
        assert!(json["text"].as_str().unwrap().contains("```text\n"));
    }
}

#[test]
fn all_codes_are_listed_by_how_bad_they_are() {
    let sandbox = Sandbox::new();
    let list = sandbox.ca(&["explain"]).is(0).out;
    let at = |word: &str| list.find(word).unwrap_or_else(|| panic!("no `{word}` in\n{list}"));
    let [errors, warnings, notes] = ["Errors", "Warnings", "Notes"].map(at);
    assert!(errors < warnings && warnings < notes);
    for (code, title) in CODES {
        let line = at(&format!("  {code}  {title}\n"));
        let group = if line < warnings {
            'E'
        } else if line < notes {
            'W'
        } else {
            'N'
        };
        assert!(code.starts_with(group), "{list}");
    }
    let json = sandbox.ca(&["explain", "--json"]).is(0).json();
    let json = json.as_array().unwrap();
    assert_eq!(json.len(), CODES.len());
    for (entry, (code, title)) in json.iter().zip(CODES) {
        assert_eq!((entry["code"].as_str(), entry["title"].as_str()), (Some(*code), Some(*title)));
        let severity = entry["severity"].as_str().unwrap();
        assert!(severity.to_uppercase().starts_with(&code[..1]), "{entry}");
    }
}

#[test]
fn an_unknown_code_is_refused_with_the_nearest() {
    let sandbox = Sandbox::new();
    sandbox.ca(&["explain", "E13"]).is(2).says(&["`E13`", "did you mean `E013`?"]);
    sandbox.ca(&["explain", "w99"]).is(2).says(&["`w99`", "`ca explain` lists all codes"]);
    assert_eq!(sandbox.ca(&["explain", "E0000"]).is(2).out, "");
}

/// The reference is one line after the first report with an error or a warning. It is omitted with `--json` and with
/// `-q`.
#[test]
fn a_report_leads_to_the_page() {
    let sandbox = Sandbox::new();
    let ends = "[SOX]\nout = { from = \"bar\" }\n";
    // the warning comes before the error, which is more severe
    sandbox.put(
        "bad.ca.toml",
        &format!("[MAS]\nlone = {{ m = 1 }}\n[CEL]\nbar = {{ m = 1, f = \"2 kg\", dx0 = 1 }}\n{ends}"),
    );
    sandbox.put(
        "odd.ca.toml",
        &format!("[MAS]\nlone = {{ m = 1 }}\n[CEL]\nbar = {{ m = 1, f = 200, dx0 = 1e-3 }}\n{ends}"),
    );
    for command in ["check", "render", "modes", "equiv"] {
        let ran = sandbox.ca(&[command, "bad.ca.toml"]).is(1);
        assert!(ran.err.ends_with("\nfor details, run `ca explain E008`\n"), "{command}: {}", ran.err);
    }
    let ran = sandbox.ca(&["check", "odd.ca.toml"]).is(0);
    assert!(ran.err.ends_with("\nfor details, run `ca explain W101`\n"), "{}", ran.err);
    sandbox.ca(&["explain", "W101"]).is(0).says(&["without effect on an output"]);
    let more = |args: &[&str]| sandbox.ca(args).err.matches("for details, run").count();
    assert_eq!(more(&["render", "odd.ca.toml"]), 0, "its summary leads to `ca check`");
    let quiet = sandbox.ca(&["render", "odd.ca.toml", "-q"]).says(&["warning[W101]"]);
    assert!(!quiet.err.contains("for details, run"), "{}", quiet.err);
    assert_eq!(more(&["render", "odd.ca.toml", "--json"]), 0);
    assert_eq!(more(&["render", "bad.ca.toml", "-q"]), 0);
    assert_eq!(more(&["check", "bad.ca.toml", "--json"]), 0);
    assert_eq!(more(&["check", "hammered_string"]), 0, "a model without errors and warnings");
    // the MIMS text and the converted model produce two reports, but at most one reference
    sandbox.put(
        "a.mdl",
        "@K audioParam 0.1\n@a mass 1. 0. 0.\n@b mass 1. 0. 0.\n@s springDamper @b @a 9. 0.001\n@out1 posOutput @a\n",
    );
    assert_eq!(more(&["import", "a.mdl"]), 1);
}
