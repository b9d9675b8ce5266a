//! The order in which connected outputs are read and inputs are set, so that values with direct feedthrough are consistent
//! at a communication point, and the order in which components step.
use super::connections::Connections;
use super::parts::Parts;
use crate::Error;

/// The order of one sweep over all connections.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Order {
    /// The round in which each output is read.
    pub(crate) read: Vec<usize>,
    /// The round in which each input is set, after the reading.
    pub(crate) set: Vec<usize>,
    pub(crate) rounds: usize,
    /// Components, sources first where values pass through.
    pub(crate) components: Vec<usize>,
    pub(crate) notes: Vec<String>,
}

/// Who depends on whom: for each output its inputs that pass through.
struct Graph<'a> {
    parts: Parts<'a>,
    connections: &'a Connections,
    through: Vec<Vec<usize>>,
}

/// Orders the connections.
///
/// # Errors
/// An algebraic loop through declared dependencies, with the variables along it. If an FMU declares no dependencies, all are assumed;
/// a loop that contains such a dependency is solved with a delay of one step, and a note reports it.
pub(crate) fn order(parts: Parts, connections: &Connections) -> Result<Order, Error> {
    let mut notes = Vec::new();
    let all = Graph::new(parts, connections, true);
    let graph = match all.circle() {
        None => all,
        Some(open) => {
            let declared = Graph::new(parts, connections, false);
            if let Some(circle) = declared.circle() {
                let place = &parts.structure.connections[connections.inputs[circle[0]].connection].place;
                return Err(place.fault(format!("algebraic loop: {}", declared.path_text(&circle))));
            }
            notes.push(format!(
                "{} may be an algebraic loop, as an FMU in it does not declare what its outputs depend on; \
                 the values are delayed by one step",
                all.path_text(&open)
            ));
            declared
        }
    };
    let (read, set, rounds) = graph.rounds();
    Ok(Order { read, set, rounds, components: graph.components(), notes })
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

    /// The inputs along a loop, in the direction of the signal flow.
    fn circle(&self) -> Option<Vec<usize>> {
        #[derive(Clone, Copy, PartialEq)]
        enum Mark {
            New,
            Open,
            Done,
        }
        fn visit(
            graph: &Graph,
            input: usize,
            marks: &mut [Mark],
            path: &mut Vec<usize>,
        ) -> Option<Vec<usize>> {
            marks[input] = Mark::Open;
            path.push(input);
            for &next in &graph.through[graph.connections.inputs[input].source] {
                match marks[next] {
                    Mark::Done => {}
                    Mark::Open => {
                        let first = path.iter().position(|i| *i == next).unwrap_or(0);
                        // The path runs against the signal flow.
                        return Some(path[first..].iter().rev().copied().collect());
                    }
                    Mark::New => {
                        let found = visit(graph, next, marks, path);
                        if found.is_some() {
                            return found;
                        }
                    }
                }
            }
            path.pop();
            marks[input] = Mark::Done;
            None
        }
        let mut marks = vec![Mark::New; self.connections.inputs.len()];
        for input in 0..marks.len() {
            if marks[input] == Mark::New {
                let found = visit(self, input, &mut marks, &mut Vec::new());
                if found.is_some() {
                    return found;
                }
            }
        }
        None
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

    fn rounds(&self) -> (Vec<usize>, Vec<usize>, usize) {
        let count = self.connections.outputs.len();
        let mut read = vec![0_usize; count];
        // Without loops the longest path has at most as many members as there are outputs.
        for _ in 0..count {
            for output in 0..count {
                let after = self.through[output].iter().map(|i| read[self.connections.inputs[*i].source] + 1);
                read[output] = after.max().unwrap_or(0);
            }
        }
        let rounds: usize = read.iter().max().map_or(0, |r| r + 1);
        // An input is set as late as possible, so that most inputs of a component are set in one call.
        let needed = |input: usize| {
            let users = (0..count).filter(|o| self.through[*o].contains(&input));
            users.map(|o| read[o]).min().map(|first| first - 1)
        };
        let inputs = &self.connections.inputs;
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
