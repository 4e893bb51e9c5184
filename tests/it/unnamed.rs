//! Tables of numbers alone: one message names everything that a person has to state, and its commands
//! work as they stand.

use crate::support::{Folder, finish, program};

/// Rows of a table: times from −10 ms on in units of `second`, and columns of samples.
fn rows(second: f64, columns: usize, separator: char) -> String {
    (0..800)
        .map(|index| {
            let time_s = f64::from(index) * 1e-4 - 0.01;
            let mut cells = vec![format!("{:.5}", time_s * second)];
            let pulse = if (0.0..0.02).contains(&time_s) {
                -300.0
            } else {
                0.0
            };
            let sample = pulse * (time_s * 50.0 * std::f64::consts::PI).sin()
                + 0.02 * f64::from(index).sin();
            cells.extend((1..=columns).map(|column| format!("{:.4}", sample / column as f64)));
            cells.join(&separator.to_string()) + "\n"
        })
        .collect()
}

/// Checks the message, and that each command that it ends with is answered by a verdict.
#[track_caller]
fn check_one_message(name: &str, text: &str, options: &[&str], says: &str, commands: usize) {
    let folder = Folder::new("unnamed");
    folder.write(name, text);
    let begin = || {
        let mut command = program();
        command.current_dir(folder.path());
        command
    };
    let further = ["--members", "0", "--no-report"];
    let arguments = [&["replay", name], options, &further].concat();
    let done = finish(begin().args(arguments));
    assert_eq!((done.code, done.out.as_str()), (4, ""), "{}", done.err);
    // What a pass would wait for next is named with it.
    let direction = match options.contains(&"--opens-when") {
        true => "",
        false => "--opens-when negative|positive|both ",
    };
    let expected = format!(
        "latchgate: {name}:1: {says}. A pass may wait for more. State together: {direction}--transfer LO..HI. \
         latchgate init card {name} writes a card for all"
    );
    assert_eq!(done.err.lines().next(), Some(expected.as_str()));
    let lines: Vec<&str> = done.err.lines().skip(1).collect();
    assert_eq!(lines.len(), commands, "{}", done.err);
    for line in lines {
        let words = line.strip_prefix("  try: latchgate ").unwrap();
        let words = words.replace("--rate-hz HZ", "--rate-hz 10000");
        let done = finish(begin().args(words.split(' ')));
        assert!([0, 1, 3].contains(&done.code), "{line}: {}", done.err);
    }
}

#[test]
fn cli_a_table_of_numbers_alone_gets_one_message_with_commands_that_work() {
    let two = "two columns of numbers without names; state --skip-lines 0, --time-column 1 and --unit g|m/s2";
    check_one_message("x.csv", &rows(1.0, 1, ','), &[], two, 2);
    check_one_message("x.txt", &rows(1.0, 1, '\t'), &[], two, 2);
    check_one_message("x.txt", &rows(1.0, 1, ' '), &[], two, 2);
    check_one_message(
        "x.csv",
        &rows(1.0, 1, ';').replace('.', ","),
        &["--unit", "g"],
        "two columns of numbers without names; state --skip-lines 0 and --time-column 1",
        1,
    );
    check_one_message(
        "ms.csv",
        &rows(1e3, 1, ','),
        &["--unit", "g"],
        "two columns of numbers without names; state --skip-lines 0, --time-column 1 and --time-unit ms",
        1,
    );
    check_one_message(
        "three.csv",
        &rows(1.0, 2, ','),
        &[],
        "three columns of numbers without names; state --skip-lines 0, --time-column 1, --channel 2|3 and --unit g|m/s2",
        4,
    );
    let samples: String = rows(1.0, 1, ',')
        .lines()
        .map(|line| format!("{}\n", line.split_once(',').unwrap().1))
        .collect();
    check_one_message(
        "one.csv",
        &samples,
        &["--opens-when", "negative"],
        "one column of numbers without names; state --skip-lines 0, --rate-hz HZ, --channel 1 and --unit g|m/s2",
        2,
    );
    check_one_message(
        "one.csv",
        &samples,
        &["--rate-hz", "1e4", "--unit", "g"],
        "one column of numbers without names; state --skip-lines 0 and --channel 1",
        1,
    );
}

/// Comments above the numbers are passed over; words or names above them are another case.
#[test]
fn cli_what_stands_above_numbers_is_no_table_without_names() {
    let folder = Folder::new("unnamed-above");
    for (name, text, says) in [
        (
            "comment.csv",
            format!("# sled 7\n{}", rows(1.0, 1, ',')),
            "--skip-lines",
        ),
        (
            "words.csv",
            format!("sled 7, left\n{}", rows(1.0, 2, ',')),
            "header",
        ),
    ] {
        let path = folder.write(name, text);
        let done = finish(program().args(["replay", &path, "--no-report"]));
        assert_eq!(done.code, 4, "{}", done.out);
        assert!(done.err.contains(says), "{}", done.err);
    }
}
