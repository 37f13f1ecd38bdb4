//! Entity text: `{ "key" "value" ... }` blocks.
//!
//! `quake-util`'s parser is not used here: it is for `.map` source. It ends a quoted string at `\"`,
//! knows no `;` comments and takes bytes from 128 up as parts of words.
//!
//! Bytes have no character set. A string here holds one char for each byte of the file (Latin-1), so
//! every byte survives and names compare exactly.

use crate::{Error, Result};

/// An entity: its keys and values in file order.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Entity {
    pairs: Vec<(String, String)>,
}

impl Entity {
    /// Keys and values in order. No key occurs twice.
    pub fn pairs(&self) -> impl Iterator<Item = (&str, &str)> {
        self.pairs.iter().map(|(key, value)| (key.as_str(), value.as_str()))
    }

    /// Value of exactly this key.
    pub fn get(&self, key: &str) -> Option<&str> {
        self.pairs().find(|&(known, _)| known == key).map(|(_, value)| value)
    }

    /// Value of a setting: keys count without their leading underscores, case sensitively, so that
    /// `light`, `_light` and `__light` are one setting; the last of them wins.
    pub fn setting(&self, name: &str) -> Option<&str> {
        let name = name.trim_start_matches('_');
        self.pairs()
            .filter(|(key, _)| key.trim_start_matches('_') == name)
            .last()
            .map(|(_, value)| value)
    }

    /// The `classname`, empty if there is none.
    pub fn classname(&self) -> &str {
        self.get("classname").unwrap_or("")
    }

    /// Sets a key in place, or adds it at the end.
    pub fn set(&mut self, key: &str, value: impl Into<String>) {
        match self.pairs.iter_mut().find(|(known, _)| known == key) {
            Some((_, old)) => *old = value.into(),
            None => self.pairs.push((key.to_owned(), value.into())),
        }
    }

    /// Removes a key; returns its value.
    pub fn remove(&mut self, key: &str) -> Option<String> {
        let place = self.pairs.iter().position(|(known, _)| known == key)?;
        Some(self.pairs.remove(place).1)
    }

    /// All keys, and their values to be changed in place.
    pub(crate) fn pairs_mut(&mut self) -> impl Iterator<Item = (&str, &mut String)> {
        self.pairs.iter_mut().map(|(key, value)| (key.as_str(), value))
    }
}

/// Parses an entity lump, with or without its final NUL.
///
/// # Errors
/// With the line number: text outside braces, a key without value, a quote or brace left open.
pub fn parse_entities(lump: &[u8]) -> Result<Vec<Entity>> {
    let text = lump.strip_suffix(&[0]).unwrap_or(lump);
    let mut tokens = Tokens { text, position: 0, line: 1 };
    let mut entities = Vec::new();
    while let Some(token) = tokens.next()? {
        if token != Token::Open {
            return Err(tokens.error("an entity must begin with {"));
        }
        entities.push(parse_entity(&mut tokens, entities.len())?);
    }
    Ok(entities)
}

fn parse_entity(tokens: &mut Tokens<'_>, index: usize) -> Result<Entity> {
    let opened = tokens.line;
    // Looking up by hash keeps an entity of a million keys from taking forever.
    let mut places = std::collections::HashMap::new();
    let mut entity = Entity::default();
    loop {
        let key = match tokens.next()? {
            Some(Token::Close) => return Ok(entity),
            Some(Token::Text(key)) => key,
            Some(Token::Open) => return Err(tokens.error("{ inside an entity: a } is missing")),
            None => return Err(unclosed(index, opened)),
        };
        let value = match tokens.next()? {
            Some(Token::Text(value)) => value,
            Some(_) => return Err(tokens.error(&format!("key \"{key}\" has no value"))),
            None => return Err(unclosed(index, opened)),
        };
        let key = key.trim_matches(|c: char| c <= ' ').to_owned();
        if key.is_empty() || value.is_empty() {
            log::warn!(
                "entity text line {}: empty key or value in \"{key}\" \"{value}\"",
                tokens.line
            );
        }
        match places.get(&key) {
            Some(&place) => {
                let pair: &mut (String, String) = &mut entity.pairs[place];
                pair.1 = value;
            }
            None => {
                places.insert(key.clone(), entity.pairs.len());
                entity.pairs.push((key, value));
            }
        }
    }
}

fn unclosed(index: usize, line: usize) -> Error {
    let problem = format!("entity {index} has no closing }}: the text is cut off");
    Error::format(format!("entity text line {line}"), problem)
}

/// The text of entities as an entity lump: `{`, one `"key" "value"` a line, `}`, and a final NUL.
pub fn write_entities(entities: &[Entity]) -> Vec<u8> {
    let mut out = Vec::new();
    for entity in entities {
        out.extend_from_slice(b"{\n");
        for (key, value) in entity.pairs() {
            out.push(b'"');
            push_bytes(&mut out, key);
            out.extend_from_slice(b"\" \"");
            push_bytes(&mut out, value);
            out.extend_from_slice(b"\"\n");
        }
        out.extend_from_slice(b"}\n");
    }
    out.push(0);
    out
}

/// One byte a char; what is no Latin-1 (set by a caller, never read) goes out as UTF-8.
fn push_bytes(out: &mut Vec<u8>, text: &str) {
    for c in text.chars() {
        match u8::try_from(u32::from(c)) {
            Ok(byte) => out.push(byte),
            Err(_) => out.extend_from_slice(c.encode_utf8(&mut [0; 4]).as_bytes()),
        }
    }
}

#[derive(Debug, PartialEq)]
enum Token {
    Open,
    Close,
    Text(String),
}

