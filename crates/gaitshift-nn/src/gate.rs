//! Waiting for another thread.

use crate::sync::{AtomicBool, Ordering, hint, thread};

/// Polls between yields of a thread that waits for a task of another.
const WAITING_SPINS: u32 = 2_000;

/// Polls until `condition` holds, which another thread is about to bring about.
pub fn spin_until(condition: impl Fn() -> bool) {
    let mut polls = 0;
    while !condition() {
        polls += 1;
        if polls % WAITING_SPINS == 0 {
            thread::yield_now();
        } else {
            hint::spin_loop();
        }
    }
}

/// Holds tasks of the second stage until one of the first is done.
#[derive(Debug)]
pub struct Gate(AtomicBool);

impl Default for Gate {
    fn default() -> Self {
        Self(AtomicBool::new(false))
    }
}

impl Gate {
    /// Until it is opened.
    pub fn close(&mut self) {
        self.0.store(false, Ordering::Relaxed);
    }

    /// Opens it when the result is dropped, at the end of the task, should it panic too.
    pub fn open_at_end(&self) -> impl Drop {
        struct Opener<'a>(&'a AtomicBool);
        impl Drop for Opener<'_> {
            fn drop(&mut self) {
                self.0.store(true, Ordering::Release);
            }
        }
        Opener(&self.0)
    }

    /// Waits for the gate to open. It does, because the thread that called [`crate::Workers::two_stages`] takes tasks of the
    /// first stage until none is left, whatever the others do.
    pub fn wait(&self) {
        spin_until(|| self.0.load(Ordering::Acquire));
    }
}
