//! Name of the processor, for reports of measured times.

/// Name of the processor from `/proc/cpuinfo` of Linux; its architecture on other systems.
pub(crate) fn processor() -> String {
    let info = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    model_name(&info).unwrap_or(std::env::consts::ARCH).to_owned()
}

/// Model name of the first processor in the list.
fn model_name(info: &str) -> Option<&str> {
    let (_, name) = info.lines().find_map(|line| line.strip_prefix("model name")?.split_once(':'))?;
    Some(name.trim()).filter(|name| !name.is_empty())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_processor_gives_its_name() {
        let list = "processor\t: 0\nmodel\t\t: 85\nmodel name\t: Quick 9 @ 3:2\n\nmodel name\t: Slow 1\n";
        assert_eq!(model_name(list), Some("Quick 9 @ 3:2"));
        for nameless in ["", "processor\t: 0\nBogoMIPS\t: 50\n", "model name\t: \n"] {
            assert_eq!(model_name(nameless), None, "{nameless:?}");
        }
    }

    #[test]
    fn every_machine_has_a_name() {
        assert!(!processor().is_empty());
    }
}
