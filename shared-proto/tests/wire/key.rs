//! Seals: what is changed, sent again elsewhere or sealed by another key shows; the page's numbers are these.

use proptest::prelude::*;
use shared_proto::*;

use crate::{golden, samples, strategy};

/// What one frame carries, with its seal.
fn received<T>(frame: &[u8], look: impl FnOnce(&Received<'_>) -> T) -> T {
    let mut decoder = Decoder::new();
    let (last, rest) = frame.split_last().expect("a frame");
    assert!(rest.iter().all(|&byte| decoder.push(byte).is_none()));
    look(&decoder.push(*last).expect("the frame's end").expect("an undamaged frame"))
}

/// A frame with one bit of what it carries flipped, and its checksum made anew: as somebody on the way can.
fn forged(frame: &[u8], bit: usize) -> Vec<u8> {
    let mut raw = frame[..frame.len() - 1].to_vec();
    let len = cobs::decode_in_place(&mut raw).expect("a frame");
    raw.truncate(len - 4);
    raw[bit / 8] ^= 1 << (bit % 8);
    let crc = Crc32::new().over(&raw).value().to_le_bytes();
    raw.extend(crc);
    let mut encoded = vec![0; cobs::max_encoding_length(raw.len())];
    let len = cobs::encode(&raw, &mut encoded);
    encoded.truncate(len);
    encoded.push(0);
    encoded
}

fn status(counter: u64) -> Frame {
    let request = Request { session: 0xA1B2, id: 7, until_ms: 0, command: Command::Status };
    Encoder::new().sealed_message(&request, Some((&samples::session_key(), counter)))
}

#[test]
fn no_bit_of_a_sealed_frame_can_be_flipped_but_those_of_its_number_on_the_line() {
    let key = samples::session_key();
    let frame = status(5);
    let bits = 8 * (frame.len() - 2 - 4);
    let mut genuine = Vec::new();
    for bit in 0..bits {
        let mut decoder = Decoder::new();
        for byte in forged(&frame, bit) {
            if let Some(Ok(frame)) = decoder.push(byte)
                && frame.is_sealed_by(&key)
            {
                genuine.push(bit);
            }
        }
    }
    // The sequence number: whoever passes frames on counts them anew.
    assert_eq!(genuine, (8..24).collect::<Vec<_>>());
}

#[test]
fn a_frame_passed_on_keeps_its_seal() {
    let key = samples::session_key();
    let frame = status(5);
    let relayed = received(&frame, |frame| {
        let mut encoder = Encoder::new();
        encoder.relay(frame);
        encoder.relay(frame)
    });
    assert_ne!(*relayed, *frame);
    assert!(received(&relayed, |frame| frame.is_sealed_by(&key) && frame.session() == Some(0xA1B2)));
}

proptest! {
    #[test]
    fn a_sealed_message_is_read_back_and_is_sealed_by_its_key_alone(
        message in strategy::message(),
        key in any::<[u8; 16]>(),
        counter in any::<u64>(),
        bit in 0..128_usize,
    ) {
        let mut other = key;
        other[bit / 8] ^= 1 << (bit % 8);
        let (key, other) = (Key::new(key), Key::new(other));
        let by = Some((&key, counter));
        let mut encoder = Encoder::new();
        let frame = match &message {
            samples::Any::Request(message) => encoder.sealed_message(message, by),
            samples::Any::Reply(message) => encoder.sealed_message(message, by),
            samples::Any::Telemetry(message) => encoder.sealed_message(message, by),
            samples::Any::Event(message) => encoder.sealed_message(message, by),
            _ => return Ok(()),
        };
        received(&frame, |frame| {
            prop_assert_eq!(frame.seal.map(|seal| seal.counter), Some(counter));
            prop_assert!(frame.is_sealed_by(&key));
            prop_assert!(!frame.is_sealed_by(&other));
            prop_assert_eq!(format!("{:?}", samples::Any::read(frame)), format!("{:?}", Some(&message)));
            Ok(())
        })?;
    }
}

#[test]
fn the_keys_and_sealed_frames_in_the_page_are_those_of_this_build() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/protocol.md");
    let page = std::fs::read_to_string(path).expect("docs/protocol.md is there");
    let robot_key = Key::new(samples::bytes(0)).of_robot(&samples::bytes(0x30));
    let reply = Reply { session: 0xA1B2, id: 7, t_us: 20_975_000, outcome: Ok(Answer::Done) };
    let reply = Encoder::new().sealed_message(&reply, Some((&robot_key, 1001)));
    for (name, value) in [
        ("pre-shared key", golden::hex(&samples::bytes(0))),
        ("host's hello", golden::hex(&samples::host_hello().to_bytes())),
        ("host's nonce", golden::hex(&samples::bytes(0x10))),
        ("challenge", golden::hex(&samples::bytes(0x20))),
        ("boot", golden::hex(&samples::bytes(0x30))),
        ("session's key", golden::hex(samples::session_key().expose())),
        ("robot's key", golden::hex(robot_key.expose())),
        ("hello, challenge", golden::hex(&golden::frame("hello.challenge"))),
        ("Open", golden::hex(&golden::frame("open"))),
        ("Opened", golden::hex(&golden::frame("opened"))),
        ("request, Status", golden::hex(&status(1))),
        ("reply, Done", golden::hex(&reply)),
    ] {
        let line = format!("{name:<18}{value}");
        assert!(page.contains(&line), "docs/protocol.md should say\n{line}");
    }
}
