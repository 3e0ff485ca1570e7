//! Completions in the installed shells.

use std::process::Command;

use crate::program::Workplace;

/// Completions that bash offers for the last of these words.
fn offers(place: &Workplace, words: &str) -> Option<Vec<String>> {
    let script = r#"
        source completions.bash || exit 3
        function=$(complete -p rt-cli | sed 's/.*-F \([^ ]*\).*/\1/')
        IFS=' ' read -r -a COMP_WORDS <<< "${1%+}"
        [[ $1 == *+ ]] && COMP_WORDS+=("")
        COMP_CWORD=$((${#COMP_WORDS[@]} - 1))
        "$function" rt-cli "${COMP_WORDS[COMP_CWORD]}" "${COMP_WORDS[COMP_CWORD - 1]}" 2>/dev/null
        printf '%s\n' "${COMPREPLY[@]}"
    "#;
    let run = Command::new("bash").args(["-c", script, "bash", words]).current_dir(place.path("")).output().ok()?;
    assert!(run.status.success(), "{words}: {run:?}");
    Some(String::from_utf8_lossy(&run.stdout).lines().map(str::to_owned).collect())
}

#[test]
fn bash_completes_commands_and_their_options() {
    let place = Workplace::new();
    place.write("completions.bash", place.succeed("completions bash").stdout);
    for (words, expected) in [
        ("rt-cli ren", "render"),
        ("rt-cli comp", "compare"),
        ("rt-cli --lim", "--limits"),
        ("rt-cli render --sp", "--spp"),
        ("rt-cli render scene.ron --targ", "--target-error"),
        ("rt-cli render scene.ron --tone ac", "aces"),
        ("rt-cli render scene.ron --integrator pa", "path"),
        ("rt-cli develop in.exr --gam", "--gamma"),
        ("rt-cli check scene.ron --format +", "json"),
        ("rt-cli completions fi", "fish"),
        ("rt-cli scene.ron --sp", "--spp"),
    ] {
        let Some(offers) = offers(&place, words) else {
            return rt_tests::skip("there is no bash");
        };
        assert!(offers.iter().any(|offer| offer == expected), "{words}: {offers:?}");
    }
}

#[test]
fn other_shells_read_their_scripts() {
    let place = Workplace::new();
    for (shell, check) in [("zsh", "-n"), ("fish", "--no-execute")] {
        let script = place.succeed(&format!("completions {shell}")).stdout;
        assert!(!script.contains("rt__subcmd"), "{shell}");
        place.write("script", script);
        match Command::new(shell).args([check, "script"]).current_dir(place.path("")).output() {
            Ok(run) => assert!(run.status.success(), "{shell}: {run:?}"),
            Err(_) => rt_tests::skip(format_args!("there is no {shell}")),
        }
    }
}
