//! Generated parts of pages: text between `<!-- NAME -->` and `<!-- /NAME -->`, each on a line of its own.

/// The page with everything between the two markers replaced. The text says which markers are missing.
pub(crate) fn replace(page: &str, name: &str, text: &str) -> Result<String, String> {
    let (start, end) = (format!("<!-- {name} -->\n"), format!("<!-- /{name} -->\n"));
    let parts = page.split_once(&start).and_then(|(before, rest)| Some((before, rest.split_once(&end)?.1)));
    let (before, after) = parts.ok_or_else(|| format!("has no lines {} and {}", start.trim(), end.trim()))?;
    Ok(format!("{before}{start}{text}{end}{after}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_block_is_replaced() {
        let page = "a\n<!-- table1 -->\nold\n<!-- /table1 -->\nb\n";
        assert_eq!(replace(page, "table1", "new\n").unwrap(), "a\n<!-- table1 -->\nnew\n<!-- /table1 -->\nb\n");
        assert!(replace("no markers", "table1", "new").is_err());
        assert!(replace("<!-- table1 -->\n", "table1", "new").is_err());
    }
}
