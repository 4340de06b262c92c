//! Wall and CPU time of an operation, beside other programs' figures.

use serde_json::Value;
use std::time::Instant;

/// Median milliseconds.
#[derive(Clone, Copy, Debug)]
pub struct Time {
    pub wall: f64,
    pub cpu: f64,
}

/// Prints rows and knows the peers' figures.
pub struct Report {
    peers: Vec<Value>,
}

fn cpu_ms() -> f64 {
    let t = rustix::time::clock_gettime(rustix::time::ClockId::ProcessCPUTime);
    t.tv_sec as f64 * 1e3 + t.tv_nsec as f64 * 1e-6
}

impl Time {
    /// Of runs that were measured one by one.
    pub fn median(times: Vec<Self>) -> Self {
        Self {
            wall: median(times.iter().map(|t| t.wall).collect()),
            cpu: median(times.iter().map(|t| t.cpu).collect()),
        }
    }
}

/// The middle one.
pub fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// Runs `operation` `warm + count` times, numbered from 0, and times the last `count`.
pub fn measure<E>(warm: usize, count: usize, mut operation: impl FnMut(usize) -> Result<(), E>) -> Result<Time, E> {
    let [time] = measure_by_turns(warm, count, |_, i| operation(i))?;
    Ok(time)
}

/// The same for `N` operations that take turns, so that what slows the machine for a while slows them all.
pub fn measure_by_turns<const N: usize, E>(
    warm: usize,
    count: usize,
    mut operation: impl FnMut(usize, usize) -> Result<(), E>,
) -> Result<[Time; N], E> {
    let mut times = [const { Vec::new() }; N];
    for i in 0..warm + count {
        for (which, times) in times.iter_mut().enumerate() {
            let (start, cpu_start) = (Instant::now(), cpu_ms());
            operation(which, i)?;
            if i >= warm {
                times.push(Time { wall: start.elapsed().as_secs_f64() * 1e3, cpu: cpu_ms() - cpu_start });
            }
        }
    }
    Ok(times.map(Time::median))
}

impl Report {
    pub fn new() -> Self {
        let mut peers = Vec::new();
        if let Some(dir) = std::env::var_os("BURIN_PEERS")
            && let Ok(entries) = std::fs::read_dir(dir)
        {
            for path in entries.flatten().map(|e| e.path()).filter(|p| p.extension().is_some_and(|e| e == "jsonl")) {
                let text = std::fs::read_to_string(path).unwrap_or_default();
                peers.extend(text.lines().filter_map(|l| serde_json::from_str(l).ok()));
            }
        }
        println!("{:<44} {:>10} {:>10}   beside", "operation", "wall ms", "CPU ms");
        Self { peers }
    }

    /// A row without a peer.
    pub fn row(&self, name: &str, time: Time, beside: &str) {
        println!("{name:<44} {:>10.1} {:>10.1}   {beside}", time.wall, time.cpu);
    }

    /// A row beside the peer whose result has all these values; `wall` compares wall time instead of CPU time.
    pub fn beside(&self, name: &str, time: Time, peer: &str, keys: &[(&str, Value)], wall: bool) {
        let field = if wall { "median_ms" } else { "cpu_median_ms" };
        let figure =
            self.peers.iter().find(|r| keys.iter().all(|(k, v)| r.get(k) == Some(v))).and_then(|r| r[field].as_f64());
        let own = if wall { time.wall } else { time.cpu };
        let unit = if wall { "wall" } else { "CPU" };
        let text = match figure {
            Some(figure) => format!("{:.2} of {peer} ({figure:.0} ms {unit})", own / figure),
            None => String::new(),
        };
        self.row(name, time, &text);
    }

    /// A line of words.
    pub fn note(&self, text: &str) {
        println!("{text}");
    }
}
