//! Model files from their parts: a stored zip archive with its checksum as comment.

use sha2::{Digest, Sha256};

/// CRC-32 of zip archives (ISO 3309).
fn crc32(bytes: &[u8]) -> u32 {
    let step = |crc: u32, byte: &u8| {
        (0..8).fold(crc ^ u32::from(*byte), |crc, _| if crc & 1 == 1 { (crc >> 1) ^ 0xEDB8_8320 } else { crc >> 1 })
    };
    !bytes.iter().fold(u32::MAX, step)
}

/// The bytes of a model with this manifest and these weights.
pub fn model(manifest: &[u8], weights: &[u8]) -> Vec<u8> {
    let (mut archive, mut directory) = (Vec::new(), Vec::new());
    let parts = [("manifest.json", manifest), ("weights.safetensors", weights)];
    for (name, content) in parts {
        let offset = archive.len() as u32;
        // Version 1.0, no flags, stored, 1980-01-01.
        let mut header = [10_u16, 0, 0, 0, 0x21].map(u16::to_le_bytes).concat();
        for number in [crc32(content), content.len() as u32, content.len() as u32] {
            header.extend(number.to_le_bytes());
        }
        header.extend([name.len() as u16, 0].map(u16::to_le_bytes).concat());
        archive.extend(b"PK\x03\x04");
        archive.extend(&header);
        archive.extend(name.as_bytes());
        archive.extend(content);
        directory.extend(b"PK\x01\x02\x0a\x00");
        directory.extend(&header);
        directory.extend([0; 10]);
        directory.extend(offset.to_le_bytes());
        directory.extend(name.as_bytes());
    }
    let (at, length) = (archive.len() as u32, directory.len() as u32);
    archive.extend(directory);
    archive.extend(b"PK\x05\x06");
    archive.extend([0_u16, 0, 2, 2].map(u16::to_le_bytes).concat());
    archive.extend([length, at].map(u32::to_le_bytes).concat());
    archive.extend(64_u16.to_le_bytes());
    with_checksum(archive)
}

/// The archive, whose comment is still missing, with the SHA-256 of its bytes as the comment.
pub fn with_checksum(mut archive: Vec<u8>) -> Vec<u8> {
    let digits: String = Sha256::digest(&archive).iter().map(|byte| format!("{byte:02x}")).collect();
    archive.extend(digits.as_bytes());
    archive
}

/// Manifest and weights of a model with stored parts, in this order.
pub fn parts(model: &[u8]) -> (Vec<u8>, Vec<u8>) {
    let number = |at: usize, size: usize| model[at..at + size].iter().rev().fold(0, |sum, byte| sum << 8 | usize::from(*byte));
    let part = |at: usize| {
        let from = at + 30 + number(at + 26, 2) + number(at + 28, 2);
        (from, from + number(at + 18, 4))
    };
    let (from, to) = part(0);
    let (weights_from, weights_to) = part(to);
    (model[from..to].to_vec(), model[weights_from..weights_to].to_vec())
}
