//! The configuration in use and in flash: written, read, saved, restored, and refused.

use beeline_tests::robot::{meters, on_robot, on_robot_with};
use shared_proto::{Answer, Command, Config, ConfigError, ConfigOrigin, Refusal, State};
use sim_target::{Options, Scenario, now_us};

fn with_wheel_weight(value: f64) -> Config {
    let mut config = Config::default();
    config.geometry.wheel_weight = value;
    config
}

#[test]
fn written_is_in_use_saved_survives_and_factory_comes_back() {
    let folder = tempfile::tempdir().expect("a folder");
    let flash = || Options { flash: Some(folder.path().join("flash.toml")), ..Options::default() };
    let (saved, unsaved) = (with_wheel_weight(0.99), with_wheel_weight(1.01));

    on_robot_with(&Scenario::default(), flash(), async |robot| {
        let identity = robot.session.identify().await.expect("it answers");
        assert_eq!((identity.config_origin, identity.unsaved), (ConfigOrigin::Factory, false));
        robot.session.write_config(&saved).await.expect("valid");
        assert!(robot.session.identify().await.expect("it answers").unsaved);
        robot.session.save_config().await.expect("writable");
        let identity = robot.session.identify().await.expect("it answers");
        assert_eq!((identity.config_origin, identity.unsaved), (ConfigOrigin::Saved, false));
        robot.session.write_config(&unsaved).await.expect("valid");
    });
    // Power off and on: the unsaved one is forgotten.
    on_robot_with(&Scenario::default(), flash(), async |robot| {
        let identity = robot.session.identify().await.expect("it answers");
        assert_eq!((identity.config_origin, identity.unsaved), (ConfigOrigin::Saved, false));
        assert_eq!(robot.session.read_config().await.expect("it answers"), saved);
        robot.session.write_config(&unsaved).await.expect("valid");
        let session = &mut robot.session;
        assert_eq!(session.restore_config(ConfigOrigin::Saved).await.expect("there"), saved);
        let factory = session.restore_config(ConfigOrigin::Factory).await.expect("there");
        assert_eq!(factory, Config::default());
        assert!(session.identify().await.expect("it answers").unsaved);
    });
    // Restoring the factory's is not saving it.
    on_robot_with(&Scenario::default(), flash(), async |robot| {
        assert_eq!(robot.session.read_config().await.expect("it answers"), saved);
    });
}

#[test]
fn a_flash_that_cannot_be_written_keeps_what_it_had() {
    let config = Some(with_wheel_weight(0.99));
    on_robot_with(&Scenario::default(), Options { config, ..Options::default() }, async |robot| {
        let content = robot.testbed.flash_content();
        robot.session.write_config(&with_wheel_weight(1.01)).await.expect("valid");
        robot.testbed.write_protect_flash(true);
        assert_eq!(robot.ask(Command::SaveConfig).await, Err(Refusal::Store));
        assert_eq!(robot.testbed.flash_content(), content);
        let session = &mut robot.session;
        // The written configuration is still in use, and reported as unsaved.
        assert!(session.identify().await.expect("it answers").unsaved);
        assert_eq!(session.read_config().await.expect("there").geometry.wheel_weight, 1.01);
        let saved = session.restore_config(ConfigOrigin::Saved).await.expect("there");
        assert_eq!(saved.geometry.wheel_weight, 0.99);
        robot.testbed.write_protect_flash(false);
        robot.tell(Command::SaveConfig).await;
    });
}

#[test]
fn somebodys_file_is_not_taken_for_a_flash() {
    let folder = tempfile::tempdir().expect("a folder");
    let notes = folder.path().join("notes.txt");
    std::fs::write(&notes, "name = \"my notes\"\n").expect("writable");
    let options = Options { flash: Some(notes.clone()), ..Options::default() };
    assert!(sim_target::SimTarget::new(&Scenario::default(), options).is_err());
    assert_eq!(std::fs::read_to_string(notes).expect("still there"), "name = \"my notes\"\n");
}

