//! The order in which connected outputs are read and inputs are set, so that values with direct feedthrough are consistent
//! at a communication point, and the order in which components step.
use super::connections::Connections;
use super::parts::Parts;

/// Coupling algorithm during a step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Algorithm {
    /// All components step with the outputs at the beginning of the step. Direct feedthrough is resolved within the
    /// communication point.
    #[default]
    Jacobi,
    /// One after the other; later components use the outputs at the end of the step of earlier ones.
    GaussSeidel,
    /// As Jacobi, but all outputs are read once after the step: direct feedthrough is delayed by one step. Many masters
    /// do so.
    JacobiDelayed,
}

/// The order of one sweep over all connections.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Order {
    /// The round in which each output is read.
    pub(crate) read: Vec<usize>,
    /// The round in which each input is set, after the reading.
    pub(crate) set: Vec<usize>,
    pub(crate) rounds: usize,
    /// Algebraic loops, solved in a round after the reading; their inputs and outputs are in no other round.
    pub(crate) loops: Vec<Loop>,
    /// Components, sources first where values pass through.
    pub(crate) components: Vec<usize>,
    pub(crate) notes: Vec<String>,
}

/// Connections that depend on each other without a step in between.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Loop {
    pub(crate) round: usize,
    /// Connected inputs and outputs.
    pub(crate) inputs: Vec<usize>,
    pub(crate) outputs: Vec<usize>,
    /// The variables along it.
    pub(crate) path: String,
}

/// Who depends on whom: for each output its inputs that pass through.
struct Graph<'a> {
    parts: Parts<'a>,
    connections: &'a Connections,
    through: Vec<Vec<usize>>,
}

/// Orders the connections. If an FMU declares no dependencies, all are assumed; a loop that contains such a dependency is solved with
/// a delay of one step, as all loops are if values are `delayed` anyway, and a note reports it.
pub(crate) fn order(parts: Parts, connections: &Connections, delayed: bool) -> Order {
    let mut notes = Vec::new();
    let mut graph = Graph::new(parts, connections, true);
    let mut loops = graph.loops();
    if !loops.is_empty() && !delayed {
        let declared = Graph::new(parts, connections, false);
        let certain = declared.loops();
        let open = loops.iter().find(|l| !certain.iter().any(|c| c.inputs == l.inputs));
        if let Some(open) = open {
            notes.push(format!(
                "{} may be an algebraic loop, as an FMU in it does not declare what its outputs depend on; \
                 the values are delayed by one step",
                open.path
            ));
            (graph, loops) = (declared, certain);
        }
    }
    if delayed {
        let late = |l: &Loop| format!("algebraic loop: {}: the values are delayed by one step", l.path);
        notes.extend(loops.iter().map(late));
    }
    let (read, set, rounds) = graph.rounds(&mut loops);
    Order { read, set, rounds, loops, components: graph.components(), notes }
}

impl<'a> Graph<'a> {
    fn new(parts: Parts<'a>, connections: &'a Connections, undeclared: bool) -> Self {
        let through = connections.outputs.iter().map(|output| {
            let declared = parts.description(output.component).feedthrough(output.variable);
            let passes = |variable: &usize| declared.as_ref().map_or(undeclared, |on| on.contains(variable));
            let of_same = |i: &usize| connections.inputs[*i].port.component == output.component;
            let inputs = (0..connections.inputs.len()).filter(of_same);
            inputs.filter(|i| passes(&connections.inputs[*i].port.variable)).collect()
        });
        Self { parts, connections, through: through.collect() }
    }

    /// All loops: the strongly connected inputs (Tarjan), in the order of the inputs.
    fn loops(&self) -> Vec<Loop> {
        struct Search<'g> {
            graph: &'g Graph<'g>,
            /// By input: when it was found, and the earliest input that it leads to; 0 for new ones.
            found: Vec<usize>,
            low: Vec<usize>,
            count: usize,
            open: Vec<usize>,
            sets: Vec<Vec<usize>>,
        }
        impl Search<'_> {
            fn next(&self, input: usize) -> &[usize] {
                &self.graph.through[self.graph.connections.inputs[input].source]
            }

