//! Rivals and clocks of the benches.

use std::sync::Once;

use cpu_time::ThreadTime;

/// A function in the instructions that the kernels may use as well.
#[allow(unused_macros, reason = "not every bench has a rival for all bodies")]
macro_rules! avx2_or_plain {
    (fn $name:ident($($argument:ident: $type:ty),*) $body:block) => {
        fn $name($($argument: $type),*) {
            #[cfg(target_arch = "x86_64")]
            {
                #[target_feature(enable = "avx2")]
                fn avx2($($argument: $type),*) $body
                if std::arch::is_x86_feature_detected!("avx2") {
                    #[expect(unsafe_code, reason = "detected in the line above; the rival gets what the kernels get")]
                    // SAFETY: AVX2 was detected.
                    unsafe { avx2($($argument),*) }
                    return;
                }
            }
            $body
        }
    };
}
#[allow(unused_imports, reason = "not every bench has a rival for all bodies")]
pub(crate) use avx2_or_plain;

/// Gives this thread real-time priority, if it may: times then agree better on a shared machine. Says so.
fn take_real_time_priority() {
    #[cfg(target_os = "linux")]
    {
        use thread_priority::{
            RealtimeThreadSchedulePolicy, ThreadPriority, ThreadSchedulePolicy,
            set_thread_priority_and_policy, thread_native_id,
        };
        let policy = ThreadSchedulePolicy::Realtime(RealtimeThreadSchedulePolicy::Fifo);
        let lowest = ThreadPriority::Crossplatform(1.try_into().expect("in range"));
        match set_thread_priority_and_policy(thread_native_id(), lowest, policy) {
            Ok(()) => println!("with real-time priority"),
            Err(_) => {
                println!(
                    "without real-time priority: as root, or with `sudo chrt -f 1`, times agree better"
                );
            }
        }
    }
}

/// One contestant: its name and one step of it.
pub type Contestant<'a> = (&'static str, Box<dyn FnMut() + 'a>);

/// Medians of nanoseconds per step and of the ratio to the first contestant inside each round, with the quartiles of the
/// ratios.
pub fn compare(
    n: usize,
    title: &str,
    bounds: &[Option<f64>],
    mut contestants: Vec<Contestant<'_>>,
) {
    static PRIORITY: Once = Once::new();
    PRIORITY.call_once(take_real_time_priority);
    let steps = (2_000_000 / n).clamp(1, 20_000);
    let rounds = 21;
    let mut times = vec![Vec::new(); contestants.len()];
    for (_, step) in &mut contestants {
        (0..steps.min(200)).for_each(|_| step());
    }
    for round in 0..rounds {
        let mut took = vec![0.0; contestants.len()];
        for turn in 0..contestants.len() {
            let who = (round + turn) % contestants.len();
            let clock = ThreadTime::now();
            for _ in 0..steps {
                contestants[who].1();
            }
            #[expect(clippy::cast_precision_loss, reason = "a count of steps")]
            {
                took[who] = clock.elapsed().as_secs_f64() * 1e9 / steps as f64;
            }
        }
        took.into_iter().zip(&mut times).for_each(|(t, times)| times.push(t));
    }
    let quartiles = |mut values: Vec<f64>| {
        values.sort_by(f64::total_cmp);
        [1, 2, 3].map(|quarter| values[quarter * (values.len() - 1) / 4])
    };
    for (who, (name, _)) in contestants.iter().enumerate() {
        let ratios = times[who].iter().zip(&times[0]).map(|(a, b)| a / b).collect();
        let [low, ratio, high] = quartiles(ratios);
        let bound = bounds[who].map_or(String::new(), |bound| {
            format!("  reach {bound:4.2}: {}", if ratio <= bound { "held" } else { "MISSED" })
        });
        println!(
            "{title:>22} {n:>9}  {name:<34} {:>14.1} ns  {ratio:6.3} ({low:.3} to {high:.3}){bound}",
            quartiles(times[who].clone())[1]
        );
    }
}
