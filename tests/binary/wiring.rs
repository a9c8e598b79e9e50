//! `beeline wiring` on simulated robots whose wires are exchanged in ways that no check of theirs can see.

use crate::temp_folder::TempFolder;

/// A robot with these motors and encoders the wrong way round.
fn robot(temp: &TempFolder, reversed: &[&str]) -> String {
    let keys: String = reversed
        .iter()
        .map(|side| {
            format!(
                "[plant.motor.{side}]\nreversed = true\n[plant.encoder.{side}]\nreversed = true\n"
            )
        })
        .collect();
    temp.write("robot.toml", &format!("name = \"wired\"\n{keys}"));
    "--port sim:robot.toml --flash flash".into()
}

#[test]
fn forward_that_is_backward_is_named_mended_and_kept() {
    for (reversed, named) in [
        (vec!["left", "right"], "Forward is backward"),
        (vec!["left"], "The left motor and its encoder are reversed"),
        (vec!["right"], "The right motor and its encoder are reversed"),
    ] {
        let temp = TempFolder::new();
        let port = robot(&temp, &reversed);
        let wiring = format!("wiring {port}");
        let arguments: Vec<&str> = wiring.split(' ').collect();
        // To begin, and four times what the simulator shows: twice before, and twice after.
        let said = temp.run_with(&arguments, "\n\n\n\n\n").ok().stdout;
        assert!(said.contains(named) && said.contains("Mended and saved"), "{said}");
        for side in ["left", "right"] {
            for part in ["motor", "encoder"] {
                let value =
                    temp.run(&format!("config get {part}.{side}.reversed {port}")).ok().stdout;
                assert_eq!(
                    value.contains("true"),
                    reversed.contains(&side),
                    "{part}.{side}: {value}"
                );
            }
        }
        let said = temp.run_with(&arguments, "\n\n\n").ok().stdout;
        assert!(said.contains("forward is forward"), "{said}");
    }
}

#[test]
fn exchanged_sides_and_answers_that_cannot_be_change_nothing() {
    for (answers, message) in [
        ("ra\nla\n", "left and right are exchanged"),
        ("rb\nla\n", "left and right are exchanged"),
        ("rb\nlb\n", "its other end for the front"),
        ("what?\nla\nlb\n", "cannot have turned both times"),
        ("la\nn\n", "no wheel turned"),
        // Said to be reversed, and still so after both were turned round.
        ("lb\nrb\nlb\nrb\n", "still the wrong way round"),
    ] {
        let temp = TempFolder::new();
        let port = robot(&temp, &[]);
        let wiring = format!("wiring {port}");
        let arguments: Vec<&str> = wiring.split(' ').collect();
        let outcome = temp.run_with(&arguments, &format!("\n{answers}"));
        assert_eq!(outcome.code, Some(1), "{outcome:#?}");
        let said = outcome.stderr;
        assert!(said.contains(message) && said.contains("nothing was changed"), "{said}");
        let value = temp.run(&format!("config get motor.left.reversed {port}")).ok().stdout;
        assert!(value.contains("false"), "{value}");
    }
}

#[test]
fn it_waits_until_the_wheels_are_free_and_saves_nothing_that_somebody_else_changed() {
    let temp = TempFolder::new();
    let said = temp.run_with(&["wiring"], "no\n");
    assert!(said.stderr.contains("nothing was driven"), "{said:#?}");
    let said = temp.run_with(&["wiring"], "");
    assert!(said.stderr.contains("nobody to answer"), "{said:#?}");
    assert!(!said.stderr.contains("Which wheel"), "{said:#?}");
}
