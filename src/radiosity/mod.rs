//! Diffuse light exchange: hemicubes, form factors, the sparse transfer rows and the solver.

pub mod bounce;
pub mod form_factor;
pub mod hemicube;
pub mod per_ray;
pub mod solve;
pub mod transfers;
pub mod trapped;
