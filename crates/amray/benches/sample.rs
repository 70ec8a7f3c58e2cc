//! Samples a second on one thread, sixteen points at a time and one by one, along rays and anywhere.

use std::sync::Arc;

use amray::hierarchy::{BrickValues, Field, FieldValues, Hierarchy, Normalisation};
use amray::index::Index;
use amray::reconstruction::{Method, PacketPoints, PacketSampler, PacketSamples, Sampler};
use amray::simd::InstructionSet;
use amray_testing::{explosion, random_packets, ray_packets};
use divan::Bencher;
use divan::counter::ItemsCount;

const PACKETS: usize = 1 << 14;
const LANES: usize = 16;
const NORMALISATION: Normalisation = Normalisation { low: 0.0, scale: 1.0 };

fn main() {
    divan::main();
}

type Points = fn(&Hierarchy, usize) -> Vec<PacketPoints>;

const RAYS: Points = ray_packets;
const ANYWHERE: Points = random_packets;

struct Case {
    index: Index,
    field: Field,
    packets: Vec<PacketPoints>,
}

impl Case {
    fn new(points: Points) -> Self {
        let (hierarchy, field): (Arc<Hierarchy>, _) = explosion();
        Self { packets: points(&hierarchy, PACKETS), index: Index::build(hierarchy), field }
    }

    fn bricks(&self) -> &[BrickValues<f32>] {
        match self.field.values() {
            FieldValues::F32(bricks) => bricks,
            FieldValues::F64(_) => unreachable!("the field holds f32"),
        }
    }
}

fn packets(bencher: Bencher, points: Points, method: Method, set: InstructionSet) {
    let case = Case::new(points);
    let sampler = PacketSampler::new(&case.index, case.bricks(), method, NORMALISATION);
    let mut samples = vec![PacketSamples { values: [0.0; LANES], levels: [0; LANES] }; PACKETS];
    bencher
        .counter(ItemsCount::new(PACKETS * LANES))
        .bench_local(|| sampler.sample_packets(set, &case.packets, &mut samples));
}

fn one_by_one(bencher: Bencher, points: Points, method: Method) {
    let case = Case::new(points);
    let sampler = Sampler::new(&case.index, case.bricks(), method);
    bencher.counter(ItemsCount::new(PACKETS * LANES)).bench_local(|| {
        let points = case.packets.iter().flat_map(|[x, y, z]| (0..LANES).map(|lane| [x[lane], y[lane], z[lane]]));
        points.map(|point| sampler.sample(point)).sum::<f64>()
    });
}

#[divan::bench(args = Method::ALL)]
fn rays_packets(bencher: Bencher, method: Method) {
    packets(bencher, RAYS, method, InstructionSet::best());
}

#[divan::bench(args = InstructionSet::available().into_iter().map(InstructionSet::name))]
fn rays_packets_current(bencher: Bencher, name: &str) {
    let set = InstructionSet::available().into_iter().find(|set| set.name() == name).expect("names come from there");
    packets(bencher, RAYS, Method::Current, set);
}

#[divan::bench(args = Method::ALL)]
fn rays_one_by_one(bencher: Bencher, method: Method) {
    one_by_one(bencher, RAYS, method);
}

#[divan::bench(args = Method::ALL)]
fn anywhere_packets(bencher: Bencher, method: Method) {
    packets(bencher, ANYWHERE, method, InstructionSet::best());
}

#[divan::bench(args = Method::ALL)]
fn anywhere_one_by_one(bencher: Bencher, method: Method) {
    one_by_one(bencher, ANYWHERE, method);
}
