//! The one place where the indices between lumps are checked.

use super::file::Bsp;
use crate::{Error, Result};

/// Deepest node tree accepted. Real maps stay in the hundreds; engines descend recursively.
const MAX_TREE_DEPTH: u32 = 4096;

/// Ranges into a list (faces into surfedges, leafs into marksurfaces, models into faces) may name each
/// entry this often on average. Compilers name each once; more would let a small file stand for a
/// huge amount of work.
const MAX_SHARING: u64 = 16;

/// Checks every index of every record.
pub(crate) fn validate(bsp: &Bsp) -> Result<()> {
    check_points(bsp)?;
    check_faces(bsp)?;
    check_leafs(bsp)?;
    check_models(bsp)?;
    check_lightmaps(bsp)?;
    check_tree(bsp)
}

/// BSPX lumps without which face records alone say where lightmaps are.
const ELSEWHERE: [&str; 4] = ["LMOFFSET", "DECOUPLED_LM", "RGBLIGHTING", "LIGHTING_E5BGR9"];

/// Checks that lightmaps begin inside the lighting lump. New lighting replaces them, but a file in
/// which they do not is damaged, and some engines crash on it.
fn check_lightmaps(bsp: &Bsp) -> Result<()> {
    let bytes = bsp.lighting.len();
    if bytes == 0 || bsp.bspx.iter().any(|lump| ELSEWHERE.contains(&lump.name.as_str())) {
        return Ok(());
    }
    for (index, face) in bsp.faces.iter().enumerate() {
        let inside = usize::try_from(face.light_offset).is_ok_and(|offset| offset < bytes);
        if face.styles[0] != 255 && face.light_offset != -1 && !inside {
            return Err(Error::format(
                format!("faces lump, record {index}"),
                format!(
                    "its lightmap is at {} of {bytes} bytes of lighting: the file is damaged",
                    face.light_offset
                ),
            ));
        }
    }
    Ok(())
}

/// Fails unless `value < count`.
fn check(lump: &str, index: usize, field: &str, value: u64, count: usize) -> Result<()> {
    if value < count as u64 {
        return Ok(());
    }
    Err(Error::format(
        format!("{lump} lump, record {index}"),
        format!("{field} is {value} but there are only {count}: the file is damaged"),
    ))
}

/// Checks ranges `first .. first + length` of one lump into a list of `count` entries.
struct Ranges {
    lump: &'static str,
    field: &'static str,
    count: usize,
    total: u64,
}

impl Ranges {
    fn new(lump: &'static str, field: &'static str, count: usize) -> Self {
        Self { lump, field, count, total: 0 }
    }

    fn check(&mut self, index: usize, first: u32, length: u32) -> Result<()> {
        let Self { lump, field, count, .. } = *self;
        if length == 0 {
            return Ok(());
        }
        let end = u64::from(first) + u64::from(length);
        if end > count as u64 {
            return Err(Error::format(
                format!("{lump} lump, record {index}"),
                format!("{field} {first} to {end} but there are only {count}: the file is damaged"),
            ));
        }
        self.total += u64::from(length);
        if self.total > MAX_SHARING * count as u64 {
            return Err(Error::format(
                format!("{lump} lump, record {index}"),
                format!("{field} are shared again and again: the file is damaged"),
            ));
        }
        Ok(())
    }
}

fn check_points(bsp: &Bsp) -> Result<()> {
    for (index, vertex) in bsp.vertices.iter().enumerate() {
        if !vertex.is_finite() {
            return Err(Error::format(
                format!("vertices lump, vertex {index}"),
                format!("its position ({vertex}) is not finite: the file is damaged"),
            ));
        }
    }
    for (index, plane) in bsp.planes.iter().enumerate() {
        if !plane.normal.is_finite() || !plane.dist.is_finite() {
            return Err(Error::format(
                format!("planes lump, plane {index}"),
                format!(
                    "normal ({}) and distance {} are not finite: the file is damaged",
                    plane.normal, plane.dist
                ),
            ));
        }
    }
    for (index, &[a, b]) in bsp.edges.iter().enumerate() {
        check("edges", index, "vertex", a.max(b).into(), bsp.vertices.len())?;
    }
    for (index, &edge) in bsp.surfedges.iter().enumerate() {
        check("surfedges", index, "edge", edge.unsigned_abs().into(), bsp.edges.len())?;
    }
    Ok(())
}

