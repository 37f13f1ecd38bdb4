//! The file formats against real maps, generated maps, another reader, and damaged files.

mod support;

use glam::Vec3;
use proptest::prelude::*;
use qbsp::{BspData, BspParseInput, BspParseSettings};
use qrad::Error;
use qrad::bsp::{
    Bsp, Format, StyleRange, average_colour, find_texture, load_wad, parse_entities, read_lit,
    rewrite_entities, write_entities,
};
use support::map_builder::MapBuilder;
use support::wads::wad;

const FORMATS: [Format; 3] = [Format::Bsp29, Format::Bsp2, Format::TwoPsb];

/// A subdivided room with two pillars, three textures and a BSPX lump.
fn sample(format: Format) -> Bsp {
    MapBuilder::room([-128.0, -64.0, 0.0], [128.0, 192.0, 96.0])
        .solid_texture("grey", 12)
        .random_texture("noise", 3)
        .solid_texture("sky1", 208)
        .flags(1)
        .room_textures([0, 1, 0, 1, 0, 2])
        .pillar([-32.0, 0.0, 0.0], [0.0, 48.0, 64.0], 1)
        .pillar([64.0, 96.0, 16.0], [80.0, 112.0, 32.0], 0)
        .subdivide(96.0)
        .entities("{\n\"classname\" \"worldspawn\"\n}\n{\n\"classname\" \"light\"\n}\n")
        .bspx("QRADNOTES", b"seven b")
        .bspx("LMSTYLE", b"stale")
        .build(format)
}

/// Lump table of a BSP file: offset and length.
fn lumps(file: &[u8]) -> Vec<(usize, usize)> {
    let number = |at: usize| u32::from_le_bytes(file[at..at + 4].try_into().unwrap()) as usize;
    (0..15).map(|lump| (number(4 + 8 * lump), number(8 + 8 * lump))).collect()
}

#[test]
fn real_maps_come_back_byte_for_byte() {
    let maps = support::all_maps();
    assert!(maps.len() >= 9, "the project's own maps are there");
    for path in maps {
        let file = std::fs::read(&path).unwrap();
        let bsp = Bsp::read(&file).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        let written = bsp.write().unwrap();
        for (lump, (old, new)) in lumps(&file).into_iter().zip(lumps(&written)).enumerate() {
            let same = file[old.0..old.0 + old.1] == written[new.0..new.0 + new.1];
            assert!(same, "{}: lump {lump} differs", path.display());
        }
        // qbsp and vis write the same order and padding, so here even the whole files agree.
        assert!(file == written, "{}: BSPX or padding differs", path.display());
    }
}

#[test]
fn relighting_changes_only_faces_lighting_entities_and_bspx() {
    for format in FORMATS {
        let mut bsp = sample(format);
        let before = bsp.write().unwrap();
        bsp.lighting = vec![7; 301];
        bsp.faces[3].styles = [0, 32, 255, 255];
        bsp.faces[3].light_offset = 100;
        bsp.entities = b"{\n}\n\0".to_vec();
        let lit = bsp.write().unwrap();
        assert_eq!(Bsp::read(&lit).unwrap(), bsp);
        for (lump, (old, new)) in lumps(&before).into_iter().zip(lumps(&lit)).enumerate() {
            let same = before[old.0..old.0 + old.1] == lit[new.0..new.0 + new.1];
            assert_eq!(same, ![0, 7, 8].contains(&lump), "{format:?} lump {lump}");
        }
        bsp.clear_lighting();
        assert!(bsp.lighting.is_empty());
        assert!(bsp.faces.iter().all(|face| face.styles == [255; 4] && face.light_offset == -1));
        let names: Vec<&str> = bsp.bspx.iter().map(|lump| lump.name.as_str()).collect();
        assert_eq!(names, ["QRADNOTES"]);
    }
}