struct Tokens<'a> {
    text: &'a [u8],
    position: usize,
    line: usize,
}

impl Tokens<'_> {
    fn peek(&self, ahead: usize) -> Option<u8> {
        self.text.get(self.position + ahead).copied()
    }

    fn advance(&mut self) -> Option<u8> {
        let byte = self.peek(0)?;
        self.position += 1;
        self.line += usize::from(byte == b'\n');
        Some(byte)
    }

    fn error(&self, problem: &str) -> Error {
        Error::format(format!("entity text line {}", self.line), problem)
    }

    /// Skips separators and comments. Bytes from 128 up separate too: they are negative to the C code
    /// that defines this format.
    fn skip_separators(&mut self) {
        while let Some(byte) = self.peek(0) {
            if byte == b';' || (byte == b'/' && self.peek(1) == Some(b'/')) {
                while self.peek(0).is_some_and(|byte| byte != b'\n') {
                    self.advance();
                }
            } else if is_separator(byte) {
                self.advance();
            } else {
                return;
            }
        }
    }

    fn next(&mut self) -> Result<Option<Token>> {
        self.skip_separators();
        match self.peek(0) {
            None => return Ok(None),
            Some(b'"') => return self.quoted().map(Some),
            Some(_) => {}
        }
        let start = self.position;
        let is_brace = |byte| byte == b'{' || byte == b'}';
        let mut end = start + 1;
        if !is_brace(self.text[start]) {
            let rest = &self.text[start..];
            let length = rest.iter().position(|&byte| is_separator(byte) || is_brace(byte));
            end = start + length.unwrap_or(rest.len());
        }
        self.position = end;
        Ok(Some(match &self.text[start..end] {
            b"{" => Token::Open,
            b"}" => Token::Close,
            bytes => Token::Text(latin1(bytes)),
        }))
    }

    /// A quoted token. Backslash sequences stay as they are; only `\"` matters, which does not end the
    /// token unless a line break follows (a path such as `"c:\maps\"`).
    fn quoted(&mut self) -> Result<Token> {
        let opened = self.line;
        self.advance();
        let start = self.position;
        while let Some(byte) = self.advance() {
            if byte == b'"' {
                return Ok(Token::Text(latin1(&self.text[start..self.position - 1])));
            }
            if byte == b'\\' {
                let at_line_end = matches!(self.peek(1), Some(b'\r' | b'\n'));
                if !(self.peek(0) == Some(b'"') && at_line_end) {
                    self.advance();
                }
            }
        }
        Err(Error::format(
            format!("entity text line {opened}"),
            "a quote opened here is never closed: the text is cut off",
        ))
    }
}

fn is_separator(byte: u8) -> bool {
    byte <= b' ' || byte >= 128
}

fn latin1(bytes: &[u8]) -> String {
    bytes.iter().copied().map(char::from).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pairs(entity: &Entity) -> Vec<(&str, &str)> {
        entity.pairs().collect()
    }

    #[test]
    fn parses_quotes_words_comments_and_high_bytes() {
        let text = b"// note\n{\n\"classname\" worldspawn ; rest\n\x80\" message \" \"h\xE9 // {\" }\n{}\n\0";
        let entities = parse_entities(text).unwrap();
        assert_eq!(entities.len(), 2);
        assert_eq!(pairs(&entities[0]), [("classname", "worldspawn"), ("message", "h\u{E9} // {")]);
        assert_eq!(entities[0].classname(), "worldspawn");
        let written = write_entities(&entities);
        assert_eq!(
            written,
            b"{\n\"classname\" \"worldspawn\"\n\"message\" \"h\xE9 // {\"\n}\n{\n}\n\0"
        );
        assert_eq!(parse_entities(&written).unwrap(), entities);
    }

    #[test]
    fn escapes_are_kept_verbatim() {
        let text = b"{ \"a\" \"say \\\"hi\\\" \\n \\\\\" \"path\" \"c:\\maps\\\"\n\"b\" \"1\" }";
        let entities = parse_entities(text).unwrap();
        assert_eq!(entities[0].get("a"), Some(r#"say \"hi\" \n \\"#));
        assert_eq!(entities[0].get("path"), Some(r"c:\maps\"));
        assert_eq!(entities[0].get("b"), Some("1"));
    }

    #[test]
    fn repeated_keys_overwrite_in_place_and_settings_ignore_underscores() {
        let text = b"{ a 1 _light 5 a 2 light 6 Light 7 __color x }";
        let entity = &parse_entities(text).unwrap()[0];
        let expected =
            [("a", "2"), ("_light", "5"), ("light", "6"), ("Light", "7"), ("__color", "x")];
        assert_eq!(pairs(entity), expected);
        assert_eq!(entity.get("_light"), Some("5"));
        assert_eq!(entity.setting("light"), Some("6"));
        assert_eq!(entity.setting("_color"), Some("x"));
        assert_eq!(entity.setting("colour"), None);
    }

    #[test]
    fn errors_name_the_line() {
        for (text, line, what) in [
            (&b"\n\nclassname"[..], 3, "begin with {"),
            (b"{\n\"a\"\n}", 3, "no value"),
            (b"{ a b\n{ }", 2, "missing"),
            (b"\n{ a b\n", 2, "closing"),
            (b"{ a\n \"b\n\n", 2, "quote"),
            (b"{ a", 1, "closing"),
        ] {
            let message = parse_entities(text).unwrap_err().to_string();
            assert!(
                message.contains(&format!("line {line}")) && message.contains(what),
                "{message}"
            );
        }
        assert_eq!(parse_entities(b"").unwrap(), []);
        assert_eq!(parse_entities(b"\0").unwrap(), []);
    }
}
