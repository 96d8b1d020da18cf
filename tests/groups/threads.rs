//! Threads share the rows and springs of a large group and change no bit.

use glam::DVec3;
use motion::{DampingModel, Elastic, Method, Threads};

use crate::rigs::{Bits, Dice, Environment, Net, Start, net::H};

/// Points along the two edges of a cloth. Their product is not a multiple of what is computed at once.
const EDGES: [usize; 2] = [149, 137];

/// A cloth with damped springs to the right, down and across, and springs between points far apart: each end of these is
/// in the part of another thread. Some points are immovable.
fn cloth() -> Net {
    let [rows, columns] = EDGES;
    let mut dice = Dice(5);
    let point = |i: usize| Start {
        x: DVec3::new((i % columns) as f64, 0.0, (i / columns) as f64) + dice.vector() * 0.1,
        v: dice.vector(),
        w: if i.is_multiple_of(1999) { 0.0 } else { 1.0 },
    };
    let bodies: Vec<_> = (0..rows * columns).map(point).collect();
    let elastic = Elastic::new(200.0, 1.0).damped(0.5);
    let mut springs = Vec::new();
    for i in 0..bodies.len() {
        let (right, down) = (i % columns + 1 < columns, i + columns < bodies.len());
        springs.extend(right.then_some(([i, i + 1], elastic)));
        springs.extend(down.then_some(([i + columns, i], elastic)));
        springs.extend((right && down).then_some(([i, i + columns + 1], elastic)));
        let far = Elastic::new(1.0, 60.0);
        springs.extend((i % 100 == 7).then_some(([i, bodies.len() - 1 - i], far)));
    }
    Net { bodies, springs }
}

fn run(net: &Net, method: Method, threads: usize) -> Vec<Bits> {
    let damping = Some(motion::Damping { model: DampingModel::Exact, rate: 0.1 });
    let mut lab = net.lab(&Environment { damping, ..Environment::falling() }, method, H);
    lab.world.insert_resource(Threads::new(threads));
    for tick in 0..3 {
        lab.push(1, DVec3::X * 30.0);
        lab.push(EDGES[0] * EDGES[1] - 2, DVec3::Y * f64::from(tick));
        lab.run(1);
    }
    lab.all_bits(&[])
}

#[test]
fn a_large_net_has_the_same_bits_with_any_number_of_threads() {
    let net = cloth();
    assert!(net.bodies.len() > Threads::FROM);
    for method in Method::ALL {
        let one = run(&net, method, 1);
        for threads in [2, 3] {
            assert!(one == run(&net, method, threads), "{method:?} with {threads} threads");
        }
    }
}
