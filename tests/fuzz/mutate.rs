//! The seeded mutator.

use crate::archive;
use crate::seeds::{Kind, Seed};

/// Numbers at which readers overflow, divide by zero or count for ever.
const NUMBERS: [&str; 20] = [
    "0",
    "-0.0",
    "-1",
    "1e300",
    "-1e308",
    "1e-300",
    "1e999",
    "nan",
    "inf",
    "0.0001",
    "0.000000001",
    "99999999999",
    "1e9",
    "65536",
    "2147483648",
    "4294967296",
    "9007199254740993",
    "9223372036854775807",
    "18446744073709551615",
    "-9223372036854775808",
];
/// Characters with a meaning in one of the formats.
const CHARACTERS: &[u8] = b"0-.;:,\"'<>{}[]()#=%/\\\n\r\t \0\xFFeEGMXYZFIJKRPQNOT*";

/// SplitMix64 (Steele et al. 2014).
pub struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    fn below(&mut self, end: usize) -> usize {
        (self.next() % end.max(1) as u64) as usize
    }
}

/// The input of this number: one of the seeds with up to four mutations.
pub fn input(seeds: &[Seed], number: u64) -> (Kind, Vec<u8>) {
    let mut random = Random(number);
    let seed = &seeds[random.below(seeds.len())];
    let bytes = match seed.kind {
        Kind::Model => model(&seed.bytes, &mut random),
        _ => mutated(seed.bytes.clone(), seeds, &mut random),
    };
    (seed.kind, bytes)
}

/// A model with mutated manifest, weights or archive, whose checksum fits.
fn model(bytes: &[u8], random: &mut Random) -> Vec<u8> {
    let (manifest, weights) = archive::parts(bytes);
    match random.below(8) {
        0 => archive::with_checksum(mutated(bytes[..bytes.len() - 64].to_vec(), &[], random)),
        1 | 2 => archive::model(&manifest, &mutated(weights, &[], random)),
        _ => archive::model(&with_number(manifest, random), &weights),
    }
}

fn mutated(mut bytes: Vec<u8>, seeds: &[Seed], random: &mut Random) -> Vec<u8> {
    for _ in 0..=random.below(4) {
        bytes = match random.below(8) {
            0..4 => with_number(bytes, random),
            _ => with_bytes(bytes, seeds, random),
        };
    }
    bytes
}

/// With another number in place of one of those in the text.
fn with_number(mut bytes: Vec<u8>, random: &mut Random) -> Vec<u8> {
    let start = random.below(bytes.len());
    let is_of_number = |byte: &u8| byte.is_ascii_digit() || *byte == b'.';
    let Some(from) = bytes[start..].iter().position(is_of_number).map(|at| start + at) else { return bytes };
    let to = bytes[from..].iter().position(|byte| !is_of_number(byte)).map_or(bytes.len(), |at| from + at);
    bytes.splice(from..to, NUMBERS[random.below(NUMBERS.len())].bytes());
    bytes
}

fn with_bytes(mut bytes: Vec<u8>, seeds: &[Seed], random: &mut Random) -> Vec<u8> {
    let at = random.below(bytes.len());
    let end = (at + 1 + random.below(40)).min(bytes.len());
    match random.below(6) {
        0 => bytes.truncate(at),
        1 => drop(bytes.drain(at..end)),
        2 => {
            let copy = bytes[at..end].to_vec();
            bytes.splice(at..at, copy);
        }
        3 if !seeds.is_empty() => {
            let other = &seeds[random.below(seeds.len())].bytes;
            let from = random.below(other.len());
            bytes.splice(at..at, other[from..(from + 80).min(other.len())].iter().copied());
        }
        4 => bytes.insert(at, CHARACTERS[random.below(CHARACTERS.len())]),
        _ => {
            if let Some(byte) = bytes.get_mut(at) {
                *byte ^= 1 << random.below(8);
            }
        }
    }
    bytes
}
