//! Every message arrives as it was sent.

use proptest::collection::vec;
use proptest::prelude::*;
use shared_proto::*;

use crate::decoding::{decode, parts};
use crate::samples::Any;
use crate::strategy;

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2048))]

    #[test]
    fn every_message_arrives_as_it_was_sent(message in strategy::message(), skip in 0..1000_u16) {
        let mut encoder = Encoder::new();
        for _ in 0..skip {
            encoder.hello(Hello::of_this_build(0));
        }
        let frame = message.frame(&mut encoder.clone());
        prop_assert!(frame.len() <= FRAME_LEN_MAX);
        prop_assert_eq!(frame.iter().position(|&byte| byte == 0), Some(frame.len() - 1));

        let found = decode(&mut Decoder::new(), &frame);
        prop_assert_eq!(found.len(), 1);
        let arrived = found[0].clone().expect("a good frame");
        // As bytes, because a NaN differs from itself; that of a configuration arrives as it is,
        // and is for `validate` to refuse.
        prop_assert_eq!(&*arrived.frame(&mut encoder), &*frame);
        prop_assert_eq!(format!("{arrived:?}"), format!("{message:?}"));
    }

    #[test]
    fn no_payload_is_longer_than_its_bound(message in strategy::message()) {
        let frame = message.frame(&mut Encoder::new());
        let (channel, payload) = parts(&frame);
        let bound = LengthBound::ALL[channel as usize];
        prop_assert!(payload.len() <= bound.payload_len);
        prop_assert!(frame.len() <= bound.frame_len);
    }

    #[test]
    fn a_stream_of_messages_arrives_in_order_with_none_lost(messages in vec(strategy::message(), 0..20)) {
        let mut encoder = Encoder::new();
        let mut decoder = Decoder::new();
        for message in &messages {
            let frame = message.frame(&mut encoder);
            let (last, rest) = frame.split_last().unwrap();
            for &byte in rest {
                prop_assert!(decoder.push(byte).is_none());
            }
            let received = decoder.push(*last).unwrap().unwrap();
            prop_assert_eq!(received.lost, 0);
            prop_assert_eq!(format!("{:?}", Any::read(&received).unwrap()), format!("{message:?}"));
        }
    }

    #[test]
    fn arbitrary_bytes_never_panic_and_leave_the_decoder_in_step(
        noise in vec(any::<u8>(), 0..3000),
        message in strategy::message(),
    ) {
        let mut decoder = Decoder::new();
        decode(&mut decoder, &noise);
        decoder.push(0);
        let found = decode(&mut decoder, &message.frame(&mut Encoder::new()));
        prop_assert_eq!(format!("{found:?}"), format!("{:?}", [Ok::<_, FrameError>(message)]));
    }

    #[test]
    fn an_arbitrary_payload_never_panics(payload in vec(any::<u8>(), 0..=PAYLOAD_LEN_MAX), number in 0..7_u8) {
        let channel = Channel::from_number(number).unwrap();
        // Mostly `None`; what is read must at least fit into a frame again.
        if let Some(message) = Any::read(&Received { channel, lost: 0, payload: &payload, seal: None }) {
            prop_assert!(message.frame(&mut Encoder::new()).len() <= FRAME_LEN_MAX);
        }
    }
}
