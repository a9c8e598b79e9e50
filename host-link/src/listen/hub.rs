//! Several clients on the robot's line, whatever carries their bytes: TCP, or a simulated network.

use std::io::{Read, Write};
use std::time::Duration;

use shared_proto::Encoder;

use super::client::{Client, ClientEvent, HELD_MAX, UNREAD_MAX};
use super::from_robot::FromRobot;

/// So many clients at once, those that have not said hello yet included.
const CLIENTS_MAX: usize = 32;

/// Who has just connected has so long to be let in before others may take its place: a crowd that connects again and again
/// would cut off a stop in the middle of its handshake.
const GRACE: Duration = Duration::from_millis(25);

/// Nobody is kept out by those who only connect: the one that has been here longest without being let in goes.
fn make_room<S: Read + Write>(clients: &mut Vec<Client<S>>, tell: &mut dyn FnMut(ClientEvent)) {
    if clients.len() < CLIENTS_MAX {
        return;
    }
    // In the order in which they came. If all were let in, the newest goes.
    let stranger = clients.iter().position(|client| !client.is_let_in());
    let gone = clients.remove(stranger.unwrap_or(clients.len() - 1));
    tell(gone.leaving_event());
}

/// The robot's answers are told apart by their sessions, so nobody gets another client's.
fn keep_sessions_apart<S: Read + Write>(
    clients: &mut Vec<Client<S>>,
    tell: &mut dyn FnMut(ClientEvent),
) {
    let sessions: Vec<_> = clients.iter().map(Client::session).collect();
    let mut number = 0;
    clients.retain(|client| {
        // Who is let in has it; of others, the first.
        let rivals = sessions.iter().take(number).any(|other| *other == client.session());
        number += 1;
        let stays = client.session().is_none() || client.is_let_in() || !rivals;
        if !stays {
            tell(ClientEvent::Stranger);
        }
        stays
    });
}

/// The clients of one robot. Times are those of the server, since it began.
pub struct Hub<S> {
    clients: Vec<Client<S>>,
    /// What the robot says, in frames.
    from_robot: FromRobot,
    /// Counts the frames of all clients together, as those of one.
    encoder: Encoder,
}

impl<S> Default for Hub<S> {
    fn default() -> Self {
        Self { clients: Vec::new(), from_robot: FromRobot::default(), encoder: Encoder::new() }
    }
}

impl<S: Read + Write> Hub<S> {
    /// More is never held of a client and for it \[bytes\]: what one write adds comes on top.
    pub const WAITING_MAX_EACH: usize = HELD_MAX + UNREAD_MAX;

    /// Whether there is a place for one more client now. Who waits for it loses nothing.
    pub fn has_place(&self, now: Duration) -> bool {
        let stranger = self.clients.iter().find(|client| !client.is_let_in());
        self.clients.len() < CLIENTS_MAX || stranger.is_none_or(|client| client.age(now) >= GRACE)
    }

    /// A client has connected. Its stream must not block.
    pub fn join(&mut self, stream: S, now: Duration, tell: &mut dyn FnMut(ClientEvent)) {
        make_room(&mut self.clients, tell);
        self.clients.push(Client::new(stream, now));
    }

    /// What is held of a client and for it, of the one with the most \[bytes\].
    pub fn waiting_most(&self) -> usize {
        self.clients.iter().map(Client::waiting).max().unwrap_or(0)
    }

    /// Passes on to the robot what clients have sent, while `room` says that the line takes more bytes.
    pub fn pass_on(
        &mut self,
        now: Duration,
        room: &dyn Fn() -> bool,
        to_robot: &mut dyn FnMut(&[u8]),
        tell: &mut dyn FnMut(ClientEvent),
    ) {
        let Self { clients, from_robot, encoder } = self;
        clients.retain_mut(|client| client.receive(now, from_robot.has_key(), tell));
        keep_sessions_apart(clients, tell);
        // One frame of each in turn: nobody's stop waits for anybody's queue.
        while room() {
            let mut any = false;
            for client in &mut *clients {
                if let Some(frame) = client.next_frame(now, from_robot.has_key(), encoder) {
                    to_robot(&frame);
                    any = true;
                }
            }
            if !any {
                break;
            }
        }
    }

    /// Sends the robot's bytes to the clients that it has let in, and to others what is for them.
    pub fn write(&mut self, bytes: &[u8], now: Duration, tell: &mut dyn FnMut(ClientEvent)) {
        let Self { clients, from_robot, .. } = self;
        let had_key = from_robot.has_key();
        from_robot.push(bytes, &mut |bytes, frame| {
            clients.iter_mut().for_each(|client| client.hear(bytes, frame));
        });
        if from_robot.has_key() && !had_key {
            clients.iter_mut().for_each(|client| client.shut_out(now));
        }
        clients.retain_mut(|client| client.send(tell));
    }
}

