//! Persistent worker threads that share out numbered tasks.
//!
//! An update takes well under a millisecond, so threads cannot be spawned inside it. Workers wait by
//! spinning for a moment (the next phase of an update follows within microseconds), then by yielding, then
//! they park, so that an idle learner does not burn a core. The calling thread works too and never
//! waits for a worker that sleeps: it only waits for tasks already begun.
//!
//! Tasks come in stages. A thread goes on to the next stage as soon as no task of this one is left to take, while others
//! still work on theirs, so that nobody waits for the slowest thread more than once in a call; a task that needs the
//! result of another waits for that one.
//!
//! Half of the threads take tasks from the front, half from the back, so that with two of them a task finds its memory
//! mostly in the cache of the core that ran it last time. Beyond that, which thread runs a task is left to chance; results
//! must not depend on it, and do not, because each task owns what it writes and sums over tasks are taken in task order.

use std::panic::{AssertUnwindSafe, catch_unwind};

use crate::disjoint::Disjoint;
use crate::gate::{Gate, spin_until};
use crate::sync::{
    Arc, AtomicBool, AtomicU64, AtomicUsize, JoinHandle, Ordering, UnsafeCell, hint, thread,
};

/// Polls before a worker starts to yield, some hundreds of microseconds: between two updates an environment may take a step.
const SPINS: u32 = 20_000;
/// Yields before a worker parks.
const YIELDS: u32 = 20;

/// Stages of one call, some of which may be empty.
const STAGES: usize = 2;

/// Called with the number of the thread, the stage and the task within it.
type StagedTask<'a> = dyn Fn(usize, usize, usize) + Sync + 'a;
type Task = *const StagedTask<'static>;

struct Shared {
    /// For each stage the tasks not yet taken: the end in the upper 32 bits, the start in the lower.
    tickets: [AtomicU64; STAGES],
    task: UnsafeCell<Option<Task>>,
    done: AtomicUsize,
    panicked: AtomicBool,
    stop: AtomicBool,
    sleeping: Vec<AtomicBool>,
}

// SAFETY: `task` is written only while no claim of the previous call is outstanding, and read only under
// a valid claim; the pointee is `Sync`.
unsafe impl Sync for Shared {}
// SAFETY: as above.
unsafe impl Send for Shared {}

impl Shared {
    /// Runs one task, of the first stage that has one left.
    fn work(&self, thread: usize) -> bool {
        (0..STAGES).any(|stage| self.work_on(thread, stage))
    }

    /// Runs one task of a stage if one is left.
    fn work_on(&self, thread: usize, stage: usize) -> bool {
        let ticket = &self.tickets[stage];
        let mut current = ticket.load(Ordering::Acquire);
        loop {
            let Some((start, end)) = left(current) else {
                return false;
            };
            let (taken, rest) = if thread.is_multiple_of(2) {
                (start, ticket_of(start + 1, end))
            } else {
                (end - 1, ticket_of(start, end - 1))
            };
            match ticket.compare_exchange_weak(current, rest, Ordering::AcqRel, Ordering::Acquire) {
                Err(changed) => current = changed,
                Ok(_) => {
                    // SAFETY: the claimed task is not done, so `run_stages` has not returned: the pointer was
                    // written before the ticket was published and its pointee is alive.
                    let task = self.task.with(|task| unsafe { (*task).map(|task| &*task) });
                    let outcome = catch_unwind(AssertUnwindSafe(|| {
                        if let Some(task) = task {
                            task(thread, stage, taken as usize);
                        }
                    }));
                    if outcome.is_err() {
                        self.panicked.store(true, Ordering::Relaxed);
                    }
                    self.done.fetch_add(1, Ordering::Release);
                    return true;
                }
            }
        }
    }

    fn wait_for_work(&self, worker: usize) {
        let mut idle = 0;
        while !self.stop.load(Ordering::Relaxed) {
            if self.work(worker + 1) {
                idle = 0;
                continue;
            }
            idle += 1;
            if idle < SPINS {
                hint::spin_loop();
            } else if idle < SPINS + YIELDS {
                thread::yield_now();
            } else {
                // Announce sleep, then look once more: either this look sees the new ticket or the
                // publisher sees the announcement.
                self.sleeping[worker].store(true, Ordering::SeqCst);
                let left = self
                    .tickets
                    .iter()
                    .any(|ticket| left(ticket.load(Ordering::SeqCst)).is_some());
                if !left && !self.stop.load(Ordering::SeqCst) {
                    thread::park();
                }
                self.sleeping[worker].store(false, Ordering::SeqCst);
                idle = 0;
            }
        }
    }
}

/// The tasks `start..end`.
fn ticket_of(start: u32, end: u32) -> u64 {
    u64::from(end) << 32 | u64::from(start)
}

/// Start and end of the tasks that a ticket has left.
fn left(ticket: u64) -> Option<(u32, u32)> {
    let (start, end) = (ticket as u32, (ticket >> 32) as u32);
    (start < end).then_some((start, end))
}

