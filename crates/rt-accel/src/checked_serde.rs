//! Saving structures, and loading them again without trusting what is loaded.

/// Implements serde's traits for a structure that derives them under `serde(remote = "Self")`: what is loaded must pass
/// a check, so that no walk ever follows a number that leads nowhere. That it fits the primitives is for
/// [`Accelerator::validate`](crate::Accelerator::validate) to say.
macro_rules! impl_checked_serde {
    ($structure:ty, $check:expr $(, $($parameter:ident: $bound:path),+)?) => {
        impl $(<$($parameter: $bound + serde::Serialize),+>)? serde::Serialize for $structure {
            fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                Self::serialize(self, serializer)
            }
        }

        impl<'de $(, $($parameter: $bound + serde::Deserialize<'de>),+)?> serde::Deserialize<'de> for $structure {
            fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                let loaded = Self::deserialize(deserializer)?;
                $check(&loaded).map_err(serde::de::Error::custom)?;
                Ok(loaded)
            }
        }
    };
}

pub(crate) use impl_checked_serde;
