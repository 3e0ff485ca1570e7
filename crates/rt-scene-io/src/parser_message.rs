//! Messages of parsers of other crates in words of the format: offending text, and what is expected.

/// Message of serde about a value of the wrong type; other messages stay as they are.
pub(crate) fn plain(message: &str) -> String {
    if message.starts_with("EOF while parsing") {
        return "the file ends too early".to_owned();
    }
    let wrong = ["invalid type: ", "invalid value: "].iter().find_map(|start| message.strip_prefix(start));
    match wrong.and_then(|wrong| wrong.rsplit_once(", expected ")) {
        Some((found, expected)) => format!("found {}, expected {}", found_value(found), expected_value(expected)),
        None => message.to_owned(),
    }
}

fn found_value(found: &str) -> &str {
    match found {
        "sequence" => "a list",
        "map" => "an object",
        // The kind stands before the value, which is quoted.
        _ => found.find(['`', '"']).map_or(found, |start| &found[start..]),
    }
}

fn expected_value(expected: &str) -> &str {
    match expected {
        "index into child of root" => "the index of an entry: a whole number from 0 up",
        "u8" | "u16" | "u32" | "u64" | "usize" => "a whole number from 0 up",
        "i8" | "i16" | "i32" | "i64" => "a whole number",
        "f32" | "f64" => "a number",
        "a string" | "a borrowed string" => "text in double quotes",
        "a boolean" => "true or false",
        "a sequence" => "a list",
        "a map" => "an object",
        _ if expected.starts_with("struct ") => "an object",
        _ => expected,
    }
}

#[cfg(test)]
mod tests {
    use super::plain;

    #[test]
    fn messages_have_the_value_and_the_expected_kind() {
        for (message, words) in [
            (
                "invalid type: integer `-1`, expected index into child of root",
                "found `-1`, expected the index of an entry: a whole number from 0 up",
            ),
            ("invalid type: string \"a, expected b\", expected f32", "found \"a, expected b\", expected a number"),
            ("invalid value: integer `-2`, expected u32", "found `-2`, expected a whole number from 0 up"),
            ("invalid type: map, expected a sequence", "found an object, expected a list"),
            ("invalid type: null, expected struct Node", "found null, expected an object"),
            ("EOF while parsing a value", "the file ends too early"),
            ("missing field `asset`", "missing field `asset`"),
        ] {
            assert_eq!(plain(message), words);
        }
    }
}
