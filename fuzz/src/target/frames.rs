//! What crosses the wire, in both directions.

use shared_proto::{
    Channel, Command, Config, Decoder, Encoder, Event, FRAME_LEN_MAX, Hello, Message,
    PAYLOAD_LEN_MAX, Received, Reply, Request, Seal, Telemetry,
};

use crate::bytes::Bytes;

/// The first two bytes choose a bit to flip, the others are a stream.
pub fn frames(input: &[u8]) {
    let mut bytes = Bytes(input);
    let flip = usize::from(u16::from_le_bytes([bytes.byte(), bytes.byte()]));
    let mut decoder = Decoder::new();
    for &byte in bytes.0 {
        let Some(Ok(received)) = decoder.push(byte) else { continue };
        assert!(received.payload.len() <= PAYLOAD_LEN_MAX);
        pass_on(&received, flip);
    }
    // Any payload can be sent, whatever is in it.
    let payload = &bytes.0[..bytes.0.len().min(PAYLOAD_LEN_MAX)];
    pass_on(&Received { channel: Channel::Event, lost: 0, payload, seal: None }, flip);
    let payload = &payload[..payload.len().min(PAYLOAD_LEN_MAX - Seal::LEN)];
    let seal = Some(Seal { counter: flip as u64, tag: [flip as u8; 8] });
    pass_on(&Received { channel: Channel::Event, lost: 0, payload, seal }, flip);
}

/// Sends what has arrived once more, undamaged and with one bit flipped.
fn pass_on(received: &Received<'_>, flip: usize) {
    let mut encoder = Encoder::new();
    let frame = encoder.relay(received);
    assert!(frame.len() <= FRAME_LEN_MAX && frame.iter().filter(|byte| **byte == 0).count() == 1);
    let arrives = |bytes: &[u8]| {
        let mut decoder = Decoder::new();
        let mut whole = None;
        for &byte in bytes {
            if let Some(Ok(received)) = decoder.push(byte) {
                whole = Some((received.channel, received.payload.to_vec(), received.seal));
            }
        }
        whole
    };
    let sent = Some((received.channel, received.payload.to_vec(), received.seal));
    assert_eq!(arrives(&frame), sent);
    let mut damaged = frame.to_vec();
    let bit = flip % (8 * damaged.len());
    damaged[bit / 8] ^= 1 << (bit % 8);
    let arrived = arrives(&damaged);
    // The zero at the end was hit: the frame has not ended yet.
    assert!(arrived.is_none() || arrived == sent, "bit {bit} of {frame:?}: {arrived:?}");
}

/// The first byte is the channel, the others are a payload.
pub fn messages(input: &[u8]) {
    let mut bytes = Bytes(input);
    let Some(channel) = Channel::from_number(bytes.byte() % 7) else { return };
    let payload = &bytes.0[..bytes.0.len().min(PAYLOAD_LEN_MAX)];
    let received = Received { channel, lost: 0, payload, seal: None };
    match channel {
        Channel::Hello => {
            let Some(hello) = received.hello() else { return };
            let again = hello.to_bytes();
            assert_eq!(Hello::from_bytes(&again), Some(hello));
        }
        Channel::Request => {
            if let Some(Request { command: Command::WriteConfig(config), .. }) = round(&received) {
                in_its_ranges(&config);
            }
        }
        Channel::Reply => drop(round::<Reply>(&received)),
        Channel::Telemetry => drop(round::<Telemetry>(&received)),
        Channel::Event => drop(round::<Event>(&received)),
        Channel::Open => drop(received.open()),
        Channel::Opened => assert_eq!(received.opened(), None, "it has no seal"),
    }
}

/// Reads a message, writes and reads it again. Bytes are compared, as no number equals itself that is none.
fn round<M: Message>(received: &Received<'_>) -> Option<M> {
    let message: M = received.message()?;
    let written = postcard::to_allocvec(&message).expect("what was read can be written");
    assert!(written.len() <= M::LEN_MAX, "{} bytes", written.len());
    let again = Received { payload: &written, ..*received };
    let again: M = again.message().expect("what was written can be read");
    let rewritten = postcard::to_allocvec(&again).expect("and written");
    assert_eq!(written, rewritten);
    Some(message)
}

/// What passes the check has every number in its range.
pub fn in_its_ranges(config: &Config) {
    if config.validate().is_err() {
        return;
    }
    for field in Config::FIELDS {
        let value = (field.read)(config);
        assert!((field.min..=field.max).contains(&value), "{} = {value}", field.path);
    }
}
