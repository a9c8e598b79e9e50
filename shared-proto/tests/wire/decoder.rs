//! The decoder's edge cases one by one, on frames made by hand from the documentation alone.

use shared_proto::*;

use crate::decoding::{decode, parts};
use crate::golden::{from_hex, hex};
use crate::samples::Any;

/// CRC-32/ISO-HDLC bit by bit: reflected polynomial 0xEDB88320, all ones at both ends.
fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(u32::MAX, |crc, &byte| {
        (0..8).fold(crc ^ u32::from(byte), |crc, _| (crc >> 1) ^ (0xEDB8_8320 * (crc & 1)))
    })
}

/// COBS as in Cheshire and Baker (1999): blocks of up to 254 bytes without a zero, each after its
/// length plus one; a shorter block stands for its bytes and a zero.
fn cobs(bytes: &[u8]) -> Vec<u8> {
    let mut encoded = vec![0];
    let mut code_at = 0;
    for (i, &byte) in bytes.iter().enumerate() {
        if byte != 0 {
            encoded.push(byte);
        }
        let block_len = encoded.len() - code_at;
        let full = block_len == 255 && i + 1 < bytes.len();
        if byte == 0 || full {
            encoded[code_at] = block_len as u8;
            code_at = encoded.len();
            encoded.push(0);
        }
    }
    encoded[code_at] = (encoded.len() - code_at) as u8;
    encoded
}

/// A frame from its parts.
pub fn by_hand(channel: u8, sequence: u16, payload: &[u8]) -> Vec<u8> {
    let mut raw = vec![channel];
    raw.extend(sequence.to_le_bytes());
    raw.extend(payload);
    raw.extend(crc32(&raw).to_le_bytes());
    let mut frame = cobs(&raw);
    frame.push(0);
    frame
}

fn event(t_us: u64) -> Any {
    Any::Event(Event::State { t_us, state: State::Idle })
}

#[test]
fn the_checksum_has_its_published_check_value() {
    // CRC catalogue, CRC-32/ISO-HDLC.
    assert_eq!(crc32(b"123456789"), 0xCBF4_3926);
}

#[test]
fn frames_made_by_hand_are_those_of_the_encoder() {
    for (name, golden) in crate::golden::lines() {
        let Some((_, message)) = crate::samples::all().into_iter().find(|(n, _)| *n == name) else {
            continue;
        };
        let (channel, payload) = parts(&from_hex(&golden));
        if matches!(channel, Channel::Open | Channel::Opened) {
            // Sealed: `key.rs` has those.
            continue;
        }
        assert_eq!(hex(&by_hand(channel as u8, 0, &payload)), golden, "{name}: {message:?}");
    }
}

#[test]
fn empty_frames_are_neither_frames_nor_errors() {
    assert_eq!(decode(&mut Decoder::new(), &[0; 100]), []);
}

#[test]
fn noise_without_a_zero_costs_the_frame_behind_it_and_no_more() {
    let mut encoder = Encoder::new();
    let mut bytes = vec![0x55; 20];
    bytes.extend(&*event(1).frame(&mut encoder));
    bytes.extend(&*event(2).frame(&mut encoder));
    let found = decode(&mut Decoder::new(), &bytes);
    assert_eq!(found.len(), 2);
    assert!(found[0].is_err());
    assert_eq!(found[1], Ok(event(2)));
}

#[test]
fn two_frames_glued_by_a_lost_zero_are_one_error() {
    let mut encoder = Encoder::new();
    let first = event(1).frame(&mut encoder);
    let mut bytes = first[..first.len() - 1].to_vec();
    bytes.extend(&*event(2).frame(&mut encoder));
    bytes.extend(&*event(3).frame(&mut encoder));
    let found = decode(&mut Decoder::new(), &bytes);
    assert_eq!(found.len(), 2);
    assert!(found[0].is_err());
    assert_eq!(found[1], Ok(event(3)));
}

#[test]
fn a_frame_longer_than_any_is_skipped_whole() {
    for len in [FRAME_LEN_MAX + 1, FRAME_LEN_MAX * 10] {
        let mut encoder = Encoder::new();
        let mut bytes = vec![1; len];
        bytes.push(0);
        bytes.extend(&*event(1).frame(&mut encoder));
        let found = decode(&mut Decoder::new(), &bytes);
        assert_eq!(found, [Err(FrameError::TooLong), Ok(event(1))], "{len} bytes");
    }
}

#[test]
fn the_longest_payload_passes_and_one_byte_more_does_not() {
    // Without and with zeros: COBS at its longest and at its shortest.
    for fill in [0xAA, 0] {
        let (_, payload) = parts(&by_hand(0, 0x0101, &[fill; PAYLOAD_LEN_MAX]));
        assert_eq!(payload.len(), PAYLOAD_LEN_MAX);
        let too_long = by_hand(0, 0x0101, &[fill; PAYLOAD_LEN_MAX + 1]);
        assert_eq!(decode(&mut Decoder::new(), &too_long), [Err(FrameError::TooLong)]);
    }
}

