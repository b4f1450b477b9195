//! `gaitshift completions` and `gaitshift manual`: every command is in them, as in `--help`.

use crate::common::Place;

#[test]
fn every_shell_completes_every_command() {
    let place = Place::new();
    let commands = place.commands("");
    assert!(commands.contains(&"train".to_owned()), "{commands:?}");
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let script = place.stdout(&format!("completions {shell}"));
        for name in &commands {
            assert!(script.contains(name.as_str()), "{shell}: no {name}");
        }
        assert!(script.contains("stop-when-accepted"), "{shell}");
    }
    place.refused("completions tcsh", &["tcsh"]);
}

#[cfg(unix)]
#[test]
fn bash_takes_the_script() {
    let place = Place::new();
    place.write("gaitshift.bash", place.stdout("completions bash"));
    let script = "source gaitshift.bash; COMP_WORDS=(gaitshift tra); COMP_CWORD=1; \
                  _gaitshift gaitshift tra gaitshift; echo ${COMPREPLY[@]}";
    let Ok(output) = std::process::Command::new("bash")
        .args(["--norc", "-c", script])
        .current_dir(place.path(""))
        .output()
    else {
        // A machine without bash.
        return;
    };
    let said = String::from_utf8_lossy(&output.stdout);
    assert!(
        said.split_whitespace().any(|word| word == "train"),
        "{said}"
    );
}

#[test]
fn the_manual_has_a_page_for_every_command() {
    let place = Place::new();
    let page = place.stdout("manual");
    assert!(page.contains(".TH gaitshift 1"), "{page}");
    place.stdout("manual --out pages");
    for name in place.commands("") {
        let page = place.read(&format!("pages/gaitshift-{name}.1"));
        let page = String::from_utf8(page).unwrap();
        assert!(page.contains(".TH"), "{name}");
        assert!(
            page.contains(&format!("gaitshift {name}"))
                || page.contains(&format!("gaitshift\\-{name}")),
            "{page}"
        );
    }
    // `gaitshift-export.1` refers to them.
    for format in ["mjcf", "onnx", "hub", "csv", "html", "npz"] {
        assert!(
            place
                .path(&format!("pages/gaitshift-export-{format}.1"))
                .exists(),
            "{format}"
        );
    }
    let train = String::from_utf8(place.read("pages/gaitshift-train.1")).unwrap();
    assert!(train.contains("stop\\-when\\-accepted"), "{train}");
}
