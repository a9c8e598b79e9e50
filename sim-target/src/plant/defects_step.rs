//! One integration step of a robot with defects, or on an uneven floor.

use shared_proto::WheelPair;

use super::Plant;
use super::body::{Body, Wrench};
use super::defects::{DefectiveWheel, Defects, WARMTH_EVERY_US};
use super::parameters::PlantParameters;
use super::pose::Twist;
use super::wheel::DrivenWheel;

impl Plant {
    /// Advances positions, angles and deflections; the new deflections give the next kick's forces.
    pub(super) fn drift_with_defects(&mut self, defects: &mut Defects, h_s: f64) {
        let twist = self.body.drift(h_s);
        self.loads = self.load_model.loads(self.body.acceleration_mps2);
        if self.t_us >= defects.next_warmth_us {
            defects.radius_share = self.parameters.warming.radius_share(self.t_us as f64 * 1e-6);
            defects.next_warmth_us = self.t_us + WARMTH_EVERY_US;
        }
        defects.extra = self.extra(twist);
        let share = defects.radius_share;
        let step =
            DefectiveStep { parameters: &self.parameters, body: &self.body, twist, share, h_s };
        let WheelPair { left, right } = defects.wheel.as_mut();
        step.roll(left, &mut self.wheel.left, self.loads.driven_n.left, &mut defects.extra);
        step.roll(right, &mut self.wheel.right, self.loads.driven_n.right, &mut defects.extra);
        let behind_m = self.parameters.caster.pivot_behind_m + self.parameters.caster.trail_m;
        let friction = self.parameters.floor.friction_at(self.body.point_m(-behind_m, 0.0));
        self.caster.drift(&self.parameters.caster, twist, self.loads.caster_n, friction, h_s);
    }

    /// Forces of slope, tether and drag.
    ///
    /// ```text
    /// gravity: m g sin(slope) downhill, at the centre of mass       (1)
    /// ```
    fn extra(&self, twist: Twist) -> Wrench {
        let PlantParameters { floor, tether, drag, .. } = &self.parameters;
        let (cx, cy) = (self.body.center_x_m, self.body.center_y_m);
        let mut extra = Wrench { yaw_nm: tether.twist_nm, ..Wrench::default() };
        if floor.slope_rad != 0.0 {
            let weight_n = self.parameters.body.laden_mass_kg() * floor.gravity_mps2;
            let (sin, cos) = floor.downhill_rad.sin_cos();
            let down_n = weight_n * floor.slope_rad.sin();
            let (forward_n, left_n) = self.body.rotation().undo(down_n * cos, down_n * sin);
            extra.forward_n += forward_n; // (1)
            extra.left_n += left_n;
        }
        if tether.left_n != 0.0 {
            extra.left_n += tether.left_n;
            extra.yaw_nm += (-tether.behind_m - cx) * tether.left_n;
        }
        if !drag.is_ideal() {
            let (forward_n, left_n) = drag.force_n(twist);
            extra.forward_n += forward_n;
            extra.left_n += left_n;
            extra.yaw_nm += (-drag.behind_m - cx) * left_n - (drag.left_m - cy) * forward_n;
        }
        extra
    }
}

/// What both wheels need to know in one step.
struct DefectiveStep<'a> {
    parameters: &'a PlantParameters,
    body: &'a Body,
    twist: Twist,
    share: f64,
    h_s: f64,
}

