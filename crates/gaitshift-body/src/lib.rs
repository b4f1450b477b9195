//! The passive-hipped biped: parameters, closed-form dynamics, contact, energy account, integrator.
//!
//! The body is the planar model of the paper's Fig. 1: a hip segment, two legs whose hip joints are
//! passive torsion springs, and in each leg a thigh that a linear actuator moves along the leg, a
//! foot and a wobbling tibia mass joined by three springs and two dampers. Eleven degrees of freedom:
//! hip `x`, `z`, pitch `θ`, and per leg the hip angle `φ`, thigh displacement `h`, leg compression `d`
//! and tibia compression `w`.
//!
//! Nothing here knows of learning. All quantities are in SI units and radians.
//!
//! ```
//! use gaitshift_body::{Body, BodyParameters, BodyState, EnergyAccount};
//! let body = Body::new(BodyParameters::default())?;
//! let mut state = BodyState::standing(&body);
//! let mut account = EnergyAccount::default();
//! let report = body.advance(&mut state, [0.0, 0.0], 25, &mut account);
//! assert!(!report.diverged);
//! # Ok::<(), gaitshift_body::ParameterError>(())
//! ```

mod body;
mod contact;
mod dynamics;
mod energy;
mod integrator;
mod meter;
mod parameters;
mod state;
mod terrain;

pub use body::Body;
pub use contact::{FootContact, sphere_center};
pub use dynamics::{Accelerations, LegForces};
pub use energy::{CentreOfMass, EnergyAccount, MechanicalEnergy, Momentum};
pub use integrator::AdvanceReport;
pub use meter::{LegMeter, Meter};
pub use parameters::{BodyParameters, ParameterError};
pub use state::{BodyState, LEFT, LegState, RIGHT};
pub use terrain::Terrain;
