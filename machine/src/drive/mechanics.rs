//! Motor and table, connected by an elastic screw with backlash.

use super::plant::Plant;

/// State of the two masses in SI units. The table position is in m (rad for a rotary axis).
#[derive(Debug, Clone)]
pub(super) struct TwoMass {
    /// Angle of the motor, rad.
    pub angle: f64,
    /// Speed of the motor, rad/s.
    pub speed: f64,
    /// Position of the table.
    pub position: f64,
    /// Velocity of the table.
    pub velocity: f64,
}

/// Torque and forces on the two masses during a step. Friction opposes positive motion.
#[derive(Debug, Clone, Copy)]
pub(super) struct Loads {
    pub torque: f64,
    pub motor_friction: f64,
    pub table_friction: f64,
    pub disturbance: f64,
}

impl TwoMass {
    /// At standstill at `position`, in the middle of the backlash.
    pub(super) fn at_rest(position: f64, plant: &Plant) -> Self {
        Self { angle: position / plant.per_rad, speed: 0.0, position, velocity: 0.0 }
    }

    /// First half of a semi-implicit step: positions from the present speeds.
    pub(super) fn drift(&mut self, step_s: f64) {
        self.angle += step_s * self.speed;
        self.position += step_s * self.velocity;
    }

    /// Second half: speeds from the forces at the new positions.
    pub(super) fn kick(&mut self, plant: &Plant, loads: Loads, step_s: f64) {
        if plant.rigid {
            let motor_force = (loads.torque - plant.motor_viscous * self.speed) / plant.per_rad - loads.motor_friction;
            let force = motor_force - loads.table_friction - plant.table_viscous * self.velocity + loads.disturbance;
            self.velocity += step_s * force / (plant.table_inertia + plant.motor_inertia / (plant.per_rad * plant.per_rad));
            self.speed = self.velocity / plant.per_rad;
            return;
        }
        let force = self.transmitted(plant);
        let motor_torque = loads.torque - plant.motor_viscous * self.speed - (force + loads.motor_friction) * plant.per_rad;
        let table_force = force - loads.table_friction - plant.table_viscous * self.velocity + loads.disturbance;
        self.speed += step_s * motor_torque / plant.motor_inertia;
        self.velocity += step_s * table_force / plant.table_inertia;
    }

    /// Force through the screw, `K_s dead(θR − x) + C_s (θ̇R − ẋ)`, 0 inside the dead zone.
    fn transmitted(&self, plant: &Plant) -> f64 {
        let twist = self.angle * plant.per_rad - self.position;
        let beyond = twist.abs() - plant.half_width;
        // Equality closes the contact without backlash.
        if beyond > 0.0 || plant.half_width == 0.0 {
            plant.stiffness * beyond.copysign(twist) + plant.damping * (self.speed * plant.per_rad - self.velocity)
        } else {
            0.0
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plant() -> Plant {
        Plant {
            per_rad: 5e-3 / std::f64::consts::TAU,
            motor_inertia: 3e-4,
            motor_viscous: 0.0,
            table_inertia: 40.0,
            table_viscous: 0.0,
            stiffness: 1.2e8,
            damping: 0.0,
            half_width: 2e-6,
            rigid: false,
        }
    }

    #[test]
    fn the_dead_zone_carries_no_force() {
        let plant = plant();
        let mut masses = TwoMass::at_rest(0.01, &plant);
        masses.angle += 1.9e-6 / plant.per_rad;
        assert_eq!(masses.transmitted(&plant), 0.0);
        masses.angle += 0.2e-6 / plant.per_rad;
        assert!((masses.transmitted(&plant) - 1.2e8 * 0.1e-6).abs() < 1e-3);
    }

    #[test]
    fn free_masses_keep_their_energy_and_momentum() {
        let plant = Plant { half_width: 0.0, ..plant() };
        let mut masses = TwoMass::at_rest(0.0, &plant);
        masses.velocity = 0.05;
        let energy = |m: &TwoMass| {
            let twist = m.angle * plant.per_rad - m.position;
            0.5 * (plant.motor_inertia * m.speed.powi(2)
                + plant.table_inertia * m.velocity.powi(2)
                + plant.stiffness * twist * twist)
        };
        let momentum = |m: &TwoMass| plant.motor_inertia * m.speed / plant.per_rad + plant.table_inertia * m.velocity;
        let (energy_0, momentum_0) = (energy(&masses), momentum(&masses));
        let loads = Loads { torque: 0.0, motor_friction: 0.0, table_friction: 0.0, disturbance: 0.0 };
        for _ in 0..40_000 {
            masses.drift(2.5e-5);
            masses.kick(&plant, loads, 2.5e-5);
        }
        assert!((energy(&masses) / energy_0 - 1.0).abs() < 0.05);
        assert!((momentum(&masses) / momentum_0 - 1.0).abs() < 1e-9);
    }
}
