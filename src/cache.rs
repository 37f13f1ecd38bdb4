//! Transfers kept from one run to the next: lights change far more often than walls.
//!
//! A file holds the transfers of one geometry, named by a digest of all that they are made from. It is
//! used only if the digest in it and that of its content are right; anything else is made anew.

use crate::output;
use crate::patch::PatchSet;
use crate::radiosity::hemicube::HemicubeSize;
use crate::radiosity::transfers::{Sharing, Transfers};
use crate::scene::Tracer;
use crate::{Error, Result};
use std::path::PathBuf;
use std::time::{SystemTime, UNIX_EPOCH};

/// Ending of the files.
const EXTENSION: &str = "qradcache";
/// First bytes of each, with the version of what follows.
const MAGIC: &[u8; 16] = b"qrad transfers 5";
/// Bytes of a digest.
const DIGEST: usize = blake3::OUT_LEN;
/// The most files that a folder keeps: the oldest go.
const MOST: usize = 16;

/// A folder of files with transfers.
#[derive(Clone, Debug)]
pub struct Cache {
    folder: PathBuf,
}

/// What transfers are made from, as a digest.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Key(blake3::Hash);

impl Cache {
    /// A cache in `folder`, which is made when there is something to keep.
    pub fn new(folder: PathBuf) -> Self {
        Self { folder }
    }

    /// Whether something can be kept.
    ///
    /// # Errors
    /// When the folder can be neither made nor written to.
    pub fn check(&self) -> Result<()> {
        output::check_folder(&self.folder)
    }

    /// The transfers of a key between `patches` patches, if they are here and whole. Says so when they
    /// are here and damaged.
    pub fn load(&self, key: Key, patches: usize) -> Option<Transfers> {
        let path = self.path(key);
        let bytes = std::fs::read(&path).ok()?;
        let found = content(&bytes, key).and_then(|rows| Transfers::from_bytes(rows, patches));
        if found.is_none() {
            log::warn!("{}: damaged; its transfers are made again", path.display());
        }
        found
    }

    /// Keeps transfers. That they cannot be written is no reason to end a run, and is said.
    pub fn keep(&self, key: Key, transfers: &Transfers) {
        let rows = transfers.to_bytes();
        let mut bytes = Vec::with_capacity(MAGIC.len() + 2 * DIGEST + rows.len());
        bytes.extend(MAGIC);
        bytes.extend(key.0.as_bytes());
        bytes.extend(blake3::hash(&rows).as_bytes());
        bytes.extend(rows);
        let made = std::fs::create_dir_all(&self.folder);
        let made = made.map_err(Error::io("make folder", &self.folder));
        if let Err(error) = made.and_then(|()| output::write(&self.path(key), &bytes)) {
            log::warn!("{error}; the transfers are not kept");
        }
        self.remove_oldest();
    }

    fn path(&self, key: Key) -> PathBuf {
        let name = key.0.to_hex();
        self.folder.join(&name.as_str()[..32]).with_extension(EXTENSION)
    }

    fn remove_oldest(&self) {
        let Ok(entries) = std::fs::read_dir(&self.folder) else { return };
        let mut files: Vec<(SystemTime, PathBuf)> = entries
            .filter_map(|entry| Some(entry.ok()?.path()))
            .filter(|path| path.extension().is_some_and(|e| e == EXTENSION))
            .filter_map(|path| Some((path.metadata().ok()?.modified().ok()?, path)))
            .collect();
        files.sort();
        for (_, path) in files.iter().take(files.len().saturating_sub(MOST)) {
            // Another run may have removed it.
            let _ = std::fs::remove_file(path);
        }
    }
}

/// The content of a file of this key, if it is as it was written.
fn content(bytes: &[u8], key: Key) -> Option<&[u8]> {
    let bytes = bytes.strip_prefix(MAGIC)?;
    let bytes = bytes.strip_prefix(key.0.as_bytes())?;
    let (digest, rows) = bytes.split_at_checked(DIGEST)?;
    (blake3::hash(rows).as_bytes()[..] == *digest).then_some(rows)
}

impl Key {
    /// Of transfers between `patches` in the geometry of `tracer`, with hemicubes of this size and rows
    /// shared as [`Transfers::shared`] says.
    pub fn new(
        tracer: &Tracer,
        patches: &PatchSet,
        Sharing { groups, share, small }: Sharing<'_>,
        size: HemicubeSize,
    ) -> Self {
        let mut digest = Digest::default();
        digest.program();
        digest.words([size.width(), size.height(), share.to_bits()]);
        for polygon in tracer.polygons() {
            digest.word(polygon.vertices.len() as u32);
            let corners = polygon.vertices.iter().chain([&polygon.normal]);
            corners.for_each(|v| digest.words(v.to_array().map(f32::to_bits)));
        }
        digest.word(patches.patches.len() as u32);
        for patch in &patches.patches {
            let points = [patch.eye, patch.normal];
            points.iter().for_each(|v| digest.words(v.to_array().map(f32::to_bits)));
        }
        groups.of.iter().for_each(|&group| digest.word(group));
        small.iter().for_each(|&small| digest.word(small.into()));
        patches.lookup.words(&mut |word| digest.word(word));
        Self(digest.finish())
    }
}

#[derive(Default)]
struct Digest {
    hasher: blake3::Hasher,
    /// Single words are slow to digest.
    waiting: Vec<u8>,
}

impl Digest {
    fn word(&mut self, word: u32) {
        self.waiting.extend(word.to_le_bytes());
        if self.waiting.len() >= 1 << 16 {
            self.hasher.update(&self.waiting);
            self.waiting.clear();
        }
    }

    fn finish(mut self) -> blake3::Hash {
        self.hasher.update(&self.waiting).finalize()
    }

    fn words<const N: usize>(&mut self, words: [u32; N]) {
        words.into_iter().for_each(|word| self.word(word));
    }

    /// Another build of the program may make other transfers.
    fn program(&mut self) {
        self.waiting.extend(env!("CARGO_PKG_VERSION").as_bytes());
        let file = std::env::current_exe().and_then(|path| path.metadata());
        let Ok(file) = file else { return };
        let changed = file.modified().ok().and_then(|t| t.duration_since(UNIX_EPOCH).ok());
        self.waiting.extend(file.len().to_le_bytes());
        self.waiting.extend(changed.map_or(0, |t| t.as_nanos()).to_le_bytes());
    }
}
