//! The command line of ericw-tools `light`, rewritten into that of `qrad`.
//!
//! Names are exact and take any number of leading dashes. The long options of `qrad` win when they are
//! spelled with two dashes, its short ones when spelled alone with one; `-v` and `-h` mean the same in
//! both. A later option wins over an earlier one.

mod table;
mod worldspawn;

pub use table::{Effect, LegacyOption, OPTIONS, Values};
pub use worldspawn::of_worldspawn;

use crate::scene::ALL_BOUNCES;
use crate::{Error, Result};
use clap::Command;
use std::ffi::{OsStr, OsString};
use std::iter::Peekable;
use std::path::Path;
use std::vec::IntoIter;

/// The most bounces that the reference accepts.
const MOST_BOUNCES: f64 = 100.0;

/// Arguments of `qrad` that mean the same as `args`, whose first is the name of the program, and a
/// sentence for every option that has no effect. `own` is the command line of `qrad`.
///
/// # Errors
/// For an option that neither program has, and for missing and unusable values.
pub fn rewrite(args: Vec<OsString>, own: &Command) -> Result<(Vec<OsString>, Vec<String>)> {
    let mut own = own.clone();
    own.build();
    let mut args = args.into_iter().peekable();
    let out = args.next().into_iter().collect();
    Rewriter { args, own: &own, out, notes: Vec::new() }.run()
}

/// What an option does, for the table in the documentation: Markdown.
pub fn describe(option: &LegacyOption, own: &Command) -> String {
    let name = option.names[0];
    let has = |long: &str| own.get_arguments().any(|a| a.get_long() == Some(long));
    match option.effect {
        Effect::Key => format!("`--set {name}=…`"),
        Effect::Own(long, _) if has(long) => format!("`--{long}`"),
        Effect::Own(_, reason) | Effect::Ignored(reason) => format!("ignored: {reason}"),
        Effect::Off(key) => format!("`--set {key}=0`"),
        Effect::View(view) => format!("`--debug {view}`"),
        Effect::Bounces => "`--bounces`; without a number, `all`".into(),
        Effect::Search => "`--wad` for a `.wad` file, else `--path`".into(),
        Effect::Threads => "`--threads`; 0 is all cores".into(),
        Effect::Help => "`--help`".into(),
    }
}

/// The option of this name, without dashes.
fn find(name: &str) -> Option<&'static LegacyOption> {
    OPTIONS.iter().find(|o| o.names.contains(&name))
}

/// The whole of `text` as a finite number. `2fort.bsp` is none, although it begins like one.
fn number(text: &str) -> Option<f64> {
    text.parse().ok().filter(|n: &f64| n.is_finite())
}

struct Rewriter<'a> {
    args: Peekable<IntoIter<OsString>>,
    own: &'a Command,
    out: Vec<OsString>,
    notes: Vec<String>,
}

