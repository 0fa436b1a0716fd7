//! Saving the state of a simulation, and continuing from it.
//!
//! A saved state holds what changes: joint trees, shapes and contacts, the sensor with its random streams, the last
//! report, and the last equilibrium angles. It does not hold the arm and the clutter; their fingerprint tells whether a
//! saved state belongs to them.

use underbrush_recording::Fault;

use super::Simulation;
use crate::physics::ENGINE;

/// The first bytes of every saved state.
const MAGIC: &[u8; 16] = b"underbrush state";

/// Raised when what a state holds changes, because its encoding does not describe itself.
const FORMAT: u32 = 7;

/// Length of a BLAKE3 hash, bytes.
const HASH: usize = blake3::OUT_LEN;

/// Why a state could not be saved or loaded.
#[derive(Debug, thiserror::Error)]
pub enum StateError {
    /// The bytes are not a saved state.
    #[error("these bytes are not a saved state of a simulation: give bytes that `Simulation::save` returned")]
    NotAState,
    /// The state was saved from another simulation.
    #[error(
        "this state was saved by another version of the program or from a simulation with another arm, clutter or step: load it \
         into a simulation with the same"
    )]
    Foreign,
    /// Some bytes are missing or were changed.
    #[error("this saved state is damaged, its checksum does not match: save it again")]
    Damaged,
    /// The state could not be written or read although its checksum matches.
    #[error("this state cannot be written or read: {0}")]
    Format(#[from] postcard::Error),
}

impl From<StateError> for Fault {
    fn from(error: StateError) -> Self {
        Fault::Usage(error.to_string())
    }
}

impl Simulation {
    /// The present state as bytes, for [`Simulation::load`]: magic, fingerprint, checksum, and the encoded state.
    ///
    /// # Errors
    /// If the state cannot be encoded.
    pub fn save(&self) -> Result<Vec<u8>, StateError> {
        let encoded = postcard::to_allocvec(&self.state)?;
        let (fingerprint, checksum) = (self.fingerprint(), blake3::hash(&encoded));
        Ok([MAGIC.as_slice(), &fingerprint, checksum.as_bytes(), &encoded].concat())
    }

    /// Continues from a state that a simulation with the same arm, clutter and options saved, bit for bit as that one
    /// would. The sensor is replaced by the saved one, too.
    ///
    /// # Errors
    /// If the bytes are not a saved state, are damaged, or belong to another simulation; this one is then unchanged.
    pub fn load(&mut self, bytes: &[u8]) -> Result<(), StateError> {
        let rest = bytes.strip_prefix(MAGIC).ok_or(StateError::NotAState)?;
        let (own, rest) = rest.split_at_checked(HASH).ok_or(StateError::Damaged)?;
        let (checksum, encoded) = rest.split_at_checked(HASH).ok_or(StateError::Damaged)?;
        if own != self.fingerprint() {
            return Err(StateError::Foreign);
        }
        if checksum != blake3::hash(encoded).as_bytes() {
            return Err(StateError::Damaged);
        }
        self.state = postcard::from_bytes(encoded)?;
        Ok(())
    }

    /// A hash of the program's version and of everything that a saved state relies on.
    fn fingerprint(&self) -> [u8; HASH] {
        let (model, physics) = (&self.model, self.physics());
        // `Debug` prints a float with as many digits as tell it from every other.
        let text = format!(
            "{} {FORMAT} {ENGINE} {physics:?} {} {:?} {:?} {:?}",
            env!("CARGO_PKG_VERSION"),
            model.dormancy,
            model.arm,
            model.clutter.objects,
            model.clutter.materials
        );
        *blake3::hash(text.as_bytes()).as_bytes()
    }
}

#[cfg(test)]
mod tests;
