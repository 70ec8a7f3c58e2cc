//! A hierarchy like that of an explosion, for benchmarks: refined around a sphere, with a smooth field.

use std::sync::Arc;

use amray::hierarchy::{Field, Hierarchy, IndexBox, LevelDescription};
use amray::reconstruction::PacketPoints;

use crate::Random;

/// The sphere's radius, where the domain's side is 1.
const RADIUS: f64 = 0.3;

/// Three levels over the unit cube: 64^3 cells, and around a sphere bricks of 32^3 and 16^3 cells at ratio 2.
pub fn explosion() -> (Arc<Hierarchy>, Field) {
    let level = |level: u32, brick: i64, reach: f64| {
        let cells = 64i64 << level;
        let domain = IndexBox::new([0; 3], [cells; 3]);
        let size = brick as f64 / cells as f64;
        let is_near = |block: [i64; 3]| {
            let center = block.map(|index| (index as f64 + 0.5) * size - 0.5);
            (center.iter().map(|x| x * x).sum::<f64>().sqrt() - RADIUS).abs() < reach
        };
        let blocks = domain.coarsened([brick; 3]);
        let bricks = blocks.iter().filter(|&block| is_near(block));
        LevelDescription {
            ratio: [if level == 0 { 1 } else { 2 }; 3],
            cell_size: [1.0 / cells as f64; 3],
            domain,
            bricks: bricks.map(|low| IndexBox::new(low, low.map(|i| i + 1)).refined([brick; 3])).collect(),
        }
    };
    let levels = vec![level(0, 32, 9.0), level(1, 32, 0.22), level(2, 16, 0.04)];
    let hierarchy = Arc::new(Hierarchy::new([0.0; 3], levels).expect("blocks of a lattice are valid bricks"));
    let field = Field::from_fn("density", &hierarchy, |level, cell| {
        let [x, y, z] = hierarchy.to_world(level, cell.map(|index| index as f64 + 0.5)).map(|x| x - 0.5);
        let distance = (x * x + y * y + z * z).sqrt();
        let wrinkles = 0.02 * (31.0 * x).sin() * (23.0 * y).sin() * (27.0 * z).sin();
        (1.0 / (1.0 + ((distance - RADIUS + wrinkles) / 0.02).powi(2))) as f32
    });
    (hierarchy, field)
}

/// Packets of 4x4 neighbouring rays that march through the domain by a finest cell's width at a time, half a cell apart;
/// in cells of the finest level.
pub fn ray_packets(hierarchy: &Hierarchy, count: usize) -> Vec<PacketPoints> {
    const STEPS: usize = 128;
    let side = hierarchy.levels()[hierarchy.finest_level()].domain().size()[0] as f64;
    let mut random = Random(1);
    let mut packets = Vec::with_capacity(count);
    while packets.len() < count {
        let [across, up] = [random.unit(), random.unit()].map(|place| side * (0.05 + 0.7 * place));
        let slope = [random.unit(), random.unit()].map(|place| 0.3 * (place - 0.2));
        packets.extend((0..STEPS.min(count - packets.len())).map(|step| {
            let depth = side * (step as f64 + 0.5) / STEPS as f64;
            let ray = |lane: usize| [across + 0.5 * (lane % 4) as f64, up + 0.5 * (lane / 4) as f64];
            [
                std::array::from_fn(|lane| ray(lane)[0] + slope[0] * depth),
                std::array::from_fn(|lane| ray(lane)[1] + slope[1] * depth),
                [depth; 16],
            ]
        }));
    }
    packets
}

/// Packets of points anywhere in the domain, in cells of the finest level.
pub fn random_packets(hierarchy: &Hierarchy, count: usize) -> Vec<PacketPoints> {
    let side = hierarchy.levels()[hierarchy.finest_level()].domain().size()[0] as f64;
    let mut random = Random(2);
    (0..count).map(|_| [(); 3].map(|()| [(); 16].map(|()| side * random.unit()))).collect()
}
