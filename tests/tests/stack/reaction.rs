//! A push of one wheel that rolls the other one a little.

use beeline_tests::robot::{meters, on_robot};
use shared_proto::{Command, Fault, Wheel};
use sim_target::plant::PlantFault;

use crate::rolling::coasting;

#[test]
fn a_dead_encoder_is_not_exchanged_with_that_of_a_wheel_that_the_push_rolls_a_little() {
    for counts_per_rev in [2797.0, 3651.0, 8000.0, 20_000.0] {
        for friction in [0.6, 0.8, 1.0] {
            for payload_kg in [0.0, 1.0, 2.0] {
                let (scenario, config) = coasting(counts_per_rev, payload_kg, friction);
                on_robot(&scenario, async |robot| {
                    robot.session.write_config(&config).await.expect("valid");
                    robot.testbed.inject(PlantFault::EncoderUnplugged(Wheel::Right));
                    robot.tell(Command::Arm { take: false }).await;
                    let id = robot.drive(&meters(0.1, 0.1, 0.04, 0.03)).await.expect("accepted");
                    robot.renew(id, 3.0).await;
                    let case = (counts_per_rev, friction, payload_kg);
                    let fault = robot.fault().await.map(|report| report.fault);
                    println!("{case:?}: {fault:?}");
                    // `encoders_exchanged`, where the left wheel rolled 0.2 mm.
                    assert_eq!(fault, Some(Fault::NoResponse(Wheel::Right)), "{case:?}");
                });
            }
        }
    }
}
