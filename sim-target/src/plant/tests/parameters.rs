use crate::plant::PlantParameters;

fn refusal(change: impl Fn(&mut PlantParameters)) -> String {
    let mut parameters = PlantParameters::default();
    change(&mut parameters);
    parameters.validate().expect_err("this should be refused").to_string()
}

#[test]
fn the_standard_robot_is_valid() {
    assert_eq!(PlantParameters::default().validate(), Ok(()));
}

#[test]
fn what_no_robot_has_is_refused_by_name() {
    let mass = refusal(|p| p.body.mass_kg = -4.0);
    assert_eq!(mass, "body.mass_kg = -4: must be from 0.05 to 500");
    assert!(refusal(|p| p.motor.right.resistance_ohm = f64::NAN).starts_with("motor.right.resi"));
    assert!(refusal(|p| p.encoder.left.counts_per_rev = 0.0).starts_with("encoder.left.counts"));
    assert!(refusal(|p| p.geometry.wheel_radius_m.left = 0.0).starts_with("geometry.wheel_rad"));
    assert!(refusal(|p| p.tyre.relaxation_length_m = 0.0).starts_with("tyre.relaxation_length_m"));
    assert!(refusal(|p| p.caster.trail_m = f64::INFINITY).starts_with("caster.trail_m"));
    assert!(refusal(|p| p.supply.open_circuit_v = -1.0).starts_with("supply.open_circuit_v"));
    assert!(refusal(|p| p.floor.friction = -0.1).starts_with("floor.friction"));
    assert!(refusal(|p| p.substep_us = 0).starts_with("substep_us"));
    assert!(refusal(|p| p.body.payload_kg = -1.0).starts_with("body.payload_kg"));
    assert!(refusal(|p| p.wheel.left.bend_rad = 2.0).starts_with("wheel.left.bend_rad"));
    assert!(refusal(|p| p.gear.right.backlash_rad = -0.1).starts_with("gear.right.backlash_rad"));
    assert!(refusal(|p| p.gear.left.set_screw_nm = Some(0.0)).starts_with("gear.left.set_screw"));
    assert!(refusal(|p| p.encoder.left.error.mesh_rad = 1.0).starts_with("encoder.left.error.mes"));
    assert!(refusal(|p| p.encoder.right.filter_s = -1.0).starts_with("encoder.right.filter_s"));
    assert!(refusal(|p| p.tyre.contact_width_m = f64::NAN).starts_with("tyre.contact_width_m"));
    assert!(refusal(|p| p.warming.time_constant_s = 0.0).starts_with("warming.time_constant_s"));
    assert!(refusal(|p| p.tether.left_n = 1e4).starts_with("tether.left_n"));
    assert!(refusal(|p| p.drag.force_n = -1.0).starts_with("drag.force_n"));
    assert!(refusal(|p| p.floor.slope_rad = 1.0).starts_with("floor.slope_rad"));
}

#[test]
fn a_robot_that_would_tip_over_is_refused() {
    assert!(refusal(|p| p.body.center_of_mass_forward_m = -0.25).contains("forward_m"));
    // Within the track, but the triangle is narrower where the mass is.
    assert!(refusal(|p| p.body.center_of_mass_left_m = 0.16).contains("left_m"));
}

#[test]
fn a_step_too_long_for_the_tyres_is_refused_with_one_that_would_do() {
    let stiff = |p: &mut PlantParameters| p.tyre.longitudinal_stiffness_n_per_m = 2e6;
    let message = refusal(stiff);
    assert!(message.starts_with("substep_us = 500: must be at most "), "{message}");
    let longest: u32 =
        message.split(' ').nth(7).and_then(|word| word.parse().ok()).expect("a number");
    let mut parameters = PlantParameters { substep_us: longest, ..PlantParameters::default() };
    stiff(&mut parameters);
    assert_eq!(parameters.validate(), Ok(()));
}

#[test]
fn one_wheels_override_leaves_the_other_as_it_was() {
    let text = "motor.left.resistance_ohm = 7.0\nencoder.right.phase = 0.5";
    let parameters: PlantParameters = toml::from_str(text).expect("valid");
    let mut expected = PlantParameters::default();
    expected.motor.left.resistance_ohm = 7.0;
    expected.encoder.right.phase = Some(0.5);
    assert_eq!(parameters, expected);
}

#[test]
fn a_misspelt_parameter_is_refused() {
    for text in ["mas_kg = 4.0", "motor.middle.resistance_ohm = 1.0", "body.mass = 4.0"] {
        let error = toml::from_str::<PlantParameters>(text).expect_err(text);
        assert!(error.message().contains("unknown field"), "{text}: {error}");
    }
}
