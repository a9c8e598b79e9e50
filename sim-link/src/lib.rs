//! The simulated robot as a host reaches it: in this process in virtual time ([`session`]), or
//! behind a port in real time ([`Server`]).
//!
//! The crate connects `host-link` and `sim-target`, so that neither knows the other. The emulated
//! board, another robot on the simulator's clock, uses it as well. What is simulated is left to
//! `sim-target`.

mod remote;
mod serve;

use std::cell::RefCell;
use std::rc::Rc;

use host_link::clock::{Clock, TimeSource};
use host_link::motion::Trigger;
use host_link::session::Session;
use host_link::wire::{Waiting, Wire};
use sim_target::{HostWire, Testbed};

pub use host_link::listen::{ClientEvent, ClientLog};
pub use remote::{RemoteTestbed, RobotEnded, TestbedRequests};
pub use serve::{ServeError, ServeEvent, ServeOptions, Server, serve};

/// A session with the robot at the other end of this wire, in virtual time; not opened yet.
///
/// `number` must differ from that of the robot's last session; `port` is what errors call the wire.
pub fn session(wire: &HostWire, number: u32, port: impl Into<String>) -> Session {
    Session::new(SimWire(wire.clone()), Clock::new(VirtualTime), number, port.into())
}

/// Triggers the testbed's camera when a recording begins.
pub fn camera_trigger(testbed: Testbed) -> Trigger {
    Rc::new(move |t_us| testbed.trigger_camera(t_us))
}

/// The host's end of the simulated serial line.
pub struct SimWire(pub HostWire);

impl Wire for SimWire {
    fn write<'a>(&'a mut self, bytes: &'a [u8]) -> Waiting<'a, std::io::Result<()>> {
        Box::pin(async move {
            self.0.write(bytes).await;
            Ok(())
        })
    }

    fn read(&mut self) -> Waiting<'_, std::io::Result<Vec<u8>>> {
        Box::pin(async move {
            let mut buffer = vec![0; 512];
            let len = self.0.read(&mut buffer).await;
            buffer.truncate(len);
            Ok(buffer)
        })
    }
}

/// The same, and what the host sends is kept, write by write: for tests that send it again.
pub struct RecordedWire(pub SimWire, pub Rc<RefCell<Vec<Vec<u8>>>>);

impl Wire for RecordedWire {
    fn write<'a>(&'a mut self, bytes: &'a [u8]) -> Waiting<'a, std::io::Result<()>> {
        self.1.borrow_mut().push(bytes.to_vec());
        self.0.write(bytes)
    }

    fn read(&mut self) -> Waiting<'_, std::io::Result<Vec<u8>>> {
        self.0.read()
    }
}

/// This thread's virtual time.
struct VirtualTime;

impl TimeSource for VirtualTime {
    fn now_us(&self) -> u64 {
        sim_target::now_us()
    }

    fn sleep_until_us(&self, t_us: u64) -> Waiting<'_, ()> {
        Box::pin(sim_target::sleep_until_us(t_us))
    }

    fn is_virtual(&self) -> bool {
        true
    }
}
