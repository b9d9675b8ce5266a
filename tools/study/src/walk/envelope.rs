//! Temperature of the winding over hours.

use super::periodic::Periodic;

/// A point of the envelope.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct EnvelopePoint {
    /// Time since the start, s.
    pub time: f64,
    /// Greatest temperature of the winding in the stride that ends there, K.
    pub winding_temperature: f64,
}

/// Temperature of the winding over hours.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize)]
pub struct Envelope {
    /// Its points, in order of time.
    pub points: Vec<EnvelopePoint>,
    /// Strides that were walked to find them.
    pub strides_walked: u32,
    /// Time at which the winding reaches the limit, s, where it does.
    pub time_to_limit: Option<f64>,
    /// The stride in which it does.
    #[serde(skip)]
    pub at_limit: Option<Periodic>,
    /// Means and peaks over the whole time.
    #[serde(skip)]
    pub mean: Periodic,
}

impl Envelope {
    /// Adds what follows from `time` on.
    pub(super) fn append(&mut self, later: Envelope, time: f64) {
        self.points.extend(later.points.iter().map(|p| EnvelopePoint { time: p.time + time, ..*p }));
        self.strides_walked += later.strides_walked;
        self.time_to_limit = later.time_to_limit.map(|t| t + time);
        self.at_limit = later.at_limit;
    }
}
