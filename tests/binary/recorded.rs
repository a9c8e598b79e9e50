//! What several tests record.

/// Runs of a plan: two turns on the spot and most of a circle, each both ways.
pub const SPINS_AND_ARCS: &str = "\
[[run]]
name = \"spin_left\"
pieces = [{ spin_deg = 720, speed_mps = 0.12 }]
[[run]]
name = \"spin_right\"
pieces = [{ spin_deg = -720, speed_mps = 0.12 }]
[[run]]
name = \"arc_left\"
pieces = [{ arc_deg = 300, radius_m = 0.5, speed_mps = 0.15 }]
[[run]]
name = \"arc_right\"
pieces = [{ arc_deg = -300, radius_m = 0.5, speed_mps = 0.15 }]
";

/// A scenario: wheels that differ by 1 %, on stiff tyres without effects of their own; and `more` of its plant.
pub fn unequal_wheels(name: &str, more: &str) -> String {
    format!(
        "name = \"{name}\"
[plant]
substep_us = 200
geometry.wheel_radius_m = {{ left = 0.03618, right = 0.03582 }}
tyre.longitudinal_stiffness_n_per_m = 120000.0
tyre.lateral_stiffness_n_per_m = 72000.0
tyre.rolling_resistance = 0.003
{more}
"
    )
}

/// [`unequal_wheels`], and nothing else: the standard caster costs 0.01 % of a turn, which shows.
pub fn only_unequal_wheels() -> String {
    unequal_wheels("unequal", "caster.rolling_resistance = 0.0")
}
