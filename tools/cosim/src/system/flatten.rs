//! Nested systems and signal dictionaries of SSP become flat: connections through their connectors are joined.
use super::structure::{Connection, Connector, Direction, End};
use crate::Error;

/// A connection whose ends may be connectors of nested systems or of signal dictionaries.
#[derive(Clone)]
pub(super) struct Edge {
    pub(super) connection: Connection,
    /// Whether an end is seen from inside of the system that has the connector.
    pub(super) start_inside: bool,
    pub(super) end_inside: bool,
}

impl Edge {
    /// With the ends exchanged.
    fn turned(self) -> Self {
        let Self { connection: Connection { start, end, legs, place }, start_inside, end_inside } = self;
        let connection = Connection { start: end, end: start, legs, place };
        Self { connection, start_inside: end_inside, end_inside: start_inside }
    }
}

/// A connector that is no end of a flat connection: of a nested system, or an entry of a signal dictionary, whose direction follows
/// from what is connected.
pub(super) struct Joint {
    pub(super) element: String,
    pub(super) connector: Connector,
    pub(super) is_entry: bool,
}

/// Joins all connections at the joints. `is_source` says of an end that is no joint whether values come from there.
pub(super) fn flat(
    mut edges: Vec<Edge>,
    joints: &[Joint],
    is_source: &dyn Fn(&End) -> bool,
) -> Result<Vec<Connection>, Error> {
    // Entries last: what they are connected to has its direction then.
    for joint in joints.iter().filter(|j| !j.is_entry).chain(joints.iter().filter(|j| j.is_entry)) {
        let name = &joint.connector.name;
        let is_joint = |end: &End| end.component.as_deref() == Some(&joint.element) && end.connector == *name;
        let touches = |edge: &Edge| is_joint(&edge.connection.start) || is_joint(&edge.connection.end);
        let (touching, others): (Vec<Edge>, Vec<Edge>) = edges.into_iter().partition(touches);
        edges = others;
        let (mut sources, mut targets) = (Vec::new(), Vec::new());
        for edge in touching {
            let at_start = is_joint(&edge.connection.start);
            let inside = if at_start { edge.start_inside } else { edge.end_inside };
            let far = if at_start { &edge.connection.end } else { &edge.connection.start };
            let comes_in = match joint.connector.direction {
                _ if joint.is_entry => is_source(far),
                Direction::Output => inside,
                Direction::Input | Direction::Parameter => !inside,
            };
            // From the source to the target.
            let edge = if at_start == comes_in { edge.turned() } else { edge };
            if comes_in { sources.push(edge) } else { targets.push(edge) }
        }
        sources.sort_by_key(|edge| edge.connection.place.line);
        if let [first, second, ..] = &sources[..] {
            let (other, place) = (&first.connection, &second.connection.place);
            let element = joint.element.replace('\t', "");
            return Err(place.fault(format!(
                "{element}.{name} has a source already: {}, line {}",
                other.start, other.place.line
            )));
        }
        let Some(source) = sources.pop() else { continue };
        for target in targets {
            let Connection { start, mut legs, .. } = source.connection.clone();
            if let Some(last) = legs.last_mut() {
                last.unit.clone_from(&joint.connector.unit);
            }
            legs.extend(target.connection.legs);
            let (end, place) = (target.connection.end, target.connection.place);
            let connection = Connection { start, end, legs, place };
            let (start_inside, end_inside) = (source.start_inside, target.end_inside);
            edges.push(Edge { connection, start_inside, end_inside });
        }
    }
    Ok(edges.into_iter().map(|edge| edge.connection).collect())
}
