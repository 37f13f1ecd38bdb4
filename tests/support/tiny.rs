//! A map of some kilobytes that has one of everything: a start for what damages maps.

use super::map_builder::MapBuilder;
use qrad::bsp::{Bsp, Format};

/// Entities of every kind that light reads.
pub const ENTITIES: &str = r#"{
"classname" "worldspawn"
"_sunlight" "50"
"_sun_mangle" "30 -60 0"
"_sunlight2" "20"
"_sunsamples" "8"
"_dirt" "1"
"_minlight" "5"
"light" "1"
}
{
"classname" "light"
"origin" "60 60 60"
"light" "200"
"_color" "255 128 64"
"delay" "2"
"wait" "0.5"
}
{
"classname" "light_torch"
"origin" "20 100 40"
"light" "150"
"targetname" "torch"
"target" "spot"
"angle" "40"
}
{
"classname" "info_null"
"targetname" "spot"
"origin" "64 64 0"
}
{
"classname" "light"
"_surface" "lamp"
"light" "300"
}
{
"classname" "func_wall"
"model" "*1"
"_shadow" "1"
"_phong" "1"
}
{
"classname" "light"
"origin" "100 20 80"
"light" "-50"
"style" "3"
}
"#;

/// The map.
pub fn map(format: Format) -> Bsp {
    MapBuilder::room([0.0, 0.0, 0.0], [128.0, 128.0, 96.0])
        .solid_texture("wall", 8)
        .solid_texture("sky1", 200)
        .flags(1)
        .solid_texture("lamp", 254)
        .solid_texture("{fence", 255)
        .room_textures([0, 0, 0, 0, 0, 1])
        .pillar([32.0, 32.0, 0.0], [48.0, 48.0, 64.0], 0)
        .pillar([80.0, 80.0, 0.0], [96.0, 96.0, 16.0], 2)
        .model([16.0, 96.0, 0.0], [48.0, 112.0, 32.0], Some(3))
        .entities(ENTITIES)
        .bspx("LMSHIFT", &[4; 24])
        .build(format)
}
