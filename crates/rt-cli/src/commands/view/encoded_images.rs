//! Image files on their way to pages: each is encoded once, for all connections that send it.

use std::sync::{Arc, Mutex, PoisonError, Weak};

use rt_image::{Development, Image, ImageFormat, write_image};

use super::http::{Response, Status};

/// Most files in memory. Pages that are slow to receive hold files of earlier versions.
const MAX_FILES: usize = 4;

/// Content of an image file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct FileKey {
    /// Version of the state that the image is of.
    pub(super) version: u64,
    pub(super) development: Development,
    pub(super) format: ImageFormat,
}

/// Files that connections are sending.
#[derive(Debug, Default)]
pub(super) struct EncodedImages(Mutex<Vec<(FileKey, Weak<Vec<u8>>)>>);

impl EncodedImages {
    /// Bytes of an image file. One file is encoded at a time.
    ///
    /// # Errors
    /// A refusal if too many other files are being sent, or the image cannot be encoded.
    pub(super) fn file(&self, key: FileKey, film: &Image) -> Result<Arc<Vec<u8>>, Response> {
        let mut files = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        files.retain(|(_, file)| file.strong_count() > 0);
        let known = files.iter().find(|(of, _)| *of == key);
        if let Some(file) = known.and_then(|(_, file)| file.upgrade()) {
            return Ok(file);
        }
        if files.len() >= MAX_FILES {
            return Err(Response::refusal(Status::BUSY, "503 Service Unavailable: too many images are being sent"));
        }
        let mut bytes = Vec::new();
        write_image(film, &key.development, key.format, &mut bytes)
            .map_err(|error| Response::refusal(Status::INTERNAL, &error.to_string()))?;
        let file = Arc::new(bytes);
        files.push((key, Arc::downgrade(&file)));
        Ok(file)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_shared_and_their_number_is_limited() {
        let (images, film) = (EncodedImages::default(), Image::new(2, 2, false));
        let file = |version: u64| {
            let key = FileKey { version, development: Development::default(), format: ImageFormat::Png };
            images.file(key, &film)
        };
        let first = file(0).expect("encoded");
        assert!(Arc::ptr_eq(&first, &file(0).expect("encoded")));
        let mut others: Vec<_> = (1..4).map(|version| file(version).expect("encoded")).collect();
        assert_eq!(file(4).expect_err("too many").status, Status::BUSY);
        assert!(Arc::ptr_eq(&first, &file(0).expect("known")));
        others.pop();
        file(4).expect("one was sent");
    }
}
