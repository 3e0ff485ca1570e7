//! Serialisation of accelerators, with checks on loading.

/// Implements serde's traits for an accelerator that derives them under `serde(remote = "Self")`. Loaded data must pass
/// `$check`, so that no traversal follows an invalid index; [`Accelerator::validate`](crate::Accelerator::validate)
/// checks that it fits the primitives.
macro_rules! impl_checked_serde {
    ($accelerator:ty, $check:expr $(, $($parameter:ident: $bound:path),+)?) => {
        impl $(<$($parameter: $bound + serde::Serialize),+>)? serde::Serialize for $accelerator {
            fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                Self::serialize(self, serializer)
            }
        }

        impl<'de $(, $($parameter: $bound + serde::Deserialize<'de>),+)?> serde::Deserialize<'de> for $accelerator {
            fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                let loaded = Self::deserialize(deserializer)?;
                $check(&loaded).map_err(serde::de::Error::custom)?;
                Ok(loaded)
            }
        }
    };
}

pub(crate) use impl_checked_serde;
