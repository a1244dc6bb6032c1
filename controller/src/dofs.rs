//! The six degrees of freedom of the task, at the tcp and along the axes of r.

use crate::transform::desired_deflection;
use nalgebra::{Matrix6, UnitQuaternion, Vector3, Vector6};
use node::scenario::ForceControlled;
use spatial::kinematics::{join, split, weighted_error};
use spatial::{Compliance, Pose, Wrench, rotation};

/// A value for each degree of freedom: along x, y, z and about x, y, z of r.
///
/// Coordinates and displacements in m and rad, wrenches in N and Nm.
pub type Dofs = Vector6<f64>;

/// The index of the contact's normal.
pub const NORMAL: usize = 2;

/// Coordinates of a tcp: its position in r and the rotation vector, in r, from an orientation of reference.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TaskFrame {
    reference: UnitQuaternion<f64>,
}

impl TaskFrame {
    /// The frame whose rotational coordinates vanish at the orientation `reference` of the tcp in r.
    pub fn new(reference: UnitQuaternion<f64>) -> Self {
        Self { reference }
    }

    /// The coordinates of a tcp at `r_from_t`.
    pub fn coordinates(&self, r_from_t: &Pose) -> Dofs {
        join(
            r_from_t.translation.vector,
            rotation::log(&(r_from_t.rotation * self.reference.inverse())),
        )
    }

    /// The pose `r_from_t` with these `coordinates`.
    pub fn pose(&self, coordinates: &Dofs) -> Pose {
        let (position, turn) = split(coordinates);
        Pose::from_parts(position.into(), rotation::exp(turn) * self.reference)
    }
}

/// From the tcp's pose `r_from_t` to its pose `r_from_t1`, in r (m, rad).
pub fn displacement(r_from_t: &Pose, r_from_t1: &Pose) -> Dofs {
    weighted_error(r_from_t1, r_from_t)
}

/// Which degrees of freedom follow a force law.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Selection([bool; 6]);

impl Selection {
    /// The selection of a scenario's task.
    pub fn new(force_controlled: &ForceControlled) -> Self {
        Self(force_controlled.dofs())
    }

    /// Whether the degree of freedom `i` follows a force law.
    pub fn contains(&self, i: usize) -> bool {
        self.0.get(i).copied().unwrap_or(false)
    }

    /// The degrees of freedom that do.
    pub fn iter(&self) -> impl Iterator<Item = usize> + '_ {
        (0..6).filter(|&i| self.0[i])
    }

    /// `chosen` where a force law acts, `others` elsewhere.
    pub fn merge(&self, chosen: &Dofs, others: &Dofs) -> Dofs {
        Dofs::from_fn(|i, _| if self.0[i] { chosen[i] } else { others[i] })
    }
}

/// How far the tcp yields to a wrench there: the 6 x 6 compliance that (3)-(10) make of the sensor's, in r.
///
/// What is not force controlled can't bear a wrench (Model choice: no friction), so that the displacement along the
/// selected degrees of freedom alone tells the wrench along them. In a vertex contact, with the normal alone
/// selected, that is `s_z / C_zz`: purely geometric and immune to the tool's swing (PLANT.md section 7).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TcpCompliance {
    matrix: Matrix6<f64>,
    /// The inverse of the selected block, zero elsewhere.
    stiffness: Matrix6<f64>,
}

impl TcpCompliance {
    /// Of a sensor with `compliance` in r, for a tcp at the `lever` (m, in r) from it.
    pub fn new(compliance: &Compliance, lever: Vector3<f64>, selection: &Selection) -> Self {
        let columns: [Dofs; 6] = std::array::from_fn(|i| {
            let (force, moment) = split(&Dofs::ith(i, 1.0));
            // Paper (9), (10) of a unit wrench.
            let yielding = desired_deflection(compliance, &Wrench { force, moment }, lever);
            join(yielding.translation, yielding.rotation)
        });
        let matrix = Matrix6::from_columns(&columns);
        let within = |i: usize, j: usize| selection.contains(i) && selection.contains(j);
        let block = Matrix6::from_fn(|i, j| match (within(i, j), i == j) {
            (true, _) => matrix[(i, j)],
            (false, true) => 1.0,
            (false, false) => 0.0,
        });
        // Positive definite for every sensor that yields; without one there is no force to be told.
        let inverse = block
            .cholesky()
            .map_or(Matrix6::zeros(), |factor| factor.inverse());
        let stiffness = Matrix6::from_fn(|i, j| if within(i, j) { inverse[(i, j)] } else { 0.0 });
        Self { matrix, stiffness }
    }

    /// Compliance along the degree of freedom `i` alone, m/N or rad/Nm.
    pub fn along(&self, i: usize) -> f64 {
        self.matrix[(i, i)]
    }

    /// The wrench along the selected degrees of freedom (zero along the others) that displaces the tcp by
    /// `displacement`.
    pub fn wrench(&self, displacement: &Dofs) -> Dofs {
        self.stiffness * displacement
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn dofs(limit: f64) -> impl Strategy<Value = Dofs> {
        proptest::array::uniform6(-limit..limit).prop_map(Dofs::from)
    }

    fn sensor() -> Compliance {
        Compliance::isotropic(1.0 / 300e3, 1.0 / 401.07)
    }

    const LEVER: Vector3<f64> = Vector3::new(0.10, 0.0, -0.15);

    proptest! {
        #[test]
        fn coordinates_survive_the_round_trip_through_a_pose(x in dofs(1.0), turn in dofs(1.0)) {
            let frame = TaskFrame::new(rotation::exp(split(&turn).1));
            prop_assert!((frame.coordinates(&frame.pose(&x)) - x).norm() < 1e-12);
        }

        /// A wrench along whatever is selected is found again from the displacement that it causes.
        #[test]
        fn the_wrench_along_the_selected_dofs_is_found(
            wrench in dofs(10.0), selected in proptest::array::uniform6(any::<bool>())
        ) {
            let selection = Selection(selected);
            let compliance = TcpCompliance::new(&sensor(), LEVER, &selection);
            let wrench = selection.merge(&wrench, &Dofs::zeros());
            let found = compliance.wrench(&(compliance.matrix * wrench));
            prop_assert!((found - wrench).norm() < 1e-9, "{found}");
        }
    }

    /// PLANT.md section 5: C_tcp,zz = 28.267 um/N.
    #[test]
    fn the_reference_tool_yields_by_28_um_per_n() {
        let selection = Selection::new(&ForceControlled::default());
        let along = TcpCompliance::new(&sensor(), LEVER, &selection).along(NORMAL);
        assert!((along - 28.267e-6).abs() < 0.001e-6, "{along}");
    }
}