#[test]
fn generated_maps_come_back_equal_in_every_format() {
    for format in FORMATS {
        let bsp = sample(format);
        assert_eq!(bsp.format, format);
        assert_eq!(Bsp::read(&bsp.write().unwrap()).unwrap(), bsp);
        // The records are the same whatever the container.
        let other = sample(Format::Bsp2);
        assert_eq!(
            (&bsp.planes, &bsp.vertices, &bsp.nodes),
            (&other.planes, &other.vertices, &other.nodes)
        );
        assert_eq!(
            (&bsp.texinfos, &bsp.faces, &bsp.leafs),
            (&other.texinfos, &other.faces, &other.leafs)
        );
        assert_eq!(
            (&bsp.edges, &bsp.surfedges, &bsp.models),
            (&other.edges, &other.surfedges, &other.models)
        );
        assert_eq!((&bsp.marksurfaces, &bsp.textures), (&other.marksurfaces, &other.textures));
    }
}

#[test]
fn two_psb_records_have_short_bounds_and_long_indices() {
    // The oracle crate does not read 2PSB, so its layout is checked here by hand.
    let bsp = sample(Format::TwoPsb);
    let file = bsp.write().unwrap();
    assert_eq!(&file[..4], b"2PSB");
    let lump = |index: usize| {
        let (offset, length) = lumps(&file)[index];
        &file[offset..offset + length]
    };
    let number =
        |bytes: &[u8], at: usize| i32::from_le_bytes(bytes[at..at + 4].try_into().unwrap());
    assert_eq!(lump(5).len(), 32 * bsp.nodes.len());
    assert_eq!(lump(10).len(), 32 * bsp.leafs.len());
    for (record, node) in lump(5).chunks(32).zip(&bsp.nodes) {
        assert_eq!(number(record, 0), node.plane as i32);
        assert_eq!([number(record, 4), number(record, 8)], node.children);
        assert_eq!(record[12..14], (-128_i16).to_le_bytes());
    }
    for (record, leaf) in lump(10).chunks(32).zip(&bsp.leafs) {
        assert_eq!(number(record, 0), leaf.contents);
        assert_eq!(
            [number(record, 20), number(record, 24)],
            [leaf.first_mark as i32, leaf.mark_count as i32]
        );
    }
}

/// What the `qbsp` crate reads.
fn oracle(file: &[u8]) -> BspData {
    let settings = BspParseSettings { use_bspx_rgb_lighting: false, parse_bspx_structures: false };
    BspData::parse(BspParseInput { bsp: file, lit: None, settings }).unwrap()
}

