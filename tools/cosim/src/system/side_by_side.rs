//! Components that step at the same time, in threads: with Jacobi coupling no component waits for another one.
//!
//! Every component steps from the same values as one after the other, so that results are the same bits. Components with shorter steps of
//! their own need values of the master in between and step afterwards.
use super::component_steps::ComponentStep;
use crate::{Error, Instance, Step};
use rayon::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};

pub(super) struct SideBySide {
    pool: ThreadPool,
    /// By component: the result of its last step, until it is taken.
    stepped: Vec<Option<Result<Step, Error>>>,
    /// By component: whether it takes the communication step in one step.
    is_whole: Vec<bool>,
}

impl SideBySide {
    pub(super) fn new(threads: usize, instances: &mut [Instance]) -> Result<Self, Error> {
        // More threads than components would wait.
        let pool = ThreadPoolBuilder::new().num_threads(threads.min(instances.len())).build();
        let pool = pool.map_err(|e| Error::option("threads", threads, format!("cannot be started: {e}")))?;
        instances.iter_mut().for_each(Instance::take_lane);
        let stepped = instances.iter().map(|_| None).collect();
        Ok(Self { pool, stepped, is_whole: vec![true; instances.len()] })
    }

    /// Steps all components that take the communication step in one step. Each result waits for [`take`](Self::take).
    pub(super) fn step(&mut self, instances: &mut [Instance], steps: &[ComponentStep], t: f64, h: f64) {
        for step in steps {
            self.is_whole[step.component] = step.parts(h) == 1;
        }
        let all = instances.par_iter_mut().zip(&mut self.stepped).zip(&self.is_whole);
        self.pool.install(|| {
            all.for_each(|((instance, stepped), is_whole)| {
                *stepped = is_whole.then(|| instance.do_step(t, h));
            });
        });
    }

    /// The result of a component, once.
    pub(super) fn take(&mut self, component: usize) -> Option<Result<Step, Error>> {
        self.stepped[component].take()
    }
}