/// A team of `threads` threads, the calling one included.
pub struct Workers {
    shared: Arc<Shared>,
    handles: Vec<JoinHandle<()>>,
    gates: Vec<Gate>,
}

impl std::fmt::Debug for Workers {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter
            .debug_struct("Workers")
            .field("threads", &self.threads())
            .finish()
    }
}

impl Workers {
    /// Starts `threads - 1` workers. Where the system refuses a thread the team is smaller, which changes
    /// the speed and nothing else.
    pub fn new(threads: usize) -> Self {
        let workers = threads.saturating_sub(1);
        let shared = Arc::new(Shared {
            tickets: Default::default(),
            task: UnsafeCell::new(None),
            done: AtomicUsize::new(0),
            panicked: AtomicBool::new(false),
            stop: AtomicBool::new(false),
            sleeping: (0..workers).map(|_| AtomicBool::new(false)).collect(),
        });
        let handles = (0..workers)
            .map_while(|worker| {
                let shared = Arc::clone(&shared);
                thread::Builder::new()
                    .name(format!("worker-{worker}"))
                    .spawn(move || shared.wait_for_work(worker))
                    .ok()
            })
            .collect();
        Self {
            shared,
            handles,
            gates: Vec::new(),
        }
    }

    /// Threads in the team.
    pub fn threads(&self) -> usize {
        self.handles.len() + 1
    }

    /// Calls `task` once for each number below `tasks`, on whichever thread is free, and returns when
    /// all are done. Takes `&mut self` so that calls cannot overlap.
    ///
    /// # Panics
    /// When a task panicked; as all calls below.
    pub fn run(&mut self, tasks: usize, task: &(dyn Fn(usize) + Sync)) {
        self.run_stages([tasks, 0], &|_, _, number| task(number));
    }

