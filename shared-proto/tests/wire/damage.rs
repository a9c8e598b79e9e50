//! A million damaged frames: none is taken for what it is not, and the next good one is found.

use proptest::strategy::{Strategy, ValueTree};
use proptest::test_runner::TestRunner;
use shared_proto::{Channel, Decoder, Encoder, Frame, Received};

use crate::samples::Any;
use crate::strategy;

const DAMAGED_FRAMES: usize = 1_000_000;
const SEED: u64 = 20260;

/// SplitMix64 (Steele, Lea and Flood 2014): the same numbers on every machine.
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    fn below(&mut self, end: usize) -> usize {
        (self.next() % end as u64) as usize
    }

    fn byte(&mut self) -> u8 {
        self.next() as u8
    }
}

/// What happens to the bytes of one or two frames on a bad line.
#[derive(Clone, Copy, Debug)]
enum Damage {
    BitFlips,
    Burst,
    Drop,
    Duplicate,
    Truncation,
    Insertion,
    Several,
}

const DAMAGES: [Damage; 7] = [
    Damage::BitFlips,
    Damage::Burst,
    Damage::Drop,
    Damage::Duplicate,
    Damage::Truncation,
    Damage::Insertion,
    Damage::Several,
];

impl Damage {
    fn apply(self, bytes: &mut Vec<u8>, random: &mut Random) {
        let start = random.below(bytes.len());
        let end = start + 1 + random.below((bytes.len() - start).min(20));
        // Now and then, a frame as a whole.
        let stretch = match bytes.iter().position(|&byte| byte == 0) {
            Some(zero) if random.below(5) == 0 => 0..zero + 1,
            _ => start..end,
        };
        match self {
            Damage::BitFlips => {
                for _ in 0..1 + random.below(4) {
                    let at = random.below(bytes.len());
                    bytes[at] ^= 1 << random.below(8);
                }
            }
            Damage::Burst => {
                bytes[start..end].iter_mut().for_each(|byte| *byte = random.byte());
            }
            Damage::Drop => {
                bytes.drain(stretch);
            }
            Damage::Duplicate => {
                let again = bytes[stretch.clone()].to_vec();
                bytes.splice(stretch.end..stretch.end, again);
            }
            Damage::Truncation => {
                // The sender is cut off, and starts again with the next frame.
                bytes.truncate(start);
            }
            Damage::Insertion => {
                let noise: Vec<u8> = (0..1 + random.below(20)).map(|_| random.byte()).collect();
                bytes.splice(start..start, noise);
            }
            Damage::Several => {
                for _ in 0..2 + random.below(3) {
                    let one = DAMAGES[random.below(DAMAGES.len() - 1)];
                    if !bytes.is_empty() {
                        one.apply(bytes, random);
                    }
                }
            }
        }
    }
}

/// A message, and what of it must arrive.
#[derive(Clone)]
struct Content {
    message: Any,
    channel: Channel,
    payload: Vec<u8>,
}

impl Content {
    fn of(message: Any) -> Self {
        let (channel, payload) = crate::decoding::parts(&message.frame(&mut Encoder::new()));
        Self { message, channel, payload }
    }

    fn arrived_as(&self, received: &Received<'_>) -> bool {
        self.channel == received.channel && self.payload == received.payload
    }
}

/// A frame as sent.
struct Sent<'a> {
    /// Its place in the order of sending.
    number: u64,
    content: &'a Content,
    frame: Frame,
}

/// The sending end.
struct Sender<'a> {
    encoder: Encoder,
    pool: &'a [Content],
    sent: u64,
    /// Those sent last, which are not sent again so soon: they could not be told apart.
    recent: [usize; 4],
}

impl<'a> Sender<'a> {
    fn send(&mut self, random: &mut Random) -> Sent<'a> {
        let at = loop {
            let at = random.below(self.pool.len());
            let payload = &self.pool[at].payload;
            if self.recent.iter().all(|&recent| self.pool[recent].payload != *payload) {
                break at;
            }
        };
        self.recent[(self.sent % 4) as usize] = at;
        self.sent += 1;
        let content = &self.pool[at];
        Sent { number: self.sent, content, frame: content.message.frame(&mut self.encoder) }
    }
}

