//! The names of variables: `hydro_file_descriptor.txt`, in its older form (`variable # 1: density`) or the newer one
//! (`1, density, d`).

/// The names of so many variables. Numbers of two digits that overflowed are written as stars: the lines' order counts.
pub(super) fn names(text: &str, count: usize) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for name in text.lines().filter_map(name).take(count) {
        let name = name.replace(char::is_control, " ").trim().to_owned();
        let is_new = !name.is_empty() && !names.contains(&name);
        names.push(if is_new { name } else { unnamed(names.len()) });
    }
    names.extend((names.len()..count).map(unnamed));
    names
}

/// The name in a line that has one.
fn name(line: &str) -> Option<&str> {
    if let Some(variable) = line.trim_start().strip_prefix("variable #") {
        return variable.split_once(':').map(|(_, name)| name);
    }
    let mut words = line.split(',');
    let (number, name, _) = (words.next()?.trim(), words.next()?, words.next()?);
    (!number.starts_with('#')).then_some(name)
}

/// What a variable is called that has no name.
fn unnamed(place: usize) -> String {
    format!("variable_{}", place + 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_forms_and_none() {
        let old = "nvar        =          3\nvariable # 1: density\nvariable # 2: velocity_x\nvariable #**: B_left_x\n";
        assert_eq!(names(old, 4), ["density", "velocity_x", "B_left_x", "variable_4"]);
        let new = "# version:  1\n# ivar, variable_name, variable_type\n 1, density, d\n 2, density, d\n 3, , d\n";
        assert_eq!(names(new, 3), ["density", "variable_2", "variable_3"]);
        assert_eq!(names(new, 1), ["density"]);
        assert_eq!(names("", 2), ["variable_1", "variable_2"]);
    }
}