fn check_faces(bsp: &Bsp) -> Result<()> {
    let mut surfedges = Ranges::new("faces", "surfedges", bsp.surfedges.len());
    for (index, face) in bsp.faces.iter().enumerate() {
        check("faces", index, "plane", face.plane.into(), bsp.planes.len())?;
        surfedges.check(index, face.first_edge, face.edge_count)?;
    }
    for (index, &face) in bsp.marksurfaces.iter().enumerate() {
        check("marksurfaces", index, "face", face.into(), bsp.faces.len())?;
    }
    Ok(())
}

fn check_leafs(bsp: &Bsp) -> Result<()> {
    let mut marks = Ranges::new("leafs", "marksurfaces", bsp.marksurfaces.len());
    for (index, leaf) in bsp.leafs.iter().enumerate() {
        marks.check(index, leaf.first_mark, leaf.mark_count)?;
    }
    Ok(())
}

/// Checks a node (`>= 0`) or leaf (`-1 - leaf`).
fn check_child(bsp: &Bsp, lump: &str, index: usize, child: i32) -> Result<()> {
    match u64::try_from(child) {
        Ok(node) => check(lump, index, "node", node, bsp.nodes.len()),
        Err(_) => check(lump, index, "leaf", u64::from(!child as u32), bsp.leafs.len()),
    }
}

fn check_models(bsp: &Bsp) -> Result<()> {
    if bsp.models.is_empty() {
        return Err(Error::format("models lump", "it is empty: give a compiled map"));
    }
    let mut faces = Ranges::new("models", "faces", bsp.faces.len());
    for (index, model) in bsp.models.iter().enumerate() {
        check_child(bsp, "models", index, model.head_node)?;
        faces.check(index, model.first_face, model.face_count)?;
        if u64::from(model.vis_leafs) > bsp.leafs.len() as u64 {
            return Err(Error::format(
                format!("models lump, record {index}"),
                format!(
                    "{} leafs with visibility but there are only {}: the file is damaged",
                    model.vis_leafs,
                    bsp.leafs.len()
                ),
            ));
        }
    }
    Ok(())
}

/// Checks that the nodes form trees: a node reached from two places would make walks endless, or
/// exponentially long.
fn check_tree(bsp: &Bsp) -> Result<()> {
    let mut has_parent = vec![false; bsp.nodes.len()];
    for (index, node) in bsp.nodes.iter().enumerate() {
        check("nodes", index, "plane", node.plane.into(), bsp.planes.len())?;
        for child in node.children {
            check_child(bsp, "nodes", index, child)?;
            if child >= 0 && std::mem::replace(&mut has_parent[child as usize], true) {
                return Err(Error::format(
                    format!("nodes lump, record {index}"),
                    format!("its child {child} already has a parent: the file is damaged"),
                ));
            }
        }
    }
    // With one parent each, what cannot be reached from a node without parent is a loop.
    let mut reached = 0;
    let roots = (0..bsp.nodes.len()).filter(|&node| !has_parent[node]);
    let mut open: Vec<(usize, u32)> = roots.map(|root| (root, 1)).collect();
    while let Some((index, depth)) = open.pop() {
        reached += 1;
        if depth > MAX_TREE_DEPTH {
            return Err(Error::Limit {
                what: format!("depth of the node tree at node {index}"),
                value: depth.into(),
                limit: MAX_TREE_DEPTH.into(),
                advice: "compile the map again",
            });
        }
        let children = bsp.nodes[index].children.into_iter();
        open.extend(children.filter(|&child| child >= 0).map(|child| (child as usize, depth + 1)));
    }
    if reached < bsp.nodes.len() {
        return Err(Error::format(
            "nodes lump",
            format!("{} nodes form a loop: the file is damaged", bsp.nodes.len() - reached),
        ));
    }
    Ok(())
}
