//! Whatever is asked of a world: everything in it stays finite, a body that is quarantined changes no bit of any other, and a
//! second run has the bits of the first.

use arbitrary::{Result, Unstructured};
use bevy_ecs::prelude::*;
use glam::DVec3;
use history::Simulation;
use motion::effects::Effect;
use motion::internals::compile_groups;
use motion::{
    Damping, DampingModel, Fault, Method, PhysicsBody, Quarantine, Request, StableId, Transform,
};
use scene::{Scene, unsolvable};

use super::numbers::{any, any_vector, at_least_0};
use super::scenes;

/// Ticks of a run.
const TICKS: u64 = 16;

/// What acts from outside.
#[derive(Clone, Copy, Debug)]
enum Event {
    Push(u32, DVec3),
    Ask(Request<u32>),
    Method(Method),
}

/// Bits of position and velocity; nothing where there is no such body.
type Bits = Option<[u64; 6]>;

/// What a run came to.
#[derive(Debug, PartialEq)]
struct Trace {
    /// After each tick, by stable id.
    states: Vec<Vec<Bits>>,
    quarantined: Vec<Frozen>,
}

/// Who was quarantined, and in which tick.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Frozen {
    body: u32,
    tick: u64,
    by: By,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum By {
    Request,
    /// Its group, which restarted for a change of method, of laws or of another body, as the others then have.
    Change,
    Step,
    /// The step of what cannot be moved: in that tick it has still held what hangs on it.
    StepOfHeld,
}

/// A random scene with pushes and requests of any size.
pub fn step(bytes: &[u8]) {
    let mut u = Unstructured::new(bytes);
    let Ok(text) = scenes::text(&mut u) else { return };
    let Ok(scene) = Scene::parse("any", &text) else { return };
    let Ok(events) = events(&mut u, &scene) else { return };
    let first = run(&scene, &events, &[]);
    let context = || format!("{text}\n{events:?}\n{:?}", first.quarantined);
    // A body that fails while its group restarts leaves the group restarted: there is no run without it to compare with.
    if first.quarantined.is_empty()
        || first.quarantined.iter().any(|quarantined| quarantined.by == By::Change)
    {
        assert!(run(&scene, &events, &[]) == first, "two runs differ: {}", context());
        return;
    }
    let (held, gone): (Vec<_>, Vec<_>) =
        first.quarantined.iter().copied().partition(|quarantined| quarantined.by == By::StepOfHeld);
    let without = run(&scene, &events, &gone);
    assert!(
        without.quarantined == held,
        "{:?} are quarantined without the others: {}",
        without.quarantined,
        context()
    );
    for (tick, (with, without)) in (1..).zip(first.states.iter().zip(&without.states)) {
        for (id, (with, without)) in (0..).zip(with.iter().zip(without)) {
            let gone =
                gone.iter().any(|quarantined| quarantined.body == id && quarantined.tick <= tick);
            let numbers = |bits: &Bits| bits.map(|bits| bits.map(f64::from_bits));
            assert!(
                gone || with == without,
                "body {id} noticed it in tick {tick}: {:?} instead of {:?}\n{}",
                numbers(with),
                numbers(without),
                context()
            );
        }
    }
}

fn events(u: &mut Unstructured<'_>, scene: &Scene) -> Result<Vec<(u64, Event)>> {
    let bodies: u32 = scene.bodies.len().try_into().expect("scenes of targets are small");
    let mut events = Vec::new();
    for tick in 1..=TICKS {
        if u.ratio(1, 4)? {
            let body = u.int_in_range(0..=bodies - 1)?;
            events.push((tick, event(u, body, scene)?));
        }
    }
    Ok(events)
}

