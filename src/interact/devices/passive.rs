//! The force on a hand that holds it for a step at a time, and never gives energy back that was not put in.
//!
//! A spring that is sampled and held gives half a step's energy on the way out more than it took on the way in. Here the force is that of
//! the step's middle, as far as the way of the hand foretells it, and what it may give is what it was given: an account of the energy is
//! kept from one contact to the next loss of it (time-domain passivity, Hannaford and Ryu 2002). Owns the account; knows no driver.

use crate::document::{Contact, ContactField, ContactForce};
use crate::math::DVec3;

/// mm of a step per N: the way of 1 kg in 1 s is 1,000 mm.
const MM_PER_M: f64 = 1_000.0;

/// What is felt at a step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Touch {
    /// How the tip stands to the surface; its own force is the spring's.
    pub contact: Contact,
    /// What the device is to hold until the next step, N, world axes: the spring's force where energy allows it.
    pub force_n: DVec3,
    /// What the hand has put in and not got back, N·mm.
    pub stored_n_mm: f64,
}

/// A hand's contact with a surface, step by step.
#[derive(Clone, Debug, PartialEq)]
pub struct Feel {
    /// How hard the surface is.
    pub law: ContactForce,
    /// The least mass that the force moves, kg: the stylus' own, if nobody holds it.
    pub mass_kg: f64,
    /// Beyond what the stylus does by itself the hand changes its speed by no more, m/s².
    pub hand_m_per_s2: f64,
    last: Option<(DVec3, DVec3)>,
    normal: Option<DVec3>,
    stored: f64,
}

impl Feel {
    /// Nothing touched yet. The mass is that of a small desktop device's stylus, 45 g; the hand's 10 m/s².
    pub fn new(law: ContactForce) -> Self {
        Self { law, mass_kg: 0.045, hand_m_per_s2: 10.0, last: None, normal: None, stored: 0.0 }
    }

    /// The force to hold for the next `dt_s` seconds, with the tip at a place, world mm at rest. `dt_s` is the time between steps. Asks the
    /// field once; takes no lock and makes nothing.
    pub fn step(&mut self, field: &ContactField, at: DVec3, value: f64, dt_s: f64) -> Touch {
        let (moved, held) = self.last.map_or((DVec3::ZERO, DVec3::ZERO), |(last, force)| (at - last, force));
        // What the device did to the hand since the last step, to the digit: the force was held all along.
        self.stored -= held.dot(moved);
        let contact = field.contact(at, value, &self.law);
        if !contact.inside {
            // Who has left the surface has nothing to get back. What was given too much stays owed.
            self.stored = self.stored.min(0.0);
            self.normal = contact.normal;
        }
        let force_n = match contact.normal.or(self.normal) {
            Some(normal) if contact.inside => {
                self.normal = Some(normal);
                normal * self.along(normal, contact.depth_mm, moved, held, dt_s)
            }
            _ => DVec3::ZERO,
        };
        self.last = Some((at, force_n));
        Touch { contact, force_n, stored_n_mm: self.stored }
    }

    /// How hard to push along the normal, N.
    fn along(&self, normal: DVec3, depth_mm: Option<f64>, moved: DVec3, held: DVec3, dt_s: f64) -> f64 {
        // Of one that nothing but the force moves: the next way outward is `way + bend × force`.
        let bend = 0.5 * MM_PER_M * dt_s * dt_s / self.mass_kg;
        let way = (moved + held * bend).dot(normal);
        let (stiffness, most) = (self.law.stiffness_n_per_mm, self.law.most_n);
        // The spring's at the middle of that way; where the field is even, so deep that nobody can tell how deep, the greatest.
        let spring = match depth_mm {
            Some(depth) => stiffness * (depth - 0.5 * way) / (1.0 + 0.5 * stiffness * bend),
            None => most,
        };
        let spring = spring.clamp(0.0, most);
        // On the way in any force takes energy, as long as it does not turn the way.
        let free = (-way / bend).max(0.0);
        // force × (way + bend × force) is what it will have given.
        let quick = way + 0.5 * MM_PER_M * self.hand_m_per_s2 * dt_s * dt_s;
        let paid = if self.stored > 0.0 {
            (-quick + (quick * quick + 4.0 * bend * self.stored).sqrt()) / (2.0 * bend)
        } else {
            0.0
        };
        spring.min(free.max(paid))
    }
}
