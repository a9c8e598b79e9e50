//! Every driver by its name: what the image's lines make of it, by its data sheet.

use emulated_board::{Bench, Emulation, MotorEffect, Wiring};
use host_link::motion::Motion;
use shared_proto::{
    Answer, AtFault, Command, Config, ConfigOrigin, Driver, DriverConfig, Fault, Refusal, State,
    TravelUnit, Wheel, WheelPair,
};
use sim_target::plant::PlantFault;
use sim_target::{now_us, sleep_until_us};

use super::robot::{AHEAD, Robot};
use super::{emulation, uneventful};

/// What a bridge does all the time.
const BRAKE: MotorEffect = MotorEffect { forward: 0.0, backward: 0.0, brake: 1.0, coast: 0.0 };
const COAST: MotorEffect = MotorEffect { brake: 0.0, coast: 1.0, ..BRAKE };

/// A driver, and what its data sheet says becomes of a motor: off, standing, and between the pulses.
struct Case {
    driver: Driver,
    off: MotorEffect,
    standing: MotorEffect,
    slow_decay: bool,
}

const fn case(driver: Driver) -> Case {
    Case { driver, off: COAST, standing: BRAKE, slow_decay: true }
}

static CASES: [Case; 10] = [
    case(Driver::PwmDir),
    // Wired to an MX1508, which opens its outputs when both inputs are low.
    Case { standing: COAST, slow_decay: false, ..case(Driver::In1In2) },
    case(Driver::PwmIn1In2),
    case(Driver::L298n),
    case(Driver::Tb6612),
    case(Driver::Drv8833),
    case(Driver::Drv8871),
    case(Driver::Bts7960),
    case(Driver::Vnh5019),
    Case { off: BRAKE, ..case(Driver::Md10c) },
];

/// The board with this driver.
fn wired(driver: Driver) -> Emulation {
    Emulation { wiring: Wiring { driver, ..Wiring::default() }, ..emulation() }
}

/// A robot whose configuration has this driver.
async fn configured(bench: Bench, driver: DriverConfig) -> Robot {
    let mut robot = Robot::meet(bench).await;
    robot.configure(driver).await;
    robot
}

impl Robot {
    async fn configure(&mut self, driver: DriverConfig) {
        let config = Config { driver, ..self.0.session.read_config().await.unwrap() };
        self.0.session.write_config(&config).await.unwrap();
    }

    /// Exchanges the driver, on the board and in the configuration, while the motors are off.
    async fn exchange(&mut self, driver: DriverConfig) {
        self.0.monitor.solder(Wiring { driver: driver.name, ..Wiring::default() });
        self.configure(driver).await;
        self.listen(1).await;
    }

    fn assert_both(&self, expected: MotorEffect, when: &str, driver: Driver) {
        let effect = self.0.monitor.motor_effect();
        assert_eq!(effect, WheelPair::both(expected), "{}, {when}", driver.name());
    }

    /// Drives at a steady speed; the wheels must turn this way, and the bridges drive nothing else.
    async fn assert_turns(&mut self, sign: f64, case: &Case) {
        let motion = Motion { distance: WheelPair::both(20.0 * sign), ..AHEAD };
        let before = self.0.testbed.plant(|plant| plant.wheel_angles_rad());
        let id = self.cruise(&motion, 1_800).await;
        let effect = self.0.monitor.motor_effect();
        let after = self.0.testbed.plant(|plant| plant.wheel_angles_rad());
        let name = case.driver.name();
        for wheel in Wheel::BOTH {
            let turned_rad = (after.get(wheel) - before.get(wheel)) * sign;
            // 0.523 turns/s after the encoder check and one second of ramp.
            assert!((2.0..4.5).contains(&turned_rad), "{name}, {sign}: {turned_rad} rad");
            let MotorEffect { forward, backward, brake, coast } = *effect.get(wheel);
            let (with, against) =
                if sign > 0.0 { (forward, backward) } else { (backward, forward) };
            assert!((0.1..0.6).contains(&with) && against == 0.0, "{name}, {sign}: {effect:?}");
            let rest = if case.slow_decay { coast } else { brake };
            assert_eq!(rest, 0.0, "{name}, {sign}: {effect:?}");
        }
        self.renew(id, 50).await;
        self.rest().await;
        // Drivers that coast let the wheels roll on.
        self.listen(300).await;
    }
}

// One life for all drivers: of a life of its own most would be the emulator's translation of the image.
#[test]
fn each_driver_drives_both_wheels_ahead_and_back_brakes_at_a_standstill_and_is_off_when_it_is_off()
{
    let ended = emulation()
        .run(|bench| async move {
            let mut robot = Robot::meet(bench).await;
            for case in &CASES {
                robot.exchange(DriverConfig { name: case.driver, ..DriverConfig::default() }).await;
                robot.assert_both(case.off, "idle", case.driver);
                robot.tell(Command::Arm { take: false }).await;
                robot.listen(5).await;
                robot.assert_both(case.standing, "armed", case.driver);
                assert_eq!(robot.0.monitor.pwm_period_ns(), Some(50_000));
                robot.rest().await;
                robot.assert_both(case.off, "disarmed", case.driver);
                robot.assert_turns(1.0, case).await;
                robot.assert_turns(-1.0, case).await;
                robot.assert_both(case.off, "after the motions", case.driver);
            }
        })
        .unwrap();
    uneventful(&ended);
}