fn event(u: &mut Unstructured<'_>, body: u32, scene: &Scene) -> Result<Event> {
    let methods =
        Method::ALL.map(|method| (method, unsolvable(method, scene.mutual_gravity.is_some())));
    let method = |u: &mut Unstructured<'_>| {
        let (method, why_not) = u.choose(&methods)?;
        Ok(if why_not.is_some() { scene.method } else { *method })
    };
    Ok(match u.int_in_range(0..=12)? {
        0..=3 => Event::Push(body, any_vector(u)?),
        4 => Event::Ask(Request::Impulse(body, any_vector(u)?)),
        5 => Event::Ask(Request::SetVelocity(body, any_vector(u)?)),
        6 => Event::Ask(Request::SetPosition(body, any_vector(u)?)),
        7 => Event::Ask(Request::SetInverseMass(body, at_least_0(u)?)),
        8 => Event::Ask(Request::SetGravity(any_vector(u)?)),
        9 => {
            let model = *u.choose(&DampingModel::ALL)?;
            Event::Ask(Request::SetDamping(Damping {
                model,
                rate: if u.ratio(1, 2)? { at_least_0(u)? } else { any(u)?.abs() },
            }))
        }
        10 => match u.int_in_range(0..=3)? {
            0 => Event::Ask(Request::ReverseVelocities),
            1 => Event::Ask(Request::Remove(body)),
            _ => Event::Ask(Request::Switch(*u.choose(&Effect::ALL)?, u.ratio(1, 2)?)),
        },
        11 => {
            let own = if u.ratio(1, 3)? { None } else { Some(method(u)?) };
            Event::Ask(Request::SetBodyMethod(body, own))
        }
        _ => Event::Method(method(u)?),
    })
}

/// A run in which the bodies `removed` are taken out in the ticks that they would not survive.
fn run(scene: &Scene, events: &[(u64, Event)], removed: &[Frozen]) -> Trace {
    let mut run = Simulation::new(scene.clone());
    let bodies = run.bodies.clone();
    let body = |id: u32| bodies[id as usize];
    let (mut states, mut quarantined, mut seen) = (Vec::new(), Vec::new(), 0);
    for tick in 1..=TICKS {
        let goes = |id: u32| removed.iter().any(|gone| gone.body == id && gone.tick == tick);
        let asked_to_go = |id: u32| removed.contains(&Frozen { body: id, tick, by: By::Request });
        let going = |by: By| removed.iter().filter(move |gone| gone.tick == tick && gone.by == by);
        for (_, event) in events.iter().filter(|(at, _)| *at == tick) {
            match *event {
                Event::Push(id, newtons) if !goes(id) => {
                    run.push(body(id), newtons);
                }
                Event::Push(..) => {}
                Event::Ask(request) => {
                    // The request that quarantined it is not carried out; one that quarantined it only later is.
                    let request = request.rename(|id| (!asked_to_go(id)).then(|| body(id)));
                    if let Some(request) = request {
                        run.request(request);
                    }
                }
                Event::Method(method) => run.set_method(method),
            }
        }
        for gone in going(By::Request) {
            run.request(Request::Remove(body(gone.body)));
        }
        run.carry_out_requests();
        quarantined.extend(news(&run.world, &mut seen, By::Change));
        if going(By::Step).next().is_some() {
            // Who quarantined in the step was there before it: who joined its group has its method.
            compile_groups(&mut run.world);
            going(By::Step).for_each(|gone| {
                run.world.despawn(body(gone.body));
            });
        }
        run.tick();
        assert_finite(&mut run.world);
        states.push(bodies.iter().map(|body| bits(&run.world, *body)).collect());
        quarantined.extend(news(&run.world, &mut seen, By::Step));
    }
    Trace { states, quarantined }
}

/// Who was quarantined since the first `seen` records, by a request or else by `by`.
fn news(world: &World, seen: &mut usize, by: By) -> Vec<Frozen> {
    let records = &world.resource::<Quarantine>().records()[*seen..];
    *seen += records.len();
    let news = records.iter().filter_map(|record| {
        let held =
            world.get::<PhysicsBody>(record.body).is_some_and(|body| body.inverse_mass == 0.0);
        let by = match record.cause.system {
            _ if record.cause.fault == Fault::Request => By::Request,
            "integrate_groups" => by,
            _ if held && by == By::Step => By::StepOfHeld,
            _ => by,
        };
        Some(Frozen { body: record.id?.0, tick: record.tick, by })
    });
    news.collect()
}

fn bits(world: &World, body: Entity) -> Bits {
    let body = world.get_entity(body).ok()?;
    let [x, y, z] = body.get::<Transform>()?.position.to_array().map(f64::to_bits);
    let [a, b, c] = body.get::<PhysicsBody>()?.velocity.to_array().map(f64::to_bits);
    Some([x, y, z, a, b, c])
}

/// Fails if a number of any body is not finite, quarantined or not.
pub fn assert_finite(world: &mut World) {
    for (id, transform, body) in
        world.query::<(Option<&StableId>, &Transform, &PhysicsBody)>().iter(world)
    {
        let finite = transform.position.is_finite()
            && body.velocity.is_finite()
            && body.inverse_mass.is_finite();
        assert!(finite, "{id:?} has {transform:?}, {body:?}");
    }
}