/// Compares all that both readers know.
fn assert_agrees(bsp: &Bsp, theirs: &BspData) {
    assert_eq!(bsp.vertices, theirs.vertices);
    assert_eq!(bsp.surfedges, theirs.surface_edges);
    assert_eq!(bsp.entities, theirs.entities);
    let edges: Vec<_> = theirs.edges.iter().map(|edge| [edge.a.0, edge.b.0]).collect();
    assert_eq!(bsp.edges, edges);
    let marks: Vec<_> = theirs.mark_surfaces.iter().map(|mark| mark.0).collect();
    assert_eq!(bsp.marksurfaces, marks);
    let planes: Vec<_> = theirs.planes.iter().map(|p| (p.normal, p.dist, p.ty as i32)).collect();
    assert_eq!(bsp.planes.iter().map(|p| (p.normal, p.dist, p.kind)).collect::<Vec<_>>(), planes);

    assert_eq!(bsp.faces.len(), theirs.faces.len());
    for (index, (face, other)) in bsp.faces.iter().zip(&theirs.faces).enumerate() {
        assert_eq!((face.plane, face.side as u32), (other.plane_idx.0, other.plane_side.0));
        assert_eq!((face.first_edge, face.edge_count), (other.first_edge, other.num_edges.0));
        assert_eq!(face.texinfo as u32, other.texture_info_idx.0);
        assert_eq!(face.styles, other.lightmap_styles.map(|style| style.0));
        assert_eq!(face.light_offset, other.lightmap_offset.pixels);
        assert!(bsp.face_vertices(index).eq(other.vertices(theirs)), "face {index}");
    }
    assert_eq!(bsp.texinfos.len(), theirs.tex_info.len());
    for (texinfo, other) in bsp.texinfos.iter().zip(&theirs.tex_info) {
        let place = &other.projection;
        assert_eq!((texinfo.s.truncate(), texinfo.s.w), (place.u_axis, place.u_offset));
        assert_eq!((texinfo.t.truncate(), texinfo.t.w), (place.v_axis, place.v_offset));
        assert_eq!(Some(texinfo.miptex as u32), other.texture_idx.0);
    }
    assert_eq!(bsp.leafs.len(), theirs.leaves.len());
    for (leaf, other) in bsp.leafs.iter().zip(&theirs.leaves) {
        assert_eq!((leaf.first_mark, leaf.mark_count), (other.face_idx.0, other.face_num.0));
    }
    assert_eq!(bsp.nodes.len(), theirs.nodes.len());
    for (node, other) in bsp.nodes.iter().zip(&theirs.nodes) {
        assert_eq!(node.plane, other.plane_idx);
        let children = [*other.front, *other.back].map(|child| match child {
            qbsp::data::BspNodeRef::Node(node) => node as i32,
            qbsp::data::BspNodeRef::Leaf(leaf) => -1 - leaf as i32,
        });
        assert_eq!(node.children, children);
    }
    assert_eq!(bsp.models.len(), theirs.models.len());
    for (model, other) in bsp.models.iter().zip(&theirs.models) {
        assert_eq!((model.mins, model.maxs), (other.bound.min, other.bound.max));
        assert_eq!((model.first_face, model.face_count), (other.first_face, other.num_faces));
        assert_eq!(Some(model.vis_leafs), other.visleafs.0);
    }
    assert_eq!(bsp.textures.len(), theirs.textures.len());
    for (texture, other) in bsp.textures.iter().zip(&theirs.textures) {
        let (Some(texture), Some(other)) = (texture, other) else {
            assert!(texture.is_none() && other.is_none());
            continue;
        };
        assert_eq!(texture.name, other.header.name.as_str());
        assert_eq!((texture.width, texture.height), (other.header.width, other.header.height));
        assert_eq!(texture.pixels.as_deref(), other.data.full.as_deref());
    }
}

#[test]
fn another_reader_agrees_about_generated_maps() {
    for format in [Format::Bsp29, Format::Bsp2] {
        let bsp = sample(format);
        let file = bsp.write().unwrap();
        let theirs = oracle(&file);
        assert_agrees(&bsp, &theirs);
        assert_eq!(theirs.bspx.get_unparsed("QRADNOTES"), Some(&b"seven b"[..]));
        // The tree sorts points into air and rock.
        let contents = |p: Vec3| bsp.leafs[theirs.leaf_at_point(0, p)].contents;
        for air in
            [[-100.0, 100.0, 50.0], [-16.0, 24.0, 80.0], [72.0, 104.0, 8.0], [100.0, -50.0, 5.0]]
        {
            assert_eq!(contents(air.into()), -1, "{air:?}");
        }
        for rock in [[-16.0, 24.0, 32.0], [72.0, 104.0, 24.0], [0.0, 0.0, -1.0], [200.0, 0.0, 50.0]]
        {
            assert_eq!(contents(rock.into()), -2, "{rock:?}");
        }
    }
}

#[test]
fn another_reader_agrees_about_real_maps() {
    for path in support::all_maps() {
        let file = std::fs::read(&path).unwrap();
        println!("{}", path.display());
        assert_agrees(&Bsp::read(&file).unwrap(), &oracle(&file));
    }
}

