//! The words after the six numbers of a patch's second line.

use qrad::patch::{PatchEffects, Reading, Shader, TextScene};

const HEAD: &str = "278 273 -800 278 273 0 0 1 0\n256 128 64 32 100\n";
const QUAD: &str = "0 0 0 2 0 0 2 1 0 0 1 0 0 0 1\n";

fn scene(words: &str) -> String {
    format!("{HEAD}{QUAD}0.5 0.25 1 0.4 0.1 0{words}\n")
}

fn effects(words: &str, reading: Reading) -> PatchEffects {
    TextScene::parse_repaired(&scene(words), "s", reading).unwrap().0.patches[0].effects
}

#[track_caller]
fn refused(words: &str, says: &str) {
    let message = TextScene::parse(&scene(words), "s.txt").unwrap_err().to_string();
    assert!(message.starts_with("s.txt: line 4: "), "{message}");
    assert!(message.contains(says) && !message.contains('\n'), "{message}");
}

#[test]
fn words_are_read_in_any_order_and_written_back() {
    let all = " straight 0.1 0.2 0.3 diffuse 0.4 0.5 0.6 two-sided checker 3 2 0.5 0 1";
    let read = effects(all, Reading::Raw);
    assert_eq!(read.straight, Some([0.1, 0.2, 0.3]));
    assert_eq!(read.diffuse, Some([0.4, 0.5, 0.6]));
    assert!(read.two_sided && read.has_two_sides() && read.is_translucent());
    assert_eq!(read.shader, Some(Shader::Checker([3, 2], [0.5, 0.0, 1.0])));
    let turned = " two-sided diffuse 0.4 0.5 0.6 checker 3 2 0.5 0 1 straight 0.1 0.2 0.3";
    assert_eq!(effects(turned, Reading::Raw), read);
    for words in
        [all, "", " two-sided", " straight 0 0 0", " gradient 1 0.5 0", " diffuse 1e-7 0 0"]
    {
        let text = scene(words);
        assert_eq!(TextScene::parse(&text, "s").unwrap().to_text(), text);
    }
    let lit = scene(" straight 0.1 0.2 0.3 back 7 8 9.5");
    assert_eq!(TextScene::parse_lit(&lit, "s").unwrap().to_text(), lit);
}

#[test]
fn complaints_name_the_keyword() {
    refused(" diffus 1 1 1", "unknown keyword \"diffus\"; did you mean \"diffuse\"?");
    refused(" diffuse 0.5 0.5", "diffuse: blue is missing");
    refused(" diffuse 0.5 0.5 x", "diffuse: blue is \"x\", not a number from 0 to 1");
    refused(" straight 0.5 nan 0", "straight: green is \"nan\"");
    refused(" straight 0.5 -0.1 0", "straight: green is \"-0.1\"");
    refused(" straight 0 0 0 straight 0 0 0", "straight is given twice");
    refused(" checker 0 2 1 1 1", "checker: columns is \"0\", not a whole number from 1 to 4096");
    refused(" checker 2 1.5 1 1 1", "checker: rows is \"1.5\"");
    refused(" checker 2 2 1 1 1 gradient 1 1 1", "one shader");
    refused(" back 1 1 1", "back: only scenes that are lit");
    refused(
        " diffuse 0.7 0 0",
        "diffuse: reflectance 0.4 + straight 0 + diffuse 0.7 is more than 1 in red",
    );
    refused(" straight 0 0.95 0", "straight: reflectance 0.1 + straight 0.95");
    refused(" 1 1 1", "9 numbers where 6 are expected");
    refused(" two-sided 1", "unknown keyword \"1\"");
}

#[test]
fn sums_of_exactly_one_are_fine_whatever_the_rounding() {
    for (rho, tau) in [(0.1, 0.9), (0.7, 0.3), (0.33, 0.67), (0.0, 1.0)] {
        let text = format!("{HEAD}{QUAD}0 0 0 {rho} 0 0 diffuse {tau} 0 0\n");
        TextScene::parse_repaired(&text, "s", Reading::Raw).unwrap();
    }
}

#[test]
fn light_that_no_sheet_absorbs_is_made_to_settle() {
    let text = format!("{HEAD}{QUAD}0 0 0 0.5 0 0 diffuse 0.5 0 0\n");
    let (scene, repairs) = TextScene::parse_repaired(&text, "s", Reading::Raw).unwrap();
    let quad = scene.patches[0];
    let sum = quad.reflectance[0] + quad.effects.diffuse.unwrap()[0];
    assert!(repairs.len() == 1 && sum < 1.0, "{repairs:?} {sum}");
}

#[test]
fn a_lit_scene_has_an_exitance_for_each_side() {
    let text = scene(" diffuse 0.5 0.5 0.5 two-sided");
    let lit = TextScene::parse(&text, "s").unwrap().lit(&[[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]);
    let out = lit.to_text();
    assert!(out.ends_with("\n0 0 0 1 2 3 back 4 5 6\n"), "{out}");
    assert_eq!(TextScene::parse_lit(&out, "s").unwrap(), lit);
    // Values are those where the shader's factor is 1.
    let text = scene(" checker 2 1 0 0.5 1");
    let out = TextScene::parse(&text, "s").unwrap().lit(&[[1.0, 1.5, 3.0]]).to_text();
    assert!(out.ends_with("\n0 0 0 2 2 3 checker 2 1 0 0.5 1\n"), "{out}");
}

#[test]
fn checkers_and_gradients_have_their_values() {
    let checker = Shader::Checker([2, 2], [0.5; 3]);
    let at = |s, t| checker.factor(s, t)[0];
    assert_eq!([at(0.1, 0.1), at(0.9, 0.1), at(0.1, 0.9), at(0.9, 0.9)], [1.0, 0.5, 0.5, 1.0]);
    assert_eq!([at(-0.1, 0.0), at(1.0, 1.0)], [1.0, 1.0], "rounded out of the patch");
    let gradient = Shader::Gradient([0.0, 0.5, 1.0]);
    assert_eq!(gradient.factor(0.3, 0.5), [0.5, 0.75, 1.0]);
}
