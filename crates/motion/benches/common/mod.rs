//! Rivals and clocks of the benches.

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

/// One contestant: its name and one step of it.
pub type Contestant<'a> = (&'static str, Box<dyn FnMut() + 'a>);

/// Medians of nanoseconds a step and of the ratio to the first contestant inside each round.
pub fn compare(n: usize, title: &str, bounds: &[Option<f64>], mut contestants: Vec<Contestant<'_>>) {
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
    let median = |mut values: Vec<f64>| {
        values.sort_by(f64::total_cmp);
        values[values.len() / 2]
    };
    for (who, (name, _)) in contestants.iter().enumerate() {
        let ratio = median(times[who].iter().zip(&times[0]).map(|(a, b)| a / b).collect());
        let bound = bounds[who].map_or(String::new(), |bound| {
            format!("  reach {bound:4.2}: {}", if ratio <= bound { "held" } else { "MISSED" })
        });
        println!(
            "{title:>22} {n:>9}  {name:<34} {:>14.1} ns  {ratio:6.3}{bound}",
            median(times[who].clone())
        );
    }
}