#[test]
fn faces_turn_clockwise_around_their_normals() {
    let bsp = sample(Format::Bsp29);
    let mut area = 0.0;
    for face in 0..bsp.faces.len() {
        let corners: Vec<Vec3> = bsp.face_vertices(face).collect();
        let plane = bsp.face_plane(face);
        assert!(corners.iter().all(|corner| plane.normal.dot(*corner) == plane.dist));
        let turn = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
        assert!(turn.dot(plane.normal) < 0.0, "face {face}");
        // The side that is seen is air: marked by an empty leaf.
        assert!(bsp.marksurfaces.contains(&(face as u32)), "face {face} is in no leaf");
        area += turn.length();
    }
    let box_area = |x: f32, y: f32, z: f32| 2.0 * (x * y + y * z + z * x);
    let pillars = box_area(32.0, 48.0, 64.0) - 32.0 * 48.0 + box_area(16.0, 16.0, 16.0);
    assert_eq!(area, box_area(256.0, 256.0, 96.0) + pillars);
    let special = |face: &usize| bsp.texinfo_of(*face).unwrap().flags == 1;
    let sky: Vec<usize> = (0..bsp.faces.len()).filter(special).collect();
    assert_eq!(sky.len(), 9);
    assert_eq!(bsp.texture_of(sky[0]).unwrap().name, "sky1");
    assert_eq!(bsp.face_extents(sky[0], 16.0).unwrap().size, [7, 7]);
}

/// Reads a damaged map and, if that works, uses what was read.
fn read_and_use(file: &[u8]) {
    let Ok(bsp) = Bsp::read(file) else { return };
    for face in 0..bsp.faces.len() {
        let _ = (bsp.face_vertices(face).count(), bsp.face_plane(face), bsp.texture_of(face));
        let _ = bsp.face_extents(face, 16.0);
    }
    for leaf in &bsp.leafs {
        let range = leaf.first_mark as usize..(leaf.first_mark + leaf.mark_count) as usize;
        assert!(leaf.mark_count == 0 || range.end <= bsp.marksurfaces.len());
    }
    for texture in bsp.textures.iter().flatten() {
        let _ = average_colour(texture.pixels.as_deref().unwrap_or(&[]));
    }
    let _ = rewrite_entities(&bsp.entities, StyleRange::default());
    // A map that was accepted can be written and read again, and is the same then.
    let written = bsp.write().unwrap();
    assert_eq!(Bsp::read(&written).unwrap().write().unwrap(), written);
}

/// A change of a file: place (as a share of its length, or a small offset into the header) and value.
fn mutations() -> impl Strategy<Value = Vec<(f64, bool, i32, usize)>> {
    let value = prop_oneof![any::<i32>(), -2..300_i32, Just(i32::MIN), Just(i32::MAX)];
    proptest::collection::vec((0.0..1.0, any::<bool>(), value, 1..5_usize), 1..8)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 1000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn damaged_maps_never_panic(changes in mutations(), cut in 0.0..1.5_f64, format in 0..3_usize) {
        let mut file = sample(FORMATS[format]).write().unwrap();
        for (share, in_header, value, width) in changes {
            let span = if in_header { 124 } else { file.len() - 4 };
            let at = (share * span as f64) as usize;
            file[at..at + width].copy_from_slice(&value.to_le_bytes()[..width]);
        }
        let length = (cut * file.len() as f64) as usize;
        file.truncate(length.max(4));
        read_and_use(&file);
    }

    #[test]
    fn any_bytes_are_read_without_panic(bytes in proptest::collection::vec(any::<u8>(), 0..400)) {
        let _ = (Bsp::read(&bytes), load_wad(&bytes), read_lit(&bytes), parse_entities(&bytes));
        for magic in [&b"BSP2"[..], b"WAD2", b"QLIT\x01\0\0\0", b"{ \"a\" "] {
            let bytes = [magic, &bytes].concat();
            let _ = (Bsp::read(&bytes), load_wad(&bytes), read_lit(&bytes), rewrite_entities(&bytes, StyleRange::default()));
        }
    }

    #[test]
    fn entity_text_comes_back(
        pairs in proptest::collection::vec(("[!-~&&[^\"\\\\]]{1,12}", "[ -~\u{80}-\u{FF}&&[^\"\\\\]]{1,30}"), 0..12)
    ) {
        let mut text = b"{ ".to_vec();
        let mut expected: Vec<(String, String)> = Vec::new();
        for (key, value) in pairs {
            let value_bytes: Vec<u8> = value.chars().map(|c| c as u8).collect();
            text.extend([b"\"", key.as_bytes(), b"\" \"", &value_bytes, b"\"\n"].concat());
            match expected.iter_mut().find(|(known, _)| *known == key) {
                Some(pair) => pair.1 = value,
                None => expected.push((key, value)),
            }
        }
        text.extend(b"}\0");
        let entities = parse_entities(&text).unwrap();
        prop_assert_eq!(entities.len(), 1);
        let found: Vec<_> = entities[0].pairs().map(|(k, v)| (k.to_owned(), v.to_owned())).collect();
        prop_assert_eq!(found, expected);
        prop_assert_eq!(parse_entities(&write_entities(&entities)).unwrap(), entities);
    }
}