impl DefectiveStep<'_> {
    /// Rolls one wheel for h, and finds its contact's force for the next kick.
    ///
    /// Slip of the tread over the floor, with the wheel's plane turned by its toe:
    ///
    /// ```text
    /// s_x = R w cos(toe) - (u - omega y) + pile_x       (1)
    /// s_y = R w sin(toe) - (v + omega x) + pile_y       (2)
    /// pile = d |R w| in its direction                   (3)  speed of the floor's surface
    /// ```
    ///
    /// Over a bump the tread climbs: the forward speed is R w / sqrt(1 + g^2), and the load N pushes back by
    /// N g, where g is the gradient along the path.
    #[inline]
    fn roll(
        &self,
        worn: &mut DefectiveWheel,
        wheel: &mut DrivenWheel,
        load_n: f64,
        extra: &mut Wrench,
    ) {
        let (h_s, twist) = (self.h_s, self.twist);
        let (tyre, floor) = (&self.parameters.tyre, &self.parameters.floor);
        wheel.drift(h_s);
        if let Some(joint) = &mut worn.joint {
            joint.drift(wheel.spin_rad_s, h_s);
        }
        let contact = worn.parameters.contact(
            worn.cold_radius_m * self.share,
            wheel.angle_rad,
            wheel.spin_rad_s,
            load_n - worn.rest_load_n,
        );
        let ahead_m = worn.parameters.contact_ahead_m;
        wheel.radius_m = contact.radius_m;
        wheel.left_m = worn.left_m + worn.float_m + contact.aside_m;

        let tread_mps = wheel.radius_m * wheel.spin_rad_s;
        let rolling_mps = tread_mps.abs();
        let mut along_mps = tread_mps;
        let mut across_mps = 0.0;
        if contact.toe_rad != 0.0 {
            let (sin, cos) = contact.toe_rad.sin_cos();
            (along_mps, across_mps) = (tread_mps * cos, tread_mps * sin);
        }
        let place_m = self.body.point_m(ahead_m, wheel.left_m);
        let gradient = floor.gradient_at(place_m);
        if gradient != (0.0, 0.0) {
            along_mps /= self.climb(gradient, (ahead_m, wheel.left_m), load_n, extra);
        }
        // (1), (2)
        let mut slip_x = along_mps - (twist.forward_mps - twist.yaw_rate_rad_s * wheel.left_m);
        let mut slip_y = across_mps - (twist.left_mps + twist.yaw_rate_rad_s * ahead_m);
        if floor.pile_drift != 0.0 {
            let carried_mps = floor.pile_drift * rolling_mps; // (3)
            let (sin, cos) = floor.pile_direction_rad.sin_cos();
            let (x, y) = self.body.rotation().undo(carried_mps * cos, carried_mps * sin);
            slip_x += x;
            slip_y += y;
        }
        if worn.parameters.end_float_m != 0.0 {
            // The floor holds the contact while the wheel slides along its axle to the end of its float.
            let half_m = 0.5 * worn.parameters.end_float_m;
            let before_m = worn.float_m;
            worn.float_m = (before_m + slip_y * h_s).clamp(-half_m, half_m);
            slip_y -= (worn.float_m - before_m) / h_s;
        }
        let grip_n = floor.friction_at(place_m) * load_n;
        let fade_x = 0.5 * h_s * rolling_mps / tyre.relaxation_length_m;
        let creep = tyre.lateral_creep_mps_per_n * tyre.lateral_stiffness_n_per_m;
        let fade = (fade_x, fade_x + 0.5 * h_s * creep);
        match &mut worn.ribs {
            None => wheel.contact.advance_fading(tyre, (slip_x, slip_y), fade, grip_n, h_s),
            Some(ribs) => {
                let yaw_rate_rad_s = twist.yaw_rate_rad_s;
                extra.yaw_nm += ribs.advance((slip_x, slip_y), yaw_rate_rad_s, fade, grip_n, h_s);
                wheel.contact.force_n = ribs.force_n();
            }
        }
        // The body's sum takes all contacts to be on the axle's line.
        extra.yaw_nm += ahead_m * wheel.contact.force_n.1;
        wheel.set_load(tyre.rolling_resistance, load_n);
    }
    /// Adds the force of a slope under a wheel at a point of the body; returns sqrt(1 + g^2).
    fn climb(
        &self,
        gradient: (f64, f64),
        at_m: (f64, f64),
        load_n: f64,
        extra: &mut Wrench,
    ) -> f64 {
        let (uphill, aside) = self.body.rotation().undo(gradient.0, gradient.1);
        let (back_n, aside_n) = (-load_n * uphill, -load_n * aside);
        extra.forward_n += back_n;
        extra.left_n += aside_n;
        extra.yaw_nm +=
            (at_m.0 - self.body.center_x_m) * aside_n - (at_m.1 - self.body.center_y_m) * back_n;
        (1.0 + uphill * uphill).sqrt()
    }
}