    /// Calls `task` once for each number of each stage, below the tasks that the stage has, and returns when all are
    /// done. `task` is told the number of the thread it runs on, below [`Workers::threads`], the stage and its number in
    /// it. No two tasks run at the same time on one thread, but those of the second stage may begin while some of the first
    /// still run.
    fn run_stages(&mut self, stages: [usize; STAGES], task: &StagedTask<'_>) {
        let tasks: usize = stages.iter().sum();
        // Tickets count in 32 bits. More tasks than that are done by one thread.
        let can_be_counted = u32::try_from(tasks).is_ok();
        if self.handles.is_empty() || tasks <= 1 || !can_be_counted {
            for (stage, tasks) in stages.into_iter().enumerate() {
                (0..tasks).for_each(|number| task(0, stage, number));
            }
            return;
        }
        let tickets = stages.map(|tasks| ticket_of(0, tasks as u32));
        let shared = &*self.shared;
        // SAFETY: no claim is outstanding, see `Shared`. The lifetime of `task` is erased; the borrow
        // outlives every use because this function returns only when all tasks are done.
        shared.task.with_mut(|place| unsafe {
            *place = Some(std::mem::transmute::<&StagedTask<'_>, Task>(task));
        });
        shared.done.store(0, Ordering::Relaxed);
        // A thread that read a ticket of an earlier call and finds the same tasks left claims one of this call, and rightly:
        // its exchange has seen this store.
        for (ticket, tasks) in shared.tickets.iter().zip(tickets) {
            ticket.store(tasks, Ordering::SeqCst);
        }
        for (sleeping, handle) in shared.sleeping.iter().zip(&self.handles) {
            if sleeping.load(Ordering::SeqCst) {
                handle.thread().unpark();
            }
        }
        while shared.work(0) {}
        spin_until(|| shared.done.load(Ordering::Acquire) >= tasks);
        assert!(
            !shared.panicked.swap(false, Ordering::Relaxed),
            "a task of the workers panicked"
        );
    }

    /// Calls `task` once for each element with sole access to it.
    pub fn for_each<E: Send>(&mut self, elements: &mut [E], task: impl Fn(usize, &mut E) + Sync) {
        let count = elements.len();
        let elements = Disjoint::new(elements);
        self.run(count, &|index| {
            // SAFETY: `run` passes each index once.
            let element = unsafe { &mut elements.range(index, index + 1)[0] };
            task(index, element);
        });
    }

    /// Calls `task` once for each pair of elements of two slices of one length, with sole access to both.
    ///
    /// # Panics
    /// When the slices have different lengths.
    pub fn for_each_pair<A: Send, B: Send>(
        &mut self,
        a: &mut [A],
        b: &mut [B],
        task: impl Fn(usize, &mut A, &mut B) + Sync,
    ) {
        assert!(a.len() == b.len());
        let count = a.len();
        let (a, b) = (Disjoint::new(a), Disjoint::new(b));
        self.run(count, &|index| {
            // SAFETY: `run` passes each index once.
            let (a, b) = unsafe { (a.range(index, index + 1), b.range(index, index + 1)) };
            task(index, &mut a[0], &mut b[0]);
        });
    }

    /// Cuts the slices of each group, which are of one length or empty, into pieces of `size` elements, and calls `task` once
    /// for each piece, with sole access to that piece of every slice and to one of `results`: with the number of the group and
    /// the place in the slices where the piece begins. Results are used group by group.
    ///
    /// # Panics
    /// When slices have different lengths, or there are fewer results than pieces.
    pub fn for_each_piece<T: Send, R: Send, const GROUPS: usize, const SLICES: usize>(
        &mut self,
        size: usize,
        groups: [[&mut [T]; SLICES]; GROUPS],
        results: &mut [R],
        task: impl Fn(usize, usize, [&mut [T]; SLICES], &mut R) + Sync,
    ) {
        let lengths = groups.iter().flatten().map(|slice| slice.len());
        let len = lengths.clone().max().unwrap_or(0);
        assert!(lengths.clone().all(|other| other == 0 || other == len));
        let pieces = len.div_ceil(size);
        assert!(GROUPS * pieces <= results.len());
        let groups = groups.map(|slices| slices.map(Disjoint::new));
        let results = Disjoint::new(results);
        self.run(GROUPS * pieces, &|number| {
            let (group, piece) = (number / pieces, number % pieces);
            let (from, to) = (piece * size, ((piece + 1) * size).min(len));
            let slices = groups[group].each_ref().map(|slice| {
                let (from, to) = if slice.is_empty() { (0, 0) } else { (from, to) };
                // SAFETY: pieces of different numbers do not overlap, and `run` passes each number once.
                unsafe { slice.range(from, to) }
            });
            // SAFETY: likewise.
            let result = unsafe { &mut results.range(number, number + 1)[0] };
            task(group, from, slices, result);
        });
    }

    /// Two stages of tasks: one task for each element of `first`, `beside` and `second`, each with sole access to its element
    /// and to the scratch of the thread that it runs on. Tasks of `second` begin when none of the others is left to take, and
    /// wait for those elements of `first` that they read.
    ///
    /// # Panics
    /// When there is less scratch than threads.
    pub fn two_stages<S: Send, A: Send + Sync, B: Send, C: Send>(
        &mut self,
        scratch: &mut [S],
        first: (&mut [A], impl Fn(&mut S, usize, &mut A) + Sync),
        beside: (&mut [B], impl Fn(&mut S, usize, &mut B) + Sync),
        second: (
            &mut [C],
            impl Fn(&mut S, usize, &mut C, &Finished<'_, A>) + Sync,
        ),
    ) {
        assert!(self.threads() <= scratch.len());
        let ((first, do_first), (beside, do_beside), (second, do_second)) = (first, beside, second);
        let counts = [first.len(), beside.len(), second.len()];
        // Kept from call to call, so that it is allocated once.
        let mut gates = std::mem::take(&mut self.gates);
        gates.resize_with(counts[0].max(gates.len()), Gate::default);
        gates.iter_mut().for_each(Gate::close);
        let (scratch, first) = (Disjoint::new(scratch), Disjoint::new(first));
        let (beside, second) = (Disjoint::new(beside), Disjoint::new(second));
        let finished = Finished {
            elements: &first,
            gates: &gates[..counts[0]],
        };
        self.run_stages(
            [counts[0] + counts[1], counts[2]],
            &|thread, stage, task| {
                // SAFETY: a thread does one task at a time.
                let scratch = unsafe { &mut scratch.range(thread, thread + 1)[0] };
                if stage == 1 {
                    // SAFETY: each task is run once, and has an element of its own.
                    let element = unsafe { &mut second.range(task, task + 1)[0] };
                    do_second(scratch, task, element, &finished);
                } else if let Some(task) = task.checked_sub(counts[0]) {
                    // SAFETY: likewise.
                    let element = unsafe { &mut beside.range(task, task + 1)[0] };
                    do_beside(scratch, task, element);
                } else {
                    let _open_at_end = finished.gates[task].open_at_end();
                    // SAFETY: likewise, and who reads it waits for the gate.
                    let element = unsafe { &mut first.range(task, task + 1)[0] };
                    do_first(scratch, task, element);
                }
            },
        );
        self.gates = gates;
    }
}

/// The elements of the first stage, to read in the second.
pub struct Finished<'a, A> {
    elements: &'a Disjoint<'a, A>,
    gates: &'a [Gate],
}

impl<A: Sync> Finished<'_, A> {
    /// Waits until the task of an element is done.
    pub fn wait_for(&self, index: usize) -> &A {
        self.gates[index].wait();
        // SAFETY: the task that wrote it is done, and was the only one.
        unsafe { self.elements.shared(index) }
    }
}

impl Drop for Workers {
    fn drop(&mut self) {
        self.shared.stop.store(true, Ordering::SeqCst);
        for handle in self.handles.drain(..) {
            handle.thread().unpark();
            // A worker cannot panic outside a task, and those panics are caught.
            let _ = handle.join();
        }
    }
}