/// Message for a sample map after a change of its bytes.
fn message_after(change: impl FnOnce(&mut Vec<u8>)) -> String {
    let mut file = sample(Format::Bsp29).write().unwrap();
    change(&mut file);
    Bsp::read(&file).unwrap_err().to_string()
}

/// Overwrites bytes of one record of a lump in a BSP29 file.
fn poke(file: &mut [u8], lump: usize, at: usize, bytes: &[u8]) {
    let start = lumps(file)[lump].0 + at;
    file[start..start + bytes.len()].copy_from_slice(bytes);
}

#[test]
fn errors_name_lump_index_and_numbers() {
    let bad = 9999_u16.to_le_bytes();
    let check = |lump: usize, at: usize, bytes: &[u8], words: &[&str]| {
        let message = message_after(|file| poke(file, lump, at, bytes));
        assert!(words.iter().all(|word| message.contains(word)), "{message}");
    };
    check(3, 12 * 5, &f32::NAN.to_le_bytes(), &["vertex 5", "not finite"]);
    check(3, 12 * 4 + 8, &f32::INFINITY.to_le_bytes(), &["vertex 4", "not finite"]);
    check(7, 20 * 2, &bad, &["faces", "record 2", "plane is 9999"]);
    check(7, 20 * 2 + 8, &bad, &["faces", "record 2", "surfedges", "8 to 10007"]);
    check(12, 4 * 3, &bad, &["edges", "record 3", "vertex is 9999"]);
    check(13, 4 * 3, &i32::MIN.to_le_bytes(), &["surfedges", "record 3", "2147483648"]);
    check(11, 2, &bad, &["marksurfaces", "record 1", "9999"]);
    check(10, 28 + 20, &bad, &["leafs", "record 1", "9999"]);
    check(5, 24, &i32::from(i16::MAX).to_le_bytes(), &["nodes", "record 1", "plane is 32767"]);
    check(5, 24 + 4, &0x7000_i16.to_le_bytes(), &["nodes", "record 1", "node is 28672"]);
    check(5, 24 + 4, &i16::MIN.to_le_bytes(), &["nodes", "record 1", "leaf is 32767"]);
    check(5, 24 + 4, &0_i16.to_le_bytes(), &["nodes", "loop"]);
    check(5, 24 + 4, &1_i16.to_le_bytes(), &["nodes", "parent"]);
    check(14, 36, &bad, &["models", "record 0", "node is"]);
    check(14, 60, &i32::MAX.to_le_bytes(), &["models", "record 0", "faces"]);
    check(14, 56, &(-1_i32).to_le_bytes(), &["models", "record 0", "first face is -1"]);
    let message = message_after(|file| file[8 + 8 * 3] += 1);
    assert!(message.contains("vertices lump") && message.contains("record size 12"), "{message}");
    let message = message_after(|file| file[4 + 8 * 3 + 3] = 0x80);
    assert!(
        message.contains("vertices lump") && message.contains("not inside the file"),
        "{message}"
    );
    let message = message_after(|file| file[8 + 8 * 14..12 + 8 * 14].fill(0));
    assert!(message.contains("models lump"), "{message}");
}

#[test]
fn a_face_without_texinfo_is_accepted() {
    let mut file = sample(Format::Bsp29).write().unwrap();
    poke(&mut file, 7, 10, &[0xFF; 2]);
    let bsp = Bsp::read(&file).unwrap();
    assert_eq!((bsp.texinfo_of(0), bsp.texture_of(0)), (None, None));
    assert_eq!(bsp.write().unwrap(), file);
}

