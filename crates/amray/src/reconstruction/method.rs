//! The names of the reconstruction methods.

use std::fmt;
use std::str::FromStr;

use thiserror::Error;

use crate::hierarchy::Centering;

/// How cells become a continuous function. P is the point; the hat of a cell is the trilinear weight that falls from
/// 1 at its centre to 0 one cell width away; a virtual corner takes its closest existing cell.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Method {
    /// The value of the leaf cell that contains P.
    Nearest,
    /// Trilinear on the finest level present, wherever P lies.
    Finest,
    /// Trilinear on the level of the leaf cell that contains P; jumps where the level changes.
    Current,
    /// Every level's trilinear value, each weighed by how much of its dual cell is actual; continuous.
    Blend,
    /// The hats of all leaf cells of all levels, normalised; continuous.
    #[default]
    Basis,
    /// Trilinear in octants of leaf cells, whose corners adjoining cells share; continuous.
    Octant,
    /// Like blend, but virtual corners take the coarser levels' continuous function; exact for linear fields.
    Prolong,
    /// Trilinear on the nodes of the leaf cell that contains P: what volumes of node-centred fields have instead of the
    /// others.
    Nodal,
}

impl Method {
    /// The methods of cell-centred fields, which can be chosen, from the simplest on.
    pub const ALL: [Self; 7] =
        [Self::Nearest, Self::Finest, Self::Current, Self::Blend, Self::Basis, Self::Octant, Self::Prolong];

    /// Which fields the method is for.
    pub const fn centering(self) -> Centering {
        match self {
            Self::Nodal => Centering::Nodes,
            _ => Centering::Cells,
        }
    }

    /// The method's name on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Nearest => "nearest",
            Self::Finest => "finest",
            Self::Current => "current",
            Self::Blend => "blend",
            Self::Basis => "basis",
            Self::Octant => "octant",
            Self::Prolong => "prolong",
            Self::Nodal => "nodal",
        }
    }
}

/// A name that no method has.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("no reconstruction method {0:?}; the methods are {names}", names = Method::ALL.map(Method::name).join(", "))]
pub struct UnknownMethod(pub String);

impl FromStr for Method {
    type Err = UnknownMethod;

    fn from_str(name: &str) -> Result<Self, UnknownMethod> {
        Self::ALL.into_iter().find(|method| method.name() == name).ok_or_else(|| UnknownMethod(name.into()))
    }
}

impl fmt::Display for Method {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_round_trip() {
        for method in Method::ALL {
            assert_eq!(method.to_string().parse(), Ok(method));
        }
        let error = "linear".parse::<Method>().unwrap_err();
        assert!(error.to_string().ends_with("nearest, finest, current, blend, basis, octant, prolong"));
    }
}
