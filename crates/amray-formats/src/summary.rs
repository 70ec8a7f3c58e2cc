//! What is known of a data set once it is open.

use std::path::PathBuf;
use std::sync::Arc;

use amray::hierarchy::Hierarchy;

use crate::FieldInfo;

/// A data set without its values.
#[derive(Clone, Debug)]
pub struct Summary {
    /// The format's name, as in `amray info`.
    pub format: &'static str,
    /// The file that was opened, or the directory.
    pub path: PathBuf,
    /// The simulation time, where the file states it.
    pub time: Option<f64>,
    /// The mesh, shared by all fields.
    pub hierarchy: Arc<Hierarchy>,
    /// The fields, in the order of the file.
    pub fields: Vec<FieldInfo>,
    /// What is unusual about the data set but does not keep it from being rendered, a line each; what is unusual about
    /// its mesh, [`Hierarchy::warnings`] says.
    pub warnings: Vec<String>,
}