#[test]
fn maps_of_other_games_are_named() {
    let with_ident = |ident: [u8; 4]| message_after(|file| file[..4].copy_from_slice(&ident));
    assert!(with_ident([30, 0, 0, 0]).contains("unsupported: this is a Half-Life"));
    assert!(with_ident(*b"IBSP").contains("unsupported: this is a Quake II"));
    assert!(with_ident(*b"QBSP").contains("unsupported: this is a Qbism"));
    assert!(with_ident(*b"RIFF").contains("no ident of a BSP"));
    let hexen =
        message_after(|file| file[8 + 8 * 14..12 + 8 * 14].copy_from_slice(&80_u32.to_le_bytes()));
    assert!(hexen.contains("unsupported: this is a Hexen II"), "{hexen}");
}

#[test]
fn damaged_bspx_is_dropped_and_the_map_stays() {
    let mut file = sample(Format::Bsp2).write().unwrap();
    let start = file.windows(4).position(|bytes| bytes == b"BSPX").unwrap();
    // The second entry's offset.
    file[start + 8 + 32 + 24..][..4].copy_from_slice(&u32::MAX.to_le_bytes());
    let names = |file: &[u8]| -> Vec<String> {
        Bsp::read(file).unwrap().bspx.into_iter().map(|lump| lump.name).collect()
    };
    assert_eq!(names(&file), ["QRADNOTES"]);
    file[start] = b'?';
    assert!(names(&file).is_empty());
}

#[test]
fn entities_of_real_maps_come_back() {
    for path in support::all_maps() {
        let bsp = Bsp::read(&std::fs::read(&path).unwrap()).unwrap();
        let entities = parse_entities(&bsp.entities).unwrap();
        assert_eq!(entities[0].classname(), "worldspawn", "{}", path.display());
        let text = write_entities(&entities);
        assert_eq!(parse_entities(&text).unwrap(), entities);
        // qbsp writes the same layout, so the bytes agree too.
        assert!(text == bsp.entities, "{}", path.display());
    }
}

#[test]
fn the_wad_holds_the_textures_of_the_maps() {
    let dir = support::maps_dir();
    let wad = load_wad(&std::fs::read(dir.join("demo.wad")).unwrap()).unwrap();
    assert!(wad.len() > 10);
    let bsp = Bsp::read(&std::fs::read(dir.join("furnace.bsp")).unwrap()).unwrap();
    let mut found = 0;
    for texture in bsp.textures.iter().flatten() {
        let other = find_texture(&wad, &texture.name.to_uppercase());
        if let Some(other) = other {
            assert_eq!((other.width, &other.pixels), (texture.width, &texture.pixels));
            found += 1;
        }
    }
    assert!(found > 0);
    let mid = find_texture(&wad, "mid").unwrap();
    let mean = average_colour(mid.pixels.as_ref().unwrap()).unwrap();
    assert_eq!(mean, Vec3::splat(f32::from(0xBB_u8) / 255.0));
}

#[test]
fn finds_textures_of_any_size_whatever_the_case() {
    // quake-util itself refuses sizes that are no multiple of 8, and panics on zero.
    for (width, height) in [(8, 16), (3, 5)] {
        let textures = load_wad(&wad(width, height)).unwrap();
        let texture = find_texture(&textures, "OUTER").unwrap();
        assert_eq!((texture.width, texture.height), (width, height));
        assert_eq!(texture.pixels, Some(vec![7; (width * height) as usize]));
        assert_eq!(find_texture(&textures, "inner"), None);
    }
    assert_eq!(load_wad(&wad(0, 0)).unwrap()[0].pixels, None);
}

#[test]
fn damaged_wads_do_not_panic() {
    let good = wad(8, 8);
    for length in 0..good.len() {
        assert!(load_wad(&good[..length]).is_err(), "cut to {length} bytes");
    }
    for at in 0..good.len() {
        for byte in [0, 0x7F, 0xFF] {
            let mut bad = good.clone();
            bad[at] = byte;
            let _ = load_wad(&bad);
        }
    }
    let mut wad3 = good;
    wad3[3] = b'3';
    assert!(matches!(load_wad(&wad3), Err(Error::Unsupported(_))));
}