#[test]
fn damaged_flash_boots_with_the_factory_configuration_and_says_so() {
    let folder = tempfile::tempdir().expect("a folder");
    let whole = folder.path().join("whole.toml");
    on_robot_with(
        &Scenario::default(),
        Options { flash: Some(whole.clone()), ..Options::default() },
        async |robot| {
            robot.session.write_config(&with_wheel_weight(0.99)).await.expect("valid");
            robot.session.save_config().await.expect("writable");
        },
    );
    let whole = std::fs::read_to_string(whole).expect("saved");
    let damages = [
        ("half", whole[..whole.len() / 2].to_string()),
        (
            "erased",
            whole.lines().next().unwrap_or_default().to_string() + &"\n\u{fffd}".repeat(100),
        ),
        ("unphysical", whole.replace("wheel_weight = 0.99", "wheel_weight = 9.9")),
        ("of another layout", whole.replacen('\n', "\nunheard_of = 1\n", 1)),
    ];
    for (name, text) in damages {
        assert_ne!(text, whole, "{name}");
        let flash = folder.path().join(format!("{name}.toml"));
        std::fs::write(&flash, text).expect("writable");
        let options = Options { flash: Some(flash), ..Options::default() };
        on_robot_with(&Scenario::default(), options, async |robot| {
            let identity = robot.session.identify().await.expect("it answers");
            assert!(identity.store_damaged, "{name}: says nothing");
            assert_eq!(identity.config_origin, ConfigOrigin::Factory, "{name}");
            let config = robot.session.read_config().await.expect("it answers");
            assert_eq!(config, Config::default(), "{name}");
            // Saving repairs it.
            robot.session.save_config().await.expect("writable");
            assert!(!robot.session.identify().await.expect("it answers").store_damaged, "{name}");
        });
    }
}

#[test]
fn saving_is_refused_while_armed_and_writing_while_driving() {
    on_robot(&Scenario::default(), async |robot| {
        robot.tell(Command::Arm { take: false }).await;
        assert_eq!(robot.ask(Command::SaveConfig).await, Err(Refusal::State(State::Armed)));
        robot.cruise(&meters(1.0, 1.0, 0.2, 0.5), 1.0).await;
        let config = with_wheel_weight(0.9);
        let driving = Err(Refusal::State(State::Driving));
        assert_eq!(robot.ask(Command::SaveConfig).await, driving);
        assert_eq!(robot.ask(Command::WriteConfig(config)).await, driving);
        for origin in [ConfigOrigin::Factory, ConfigOrigin::Saved] {
            assert_eq!(robot.ask(Command::RestoreConfig(origin)).await, driving);
        }
        assert_eq!(robot.tell(Command::ReadConfig).await, Answer::Config(Config::default()));
        assert_eq!(robot.testbed.flash_content(), None);
    });
}

#[test]
fn a_host_that_saves_all_the_time_cannot_wear_out_the_flash_within_the_hour() {
    on_robot(&Scenario::default(), async |robot| {
        let start_us = now_us();
        let mut saves = 0;
        while now_us() < start_us + 20_000_000 {
            let wheel_weight = if saves % 2 == 0 { 0.9 } else { 1.1 };
            robot.tell(Command::WriteConfig(with_wheel_weight(wheel_weight))).await;
            robot.session.save_config().await.expect("it saves, if later");
            saves += 1;
        }
        assert!((18..=21).contains(&saves), "{saves} in 20 s");
        // Nothing new is nothing to write.
        let start_us = now_us();
        for _ in 0..50 {
            robot.session.save_config().await.expect("saved already");
        }
        assert!(now_us() < start_us + 1_000_000);
    });
}

#[test]
fn a_motion_right_after_a_new_configuration_starts_where_the_wheels_are() {
    let mut scenario = Scenario::default();
    scenario.link.baud = 0;
    on_robot(&scenario, async |robot| {
        let id = robot.cruise(&meters(1.0, 1.0, 0.4, 0.5), 1.0).await;
        robot.finish(id).await;
        // The same counts are another travel now. Nothing is between the two but the line.
        robot.tell(Command::WriteConfig(with_wheel_weight(0.9))).await;
        let start = robot.snapshot();
        let id = robot.drive(&meters(0.1, 0.1, 0.2, 0.5)).await.expect("armed");
        robot.finish(id).await;
        assert_eq!(robot.fault().await, None);
        let way_m = robot.snapshot().rolled_m.left - start.rolled_m.left;
        assert!((way_m - 0.1).abs() < 0.001, "{way_m}");
    });
}

/// A configuration with one field set.
fn with_field(path: &str, value: f64) -> Config {
    let mut config = Config::default();
    *field_mut(&mut config, path) = value;
    config
}