/// The receiving end, and what it may not do.
struct Judge {
    decoder: Decoder,
    /// Number of the last frame that arrived.
    last: Option<u64>,
}

impl Judge {
    /// Hands over bytes that came of these frames; answers how many frames arrived intact, and how
    /// many were refused.
    fn receive(
        &mut self,
        bytes: &[u8],
        of: &[&Sent<'_>],
        context: &dyn Fn() -> String,
    ) -> (u32, u32) {
        let (mut intact, mut refused) = (0, 0);
        for &byte in bytes {
            let received = match self.decoder.push(byte) {
                None => continue,
                Some(Err(_)) => {
                    refused += 1;
                    continue;
                }
                Some(Ok(received)) => received,
            };
            let Some(sent) = of.iter().find(|sent| sent.content.arrived_as(&received)) else {
                panic!("accepted what nobody sent: {received:?}\n{}", context());
            };
            // The gap that its place in the sending order must show.
            let lost = match self.last {
                Some(last) if received.channel != Channel::Hello && sent.number > last => {
                    sent.number - last - 1
                }
                _ => 0,
            };
            assert_eq!(u64::from(received.lost), lost, "frames lost\n{}", context());
            self.last = Some(sent.number);
            intact += 1;
        }
        (intact, refused)
    }
}

#[test]
fn of_a_million_damaged_frames_none_is_accepted_with_wrong_content() {
    println!("seed {SEED}");
    let mut random = Random(SEED);
    let mut runner = TestRunner::deterministic();
    let strategy = strategy::message();
    let mut pool: Vec<Content> =
        (0..2000).map(|_| Content::of(strategy.new_tree(&mut runner).unwrap().current())).collect();
    pool.extend(crate::samples::all().into_iter().map(|(_, message)| Content::of(message)));

    let mut sender = Sender { encoder: Encoder::new(), pool: &pool, sent: 0, recent: [0; 4] };
    let mut judge = Judge { decoder: Decoder::new(), last: None };
    let mut outcomes = [(0_u32, 0_u32, 0_u32); DAMAGES.len()];
    let mut damaged = 0;
    while damaged < DAMAGED_FRAMES {
        // One frame, or two with the damage anywhere across them.
        let group: Vec<Sent<'_>> =
            (0..1 + random.below(4) / 3).map(|_| sender.send(&mut random)).collect();
        let whole: Vec<u8> = group.iter().flat_map(|sent| sent.frame.iter().copied()).collect();
        let kind = random.below(DAMAGES.len());
        let mut bytes = whole.clone();
        DAMAGES[kind].apply(&mut bytes, &mut random);
        if bytes == whole {
            // A burst of what was there already.
            judge.receive(&bytes, &group.iter().collect::<Vec<_>>(), &|| "undamaged".to_string());
            continue;
        }
        damaged += 1;

        let next = sender.send(&mut random);
        let after = sender.send(&mut random);
        let mut candidates: Vec<&Sent<'_>> = group.iter().collect();
        let context = || format!("{:?}, sent {whole:02x?}, arrived {bytes:02x?}", DAMAGES[kind]);
        let (intact, refused) = judge.receive(&bytes, &candidates, &context);
        let outcome = &mut outcomes[kind];
        outcome.0 += 1;
        outcome.1 += intact;
        outcome.2 += refused;

        // If the damage took the zero at the end, it took the frame behind it as well.
        let in_step = bytes.last().is_none_or(|&byte| byte == 0);
        candidates.push(&next);
        let (found, refused) = judge.receive(&next.frame, &candidates, &context);
        outcome.2 += refused;
        assert!(found == 1 || !in_step, "out of step at the next good frame\n{}", context());
        let (found, _) = judge.receive(&after.frame, &[&after], &context);
        assert_eq!(found, 1, "out of step at the good frame after that\n{}", context());
    }
    for (damage, (groups, intact, refused)) in DAMAGES.iter().zip(outcomes) {
        println!("{damage:?}: {groups} groups damaged, {intact} frames intact, {refused} refused");
        // The damage is real. A frame dropped or repeated as a whole leaves nothing to refuse.
        assert!(groups > 100_000 && refused > groups / 2, "{damage:?} does little harm");
    }
}
