//! Does a new command while the robot moves ever make the setpoint jump?

use beeline_tests::robot::{Robot, meters, on_robot};
use host_link::motion::{Motion, RecordOptions, drive};
use shared_proto::{Command, MotionEnd, Refusal, State, Telemetry, Wheel};
use sim_target::Scenario;

/// A line that never delays: telemetry of every control tick gets through.
pub fn fast_line() -> Scenario {
    let mut scenario = Scenario::default();
    scenario.link.baud = 0;
    scenario
}

/// Control period [s].
const DT_S: f64 = 0.001;
/// Setpoints come in whole micrometres, rounded down: a second difference of three is off by 2 at most.
const ROUNDING_UM: f64 = 2.0;

/// The setpoint's velocity never steps by more than acceleration x time, from tick to tick and over
/// ten ticks, where the rounding matters less. Returns the largest acceleration over ten ticks.
pub fn check_no_jump(telemetry: &[Telemetry], acceleration_mps2: f64) -> f64 {
    let tracking: Vec<&Telemetry> = telemetry
        .iter()
        .skip_while(|t| t.probing || t.state != State::Driving)
        .filter(|t| matches!(t.state, State::Driving | State::Stopping))
        .collect();
    assert!(tracking.len() > 500, "{} ticks", tracking.len());
    let mut largest_mps2: f64 = 0.0;
    for stride in [1, 10] {
        for window in tracking.windows(2 * stride + 1) {
            let (a, b, c) = (window[0], window[stride], window[2 * stride]);
            let ticks = (c.t_us - a.t_us) as f64 * 1e-6 / DT_S;
            assert_eq!(ticks, 2.0 * stride as f64, "a tick is missing at {} us", a.t_us);
            for wheel in Wheel::BOTH {
                let at = |t: &Telemetry| t.wheels.get(wheel).setpoint_um as f64;
                let step_um = at(c) - 2.0 * at(b) + at(a);
                let time_s = stride as f64 * DT_S;
                let bound_um = acceleration_mps2 * time_s * time_s * 1e6 + ROUNDING_UM;
                assert!(
                    step_um.abs() <= bound_um,
                    "{} wheel at {} us: {step_um} um over {stride} ticks, bound {bound_um}",
                    wheel.name(),
                    b.t_us
                );
                if stride == 10 {
                    largest_mps2 =
                        largest_mps2.max((step_um.abs() - ROUNDING_UM) * 1e-6 / (time_s * time_s));
                }
            }
        }
    }
    largest_mps2
}

async fn subscribed(robot: &mut Robot) {
    robot.tell(Command::Subscribe { period_ms: 1 }).await;
}

async fn finished(robot: &mut Robot) -> (Vec<Telemetry>, Option<MotionEnd>) {
    let id = robot.session.status().await.expect("it answers").motion.expect("it drove");
    robot.finish(id).await;
    let status = robot.session.status().await.expect("it answers");
    assert_eq!(status.fault, None);
    (robot.session.take_telemetry().collect(), status.motion_end)
}

/// How far a robot moves in two seconds after a motion up a slope of 8 degrees \[m\], if it holds its place so long.
fn creeps_m(hold_s: f64) -> f64 {
    let mut scenario = Scenario::default();
    scenario.plant.floor.slope_rad = 0.14;
    scenario.plant.body.payload_kg = 2.0;
    on_robot(&scenario, async |robot| {
        let mut config = robot.session.read_config().await.expect("it answers");
        config.limits.hold_s = hold_s;
        robot.session.write_config(&config).await.expect("valid");
        let id = robot.cruise(&meters(0.3, 0.3, 0.2, 0.5), 0.5).await;
        robot.finish(id).await;
        robot.listen(0.3).await;
        let stands = robot.snapshot();
        robot.listen(2.0).await;
        assert_eq!((robot.state().await, robot.fault().await), (State::Armed, None));
        let moved_m = robot.snapshot().moved_since_m(&stands);
        // And it goes on from where it is.
        let id = robot.cruise(&meters(0.1, 0.1, 0.2, 0.5), 0.3).await;
        robot.finish(id).await;
        assert_eq!(robot.fault().await, None);
        moved_m
    })
}

#[test]
fn a_robot_that_holds_its_place_stays_on_a_slope_where_another_creeps() {
    let (holds_m, creeps_m) = (creeps_m(60.0), creeps_m(0.0));
    println!("holds: {:.2} mm, without: {:.2} mm", holds_m * 1e3, creeps_m * 1e3);
    assert!(holds_m < 5e-4, "{holds_m}");
    assert!(creeps_m > 10.0 * holds_m.max(1e-4), "{creeps_m}");
}

#[test]
fn reversing_in_the_middle_of_a_cruise_does_not_jump() {
    on_robot(&fast_line(), async |robot| {
        subscribed(robot).await;
        robot.cruise(&meters(2.0, 2.0, 0.3, 0.5), 2.0).await;
        robot.drive(&meters(-0.3, -0.3, 0.3, 0.5)).await.expect("accepted");
        let (telemetry, end) = finished(robot).await;
        assert_eq!(end, Some(MotionEnd::Completed));
        let largest = check_no_jump(&telemetry, 0.5);
        // Two-sided: a plan that is too slow would meet any upper bound.
        assert!(largest > 0.45, "{largest}");
    });
}

