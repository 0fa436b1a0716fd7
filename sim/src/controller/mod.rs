//! temp
#![allow(missing_docs)]
use glam::DVec3;
use nalgebra::{DMatrix, DVector, Matrix3xX};
use crate::arm::Arm;
#[derive(Clone, Copy, Debug, serde::Serialize)]
pub struct ReachRules { pub stuck_window_s: f64, pub stuck_distance_m: f64, pub stop_force_n: f64, pub reached_distance_m: f64, pub time_out_s: f64 }
#[derive(Clone, Debug, serde::Serialize)]
pub struct Preset { pub name: &'static str, pub rate_hz: f64, pub rules: ReachRules }
impl Preset {
    pub const NAMES: [&'static str; 1] = ["cody-2013"];
    pub fn by_name(_: &str) -> Option<Preset> { Some(Preset { name: "cody-2013", rate_hz: 25.0, rules: ReachRules { stuck_window_s: 10.0, stuck_distance_m: 1e-3, stop_force_n: 100.0, reached_distance_m: 0.02, time_out_s: 30.0 } }) }
    pub fn controller(&self, arm: &Arm) -> Box<dyn Controller> { Box::new(C(arm.clone())) }
    pub fn f_max_n(&self) -> f64 { 3.0 }
}
pub struct TaxelContact { pub jacobian: Matrix3xX<f64>, pub normal_world: DVec3, pub force_n: f64 }
pub struct ControllerInput<'a> { pub joint_angle_rad: &'a [f64], pub equilibrium_angle_rad: &'a [f64], pub tip_position_world: DVec3, pub tip_jacobian: Matrix3xX<f64>, pub goal_position_world: DVec3, pub contacts: &'a [TaxelContact] }
pub struct ControllerOutput { pub equilibrium_angle_rad: Vec<f64> }
pub trait Controller { fn step(&mut self, i: &ControllerInput) -> ControllerOutput; }
struct C(Arm);
impl Controller for C {
    fn step(&mut self, i: &ControllerInput) -> ControllerOutput {
        let d = i.goal_position_world - i.tip_position_world;
        let d = d * (0.01 / d.length()).min(1.0);
        let j = &i.tip_jacobian;
        let n = j.ncols();
        let a: DMatrix<f64> = j.transpose() * j + DMatrix::identity(n, n) * 1e-2;
        let dq: DVector<f64> = a.cholesky().unwrap().solve(&(j.transpose() * nalgebra::Vector3::new(d.x, d.y, d.z)));
        let mut phi = i.equilibrium_angle_rad.to_vec();
        for k in 0..n { let b = self.0.joints[k].controller_limits_rad; phi[k] = (phi[k] + dq[k].clamp(-0.0087, 0.0087)).clamp(b[0], b[1]).clamp(i.joint_angle_rad[k]-0.35, i.joint_angle_rad[k]+0.35); }
        ControllerOutput { equilibrium_angle_rad: phi }
    }
}
