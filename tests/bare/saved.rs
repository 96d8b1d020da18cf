//! A saved state of plain arrays.

use glam::DVec3;
use motion::Method;
use motion::arrays::Bare;

use super::{run, states};
use crate::rigs::{Environment, Net, Start, elastic};

#[test]
fn a_saved_state_is_gone_back_to() {
    let bodies = [2.0, 3.0].map(|w| Start::of(1.0, DVec3::new(0.48, 0.6, 0.64), DVec3::X * w));
    let net = Net {
        bodies: std::iter::once(Start::held(DVec3::ZERO)).chain(bodies).collect(),
        springs: vec![([0, 1], elastic(4.0, 0.0)), ([0, 2], elastic(9.0, 0.0))],
    };
    let around = Environment { substeps: Some(2), ..Environment::default() };
    for method in Method::ALL {
        let mut bare = Bare::of_world(
            &mut net.lab(&around, method, 1.0 / 60.0).world,
            method,
            &|_| Vec::new(),
            Vec::new(),
        )
        .unwrap();
        run(&mut bare, 10);
        let (saved, before) = (bare.save(), bare.time());
        run(&mut bare, 10);
        let (once, after) = (states(&bare), bare.time());
        bare.restore(&saved);
        assert_eq!(bare.time(), before);
        run(&mut bare, 10);
        assert_eq!((states(&bare), bare.time()), (once, after), "{method:?}");
    }
}