fn field_mut<'a>(config: &'a mut Config, path: &str) -> &'a mut f64 {
    let encoder = &mut config.encoder;
    match path {
        "geometry.wheel_radius_m" => &mut config.geometry.wheel_radius_m,
        "geometry.track_width_m" => &mut config.geometry.track_width_m,
        "geometry.wheel_weight" => &mut config.geometry.wheel_weight,
        "geometry.heading_pull_rad_per_m" => &mut config.geometry.heading_pull_rad_per_m,
        "encoder.left.counts_per_rev" => &mut encoder.left.counts_per_rev,
        "encoder.left.gear_reduction" => &mut encoder.left.gear_reduction,
        "encoder.right.counts_per_rev" => &mut encoder.right.counts_per_rev,
        "encoder.right.gear_reduction" => &mut encoder.right.gear_reduction,
        "pid.kp_per_m" => &mut config.pid.kp_per_m,
        "pid.ki_per_m_s" => &mut config.pid.ki_per_m_s,
        "pid.kd_s_per_m" => &mut config.pid.kd_s_per_m,
        "feedforward.left.ks_forward_v" => &mut config.feedforward.left.ks_forward_v,
        "feedforward.left.ks_backward_v" => &mut config.feedforward.left.ks_backward_v,
        "feedforward.left.kv_v_s_per_m" => &mut config.feedforward.left.kv_v_s_per_m,
        "feedforward.left.ka_v_s2_per_m" => &mut config.feedforward.left.ka_v_s2_per_m,
        "feedforward.right.ks_forward_v" => &mut config.feedforward.right.ks_forward_v,
        "feedforward.right.ks_backward_v" => &mut config.feedforward.right.ks_backward_v,
        "feedforward.right.kv_v_s_per_m" => &mut config.feedforward.right.kv_v_s_per_m,
        "feedforward.right.ka_v_s2_per_m" => &mut config.feedforward.right.ka_v_s2_per_m,
        "feedforward.supply_v" => &mut config.feedforward.supply_v,
        "limits.speed_mps_max" => &mut config.limits.speed_mps_max,
        "limits.acceleration_mps2_max" => &mut config.limits.acceleration_mps2_max,
        "limits.stop_deceleration_mps2" => &mut config.limits.stop_deceleration_mps2,
        "limits.duty_max" => &mut config.limits.duty_max,
        "limits.hold_s" => &mut config.limits.hold_s,
        "limits.duty_slew_per_s" => &mut config.limits.duty_slew_per_s,
        "protection.following_error_m_max" => &mut config.protection.following_error_m_max,
        "protection.stall_time_s" => &mut config.protection.stall_time_s,
        "protection.probe_duty_max" => &mut config.protection.probe_duty_max,
        "protection.supply_v_min" => &mut config.protection.supply_v_min,
        "protection.supply_v_max" => &mut config.protection.supply_v_max,
        "protection.link_timeout_s" => &mut config.protection.link_timeout_s,
        "odometry.noise_m_per_sqrt_m" => &mut config.odometry.noise_m_per_sqrt_m,
        "odometry.wheel_weight_sd" => &mut config.odometry.wheel_weight_sd,
        "odometry.track_width_sd_m" => &mut config.odometry.track_width_sd_m,
        "driver.pwm_hz" => &mut config.driver.pwm_hz,
        _ => panic!("{path} is new: add it here"),
    }
}

#[test]
fn the_robot_itself_refuses_every_field_out_of_range_by_name_and_changes_nothing() {
    on_robot(&Scenario::default(), async |robot| {
        let in_use = with_wheel_weight(0.99);
        robot.session.write_config(&in_use).await.expect("valid");
        for (number, field) in Config::FIELDS.iter().enumerate() {
            let span = field.max - field.min;
            let outside = [
                field.min - 1e-9 * span,
                field.max + 1e-9 * span,
                f64::NAN,
                f64::INFINITY,
                -f64::INFINITY,
            ];
            for value in outside {
                let config = with_field(field.path, value);
                // As sent, past the host's own check.
                match robot.ask(Command::WriteConfig(config)).await {
                    Err(Refusal::Config(ConfigError::OutOfRange { field: refused, value: v })) => {
                        assert_eq!(usize::from(refused), number, "{} = {value}", field.path);
                        assert!(v == value || v.is_nan() && value.is_nan(), "{v} for {value}");
                    }
                    other => panic!("{} = {value}: {other:?}", field.path),
                }
            }
            let host =
                robot.session.write_config(&with_field(field.path, field.max * 2.0 + 1.0)).await;
            let message = host.expect_err("the host refuses it too").to_string();
            assert!(message.contains(field.path), "{message}");
            assert_eq!(robot.tell(Command::ReadConfig).await, Answer::Config(in_use.clone()));
        }
    });
}

#[test]
fn the_robot_itself_refuses_a_distance_per_count_that_no_encoder_has() {
    on_robot(&Scenario::default(), async |robot| {
        let mut config = Config::default();
        (config.encoder.left.counts_per_rev, config.encoder.left.gear_reduction) = (1e6, 1000.0);
        let answer = robot.ask(Command::WriteConfig(config)).await;
        assert!(
            matches!(answer, Err(Refusal::Config(ConfigError::DistancePerCount { .. }))),
            "{answer:?}"
        );
        assert_eq!(robot.tell(Command::ReadConfig).await, Answer::Config(Config::default()));
    });
}