#[test]
fn a_stop_in_the_middle_of_a_ramp_does_not_jump_and_leaves_the_robot_armed() {
    on_robot(&fast_line(), async |robot| {
        subscribed(robot).await;
        let id = robot.cruise(&meters(2.0, 2.0, 0.4, 0.25), 1.4).await;
        robot.tell(Command::Stop).await;
        // Sent twice, it is a retry.
        robot.tell(Command::Stop).await;
        robot.renew(id, 0.1).await;
        let (telemetry, end) = finished(robot).await;
        assert_eq!((end, robot.state().await), (Some(MotionEnd::Stopped), State::Armed));
        check_no_jump(&telemetry, 0.5);
    });
}

#[test]
fn any_motion_may_replace_any_other_without_a_jump() {
    let motions: [Motion; 4] = [
        meters(0.8, 0.8, 0.4, 0.5),
        meters(-0.3, 0.3, 0.2, 0.4),
        meters(0.1, 0.5, 0.3, 0.5),
        meters(-0.6, -0.2, 0.25, 0.3),
    ];
    for first in &motions {
        for second in &motions {
            on_robot(&fast_line(), async |robot| {
                subscribed(robot).await;
                robot.cruise(first, 0.9).await;
                let id = robot.drive(second).await.expect("accepted");
                robot.renew(id, 0.35).await;
                robot.drive(first).await.expect("accepted");
                let (telemetry, end) = finished(robot).await;
                assert_eq!(end, Some(MotionEnd::Completed));
                check_no_jump(&telemetry, 0.5);
            });
        }
    }
}

#[test]
fn disarming_while_driving_stops_first_and_then_lets_go() {
    on_robot(&fast_line(), async |robot| {
        subscribed(robot).await;
        let id = robot.cruise(&meters(2.0, 2.0, 0.3, 0.5), 1.5).await;
        robot.tell(Command::Disarm).await;
        assert_eq!(robot.state().await, State::Stopping);
        assert!(matches!(robot.drive(&meters(1.0, 1.0, 0.3, 0.5)).await, Err(Refusal::State(_))));
        robot.renew(id, 0.2).await;
        let (telemetry, end) = finished(robot).await;
        assert_eq!((end, robot.state().await), (Some(MotionEnd::Stopped), State::Idle));
        check_no_jump(&telemetry, 0.5);
        robot.listen(0.01).await;
        assert!(!robot.snapshot().is_powered());
    });
}

#[test]
fn a_motion_that_replaces_another_goes_as_far_as_it_says_from_where_it_began() {
    on_robot(&fast_line(), async |robot| {
        subscribed(robot).await;
        robot.cruise(&meters(2.0, 2.0, 0.3, 0.5), 1.5).await;
        let at_um = |t: &Telemetry| t.wheels.left.setpoint_um as f64;
        let from_um = robot.session.take_telemetry().last().map(|t| at_um(&t)).expect("telemetry");
        robot.drive(&meters(0.5, 0.5, 0.3, 0.5)).await.expect("accepted");
        let (telemetry, _) = finished(robot).await;
        let tracked = telemetry.iter().rfind(|t| t.state == State::Driving).expect("it drove");
        let way_um = at_um(tracked) - from_um;
        // The plan starts 10 ticks ahead, at 0.3 m/s: 3 mm; the last telemetry is a tick old.
        assert!((way_um - 503_000.0).abs() < 700.0, "{way_um}");
    });
}

/// What a host says that may not drive.
async fn refused(robot: &mut Robot, motion: &Motion) -> String {
    let options = RecordOptions::default();
    let driven = drive(&mut robot.session, motion, options, &mut |_| {}).await;
    driven.expect_err("it must not drive").to_string()
}

#[test]
fn a_drive_that_is_refused_leaves_the_motion_of_another_host_alone() {
    on_robot(&fast_line(), async |robot| {
        let id = robot.cruise(&meters(1.0, 1.0, 0.3, 0.5), 1.0).await;
        // Another host on the same line would have another motion driven.
        let driver = robot.another_host(2).await;
        let error = refused(robot, &Motion::PAPER).await;
        assert!(error.contains("already driving"), "{error}");
        let status = robot.session.status().await.expect("it answers");
        assert_eq!((status.state, status.motion), (State::Driving, Some(id)));
        robot.session = driver;
        let (_, end) = finished(robot).await;
        assert_eq!(end, Some(MotionEnd::Completed), "to its own target");
    });
}

#[test]
fn a_drive_that_is_refused_leaves_an_armed_robot_armed_and_an_idle_one_idle() {
    on_robot(&fast_line(), async |robot| {
        let too_fast = Motion { cruise: 100.0, ..Motion::PAPER };
        for state in [State::Idle, State::Armed] {
            if state == State::Armed {
                robot.tell(Command::Arm { take: false }).await;
            }
            let error = refused(robot, &too_fast).await;
            assert!(error.contains("limits.speed_mps_max"), "{error}");
            assert_eq!(robot.state().await, state);
            assert_eq!(robot.fault().await, None);
        }
    });
}
