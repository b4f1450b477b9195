//! What every contestant of benchmarks/compare.py speaks, for the examples in Rust; peers/protocol.py says the same for the
//! ones in Python.

use std::error::Error;
use std::io::BufRead;
use std::time::Instant;

/// Prints `ready`, then reads durations in seconds from standard input, one a line, and answers each with what was done
/// meanwhile as one line of JSON: `{"count": N, "seconds": S}`. `work` takes some milliseconds and returns how much it did.
///
/// # Errors
/// A line is no duration, or `work` failed.
pub fn serve<E: Error + 'static>(
    mut work: impl FnMut() -> Result<u32, E>,
) -> Result<(), Box<dyn Error>> {
    println!("ready");
    for line in std::io::stdin().lock().lines() {
        let line = line?;
        let seconds: f64 = line
            .trim()
            .parse()
            .map_err(|error| format!("'{line}', not a duration in seconds: {error}"))?;
        let start = Instant::now();
        let mut count = 0;
        while start.elapsed().as_secs_f64() < seconds {
            count += work()?;
        }
        let seconds = start.elapsed().as_secs_f64();
        println!("{{\"count\": {count}, \"seconds\": {seconds}}}");
    }
    Ok(())
}
