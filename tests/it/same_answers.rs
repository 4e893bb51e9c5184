//! Guards the program behind `tests/same-answers`: it must see what differs, and only that.

#[allow(dead_code, reason = "only its comparison is tested")]
#[path = "../../examples/same_answers.rs"]
mod program;

/// The differences that the program tells between two documents, as `what path`.
fn told(before: &str, after: &str) -> Vec<String> {
    program::told("stdout", before.as_bytes(), after.as_bytes())
}

#[test]
fn tidy_same_answers_sees_each_difference_of_two_documents() {
    let before =
        r#"{"a": {"b": [1.0, {"c": "x, \"y\"", "d": null}]}, "e": [], "run": {"elapsed_s": 1}}"#;
    let check = |from: &str, to: &str, expected: &[&str]| {
        let after = before.replace(from, to);
        assert_ne!(after, before);
        assert_eq!(told(before, &after), expected, "{after}");
    };
    assert!(told(before, before).is_empty());
    check("\"elapsed_s\": 1", "\"elapsed_s\": 2", &[]);
    check("1.0", "1", &["changed a.b[]"]);
    check("\\\"y", "\\\"z", &["changed a.b[].c"]);
    check("null", "false", &["changed a.b[].d"]);
    check(", \"d\": null", "", &["removed a.b[].d"]);
    check("[]", "[], \"f\": 1", &["added f"]);
    check("[]", "[1]", &["changed e[]"]);
    check("\"e\": []", "\"f\": []", &["removed e", "added f"]);
    check("[1.0, {", "{\"g\": {", &["changed stdout"]);
    check("1.0, ", "1.0,\n", &["changed layout of the document"]);
    let turned = r#"{"e": [], "a": {"b": [1.0, {"c": "x, \"y\"", "d": null}]}}"#;
    assert_eq!(told(before, turned), ["changed (order of keys)"]);
}

#[test]
fn tidy_same_answers_sees_each_difference_of_two_texts() {
    assert_eq!(told("one\ntwo\n", "one\nthree\n"), ["changed stdout"]);
    assert_eq!(told("one\ntwo\n", "one\n"), ["changed stdout"]);
    assert_eq!(told("one\n", "one"), ["changed stdout, line ends"]);
    assert!(told("one\n", "one\n").is_empty());
}
