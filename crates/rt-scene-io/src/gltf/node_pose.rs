//! Transforms of the nodes of a document and morph weights of its meshes, at rest or at a time of an animation.

use gltf::{Document, Mesh, Node, scene::Transform as Matrix};
use rt_math::{DMat3, DQuat, DVec3, Transform, TransformError};

use crate::LoadErrorKind;

/// Last row of an affine map.
const AFFINE_ROW: [f64; 4] = [0.0, 0.0, 0.0, 1.0];

/// Largest rounding error of an element of the last row.
const MAX_ROW_ERROR: f64 = 1e-6;

/// Transform of a node, from its matrix or from its translation, rotation and scale.
pub(super) fn transform(matrix: &Matrix) -> Result<Transform, TransformError> {
    match matrix {
        Matrix::Matrix { matrix } => {
            // Columns in the file.
            let mut rows: [[f64; 4]; 4] =
                std::array::from_fn(|row| std::array::from_fn(|column| f64::from(matrix[column][row])));
            let is_affine = rows[3].iter().zip(AFFINE_ROW).all(|(x, exact)| (x - exact).abs() <= MAX_ROW_ERROR);
            if is_affine {
                rows[3] = AFFINE_ROW;
            }
            Transform::from_rows(rows)
        }
        Matrix::Decomposed { translation, rotation, scale } => {
            let translation = DVec3::from(translation.map(f64::from));
            if !translation.is_finite() {
                return Err(TransformError::NonFinite);
            }
            let rotate = Transform::rotate_quaternion(DQuat::from_array(rotation.map(f64::from)))?;
            let scale = Transform::scale(DVec3::from(scale.map(f64::from)))?;
            Ok(Transform::translate(translation).compose(&rotate).compose(&scale))
        }
    }
}

/// Property of a node that a channel of an animation changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Property {
    Translation,
    Rotation,
    Scale,
    Weights,
}

impl Property {
    /// Property by its name in files.
    pub(super) fn of(path: &str) -> Option<Self> {
        match path {
            "translation" => Some(Self::Translation),
            "rotation" => Some(Self::Rotation),
            "scale" => Some(Self::Scale),
            "weights" => Some(Self::Weights),
            _ => None,
        }
    }

    /// Number of components; `None` where it is the number of morph targets.
    pub(super) const fn width(self) -> Option<usize> {
        match self {
            Self::Translation | Self::Scale => Some(3),
            Self::Rotation => Some(4),
            Self::Weights => None,
        }
    }
}

/// The state of all nodes, by their index.
pub(super) struct Pose {
    nodes: Vec<Posed>,
}

/// The states while the shutter is open.
pub(super) struct Poses<'a> {
    pub(super) opens: &'a Pose,
    /// Pose when the shutter closes, if different.
    pub(super) closes: Option<&'a Pose>,
}

struct Posed {
    matrix: Matrix,
    /// Morph weights that replace those of the mesh.
    weights: Option<Vec<f32>>,
}

impl Pose {
    /// Pose at rest.
    pub(super) fn rest(document: &Document) -> Self {
        let posed = |node: Node<'_>| Posed { matrix: node.transform(), weights: node.weights().map(<[f32]>::to_vec) };
        Self { nodes: document.nodes().map(posed).collect() }
    }

    /// Changes a node. A matrix cannot be animated.
    pub(super) fn set(&mut self, node: usize, property: Property, value: &[f64]) -> Result<(), LoadErrorKind> {
        let count = self.nodes.len();
        let rule = || format!("is not the index of a node; there are {count}");
        let posed = self.nodes.get_mut(node).ok_or_else(|| LoadErrorKind::invalid(node, rule()))?;
        let value: Vec<f32> = value.iter().map(|x| *x as f32).collect();
        match (property, &mut posed.matrix) {
            (Property::Weights, _) => posed.weights = Some(value),
            (_, Matrix::Matrix { .. }) => {
                return Err(LoadErrorKind::invalid(node, "is a node with a matrix, which cannot be animated"));
            }
            (Property::Translation, Matrix::Decomposed { translation, .. }) => translation.copy_from_slice(&value),
            (Property::Rotation, Matrix::Decomposed { rotation, .. }) => rotation.copy_from_slice(&value),
            (Property::Scale, Matrix::Decomposed { scale, .. }) => scale.copy_from_slice(&value),
        }
        Ok(())
    }

    /// Takes a node's space to its parent's.
    pub(super) fn matrix(&self, node: usize) -> Option<&Matrix> {
        self.nodes.get(node).map(|posed| &posed.matrix)
    }

    /// The weights of the morph targets of a mesh at a node, where they differ from those of the mesh.
    pub(super) fn weights(&self, node: &Node<'_>, mesh: &Mesh<'_>) -> Option<&[f32]> {
        let weights = self.nodes.get(node.index())?.weights.as_deref()?;
        (Some(weights) != mesh.weights()).then_some(weights)
    }

    /// The maps to the world, by the index of the node; `None` for nodes below themselves.
    pub(super) fn worlds(&self, document: &Document) -> Vec<Option<Affine>> {
        let mut worlds = vec![None; self.nodes.len()];
        let mut has_parent = vec![false; self.nodes.len()];
        document.nodes().flat_map(|node| node.children()).for_each(|child| has_parent[child.index()] = true);
        let mut open: Vec<(Node<'_>, Affine)> =
            document.nodes().filter(|node| !has_parent[node.index()]).map(|node| (node, Affine::IDENTITY)).collect();
        while let Some((node, parent)) = open.pop() {
            // A node with two parents is refused elsewhere; the first parent counts here.
            if worlds[node.index()].is_none() {
                let world = parent.compose(&Affine::of(&self.nodes[node.index()].matrix));
                worlds[node.index()] = Some(world);
                open.extend(node.children().map(|child| (child, world)));
            }
        }
        worlds
    }
}

/// Affine map, possibly singular: joints may be scaled to zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Affine {
    pub(super) linear: DMat3,
    pub(super) translation: DVec3,
}

impl Affine {
    pub(super) const IDENTITY: Self = Self { linear: DMat3::IDENTITY, translation: DVec3::ZERO };
    pub(super) const ZERO: Self = Self { linear: DMat3::ZERO, translation: DVec3::ZERO };

    /// The upper three rows of a matrix that is given by columns.
    pub(super) fn from_columns(columns: &[[f32; 4]; 4]) -> Self {
        let [x, y, z, w] = columns.map(|[x, y, z, _]| DVec3::new(x.into(), y.into(), z.into()));
        Self { linear: DMat3::from_cols(x, y, z), translation: w }
    }

    fn of(matrix: &Matrix) -> Self {
        match matrix {
            Matrix::Matrix { matrix } => Self::from_columns(matrix),
            Matrix::Decomposed { translation, rotation, scale } => {
                let rotation = DQuat::from_array(rotation.map(f64::from));
                let length = rotation.length();
                let rotation = if length > 0.0 { rotation / length } else { DQuat::IDENTITY };
                let scale = DMat3::from_diagonal(DVec3::from(scale.map(f64::from)));
                Self {
                    linear: DMat3::from_quat(rotation) * scale,
                    translation: DVec3::from(translation.map(f64::from)),
                }
            }
        }
    }

    /// The map that applies `first` and then this one.
    pub(super) fn compose(&self, first: &Self) -> Self {
        Self { linear: self.linear * first.linear, translation: self.point(first.translation) }
    }

    pub(super) fn point(&self, p: DVec3) -> DVec3 {
        self.linear * p + self.translation
    }
}
