//! A tyre that touches the floor over a width: ribs side by side.

use super::tyre::{Contact, TyreParameters};

/// Ribs across a tread.
const RIBS: usize = 5;

/// Ribs at y_j across the width w, evenly spread from -w/2 to w/2, each with a fifth of the tyre's
/// stiffness and of the load's grip. In a turn they slip at speeds of their own,
///
/// ```text
/// s_j = s + omega y_j                            (1)
/// M   = - sum y_j F_j                            (2)  moment on the body about the contact's middle
/// ```
///
/// As long as all ribs hold, a turn costs the share w^2/(2 b^2), whatever its radius: the track seems
/// wider. In tight turns the outer ribs slide, only the inner ones hold the wheel against their moment, and
/// the turn loses a larger share.
#[derive(Clone, Debug)]
pub(super) struct Ribs {
    tyre: TyreParameters,
    left_m: [f64; RIBS],
    contact: [Contact; RIBS],
}

impl Ribs {
    /// None for a tyre that touches in a point.
    pub fn new(tyre: &TyreParameters) -> Option<Self> {
        let share = 1.0 / RIBS as f64;
        let width_m = tyre.contact_width_m;
        (width_m > 0.0).then(|| Self {
            tyre: TyreParameters {
                longitudinal_stiffness_n_per_m: tyre.longitudinal_stiffness_n_per_m * share,
                lateral_stiffness_n_per_m: tyre.lateral_stiffness_n_per_m * share,
                damping_ns_per_m: tyre.damping_ns_per_m * share,
                ..*tyre
            },
            left_m: core::array::from_fn(|j| width_m * (j as f64 / (RIBS - 1) as f64 - 0.5)),
            contact: [Contact::default(); RIBS],
        })
    }

    /// Resets contact.
    pub fn lift(&mut self) {
        self.contact = [Contact::default(); RIBS];
    }

    /// Advances all ribs by h, and returns the moment on the body about their middle \[N m\].
    #[inline]
    pub fn advance(
        &mut self,
        slip_mps: (f64, f64),
        yaw_rate_rad_s: f64,
        fade: (f64, f64),
        grip_n: f64,
        h_s: f64,
    ) -> f64 {
        let grip_n = grip_n / RIBS as f64;
        let mut moment_nm = 0.0;
        for (contact, left_m) in self.contact.iter_mut().zip(self.left_m) {
            let slip = (slip_mps.0 + yaw_rate_rad_s * left_m, slip_mps.1); // (1)
            contact.advance_fading(&self.tyre, slip, fade, grip_n, h_s);
            moment_nm -= left_m * contact.force_n.0; // (2)
        }
        moment_nm
    }

    /// Force on the wheel, forward and to the left \[N\].
    #[inline]
    pub fn force_n(&self) -> (f64, f64) {
        self.contact
            .iter()
            .fold((0.0, 0.0), |(x, y), contact| (x + contact.force_n.0, y + contact.force_n.1))
    }

    /// Energy in the bent ribs \[J\].
    pub fn energy_j(&self) -> f64 {
        self.contact.iter().map(|contact| contact.energy_j(&self.tyre)).sum()
    }
}
