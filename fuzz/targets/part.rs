//! Content of the files of parts: decoded, checked, joined, and made an image of.

#![no_main]

use libfuzzer_sys::fuzz_target;
use rt_render::{Part, UncheckedPart};

/// Pixels of the largest image that is made: a short input may claim 2²⁸, which are legal and take gigabytes.
const MAX_BYTES: u64 = 1 << 24;

fuzz_target!(|bytes: &[u8]| {
    rt_fuzz::within_budget(|| {
        let Ok(unchecked) = postcard::from_bytes::<UncheckedPart>(bytes) else { return };
        let Ok(part) = unchecked.check() else { return };
        let missing = part.missing_tiles();
        if part.rendering_bytes() > MAX_BYTES {
            return;
        }
        let joined = Part::join(vec![part.clone()]);
        assert!(missing == 0 || joined.is_err(), "a part that lacks tiles is not an image");
        if let Ok(joined) = joined {
            assert!(joined.validate().is_ok(), "what is joined is sound");
        }
        assert!(!part.into_rendering().film.pixels().is_empty());
    });
});
