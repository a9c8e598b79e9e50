//! Do simulated robots leave memory behind? A program of its own, so that no other test's memory counts.

#[cfg(target_os = "linux")]
#[test]
fn two_hundred_robots_one_after_the_other_leave_no_memory_behind() {
    use beeline_tests::robot::{meters, on_robot};
    use shared_proto::{Command, MotionId};
    use sim_target::Scenario;

    fn resident_kib() -> u64 {
        let status = std::fs::read_to_string("/proc/self/status").expect("Linux has it");
        let line = status.lines().find(|line| line.starts_with("VmRSS:")).expect("VmRSS");
        line.split_whitespace().nth(1).and_then(|kib| kib.parse().ok()).expect("a number")
    }
    let one = || {
        on_robot(&Scenario::default(), async |robot| {
            robot.tell(Command::Arm { take: false }).await;
            robot.tell(Command::Drive(meters(1.0, 1.0, 0.2, 0.5).drive_now(MotionId(1)))).await;
            // Taken down in the middle of everything.
            robot.listen(0.1).await;
        });
    };
    for _ in 0..50 {
        one();
    }
    let before_kib = resident_kib();
    for _ in 0..200 {
        one();
    }
    let grown_kib = resident_kib().saturating_sub(before_kib);
    println!("grown by {grown_kib} KiB");
    // The tasks of one robot alone are more than 10 KiB, 200 of them 2 MiB.
    assert!(grown_kib < 1024, "{grown_kib} KiB");
}