impl Rewriter<'_> {
    fn run(mut self) -> Result<(Vec<OsString>, Vec<String>)> {
        while let Some(arg) = self.args.next() {
            let text = arg.to_str().filter(|t| t.len() > 1 && t.starts_with('-'));
            match text.map(str::to_owned) {
                None => self.out.push(arg),
                Some(text) if text == "--" => {
                    self.out.push(arg);
                    self.out.extend(self.args.by_ref());
                }
                Some(text) => self.option(&text)?,
            }
        }
        Ok((self.out, self.notes))
    }

    fn option(&mut self, text: &str) -> Result<()> {
        if let Some(takes_value) = self.own_option(text) {
            self.out.push(text.into());
            if takes_value && !text.contains('=') {
                self.out.extend(self.args.next());
            }
            return Ok(());
        }
        match find(text.trim_start_matches('-')) {
            Some(option) => self.translate(text, option),
            None => Err(self.unknown(text)),
        }
    }

    /// Whether `qrad` itself has the option, and if so, whether it must have a value.
    fn own_option(&self, text: &str) -> Option<bool> {
        let name = text.split_once('=').map_or(text, |(name, _)| name);
        let arg = self.own.get_arguments().find(|a| {
            let long = name.strip_prefix("--").is_some_and(|n| a.get_long() == Some(n));
            let short = name.strip_prefix('-').is_some_and(|n| {
                let mut letters = n.chars();
                letters.next() == a.get_short() && letters.next().is_none()
            });
            long || (a.get_short().is_some() && short)
        })?;
        let least = arg.get_num_args().map_or(1, |range| range.min_values());
        Some(arg.get_action().takes_values() && least > 0)
    }

    fn translate(&mut self, text: &str, option: &LegacyOption) -> Result<()> {
        let value = self.values(text, option.values)?;
        let value_text = value.as_ref().and_then(|v| v.to_str());
        let value_number = value_text.and_then(number);
        let off = option.values == Values::Switch && matches!(value_text, Some("0" | "-1"));
        match option.effect {
            Effect::Key => {
                self.emit(
                    &format!("--set={}=", option.names[0]),
                    Some(value.unwrap_or("1".into())),
                );
            }
            Effect::Own(long, missing) => {
                let flag = format!("--{long}");
                let Some(arg) = self.own.get_arguments().find(|a| a.get_long() == Some(long))
                else {
                    if !off {
                        self.ignore(text, missing);
                    }
                    return Ok(());
                };
                if !arg.get_action().takes_values() {
                    self.out.retain(|t| *t != *flag);
                    if !off {
                        self.emit(&flag, None);
                    }
                } else if value.is_some() {
                    self.emit(&format!("{flag}="), value);
                } else {
                    self.emit(&flag, None);
                }
            }
            Effect::Ignored(reason) if !off => self.ignore(text, reason),
            Effect::Ignored(_) => {}
            Effect::Bounces => {
                let count = value_number.map_or_else(
                    || ALL_BOUNCES.to_owned(),
                    |n| (n.clamp(0.0, MOST_BOUNCES) as u32).to_string(),
                );
                self.emit("--bounces=", Some(count.into()));
            }
            Effect::Off(key) => {
                let value = if off { "1" } else { "0" };
                self.emit(&format!("--set={key}="), Some(value.into()));
            }
            Effect::View(view) => {
                self.out.retain(|t| !t.to_str().is_some_and(|t| t.starts_with("--debug=")));
                if !off {
                    self.emit("--debug=", Some(view.into()));
                }
            }
            Effect::Search => {
                let path = value.unwrap_or_default();
                self.out.push(if is_wad(&path) { "--wad" } else { "--path" }.into());
                self.out.push(path);
            }
            Effect::Threads => {
                self.out.retain(|t| !t.to_str().is_some_and(|t| t.starts_with("--threads=")));
                if let Some(count @ 1.0..) = value_number {
                    self.emit("--threads=", Some((count as u64).to_string().into()));
                }
            }
            Effect::Help if !off => self.emit("--help", None),
            Effect::Help => {}
        }
        Ok(())
    }

    fn emit(&mut self, prefix: &str, value: Option<OsString>) {
        let mut arg = OsString::from(prefix);
        arg.push(value.unwrap_or_default());
        self.out.push(arg);
    }

    fn ignore(&mut self, text: &str, reason: &str) {
        let note = format!("{text}: {reason}; ignored");
        if !self.notes.contains(&note) {
            self.notes.push(note);
        }
    }

    /// Takes the values of an option; several numbers become one text.
    fn values(&mut self, option: &str, values: Values) -> Result<Option<OsString>> {
        let missing = |what: &str| Err(Error::setting(option, format!("give {what} after it")));
        match values {
            Values::Switch => {
                Ok(self.args.next_if(|a| matches!(a.to_str(), Some("0" | "1" | "-1"))))
            }
            Values::OptionalNumber => Ok(self.number()),
            Values::Number => self.number().map_or_else(|| missing("a number"), |n| Ok(Some(n))),
            Values::Vector => match self.numbers(3)?[..] {
                [ref x, ref y, ref z] => Ok(Some(format!("{x} {y} {z}").into())),
                _ => missing("three numbers"),
            },
            Values::UpToThree => match &self.numbers(3)?[..] {
                [] => missing("one to three numbers"),
                numbers => Ok(Some(numbers.join(" ").into())),
            },
            Values::Word(words) => self
                .args
                .next_if(|a| {
                    let known = |t: &str| words.iter().any(|w| w.eq_ignore_ascii_case(t));
                    a.to_str().is_some_and(|t| known(t) || t.parse::<u8>().is_ok())
                })
                .map_or_else(|| missing(&words.join(" or ")), |word| Ok(Some(word))),
            Values::Text => match self.args.next_if(|a| !begins_with_dash(a)) {
                Some(text) => Ok(Some(text)),
                None => missing("a path"),
            },
        }
    }

    fn number(&mut self) -> Option<OsString> {
        self.args.next_if(|a| a.to_str().and_then(number).is_some())
    }

    /// Up to `most` numbers, each an argument, or all in one.
    fn numbers(&mut self, most: usize) -> Result<Vec<String>> {
        let all = |text: &str| -> Option<Vec<String>> {
            let words: Vec<&str> = text.split_ascii_whitespace().collect();
            let numbers = words.len() > 1 && words.iter().all(|w| number(w).is_some());
            numbers.then(|| words.into_iter().map(str::to_owned).collect())
        };
        let quoted = self.args.peek().and_then(|a| a.to_str()).and_then(all);
        if let Some(numbers) = quoted {
            self.args.next();
            return Ok(numbers);
        }
        let mut numbers = Vec::new();
        while numbers.len() < most {
            let Some(number) = self.number() else { break };
            numbers.push(number.to_string_lossy().into_owned());
        }
        Ok(numbers)
    }

    /// The error for an option that is not known, with the most similar one that is.
    fn unknown(&self, text: &str) -> Error {
        let asked = text.trim_start_matches('-');
        let asked = asked.split_once('=').map_or(asked, |(name, _)| name);
        let own = self.own.get_arguments().filter_map(|a| a.get_long()).map(|n| ("--", n));
        let legacy = OPTIONS.iter().flat_map(|o| o.names).map(|&n| ("-", n));
        let nearest = legacy
            .chain(own)
            .map(|(dashes, name)| (strsim::damerau_levenshtein(asked, name), dashes, name))
            .min_by_key(|(distance, ..)| *distance)
            .filter(|(distance, ..)| *distance <= 1 + asked.chars().count() / 4);
        let advice = nearest.map_or_else(
            || "qrad --help lists the options".to_owned(),
            |(_, dashes, name)| format!("did you mean {dashes}{name}?"),
        );
        Error::setting(text, format!("there is no such option; {advice}"))
    }
}

fn begins_with_dash(arg: &OsStr) -> bool {
    arg.to_string_lossy().starts_with('-')
}

fn is_wad(path: &OsStr) -> bool {
    Path::new(path).extension().is_some_and(|e| e.eq_ignore_ascii_case("wad"))
}
