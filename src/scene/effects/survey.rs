//! Looks at a scene once and says which effects it calls for.

use super::apply::kind_of_filter;
use super::{Effect, Entry, Plan};
use crate::Result;
use crate::light::{Reaches, reaches};
use crate::lightmap::Gather;
use crate::outputs::LitFile;
use crate::scene::{AutoMinlight, Role, Scene, Shading, Surface};
use crate::settings::Settings;
use clap::ValueEnum;
use glam::Vec3;
use std::collections::BTreeSet;
use std::sync::Arc;

/// What is found on or off, and why.
type Finding = (bool, String);

/// The plan of a run on `scene`.
pub fn plan(scene: &Scene, settings: &Settings) -> Plan {
    let survey = Survey { scene, settings };
    let entries = Effect::value_variants().iter().map(|&effect| {
        let (on, mut reason) = survey.of(effect);
        if let (false, Some(false)) = (on, settings.switches.of(effect)) {
            reason = format!("switched off with -{}", effect.name());
        }
        Entry { effect, on, reason, predicted: None, measured: None }
    });
    Plan { entries: entries.collect() }
}

/// Refuses effects that are switched on by hand and that neither the scene nor the settings tell enough of.
///
/// # Errors
/// The first of them, with what to do.
pub(crate) fn check_switches(scene: &Scene, settings: &Settings) -> Result<()> {
    settings.switches.check(|effect| Survey { scene, settings }.of(effect).0)
}

struct Survey<'a> {
    scene: &'a Scene,
    settings: &'a Settings,
}