/// What the bridges do 5 ms after a fault at cruise, and after its clearing.
async fn after_a_fault(robot: &mut Robot, config: DriverConfig) -> [WheelPair<MotorEffect>; 2] {
    robot.exchange(config).await;
    let id = robot.cruise(&AHEAD, 1_000).await;
    robot.tell(Command::EmergencyStop).await;
    robot.renew(id, 5).await;
    let at_once = robot.0.monitor.motor_effect();
    robot.listen(500).await;
    assert_eq!(robot.0.monitor.motor_effect(), at_once, "it stays so");
    let number = robot.fault().await.expect("it was stopped").number;
    robot.tell(Command::ClearFault { number }).await;
    robot.listen(5).await;
    [at_once, robot.0.monitor.motor_effect()]
}

const AT_A_FAULT: [(Driver, AtFault, MotorEffect); 9] = [
    (Driver::PwmDir, AtFault::Off, COAST),
    (Driver::PwmDir, AtFault::Brake, BRAKE),
    (Driver::L298n, AtFault::Coast, COAST),
    (Driver::L298n, AtFault::Brake, BRAKE),
    (Driver::Tb6612, AtFault::Brake, BRAKE),
    (Driver::Drv8833, AtFault::Brake, BRAKE),
    (Driver::Drv8871, AtFault::Coast, COAST),
    (Driver::Drv8871, AtFault::Brake, BRAKE),
    (Driver::Vnh5019, AtFault::Brake, BRAKE),
];

#[test]
fn at_a_fault_the_motors_coast_or_brake_as_configured_until_it_is_cleared() {
    let ended = emulation()
        .run(|bench| async move {
            let mut robot = Robot::meet(bench).await;
            for (name, at_fault, expected) in AT_A_FAULT {
                let config = DriverConfig { name, at_fault, ..DriverConfig::default() };
                let [at_once, cleared] = after_a_fault(&mut robot, config).await;
                let case = format!("{} {}", name.name(), at_fault.name());
                assert_eq!(at_once, WheelPair::both(expected), "{case}");
                assert_eq!(cleared, WheelPair::both(COAST), "{case} cleared");
            }
        })
        .unwrap();
    uneventful(&ended);
}

#[test]
fn a_stop_in_idle_switches_no_driver_on_to_brake() {
    let ended = wired(Driver::L298n)
        .run(|bench| async move {
            let at_fault = AtFault::Brake;
            let config = DriverConfig { name: Driver::L298n, at_fault, ..DriverConfig::default() };
            let mut robot = configured(bench, config).await;
            robot.tell(Command::EmergencyStop).await;
            robot.listen(20).await;
            robot.assert_both(COAST, "stopped in idle", Driver::L298n);
        })
        .unwrap();
    uneventful(&ended);
}

#[test]
fn an_inverted_enable_line_and_an_inverted_fault_line_are_right_from_the_first_instant() {
    let wiring = Wiring { driver: Driver::PwmDir, enable_inverted: true, fault_inverted: true };
    let ended = Emulation { wiring, ..emulation() }
        .run(|bench| async move {
            let driver = DriverConfig {
                enable_inverted: true,
                fault_inverted: true,
                pwm_hz: 16_000.0,
                ..DriverConfig::default()
            };
            let mut robot = configured(bench, driver).await;
            robot.0.session.save_config().await.unwrap();
            robot.0.monitor.pull_reset();
            let until_us = now_us() + 100_000;
            while now_us() < until_us {
                sleep_until_us(now_us() + 50).await;
                robot.assert_both(COAST, "while it starts", Driver::PwmDir);
            }
            robot.meet_again(2).await;
            robot.tell(Command::Arm { take: false }).await;
            robot.listen(5).await;
            robot.assert_both(BRAKE, "armed", Driver::PwmDir);
            assert_eq!(robot.0.monitor.pwm_period_ns(), Some(62_500));
            robot.0.testbed.inject(PlantFault::DriverFault);
            robot.listen(50).await;
            let fault = robot.fault().await.map(|report| report.fault);
            assert_eq!(fault, Some(shared_proto::Fault::Driver));
            robot.assert_both(COAST, "at the driver's fault", Driver::PwmDir);
        })
        .unwrap();
    assert_eq!((ended.resets, ended.unexpected), (1, Vec::new()));
}

