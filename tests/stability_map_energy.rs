//! The stability contract: energy, reciprocity and the residual of the project's maps, worked out
//! anew from the rows of transfers. `docs/stability.md` lists the cases.

mod support;

use qrad::lightmap::Gather;
use support::lit_map::Prepared;
use support::map_energy::MapSums;

#[track_caller]
fn hold(name: &str) {
    let map = Prepared::project_map(name, false);
    let lit = map.light(Gather::Interpolate);
    let sums = MapSums::new(&map, &lit);
    println!(
        "{name}: {} patches, {sums:?}, told {:.1e}",
        map.transfers.rows(),
        lit.bounced.residual
    );
    assert!(!lit.bounced.styles.is_empty() && lit.bounced.residual <= map.settings.residual);
    assert!(sums.residual <= lit.bounced.residual + 1e-6, "one more pass adds {}", sums.residual);
    assert!(sums.asymmetry <= 0.02, "reciprocity is off by {}", sums.asymmetry);
    assert!(sums.imbalance <= 0.01, "energy is off by {}", sums.imbalance);
}

#[test]
fn furnace_rooms_keep_energy_and_reciprocity_and_their_residual_is_true() {
    hold("furnace.bsp");
    hold("furnace_inner.bsp");
}

#[test]
fn the_atrium_keeps_energy_and_reciprocity_and_its_residual_is_true() {
    hold("atrium.bsp");
}

#[test]
fn switchable_lights_keep_energy_and_reciprocity_and_their_residual_is_true() {
    hold("styles.bsp");
}
