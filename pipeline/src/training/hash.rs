//! Hash of the training data.

use datasets::Log;
use sha2::{Digest, Sha256};

/// SHA-256 of all positions, in hexadecimal digits.
pub(super) fn data_hash(logs: &[Log]) -> String {
    let mut hash = Sha256::new();
    for column in logs.iter().flat_map(|log| log.reference.columns().iter().chain(log.actual.columns())) {
        for value in column {
            hash.update(value.to_le_bytes());
        }
    }
    models::hex(&hash.finalize())
}
