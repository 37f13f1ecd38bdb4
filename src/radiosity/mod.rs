//! Diffuse light exchange: hemicubes, form factors, the sparse transfer rows and the solver.

pub mod area_points;
pub mod bounce;
pub mod channels;
pub mod contour;
mod direction;
pub mod form_factor;
pub mod hemicube;
pub(crate) mod highlights;
pub mod importance;
pub mod near_pairs;
pub mod open_parts;
pub mod overlay_pairs;
mod overlay_view;
pub mod pair_factor;
pub mod per_ray;
pub mod solve;
pub mod transfers;
pub mod trapped;
mod view_pairs;
pub mod visibility;
