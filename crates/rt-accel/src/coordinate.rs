//! One of three.

/// The coordinate that a plane is perpendicular to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) enum Coordinate {
    X,
    Y,
    Z,
}

impl Coordinate {
    pub(crate) const ALL: [Self; 3] = [Self::X, Self::Y, Self::Z];
}
