//! Boxes cut into bricks.

use amray::hierarchy::IndexBox;

/// `cells`, cut into cubes of `side` cells on the lattice through the origin; what sticks out is left away.
pub fn tiles(cells: &IndexBox, side: i64) -> Vec<IndexBox> {
    let tile = |place: [i64; 3]| IndexBox::new(place, place.map(|index| index + 1)).refined([side; 3]);
    cells.coarsened([side; 3]).iter().map(|place| tile(place).intersection(cells)).collect()
}
