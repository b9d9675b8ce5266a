//! Progress: a bar on a terminal, else a line on standard error every few seconds.

use crate::parent::complain;
use indicatif::{ProgressBar, ProgressStyle};
use std::io::IsTerminal;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Time between two lines.
const EVERY: Duration = Duration::from_secs(5);
/// Time between two pictures of the bar, so that it also moves where a part takes long.
const TICK: Duration = Duration::from_millis(200);
/// Parts of the bar.
const PARTS: f64 = 1000.0;

/// The progress of a command. It ends when it is dropped.
pub struct Progress {
    bar: ProgressBar,
    state: Arc<Mutex<(String, f64)>>,
    lines: Option<(Sender<()>, JoinHandle<()>)>,
}

impl Progress {
    /// Begins with what is done first.
    pub fn new(what: &str) -> Progress {
        let state = Arc::new(Mutex::new((what.to_owned(), 0.0)));
        if !std::io::stderr().is_terminal() {
            let (end, ended) = channel();
            let shared = Arc::clone(&state);
            let thread = std::thread::spawn(move || lines(&shared, &ended));
            return Progress { bar: ProgressBar::hidden(), state, lines: Some((end, thread)) };
        }
        let bar = ProgressBar::new(PARTS as u64);
        if let Ok(style) =
            ProgressStyle::with_template("{spinner} {wide_bar} {percent:>3} %  {elapsed}  {msg}")
        {
            bar.set_style(style);
        }
        bar.enable_steady_tick(TICK);
        let progress = Progress { bar, state, lines: None };
        progress.set(what, 0.0);
        progress
    }

    /// What is done, and the fraction of all that is done before it.
    pub fn set(&self, what: &str, fraction: f64) {
        self.bar.set_message(what.to_owned());
        self.bar.set_position((PARTS * fraction) as u64);
        *self.state.lock().unwrap_or_else(PoisonError::into_inner) = (what.to_owned(), fraction);
    }

    /// The fraction that is done of the same.
    pub fn at(&self, fraction: f64) {
        self.bar.set_position((PARTS * fraction) as u64);
        self.state.lock().unwrap_or_else(PoisonError::into_inner).1 = fraction;
    }

    /// Before anything else is printed.
    pub fn finish(self) {}
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
        if let Some((end, thread)) = self.lines.take() {
            drop(end);
            // A thread that only writes lines has nothing to tell.
            let _ = thread.join();
        }
    }
}

fn lines(state: &Mutex<(String, f64)>, ended: &Receiver<()>) {
    let begun = Instant::now();
    while ended.recv_timeout(EVERY) == Err(RecvTimeoutError::Timeout) {
        let (what, fraction) = state.lock().unwrap_or_else(PoisonError::into_inner).clone();
        let seconds = begun.elapsed().as_secs_f64();
        complain(&format!("{seconds:3.0} s, {:2.0} %: {what}", 100.0 * fraction));
    }
}