#[cfg(test)]
mod tests {
    use std::cell::RefCell;
    use std::collections::VecDeque;
    use std::io::{self, ErrorKind};
    use std::rc::Rc;

    use shared_proto::{Command, Decoder, Hello, Request};

    use super::*;

    /// The server's end of a connection: what the client has sent, and nothing more for now.
    #[derive(Clone, Default)]
    struct Connection(Rc<RefCell<VecDeque<u8>>>);

    impl Read for Connection {
        fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
            match self.0.borrow_mut().read(buffer)? {
                0 => Err(ErrorKind::WouldBlock.into()),
                len => Ok(len),
            }
        }
    }

    impl Write for Connection {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            Ok(bytes.len())
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    fn ms(ms: u64) -> Duration {
        Duration::from_millis(ms)
    }

    #[test]
    fn who_has_just_connected_keeps_its_place_for_a_moment() {
        let mut hub = Hub::default();
        for number in 0..CLIENTS_MAX as u64 {
            assert!(hub.has_place(ms(number)));
            hub.join(Connection::default(), ms(number), &mut |_| ());
        }
        assert!(!hub.has_place(ms(24)), "the oldest has been here for 24 ms");
        assert!(hub.has_place(ms(25)));
        hub.join(Connection::default(), ms(25), &mut |_| ());
        assert!(!hub.has_place(ms(25)), "the next one came at 1 ms");
        assert!(hub.has_place(ms(26)));
    }

    #[test]
    fn of_many_hellos_one_in_20_ms_reaches_the_robot() {
        let (mut hub, connection) = (Hub::default(), Connection::default());
        hub.join(connection.clone(), ms(0), &mut |_| ());
        let mut encoder = Encoder::new();
        let mut passed_on_at = Vec::new();
        for now_ms in 0..60 {
            let hello = encoder.hello(Hello::of_this_build(7));
            connection.0.borrow_mut().extend(hello.iter());
            let mut to_robot = |_: &[u8]| passed_on_at.push(now_ms);
            hub.pass_on(ms(now_ms), &|| true, &mut to_robot, &mut |_| ());
        }
        assert_eq!(passed_on_at, [0, 20, 40]);
    }

    #[test]
    fn nobody_speaks_for_another_host() {
        let (mut hub, driver, other) =
            (Hub::default(), Connection::default(), Connection::default());
        let mut encoder = Encoder::new();
        for (connection, session) in [(&driver, 7), (&other, 8)] {
            hub.join(connection.clone(), ms(0), &mut |_| ());
            connection.0.borrow_mut().extend(encoder.hello(Hello::of_this_build(session)).iter());
        }
        hub.pass_on(ms(0), &|| true, &mut |_| (), &mut |_| ());
        for session in [7, 8] {
            let request = Request { session, id: u32::MAX, until_ms: 0, command: Command::Stop };
            other.0.borrow_mut().extend(encoder.message(&request).iter());
        }
        let (mut decoder, mut sessions) = (Decoder::new(), Vec::new());
        let mut to_robot = |bytes: &[u8]| {
            for byte in bytes {
                if let Some(Ok(frame)) = decoder.push(*byte) {
                    sessions.push(frame.session());
                }
            }
        };
        hub.pass_on(ms(1), &|| true, &mut to_robot, &mut |_| ());
        assert_eq!(sessions, [Some(8)], "what it says in its own session, and nothing else");
    }

    /// A client whose stream takes nothing, and says no error.
    struct TakesNothing(Connection);

    impl Read for TakesNothing {
        fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
            self.0.read(buffer)
        }
    }

    impl Write for TakesNothing {
        fn write(&mut self, _: &[u8]) -> io::Result<usize> {
            Ok(0)
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    #[test]
    fn a_stream_that_takes_nothing_ends_its_client_and_holds_nobody_up() {
        let (mut hub, connection) = (Hub::default(), Connection::default());
        let hello = Encoder::new().hello(Hello::of_this_build(7));
        connection.0.borrow_mut().extend(hello.iter());
        hub.join(TakesNothing(connection), ms(0), &mut |_| ());
        hub.pass_on(ms(0), &|| true, &mut |_| (), &mut |_| ());
        let mut told = Vec::new();
        hub.write(&hello, ms(1), &mut |event| told.push(event));
        assert_eq!((told, hub.clients.len()), (vec![ClientEvent::Disconnected], 0));
    }
}