            fn visit(&mut self, input: usize) {
                self.count += 1;
                (self.found[input], self.low[input]) = (self.count, self.count);
                self.open.push(input);
                for k in 0..self.next(input).len() {
                    let next = self.next(input)[k];
                    if self.found[next] == 0 {
                        self.visit(next);
                        self.low[input] = self.low[input].min(self.low[next]);
                    } else if self.open.contains(&next) {
                        self.low[input] = self.low[input].min(self.found[next]);
                    }
                }
                if self.low[input] == self.found[input] {
                    let first = self.open.iter().position(|i| *i == input).unwrap_or(0);
                    let mut set = self.open.split_off(first);
                    set.sort_unstable();
                    if set.len() > 1 || self.next(input).contains(&input) {
                        self.sets.push(set);
                    }
                }
            }
        }
        let count = self.connections.inputs.len();
        let (found, low) = (vec![0; count], vec![0; count]);
        let mut search = Search { graph: self, found, low, count: 0, open: Vec::new(), sets: Vec::new() };
        for input in 0..count {
            if search.found[input] == 0 {
                search.visit(input);
            }
        }
        search.sets.sort();
        let whole = |inputs: Vec<usize>| {
            let mut outputs: Vec<usize> = inputs.iter().map(|i| self.connections.inputs[*i].source).collect();
            outputs.sort_unstable();
            outputs.dedup();
            let path = self.path_text(&self.circle(&inputs));
            Loop { round: 0, inputs, outputs, path }
        };
        search.sets.into_iter().map(whole).collect()
    }

    /// Inputs along one way around a loop, in the direction of the signal flow.
    fn circle(&self, members: &[usize]) -> Vec<usize> {
        let mut path = vec![members[0]];
        loop {
            let last = path[path.len() - 1];
            let sources = &self.through[self.connections.inputs[last].source];
            // A way that closes the loop is better than one that goes on.
            let back = sources.iter().find(|i| path.contains(i));
            let next = back.or_else(|| sources.iter().find(|i| members.contains(i)));
            let Some(next) = next else { break };
            if let Some(first) = path.iter().position(|i| i == next) {
                path.drain(..first);
                break;
            }
            path.push(*next);
        }
        // The path runs against the signal flow.
        path.reverse();
        path
    }

    /// The variables along a loop as text.
    fn path_text(&self, circle: &[usize]) -> String {
        let mut words = Vec::new();
        for &input in circle {
            let input = &self.connections.inputs[input];
            words.push(self.parts.name(self.connections.outputs[input.source]));
            words.push(self.parts.name(input.port));
        }
        words.push(words[0].clone());
        words.join(" -> ")
    }

    fn rounds(&self, loops: &mut [Loop]) -> (Vec<usize>, Vec<usize>, usize) {
        let count = self.connections.outputs.len();
        let mut read = vec![0_usize; count];
        let loop_of = |output: usize| loops.iter().position(|l| l.outputs.contains(&output));
        let loops_of: Vec<Option<usize>> = (0..count).map(loop_of).collect();
        // The longest path has at most as many members as there are outputs; all outputs of a loop are one member.
        for _ in 0..count {
            for output in 0..count {
                let own = loops_of[output];
                let within = |i: &&usize| own.is_some_and(|l| loops[l].inputs.contains(i));
                let outside = self.through[output].iter().filter(|i| !within(i));
                let after = outside.map(|i| read[self.connections.inputs[*i].source] + 1);
                read[output] = after.max().unwrap_or(0).max(read[output]);
                for other in own.iter().flat_map(|l| &loops[*l].outputs) {
                    read[*other] = read[*other].max(read[output]);
                }
            }
        }
        for l in &mut *loops {
            l.round = read[l.outputs[0]];
        }
        let rounds: usize = read.iter().max().map_or(0, |r| r + 1);
        // An input is set as late as possible, so that most inputs of a component are set in one call.
        let needed = |input: usize| {
            let users = (0..count).filter(|o| self.through[*o].contains(&input));
            users.map(|o| read[o]).min().map(|first| first - 1)
        };
        let inputs = &self.connections.inputs;
        let in_loop = |input: &usize| loops.iter().any(|l| l.inputs.contains(input));
        let needed = |input: usize| if in_loop(&input) { None } else { needed(input) };
        let asked: Vec<Option<usize>> = (0..inputs.len()).map(needed).collect();
        // An input without dependent outputs is set together with others of its component: if it were set after the outputs were
        // read, the component would have to compute them again.
        let with_others = |input: usize| {
            let input = &inputs[input];
            let others = inputs.iter().zip(&asked).filter(|(f, _)| f.port.component == input.port.component);
            others.filter_map(|(_, round)| *round).filter(|round| *round >= read[input.source]).max()
        };
        let last = rounds.saturating_sub(1);
        let round = |input: usize| asked[input].or_else(|| with_others(input)).unwrap_or(last);
        let set = (0..inputs.len()).map(round).collect();
        (read, set, rounds)
    }

    /// Source components before those that depend on them; otherwise in the order of the file.
    fn components(&self) -> Vec<usize> {
        let count = self.parts.structure.components.len();
        let (outputs, inputs) = (&self.connections.outputs, &self.connections.inputs);
        let waits_for = |c: usize| {
            let own = move |o: &usize| outputs[*o].component == c;
            let through = (0..outputs.len()).filter(own).flat_map(|o| self.through[o].iter().copied());
            let sink = !(0..outputs.len()).any(|o| own(&o));
            let last = (0..inputs.len()).filter(move |i| sink && inputs[*i].port.component == c);
            through.chain(last).map(|i| outputs[inputs[i].source].component)
        };
        let mut order: Vec<usize> = Vec::new();
        while order.len() < count {
            let mut left = (0..count).filter(|c| !order.contains(c));
            let ready = |c: &usize| waits_for(*c).all(|s| s == *c || order.contains(&s));
            let next = left.clone().find(ready).or_else(|| left.next());
            order.extend(next);
        }
        order
    }
}
