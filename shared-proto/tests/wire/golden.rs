//! `tests/golden.txt` pins the bytes of every message. Whoever changes it changes the protocol.

use std::collections::BTreeSet;
use std::fmt::Write;
use std::path::PathBuf;

use shared_proto::*;

use crate::decoding::{decode, parts};
use crate::samples;
use crate::schema;

const HEADER: &str = "\
# The bytes of every message on the wire: frame as sent first (sequence 0), the final zero included.
# Written by `BEELINE_GOLDEN=write cargo test -p shared-proto golden`; read docs/protocol.md before
# you do that, and consider PROTOCOL_VERSION.
";

fn path() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/golden.txt")
}

pub fn hex(bytes: &[u8]) -> String {
    bytes.iter().fold(String::new(), |mut text, byte| {
        write!(text, "{byte:02x}").unwrap();
        text
    })
}

pub fn from_hex(text: &str) -> Vec<u8> {
    assert!(text.len().is_multiple_of(2), "half a byte in {text}");
    (0..text.len()).step_by(2).map(|i| u8::from_str_radix(&text[i..i + 2], 16).unwrap()).collect()
}

/// Name and value of each line of the file.
pub fn lines() -> Vec<(String, String)> {
    let text = std::fs::read_to_string(path()).expect("tests/golden.txt is there");
    text.lines()
        .filter(|line| !line.is_empty() && !line.starts_with('#'))
        .map(|line| {
            let (name, value) = line.split_once(' ').expect("a name and a value");
            (name.to_string(), value.trim().to_string())
        })
        .collect()
}

/// The frame of that name.
pub fn frame(name: &str) -> Vec<u8> {
    let line = lines().into_iter().find(|(n, _)| n == name);
    from_hex(&line.unwrap_or_else(|| panic!("no {name} in golden.txt")).1)
}

fn as_built() -> String {
    let mut text = HEADER.to_string();
    let mut line = |name: &str, value: &str| writeln!(text, "{name:<34} {value}").unwrap();
    line("protocol_version", &PROTOCOL_VERSION.to_string());
    line("schema_hash", &format!("{SCHEMA_HASH:016x}"));
    for (name, message) in samples::all() {
        line(&name, &hex(&message.frame(&mut Encoder::new())));
    }
    text
}

#[test]
fn the_golden_bytes_of_every_message_are_unchanged() {
    let built = as_built();
    if std::env::var("BEELINE_GOLDEN").is_ok_and(|value| value == "write") {
        std::fs::write(path(), &built).unwrap();
    }
    let kept = std::fs::read_to_string(path()).unwrap_or_default();
    if kept == built {
        return;
    }
    let old: Vec<&str> = kept.lines().collect();
    let new: Vec<&str> = built.lines().collect();
    let mut diff = String::new();
    for line in old.iter().filter(|line| !new.contains(line)) {
        writeln!(diff, "- {line}").unwrap();
    }
    for line in new.iter().filter(|line| !old.contains(line)) {
        writeln!(diff, "+ {line}").unwrap();
    }
    if diff.is_empty() {
        diff.push_str("(the same lines in another order)\n");
    }
    panic!(
        "the bytes on the wire differ from tests/golden.txt (-: kept, +: this build):\n\n{diff}\n\
         If that is intended: does the meaning of a message change while its layout does not? Then \
         raise PROTOCOL_VERSION.\nThen run: BEELINE_GOLDEN=write cargo test -p shared-proto golden\n"
    );
}

#[test]
fn golden_frames_read_back_as_the_messages_they_were_made_of() {
    for (name, message) in samples::all() {
        let found = decode(&mut Decoder::new(), &frame(&name));
        assert_eq!(found, [Ok(message)], "{name}");
    }
}

#[test]
fn golden_names_are_unique() {
    let names: BTreeSet<String> = lines().into_iter().map(|(name, _)| name).collect();
    assert_eq!(names.len(), lines().len());
}

#[test]
fn golden_bytes_exist_for_every_variant_of_every_enum() {
    let mut wanted = BTreeSet::new();
    let mut met = BTreeSet::new();
    for (name, _) in samples::all() {
        let (channel, payload) = parts(&frame(&name));
        let Some(ty) = schema::of_channel(channel) else { continue };
        schema::variants(ty, &mut wanted);
        let rest = schema::walk(ty, &payload, &mut met);
        assert!(rest.is_empty(), "{name}: {} bytes that the schema does not know", rest.len());
    }
    assert!(wanted.len() > 60, "the walk over the schema found only {}", wanted.len());
    let missing: Vec<&String> = wanted.difference(&met).collect();
    assert!(missing.is_empty(), "add to samples::all(): {missing:?}");
}
