//! Formulas in a Chombo file: the group `Expressions`, which VisIt reads too.
//!
//! Each of its attributes is called after a kind and a name, `scalar pressure` or `vector velocity`, and holds a formula.

use crate::Definition;
use crate::hdf5::Hdf5Group;

/// Real files hold about ten.
const MOST: usize = 64;

/// The formulas for numbers and vectors. They only help to name what else could be written out: one that is damaged, or
/// the whole group, is as if it were not there.
pub(super) fn read(root: &Hdf5Group) -> Vec<Definition> {
    let Ok(Some(group)) = root.group("Expressions") else { return Vec::new() };
    let definition = |attribute: &str| {
        let name = ["scalar ", "vector "].iter().find_map(|kind| attribute.strip_prefix(kind))?;
        let formula = group.text(attribute).ok()??;
        let sound = !name.is_empty() && ![name, &formula].iter().any(|text| text.contains(char::is_control));
        sound.then(|| Definition { name: name.to_owned(), formula })
    };
    group.attribute_names().filter_map(definition).take(MOST).collect()
}