impl Survey<'_> {
    fn of(&self, effect: Effect) -> Finding {
        let Scene { lights, suns, world, .. } = self.scene;
        let outputs = &self.settings.outputs;
        let at_light = |l: &crate::scene::Light| place(l.origin);
        match effect {
            Effect::Colour => self.colour(),
            Effect::Styles => self.styles(),
            Effect::Lights => self.lights(),
            Effect::Projections => {
                let own = lights.iter().filter(|l| l.projection.is_some());
                counted(own.map(at_light), "lights that project", "no light projects a picture")
            }
            Effect::SurfaceLights => self.surface_lights(),
            Effect::Suns => {
                let own = suns.iter().filter(|s| !s.dome);
                counted(own.map(|s| direction(s.to_sun)), "suns", &self.no_sun("suns"))
            }
            Effect::SkyDomes => {
                let own = suns.iter().filter(|s| s.dome);
                counted(own.map(|s| direction(s.to_sun)), "suns of domes", &self.no_sun("domes"))
            }
            Effect::NegativeLight => {
                let points = lights.iter().filter(|l| l.brightness < 0.0).map(at_light);
                let skies = suns.iter().filter(|s| s.brightness < 0.0);
                let all = points.chain(skies.map(|s| direction(s.to_sun)));
                counted(all, "negative lights", "no light takes light away")
            }
            Effect::Minlight => self.minlight(),
            Effect::Dirt if world.dirt.in_use => (true, self.dirt()),
            Effect::Dirt => (false, "nothing asks for _dirt".into()),
            Effect::Phong if !world.phong => (false, "worldspawn _phong is 0".into()),
            Effect::Phong => {
                self.faces(|s| s.curved, "faces with smoothed normals", "no face asks for _phong")
            }
            Effect::Fences | Effect::Glass | Effect::ModelShadows => self.filters(effect),
            Effect::Curtains => self.textured(
                |s, _| s.diffuse.is_some_and(|t| t != Vec3::ZERO),
                "nothing lets light through diffusely",
            ),
            Effect::Shaders => self.shaders(),
            Effect::Bounces => self.bounces(),
            Effect::NearField => self.near_field(),
            Effect::Supersampling => {
                let smoothing = self.settings.smoothing;
                let (extra, soft) = (smoothing.extra, smoothing.soft);
                let on = extra > 1 || soft > 0;
                (on, format!("samples a luxel: {}, blur: {soft}", extra * extra))
            }
            Effect::Lit => match outputs.lit {
                LitFile::Auto if outputs.rgb_file(true) => {
                    let on = self.colour().0;
                    (on, format!("the light has {} colour", if on { "or may have" } else { "no" }))
                }
                LitFile::Auto | LitFile::Never => {
                    (false, "colours go elsewhere, if anywhere".into())
                }
                _ => (true, "asked for".into()),
            },
            Effect::Hdr => asked(outputs.hdr(), "--hdr or --bspxhdr"),
            Effect::BspxLight => asked(outputs.bspx_rgb(false), "--bspxlit"),
            Effect::Directions => asked(outputs.directions(), "--lux or --bspxlux"),
            Effect::FaceNormals => asked(outputs.face_normals, "--wrnormals"),
            Effect::FaceStyles => {
                (outputs.face_styles != 4, format!("{} styles a face", outputs.face_styles))
            }
            Effect::LuxelSizes => {
                let other = |s: &Surface| s.vanilla_luxels.is_some();
                self.faces(other, "faces with luxels of other sizes", "all as their texture says")
            }
            Effect::LightGrid => match &self.scene.light_grid {
                Some(grid) => (true, format!("{} points", grid.place.len())),
                None => asked(false, "--lightgrid"),
            },
        }
    }

    /// Counts surfaces.
    fn faces(&self, which: impl Fn(&Surface) -> bool, what: &str, none: &str) -> Finding {
        let surfaces = self.scene.surfaces.iter().filter(|s| which(s));
        counted(surfaces.map(|s| place(middle(s))), what, none)
    }

    /// Counts surfaces, and names the textures on them.
    fn textured(&self, which: impl Fn(&Surface, &str) -> bool, none: &str) -> Finding {
        let pairs = || self.scene.surfaces.iter().zip(&self.scene.names);
        let found: Vec<_> = pairs().filter(|(s, name)| which(s, name)).collect();
        let Some((first, _)) = found.first() else { return (false, none.into()) };
        let names: BTreeSet<&str> = found.iter().map(|(_, name)| name.as_str()).collect();
        let mut listed: Vec<&str> = names.iter().copied().take(3).collect();
        if names.len() > listed.len() {
            listed.push("...");
        }
        let (count, at) = (found.len(), place(middle(first)));
        (true, format!("faces of {}: {count}, first at {at}", listed.join(", ")))
    }

    fn no_sun(&self, what: &str) -> String {
        if self.scene.surfaces.iter().any(|s| s.role == Role::Sky) {
            format!("no {what} asked for")
        } else {
            "no sky to see".into()
        }
    }

    fn colour(&self) -> Finding {
        let Scene { lights, suns, surfaces, radiosity_lights, emitters, .. } = self.scene;
        if self.settings.switches.off(Effect::Colour) {
            return (false, String::new());
        }
        let lights = lights.iter().chain(&self.scene.local_minlights);
        let coloured = lights
            .filter(|l| !is_grey(l.colour) || l.projection.is_some())
            .map(|l| place(l.origin))
            .chain(suns.iter().filter(|s| !is_grey(s.colour)).map(|s| direction(s.to_sun)))
            .chain(radiosity_lights.iter().filter(|l| !is_grey(l.colour)).map(|l| place(l.middle)))
            .chain(
                emitters
                    .iter()
                    .filter(|e| !is_grey(e.exitance.0))
                    .map(|e| place(middle(&surfaces[e.surface as usize]))),
            );
        let (by_light, lights) =
            counted(coloured, "coloured lights, suns and surfaces", "no coloured light");
        let reflects = |s: &Surface| s.reflects && !is_grey(s.reflectance.0);
        let (by_faces, faces) = match self.bounces().0 {
            true => self.faces(reflects, "coloured faces", "no coloured face"),
            false => (false, "no bounce off coloured faces".into()),
        };
        let glass = self.filters(Effect::Glass).0;
        let through = |s: &Surface| s.diffuse.is_some_and(|t| !is_grey(t));
        let (by_curtains, curtains) =
            self.faces(through, "faces that light comes through coloured", "");
        let shaders = self.scene.shadings.iter().flatten().filter(|s| s.is_coloured()).count();
        let own = |s: &Surface| {
            let glow = s.minlight.glow.is_some_and(|g| !is_grey(g.colour));
            s.luxels.is_some() && (glow || s.minlight.level > 0.0 && !is_grey(s.minlight.colour))
        };
        let (by_minlight, minlight) = self.faces(own, "faces with coloured minlight", "");
        let mut reasons = vec![lights, faces];
        reasons.extend(by_minlight.then_some(minlight));
        reasons.extend(by_curtains.then_some(curtains));
        reasons.extend((shaders > 0).then(|| format!("faces with coloured patterns: {shaders}")));
        reasons.extend(glass.then(|| "glass".to_owned()));
        let on = by_light || by_faces || by_minlight || by_curtains || shaders > 0 || glass;
        (
            on,
            format!(
                "{}: {}",
                if on { "three channels" } else { "one channel" },
                reasons.join("; ")
            ),
        )
    }

    fn styles(&self) -> Finding {
        let Scene { lights, suns, radiosity_lights, emitters, models, .. } = self.scene;
        let of_models = models.iter().filter(|m| m.casts()).map(|m| m.switch_style);
        let styles: BTreeSet<u16> = lights
            .iter()
            .map(|l| l.style)
            .chain(suns.iter().map(|s| s.style))
            .chain(radiosity_lights.iter().map(|l| l.style))
            .chain(emitters.iter().map(|e| e.style))
            .chain(of_models)
            .filter(|&style| style != 0)
            .collect();
        if styles.is_empty() {
            return (false, "every light is steady".into());
        }
        let first = lights.iter().find(|l| l.style != 0).map(|l| place(l.origin));
        let first = first.map_or(String::new(), |p| format!(", first at {p}"));
        let listed: Vec<String> = styles.iter().take(6).map(u16::to_string).collect();
        (true, format!("{} styles besides 0 ({}){first}", styles.len(), listed.join(" ")))
    }

    fn lights(&self) -> Finding {
        let lights = &self.scene.lights;
        let own = lights.iter().filter(|l| l.piece_radius == 0.0).map(|l| place(l.origin));
        let (on, what) = counted(own, "point lights and spotlights", "no light of this kind");
        if !on {
            return (on, what);
        }
        let Reaches { ends, endless, idle, unknown } = reaches(self.scene);
        let mut reasons = vec![what];
        reasons.extend(ends.map(|[least, most]| match (least.round(), most.round()) {
            (least, most) if least == most => format!("reach {most} units"),
            (least, most) => format!("reach {least} to {most} units"),
        }));
        reasons.extend((endless > 0).then(|| format!("reach without end: {endless}")));
        let places = idle.iter().map(|&l| place(lights[l].origin));
        let (some, idle) = counted(places, "with no face in reach", "");
        reasons.extend(some.then_some(idle));
        reasons.extend((unknown > 0).then(|| format!("not looked at: {unknown}")));
        (on, reasons.join("; "))
    }

    fn surface_lights(&self) -> Finding {
        let Scene { lights, radiosity_lights, emitters, surfaces, .. } = self.scene;
        let copies = lights.iter().filter(|l| l.piece_radius > 0.0).map(|l| place(l.origin));
        let areas = radiosity_lights.iter().map(|l| place(l.middle));
        let patches = emitters.iter().map(|e| place(middle(&surfaces[e.surface as usize])));
        let all = copies.chain(areas).chain(patches);
        counted(all, "shining pieces of surfaces", "no texture shines")
    }

    fn minlight(&self) -> Finding {
        let local = self.scene.local_minlights.iter().map(|l| place(l.origin));
        let (by_lights, lights) = counted(local, "lights of least light", "");
        let level = |s: &Surface| {
            s.luxels.is_some()
                && !s.minlight.exempt
                && (s.minlight.level > 0.0 || s.minlight.glow.is_some())
        };
        let (by_faces, faces) = self.faces(level, "faces with a least light", "");
        let auto = |s: &Surface| s.luxels.is_some() && s.minlight.auto != AutoMinlight::Off;
        let (by_models, models) =
            self.faces(auto, "faces of models that may take that of their middle", "");
        let found = [(by_lights, lights), (by_faces, faces), (by_models, models)];
        let reasons: Vec<String> = found.into_iter().filter(|f| f.0).map(|f| f.1).collect();
        match reasons.is_empty() {
            true => (false, "nothing asks for _minlight".into()),
            false => (true, reasons.join("; ")),
        }
    }

    fn dirt(&self) -> String {
        let lights = self.scene.lights.iter().filter(|l| l.dirt.wanted).count();
        let dirt = &self.scene.world.dirt;
        format!("{lights} lights with dirt, {} units deep", dirt.depth)
    }

    fn filters(&self, effect: Effect) -> Finding {
        let none = match effect {
            Effect::Fences => "no texture with holes that casts shadow",
            Effect::Glass => "nothing that casts shadow is seen through",
            _ => "no model casts shadow in a way of its own",
        };
        let own = |s: &Surface, _: &str| s.role == Role::Filter && kind_of_filter(s) == effect;
        let (on, reason) = self.textured(own, none);
        // One ray may cross several kinds.
        (on, if on { format!("{reason}; with all that filters light") } else { reason })
    }

    fn shaders(&self) -> Finding {
        let Scene { surfaces, shadings, names, .. } = self.scene;
        let varies = |s: &Arc<Shading>| s.is_uneven() || s.glows_unevenly();
        let uneven = |i: &usize| shadings[*i].as_ref().is_some_and(varies);
        let own = (0..shadings.len()).filter(uneven);
        let places = own.map(|i| format!("{} on {}", place(middle(&surfaces[i])), names[i]));
        counted(places, "faces with patterns", "every face reflects and shines alike all over")
    }

    fn bounces(&self) -> Finding {
        let Scene { world, lights, suns, radiosity_lights, emitters, surfaces, .. } = self.scene;
        let dark = lights.is_empty()
            && suns.is_empty()
            && radiosity_lights.is_empty()
            && emitters.is_empty();
        let reflecting = || surfaces.iter().filter(|s| s.reflects);
        let reflectances = || reflecting().map(|s| s.reflectance.0.max_element());
        match world.bounce.most {
            Some(0) => return (false, "asked for none".into()),
            _ if dark => return (false, "nothing is lit".into()),
            _ if reflectances().all(|r| r == 0.0) => return (false, "nothing reflects".into()),
            _ => {}
        }
        let mean = reflectances().sum::<f32>() / reflecting().count().max(1) as f32;
        let until = match world.bounce.most {
            Some(most) => format!("at most {most} times"),
            None => {
                // Each bounce leaves about this share of the light.
                let bounces = (self.settings.residual.ln() / f64::from(mean).ln()).ceil();
                format!("about {bounces:.0} times, until {:.0e} is left", self.settings.residual)
            }
        };
        let count = reflecting().count();
        (true, format!("reflecting faces: {count}, {:.0} % on average; {until}", mean * 100.0))
    }

    fn near_field(&self) -> Finding {
        match (self.bounces().0, self.settings.gather) {
            (false, _) => (false, "no bounced light".into()),
            (true, Gather::Luxel) => (false, "every luxel has a hemicube".into()),
            (true, Gather::Interpolate) if self.settings.gather_error.is_infinite() => {
                (false, "the quality leaves it out".into())
            }
            (true, Gather::Interpolate) => {
                let error = self.settings.gather_error;
                (true, format!("where the points around a luxel differ by more than {error}"))
            }
        }
    }
}

/// On if there is any, with the number and the first.
fn counted(mut places: impl Iterator<Item = String>, what: &str, none: &str) -> Finding {
    match places.next() {
        None => (false, none.to_owned()),
        Some(first) => (true, format!("{what}: {}, first at {first}", 1 + places.count())),
    }
}

fn asked(on: bool, option: &str) -> Finding {
    (on, format!("{}asked for with {option}", if on { "" } else { "not " }))
}

fn is_grey(colour: Vec3) -> bool {
    colour.x == colour.y && colour.y == colour.z
}

fn place(p: Vec3) -> String {
    format!("({:.0} {:.0} {:.0})", p.x, p.y, p.z)
}

fn direction(d: Vec3) -> String {
    // Adding 0 makes 0 of -0.
    let [x, y, z] = d.to_array().map(|c| (c * 100.0).round() / 100.0 + 0.0);
    format!("direction ({x:.2} {y:.2} {z:.2})")
}

fn middle(surface: &Surface) -> Vec3 {
    let sum: Vec3 = surface.vertices.iter().sum();
    sum / surface.vertices.len().max(1) as f32
}