#[test]
fn a_driver_without_a_fault_line_ignores_the_pin_and_no_driver_is_exchanged_while_armed() {
    let ended = wired(Driver::L298n)
        .run(|bench| async move {
            let l298n = DriverConfig { name: Driver::L298n, ..DriverConfig::default() };
            let mut robot = configured(bench, l298n).await;
            robot.0.testbed.inject(PlantFault::DriverFault);
            robot.tell(Command::Arm { take: false }).await;
            robot.listen(100).await;
            assert_eq!(robot.status().await.state, State::Armed);
            let mut config = robot.0.session.read_config().await.unwrap();
            config.driver.name = Driver::Drv8833;
            let armed = Err(Refusal::State(State::Armed));
            assert_eq!(robot.ask(Command::WriteConfig(config)).await, armed);
            let factory = Command::RestoreConfig(ConfigOrigin::Factory);
            assert_eq!(robot.ask(factory).await, armed);
            let Answer::Config(config) = robot.tell(Command::ReadConfig).await else {
                panic!("not a configuration");
            };
            assert_eq!(config.driver, l298n);
            robot.tell(Command::WriteConfig(config)).await;
        })
        .unwrap();
    uneventful(&ended);
}

/// 5 cm, ahead or back.
const SHORT: Motion = Motion {
    unit: TravelUnit::Meter,
    distance: WheelPair::both(0.05),
    cruise: 0.1,
    acceleration: 0.5,
};
/// Before a fault is named no wheel turns farther with its motor on \[mm\].
const NAMED_MM: f64 = 10.0;
/// A driver that takes the lines as another one does drives to the end, or, if it brakes where that one coasts, nearly \[mm\].
const REACHED_MM: f64 = 3.0;
/// What a wrong name may be called: by the reversed encoder's name where a push the one way is one the other way.
const WRONG_NAME: [Fault; 3] =
    [Fault::Driver, Fault::NoResponse(Wheel::Left), Fault::EncoderReversed(Wheel::Left)];

/// One of each kind of lines that the firmware has, and of each kind of driver that takes them.
const CONFIGURED: [Driver; 4] = [Driver::PwmDir, Driver::L298n, Driver::Drv8833, Driver::Tb6612];
const SOLDERED: [Driver; 6] =
    [Driver::PwmDir, Driver::Md10c, Driver::In1In2, Driver::L298n, Driver::Tb6612, Driver::Drv8871];

/// A motion with a driver that is not the configured one: its fault, and how far each wheel turned in the direction of the motion
/// until the motors were off \[mm\].
async fn with_a_wrong_name(
    robot: &mut Robot,
    soldered: Driver,
    config: DriverConfig,
    sign: f64,
) -> (Option<Fault>, WheelPair<f64>) {
    robot.0.monitor.solder(Wiring { driver: soldered, ..Wiring::default() });
    robot.configure(config).await;
    robot.listen(20).await;
    let before_rad = robot.0.testbed.plant(|plant| plant.wheel_angles_rad());
    let motion = Motion { distance: WheelPair::both(0.05 * sign), ..SHORT };
    let id = robot.cruise(&motion, 100).await;
    while robot.status().await.state == State::Driving {
        robot.renew(id, 30).await;
    }
    robot.listen(100).await;
    let powered = robot.0.monitor.powered();
    let after_rad = powered.last().map_or(before_rad, |powered| powered.angles_rad);
    let turned_mm = after_rad.zip(before_rad).map(|(to, from)| (to - from) * 36.0 * sign);
    (robot.fault().await.map(|report| report.fault), turned_mm)
}

/// The driver is the configured one again.
async fn mend(robot: &mut Robot, driver: Driver) {
    robot.0.monitor.solder(Wiring { driver, ..Wiring::default() });
    robot.listen(100).await;
    if let Some(report) = robot.fault().await {
        robot.tell(Command::ClearFault { number: report.number }).await;
    }
    robot.rest().await;
    // Drivers that coast let the wheels roll on.
    robot.listen(200).await;
}

// One life for all, as above.
#[test]
fn a_wrong_name_is_found_before_a_wheel_has_turned_a_centimetre_or_does_no_harm() {
    let ended = emulation()
        .run(|bench| async move {
            let mut robot = Robot::meet(bench).await;
            let mut named_driver = 0;
            for (i, name) in CONFIGURED.into_iter().enumerate() {
                for (k, soldered) in SOLDERED.into_iter().enumerate() {
                    for sign in [1.0, -1.0] {
                        // Not even to brake may the motors of a driver of another kind stay on.
                        let at_fault = if (i + k) % 2 == 0 { AtFault::Off } else { AtFault::Brake };
                        let config = DriverConfig { name, at_fault, ..DriverConfig::default() };
                        let (fault, mm) =
                            with_a_wrong_name(&mut robot, soldered, config, sign).await;
                        named_driver += usize::from(fault == Some(Fault::Driver));
                        let right = match fault {
                            None => mm.all(|mm| (mm - 50.0).abs() < REACHED_MM),
                            Some(fault) => {
                                WRONG_NAME.contains(&fault) && mm.all(|mm| mm.abs() < NAMED_MM)
                            }
                        };
                        let case = format!("{} for {}", name.name(), soldered.name());
                        assert!(right, "{case}, {sign}: {fault:?} after {mm:?} mm");
                        mend(&mut robot, name).await;
                    }
                }
            }
            // Zero is full duty: two inputs high to a direction input, and to two direction inputs; those to a direction input.
            assert_eq!(named_driver, 2 * (3 + 2));
        })
        .unwrap();
    uneventful(&ended);
}
