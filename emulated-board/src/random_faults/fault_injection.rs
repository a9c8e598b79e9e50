//! Makes a fault happen, and mends it.

use std::cell::Cell;
use std::rc::Rc;

use shared_proto::Driver;
use sim_target::plant::PlantFault;
use sim_target::{HostWire, Testbed, now_us, sleep_until_us};

use super::fault_kind::FaultKind;
use crate::bug::{Bug, Effect, Place};
use crate::flash_array::blank;
use crate::monitor::BoardMonitor;
use crate::motor_driver::Wiring;

/// What the host still does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Host {
    /// All that a host does.
    Well,
    /// Renews no motion, and asks for the status.
    Hangs,
    /// Nothing.
    Dead,
}

/// Everything that can be broken.
#[derive(Clone)]
pub(super) struct World {
    pub testbed: Testbed,
    pub monitor: BoardMonitor,
    pub wire: HostWire,
    pub host: Rc<Cell<Host>>,
    pub supply_v: f64,
    /// The configured motor driver.
    pub driver: Driver,
    /// What is wrong with the supply and lasts: a dip, once it is over, does not mend it.
    pub lasting: Rc<Cell<Option<PlantFault>>>,
}

/// Bytes of garbage that are kept waiting for the line: it never falls silent, and what the host says
/// besides is hardly late.
const WAITING: usize = 150;

impl World {
    /// Makes it happen. Returns at once where it lasts, and at its end where it has one.
    pub async fn inject(&self, kind: FaultKind) {
        if let Some(fault) = self.plant_fault(kind) {
            self.testbed.inject(fault);
        }
        match kind {
            FaultKind::EncoderLine(wheel, fault) => self.monitor.break_line(wheel, Some(fault)),
            FaultKind::SupplyCut | FaultKind::SupplyLow(_) | FaultKind::SupplyHigh(_) => {
                self.lasting.set(self.plant_fault(kind));
            }
            FaultKind::SupplyDip(_, ms) | FaultKind::StopButton(ms) => {
                sleep_until_us(now_us() + 1000 * u64::from(ms)).await;
                self.mend(kind);
                if let (FaultKind::SupplyDip(..), Some(lasting)) = (kind, self.lasting.get()) {
                    self.testbed.inject(lasting);
                }
            }
            FaultKind::WrongName(driver) => self.solder(driver),
            FaultKind::StopLine => self.monitor.open_stop_line(true),
            FaultKind::StopLineBounce(us) => {
                self.monitor.open_stop_line(true);
                sleep_until_us(now_us() + u64::from(us)).await;
                self.monitor.open_stop_line(false);
            }
            FaultKind::LinkCut => self.wire.set_cut(true),
            FaultKind::LinkToRobotCut => self.wire.cut_to_robot(true),
            FaultKind::LinkToHostCut => self.wire.cut_to_host(true),
            FaultKind::HostDies => self.host.set(Host::Dead),
            FaultKind::HostHangs => self.host.set(Host::Hangs),
            FaultKind::Garbage(ms) => self.flood(ms).await,
            FaultKind::TaskStops(task) => self.plant_bug(Place::Task(task), Effect::Stop),
            FaultKind::CoreStands(ms) => {
                self.plant_bug(Place::Task("heartbeat"), Effect::Stall { ms })
            }
            FaultKind::Program(_, place, effect) => self.plant_bug(place, effect),
            FaultKind::ClockFails => self.monitor.fail_clock(),
            // Nothing was saved.
            FaultKind::PowerCut => self.monitor.power_cycle(blank()),
            FaultKind::ResetPin => self.monitor.pull_reset(),
            _ => {}
        }
    }

    /// Ends what has not ended by itself. A restart has removed what was in the program.
    pub fn mend(&self, kind: FaultKind) {
        if let Some(fault) = self.plant_fault(kind) {
            self.testbed.mend(fault);
        }
        match kind {
            FaultKind::EncoderLine(wheel, _) => self.monitor.break_line(wheel, None),
            FaultKind::WrongName(_) => self.solder(self.driver),
            FaultKind::StopLine => self.monitor.open_stop_line(false),
            FaultKind::LinkCut | FaultKind::LinkToRobotCut | FaultKind::LinkToHostCut => {
                self.wire.set_cut(false)
            }
            _ => {}
        }
    }

    /// What happens to the plant, if this is of the plant.
    fn plant_fault(&self, kind: FaultKind) -> Option<PlantFault> {
        Some(match kind {
            FaultKind::EncoderUnplugged(wheel) => PlantFault::EncoderUnplugged(wheel),
            FaultKind::EncoderSwapped(wheel) => PlantFault::EncoderReversed(wheel),
            FaultKind::EncoderNoise(wheel, rate) => PlantFault::EncoderNoise(wheel, rate),
            FaultKind::EncodersExchanged => PlantFault::EncodersExchanged,
            FaultKind::MotorsExchanged => PlantFault::MotorsExchanged,
            FaultKind::MotorReversed(wheel) => PlantFault::MotorReversed(wheel),
            FaultKind::MotorCut(wheel) => PlantFault::MotorUnplugged(wheel),
            FaultKind::WheelBlocked(wheel) => PlantFault::WheelBlocked(wheel),
            FaultKind::WheelJammed(wheel) => PlantFault::WheelJammed(wheel),
            FaultKind::SupplyCut => PlantFault::SupplyDip { volts: self.supply_v },
            FaultKind::SupplyLow(volts) | FaultKind::SupplyDip(volts, _) => {
                PlantFault::SupplyDip { volts }
            }
            FaultKind::SupplyHigh(volts) => PlantFault::SupplyDip { volts: -volts },
            FaultKind::Driver => PlantFault::DriverFault,
            FaultKind::StopButton(_) => PlantFault::EmergencyStop,
            _ => return None,
        })
    }

    fn solder(&self, driver: Driver) {
        self.monitor.solder(Wiring { driver, ..Wiring::default() });
    }

    fn plant_bug(&self, place: Place, effect: Effect) {
        self.monitor.plant(Bug { place, effect });
    }

    /// Keeps the line to the robot full of noise.
    async fn flood(&self, ms: u16) {
        let until_us = now_us() + 1000 * u64::from(ms);
        let mut noise = 1_u64;
        while now_us() < until_us {
            // A line that is cut takes all and keeps nothing waiting.
            while self.monitor.waiting() < WAITING && now_us() < until_us {
                // Every byte there is, and a zero at the end: else the host's next frame would be part of it.
                let mut bytes = [0; 100];
                for byte in &mut bytes[..99] {
                    noise = noise.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
                    *byte = (noise >> 56) as u8;
                }
                self.wire.write_now(&bytes);
                // The monitor is updated at every step.
                sleep_until_us(now_us() + 60).await;
            }
            sleep_until_us(now_us() + 100).await;
        }
    }
}
