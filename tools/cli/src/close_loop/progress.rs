//! Progress: a bar on a terminal, else a line on standard error every few seconds.

use indicatif::ProgressBar;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Time between two lines.
const EVERY: Duration = Duration::from_secs(5);

pub struct Progress {
    bar: ProgressBar,
    state: Arc<Mutex<(String, f64)>>,
    lines: Option<(Sender<()>, JoinHandle<()>)>,
}

impl Progress {
    pub fn new() -> Progress {
        let bar = crate::progress_bar(1000, "{wide_bar} {percent:>3} %  {msg}");
        let state = Arc::new(Mutex::new((String::new(), 0.0)));
        let lines = bar.is_hidden().then(|| {
            let (end, ended) = channel();
            let state = Arc::clone(&state);
            (end, std::thread::spawn(move || lines(&state, &ended)))
        });
        Progress { bar, state, lines }
    }

    /// What is done, and the fraction of all that is done before it.
    pub fn set(&self, what: &str, share: f64) {
        self.bar.set_message(what.to_owned());
        self.bar.set_position((1000.0 * share) as u64);
        *self.state.lock().unwrap_or_else(PoisonError::into_inner) = (what.to_owned(), share);
    }

    pub fn finish(mut self) {
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
        let (what, share) = state.lock().unwrap_or_else(PoisonError::into_inner).clone();
        eprintln!("{:3.0} s, {:2.0} %: {what}", begun.elapsed().as_secs_f64(), 100.0 * share);
    }
}
