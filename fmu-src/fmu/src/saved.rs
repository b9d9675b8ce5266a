//! Saved instances: in memory for get and set, as bytes for serialization.

use crate::instance::{Interface, Mode};
use crate::refusal::{Outcome, Refused};
use physics::declare::Causality;
use physics::model::Model;

/// First bytes of every serialized state; the digit is the version of the format.
const MAGIC: &[u8; 8] = b"motorfm8";

/// Number of bytes of the checksum after it.
const CHECKSUM: usize = size_of::<u32>();

/// Writes the checksum (CRC-32) of the bytes that follow it. A corrupted number is usually still a valid number, and a corrupted mode
/// another mode, so only the checksum detects them.
pub fn seal(bytes: &mut [u8]) {
    let (head, body) = bytes.split_at_mut(MAGIC.len() + CHECKSUM);
    head[MAGIC.len()..].copy_from_slice(&crc32fast::hash(body).to_le_bytes());
}

/// The content of an FMU state handle.
pub struct Saved {
    /// The model with its integrator.
    pub model: Box<dyn Model>,
    /// Interface type of the instance.
    pub interface: Interface,
    /// Mode of the instance.
    pub mode: Mode,
    /// Start and stop time, s.
    pub window: (f64, f64),
    /// Ratio of the importer's tolerance to the default tolerance.
    pub tolerance: f64,
    /// Length of the last step, s; 0 before the first.
    pub last_step: f64,
    /// Pre values of the discrete outputs, if the importer uses event mode.
    pub discrete_pre: Vec<f64>,
}

impl Saved {
    /// Serializes the state: magic, checksum of the rest, interface, mode, length of the identity, identity, count of numbers, and the
    /// numbers: start and stop time, tolerance, last step, number of discrete outputs, their pre values, the model.
    ///
    /// The identity is that of the equations: token of the variable table, fingerprints of terms and load table. The start values are not
    /// part of it, because the state contains all values.
    pub fn to_bytes(&self, equations: [u64; 2]) -> Vec<u8> {
        let (window, discrete) = (self.window, self.discrete_pre.len() as f64);
        let mut numbers = vec![window.0, window.1, self.tolerance, self.last_step, discrete];
        numbers.extend(&self.discrete_pre);
        self.model.save(&mut numbers);
        let token = self.model.declaration().token.to_string();
        let length = token.len() + size_of_val(&equations);
        let mut bytes = Vec::with_capacity(MAGIC.len() + CHECKSUM + 10 + length + 8 * numbers.len());
        bytes.extend(MAGIC);
        bytes.extend([0; CHECKSUM]);
        bytes.extend([self.interface as u8, self.mode as u8]);
        bytes.extend((length as u32).to_le_bytes());
        bytes.extend(token.as_bytes());
        equations.iter().for_each(|fingerprint| bytes.extend(fingerprint.to_le_bytes()));
        bytes.extend((numbers.len() as u32).to_le_bytes());
        numbers.iter().for_each(|n| bytes.extend(n.to_le_bytes()));
        seal(&mut bytes);
        bytes
    }

    /// Deserializes the bytes of [`to_bytes`](Saved::to_bytes) for an instance of the model `like` with these equations and
    /// this interface type.
    pub fn from_bytes(
        bytes: &[u8],
        like: &dyn Model,
        equations: [u64; 2],
        interface: Interface,
    ) -> Outcome<Saved> {
        let bad = |why: &str| Refused::error(format!("the serialized state of {} bytes {why}.", bytes.len()));
        let mut rest = bytes;
        let mut take = |n: usize| -> Outcome<&[u8]> {
            let (head, tail) = rest.split_at_checked(n).ok_or_else(|| bad("is cut short"))?;
            rest = tail;
            Ok(head)
        };
        let length = |b: &[u8]| u32::from_le_bytes(b.try_into().unwrap_or_default()) as usize;
        if take(MAGIC.len())? != MAGIC {
            return Err(bad("is not of this version of the library"));
        }
        let checksum = take(CHECKSUM)?.to_vec();
        if checksum != crc32fast::hash(&bytes[MAGIC.len() + CHECKSUM..]).to_le_bytes() {
            return Err(bad("is damaged"));
        }
        if take(1)?[0] != interface as u8 {
            return Err(bad("belongs to an instance of another interface"));
        }
        let mode = Mode::from_number(take(1)?[0]).ok_or_else(|| bad("is damaged"))?;
        let identity = length(take(4)?);
        let (token, found) = take(identity)?.split_last_chunk::<16>().ok_or_else(|| bad("is damaged"))?;
        if token != like.declaration().token.to_string().as_bytes() {
            return Err(bad("belongs to another model"));
        }
        let [terms, load] = [0, 8].map(|k| found[k..k + 8] == equations[k / 8].to_le_bytes());
        if !terms {
            return Err(bad(
                "belongs to a model with other terms (resources/effects.json), so its equations are others",
            ));
        }
        if !load {
            return Err(bad("belongs to a model with another load table (resources/load.json)"));
        }
        let count = length(take(4)?);
        let numbers: Vec<f64> = take(count.saturating_mul(8))?
            .chunks_exact(8)
            .map(|b| f64::from_le_bytes(b.try_into().unwrap_or_default()))
            .collect();
        let mut model = like.boxed_clone();
        let (window, [tolerance, last_step], discrete_pre, numbers) =
            parts(&numbers).ok_or_else(|| bad("is damaged"))?;
        let usual = tolerance > 0.0 && tolerance.is_finite() && last_step >= 0.0 && last_step.is_finite();
        if !usual || !rest.is_empty() || !model.restore(numbers) || !is_sound(model.as_mut()) {
            return Err(bad("is damaged"));
        }
        Ok(Saved {
            model,
            interface,
            mode,
            window,
            tolerance,
            last_step,
            discrete_pre: discrete_pre.to_vec(),
        })
    }
}

/// Whether parameters are within the limits that the equations require. Inputs are only checked to be finite, because an input
/// derivative may have moved them outside their limits.
fn is_sound(model: &mut dyn Model) -> bool {
    model.declaration().entries.iter().all(|entry| match entry.row.causality {
        Causality::Parameter => entry.check(model.get(entry.slot), false).is_ok(),
        Causality::Input => model.get(entry.slot).is_finite(),
        Causality::Output | Causality::Local => true,
    })
}

/// Start and stop time, s, tolerance factor and last step, pre values of the discrete outputs, and numbers of the model.
type Parts<'a> = ((f64, f64), [f64; 2], &'a [f64], &'a [f64]);

fn parts(numbers: &[f64]) -> Option<Parts<'_>> {
    let (&[start, stop, tolerance, last_step, count], rest) = numbers.split_first_chunk()?;
    // An invalid count is converted to a wrong number, which then does not match the length of the model's data.
    let (discrete_pre, model) = rest.split_at_checked(count as usize)?;
    Some(((start, stop), [tolerance, last_step], discrete_pre, model))
}