#[test]
fn a_frame_too_short_for_a_checksum_is_malformed() {
    for raw in 1..7 {
        let mut bytes = cobs(&vec![0xAA; raw]);
        bytes.push(0);
        let found = decode(&mut Decoder::new(), &bytes);
        assert_eq!(found, [Err(FrameError::Malformed)], "{raw} bytes");
    }
}

#[test]
fn bytes_behind_a_message_make_it_unreadable() {
    let mut payload = from_hex("05070001"); // session 5, request 7: status
    let mut decoder = Decoder::new();
    for (trailing, readable) in [(&[][..], true), (&[0][..], false), (&[1, 2, 3][..], false)] {
        payload.truncate(4);
        payload.extend(trailing);
        let frame = by_hand(1, 0, &payload);
        let message = frame.iter().fold(None, |_, &byte| {
            decoder.push(byte).map(|r| r.expect("a good frame").message::<Request>())
        });
        assert_eq!(message.expect("a frame").is_some(), readable, "{trailing:?}");
    }
}

#[test]
fn a_frame_that_ends_with_a_whole_block_of_cobs_ends_with_a_zero() {
    // One byte of this request is zero, and what follows it steps through the 254 bytes of a block. Behind it stands
    // the CRC, of four bytes.
    let (_, golden) = parts(&crate::golden::frame("request.write_config"));
    let mut behind = Vec::new();
    for zero in 0..golden.len() {
        let mut payload: Vec<u8> = golden.iter().map(|&byte| byte.max(1)).collect();
        payload[zero] = 0;
        let received =
            Received { channel: Channel::Request, lost: 0, payload: &payload, seal: None };
        // In a length or a flag it may be another message, or none.
        let Some(request) = received.message::<Request>() else { continue };
        let frame = Encoder::new().message(&request);
        assert_eq!(frame.iter().position(|&byte| byte == 0), Some(frame.len() - 1));
        let read = decode(&mut Decoder::new(), &frame);
        assert_eq!(read, [Ok(Any::Request(request))], "zero at {zero}");
        behind.push(payload.len() - 1 - zero + 4);
    }
    assert!((250..=258).all(|len| behind.contains(&len)), "{behind:?}");
}

#[test]
fn a_name_longer_than_any_is_not_cut_but_unreadable() {
    assert!(Name::new(&"x".repeat(NAME_LEN_MAX)).is_some());
    assert!(Name::new(&"x".repeat(NAME_LEN_MAX + 1)).is_none());
    let (_, golden) = parts(&crate::golden::frame("request.write_config"));
    // Of a command without further fields, only what is before them is left.
    let head = parts(&crate::golden::frame("request.save_config")).1.len();
    let behind_the_name = &golden[head + 1 + golden[head] as usize..];
    for (len, readable) in [(NAME_LEN_MAX, true), (NAME_LEN_MAX + 1, false)] {
        let mut payload = golden[..head].to_vec();
        payload.push(len as u8);
        payload.extend(vec![b'x'; len]);
        payload.extend(behind_the_name);
        let received =
            Received { channel: Channel::Request, lost: 0, payload: &payload, seal: None };
        assert_eq!(received.message::<Request>().is_some(), readable, "{len} bytes");
    }
}

#[test]
fn a_message_is_not_read_as_one_of_another_channel() {
    let frame = by_hand(2, 0, &from_hex("0701"));
    let mut decoder = Decoder::new();
    let read = frame.iter().fold(None, |_, &byte| {
        decoder.push(byte).map(|r| r.map(|r| (r.message::<Request>().is_some(), r.hello())))
    });
    assert_eq!(read, Some(Ok((false, None))));
}

#[test]
fn a_channel_that_is_not_ours_is_named() {
    for channel in [7, 0x7F, 0x87, 255] {
        let frame = by_hand(channel, 0, &[]);
        let found = decode(&mut Decoder::new(), &frame);
        assert_eq!(found, [Err(FrameError::Channel)], "{channel}");
    }
}

#[test]
fn a_hello_of_a_later_version_still_names_it() {
    let mut bytes = Hello { protocol: 9, schema: 8, session: 7 }.to_bytes().to_vec();
    bytes.extend(b"and more");
    let found = decode(&mut Decoder::new(), &by_hand(0, 0, &bytes));
    assert_eq!(found, [Ok(Any::Hello(Hello { protocol: 9, schema: 8, session: 7 }))]);
}

#[test]
fn gaps_in_the_sequence_are_counted_and_repetitions_are_not() {
    let mut decoder = Decoder::new();
    let mut lost = |channel: u8, sequence: u16| {
        let frame = by_hand(channel, sequence, &[]);
        frame.iter().fold(None, |_, &byte| decoder.push(byte).map(|r| r.unwrap().lost)).unwrap()
    };
    assert_eq!(lost(4, 500), 0, "the first frame shows no gap");
    assert_eq!(lost(4, 501), 0);
    assert_eq!(lost(4, 501), 0, "twice");
    assert_eq!(lost(4, 505), 3);
    assert_eq!(lost(4, 0xFFFE), 0, "so far ahead is rather behind");
    assert_eq!(lost(4, 1), 2, "over the wrap");
    assert_eq!(lost(0, 900), 0, "a hello starts a new count");
    assert_eq!(lost(4, 901), 0);
}
