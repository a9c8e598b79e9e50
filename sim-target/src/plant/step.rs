//! One integration step, for an ideal robot; `defects_step` has the other one.

use shared_proto::WheelPair;

use super::Plant;
use super::body::Wrench;
use super::defects::Defects;
use super::fault::WheelFaults;
use super::motor::Terminals;
use super::pose::Twist;
use super::wheel::DrivenWheel;

impl Plant {
    /// Advances everything but the encoders by h.
    #[inline]
    pub(super) fn step(&mut self, h_s: f64) {
        let commanded = if self.enabled { self.duty } else { WheelPair::both(0.0) };
        let bridge = &self.parameters.bridge;
        self.slewed_duty =
            self.slewed_duty.zip(commanded).map(|(duty, to)| bridge.slewed(duty, to, h_s));
        if let Some(motors) = &mut self.defective_motors {
            motors.left.prepare(&mut self.wheel.left, h_s);
            motors.right.prepare(&mut self.wheel.right, h_s);
        }
        // Taken out for the step, because the defects' step borrows the whole plant.
        match self.defects.take() {
            None => {
                self.kick(h_s);
                self.drift(h_s);
            }
            Some(mut defects) => {
                self.kick_with_defects(&mut defects, h_s);
                self.drift_with_defects(&mut defects, h_s);
                self.defects = Some(defects);
            }
        }
    }

    /// What each motor's terminals are connected to, and the bus voltage that results.
    #[inline]
    fn power(&self) -> (WheelPair<Terminals>, f64) {
        let (on, shorts) = (self.enabled, self.parameters.bridge.shorts_when_off);
        let opens = self.faults.driver || (!on && !shorts);
        let bridge = &self.parameters.bridge;
        let straight = bridge.is_ideal();
        let terminals = |wheel: &DrivenWheel, faults: &WheelFaults, duty: f64| {
            let motor = &wheel.motor;
            if opens || faults.motor_unplugged {
                return Terminals::Open;
            }
            if on && duty == 0.0 && bridge.opens_without_duty {
                return Terminals::Open;
            }
            let duty = if on { duty } else { 0.0 };
            let swap = if faults.motor_reversed { -motor.polarity } else { motor.polarity };
            let duty = duty * swap;
            if straight {
                return Terminals::Driven(duty);
            }
            Terminals::Driven(bridge.share(duty, self.bus_v, motor, wheel.spin_rad_s))
        };
        let (wheel, faults) = (&self.wheel, &self.faults.wheel);
        let exchanged = self.faults.motors_exchanged;
        let duty = if exchanged { self.slewed_duty.swapped() } else { self.slewed_duty };
        let left = terminals(&wheel.left, &faults.left, duty.left);
        let right = terminals(&wheel.right, &faults.right, duty.right);
        let load_left = wheel.left.motor.bus_load(left, wheel.left.spin_rad_s);
        let load_right = wheel.right.motor.bus_load(right, wheel.right.spin_rad_s);
        let bus_v = self.parameters.supply.bus_v(
            self.faults.dip_v,
            load_left.0 + load_right.0,
            load_left.1 + load_right.1,
        );
        (WheelPair { left, right }, bus_v)
    }

    /// Changes the momenta: wheels by motor, tyre and friction; body by tyres and caster; caster by its tyre.
    #[inline]
    fn kick(&mut self, h_s: f64) {
        let (terminals, bus_v) = self.power();
        self.bus_v = bus_v;
        let wrench = self.wrench();

        let (t_us, faults) = (self.t_us, &self.faults.wheel);
        let spin = |wheel: &mut DrivenWheel, terminals, faults: &WheelFaults| {
            wheel.kick(terminals, bus_v, faults.clamp_nm(t_us), h_s);
        };
        spin(&mut self.wheel.left, terminals.left, &faults.left);
        spin(&mut self.wheel.right, terminals.right, &faults.right);
        self.kick_body(wrench, h_s);
    }

    /// As [`kick`](Self::kick), for a robot with defects.
    fn kick_with_defects(&mut self, defects: &mut Defects, h_s: f64) {
        let (terminals, bus_v) = self.power();
        self.bus_v = bus_v;
        let (wrench, extra) = (self.wrench(), defects.extra());
        let wrench = Wrench {
            forward_n: wrench.forward_n + extra.forward_n,
            left_n: wrench.left_n + extra.left_n,
            yaw_nm: wrench.yaw_nm + extra.yaw_nm,
        };
        let clamp_nm = self.faults.wheel.map(|faults| faults.clamp_nm(self.t_us));
        let WheelPair { left, right } = defects.wheels();
        left.kick(&mut self.wheel.left, terminals.left, bus_v, clamp_nm.left, h_s);
        right.kick(&mut self.wheel.right, terminals.right, bus_v, clamp_nm.right, h_s);
        self.kick_body(wrench, h_s);
    }

    #[inline]
    fn kick_body(&mut self, wrench: Wrench, h_s: f64) {
        let yaw_before = self.body.yaw_rate_rad_s;
        self.body.kick(wrench, h_s);
        self.caster.kick(&self.parameters.caster, self.body.yaw_rate_rad_s - yaw_before, h_s);
        self.body.settle();
    }

    /// The sum of all forces on the body.
    #[inline]
    fn wrench(&self) -> Wrench {
        let (cx, cy) = (self.body.center_x_m, self.body.center_y_m);
        let (left, right) = (&self.wheel.left, &self.wheel.right);
        let ((lx, ly), (rx, ry)) = (left.contact.force_n, right.contact.force_n);
        let (px, py) = self.caster.force_n;
        let pivot_x = -self.parameters.caster.pivot_behind_m - cx;
        Wrench {
            forward_n: lx + rx + px,
            left_n: ly + ry + py,
            // Moments x F_y - y F_x about the centre of mass; the contacts are at (0, left_m).
            yaw_nm: -cx * (ly + ry) - (left.left_m - cy) * lx - (right.left_m - cy) * rx
                + pivot_x * py
                + cy * px
                + self.caster.reaction_nm,
        }
    }

    /// Advances positions, angles and deflections; the new deflections give the next kick's forces.
    #[inline]
    fn drift(&mut self, h_s: f64) {
        let twist = self.body.drift(h_s);
        self.loads = self.load_model.loads(self.body.acceleration_mps2);
        let (tyre, friction) = (&self.parameters.tyre, self.parameters.floor.friction);
        let roll = |wheel: &mut DrivenWheel, load_n: f64| {
            wheel.drift(h_s);
            let slip = wheel.slip_mps(twist);
            let rolling_mps = (wheel.radius_m * wheel.spin_rad_s).abs();
            wheel.contact.advance(tyre, slip, rolling_mps, friction * load_n, h_s);
            wheel.set_load(tyre.rolling_resistance, load_n);
        };
        roll(&mut self.wheel.left, self.loads.driven_n.left);
        roll(&mut self.wheel.right, self.loads.driven_n.right);
        self.caster.drift(&self.parameters.caster, twist, self.loads.caster_n, friction, h_s);
    }
}

impl DrivenWheel {
    /// The tread's velocity relative to the floor, forward and to the left: (R w - u + omega y, -v).
    #[inline]
    fn slip_mps(&self, body: Twist) -> (f64, f64) {
        let hub_mps = body.forward_mps - body.yaw_rate_rad_s * self.left_m;
        (self.radius_m * self.spin_rad_s - hub_mps, -body.left_mps)
    }
}
