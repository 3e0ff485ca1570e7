//! Tests that cannot run must not pass for tests that ran.

use std::{
    env, fs,
    path::Path,
    process::{Command, Output},
};

use rt_tests::{shared, skip};

/// Runs the test below alone, in a process of its own.
fn run_skipped(list: &Path, require_all: &str) -> Output {
    let mut command = Command::new(env::current_exe().expect("this program"));
    command
        .args(["--exact", "skipping::it_cannot_run", "--ignored"])
        .env("RT_SKIPPED", list)
        .env("RT_REQUIRE_ALL", require_all);
    command.output().expect("it starts")
}

/// Passed by `a_skipped_test_is_listed_and_fails_where_all_must_run` to a process of its own.
#[test]
#[ignore = "skipped on purpose, by the test below"]
fn it_cannot_run() {
    skip("there is\nno moon");
}

/// Regression: such tests passed, and their output was captured and not counted.
#[test]
fn a_skipped_test_is_listed_and_fails_where_all_must_run() {
    let list = env::temp_dir().join(format!("rt-skipped-{}.txt", std::process::id()));
    for (require_all, passes) in [("0", true), ("1", false)] {
        let _ = fs::remove_file(&list);
        let output = run_skipped(&list, require_all);
        let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
        let line = "skipped: workspace::skipping::it_cannot_run: there is no moon\n";
        assert_eq!(output.status.success(), passes, "{stderr}");
        assert!(stderr.contains(line), "{stderr}");
        assert_eq!(fs::read_to_string(&list).expect("a list"), line);
    }
    fs::remove_file(&list).expect("removed");
}

#[test]
fn shared_data_that_is_not_there_is_nowhere() {
    assert_eq!(shared("no/such/file"), None);
}
