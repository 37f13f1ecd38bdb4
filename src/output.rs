//! Files that are whole or not there: written beside their place under another name, then renamed. What
//! is no plain file, a device or a pipe, is written into; a link stays and its file is replaced.

use crate::{Error, Result};
use image::{ImageFormat, RgbImage};
use std::borrow::Cow;
use std::fs::File;
use std::io::{self, Cursor, Write};
use std::path::{Path, PathBuf};
use tempfile::NamedTempFile;

/// Replaces `path` by `bytes`. An interrupted run leaves the old file as it was.
///
/// # Errors
/// When the folder cannot be written to.
pub fn write(path: &Path, bytes: &[u8]) -> Result<()> {
    write_all(&[(path, bytes)])
}

/// Replaces several files that belong together: none is renamed before all are written.
///
/// # Errors
/// When a folder cannot be written to.
pub fn write_all(files: &[(&Path, &[u8])]) -> Result<()> {
    files.iter().try_for_each(|(path, _)| check_replaceable(path))?;
    let (plain, special): (Vec<_>, Vec<_>) = files.iter().partition(|(path, _)| !is_special(path));
    let written: Vec<_> = plain
        .iter()
        .map(|(path, bytes)| write_beside(&followed(path), bytes))
        .collect::<Result<_>>()?;
    for (path, bytes) in special {
        let mut into = File::options().write(true).open(path).map_err(Error::io("write", path))?;
        into.write_all(bytes).map_err(Error::io("write", path))?;
    }
    for (file, (path, _)) in written.into_iter().zip(plain) {
        file.persist(followed(path)).map_err(|e| Error::io("replace", path)(e.error))?;
    }
    Ok(())
}

/// Whether something is there that a file must not take the place of, such as `/dev/null`.
pub fn is_special(path: &Path) -> bool {
    path.metadata().is_ok_and(|m| !m.is_file() && !m.is_dir())
}

/// The file that a link leads to; any other path as it is.
fn followed(path: &Path) -> Cow<'_, Path> {
    let link = path.is_symlink().then(|| path.canonicalize().ok()).flatten();
    link.map_or(Cow::Borrowed(path), Cow::Owned)
}

/// Whether a file can take this place, as far as that can be told before writing: it cannot replace a
/// folder. For paths that are changed after others have been written.
///
/// # Errors
/// When there is a folder.
pub fn check_replaceable(path: &Path) -> Result<()> {
    if path.is_dir() {
        return Err(Error::io("write", path)(std::io::ErrorKind::IsADirectory.into()));
    }
    Ok(())
}

/// Whether no file is to be written twice, or over one that the run reads.
///
/// # Errors
/// Names the file.
pub fn check_distinct(outputs: &[&Path], inputs: &[&Path]) -> Result<()> {
    let taken: Vec<_> = inputs.iter().map(|p| place(p)).collect();
    for (i, path) in outputs.iter().enumerate() {
        let at = place(path);
        let again = outputs[..i].iter().any(|p| place(p) == at);
        if again || taken.contains(&at) {
            let other = if again { "another output of this run" } else { "an input of this run" };
            let problem = format!("{other} has this name; choose another");
            return Err(Error::format(path.display().to_string(), problem));
        }
    }
    Ok(())
}

/// A name that two paths of one file share.
fn place(path: &Path) -> PathBuf {
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let known = path.canonicalize().ok();
    let in_folder = || Some(folder.canonicalize().ok()?.join(path.file_name()?));
    known.or_else(in_folder).unwrap_or_else(|| path.to_path_buf())
}

/// Whether a file can be written, found out by writing an empty one beside it. For runs that take long
/// before they write.
///
/// # Errors
/// When the folder is not there or cannot be written to, or a folder has the place of the file.
pub fn check_writable(path: &Path) -> Result<()> {
    check_replaceable(path)?;
    if is_special(path) {
        return Ok(());
    }
    write_beside(&followed(path), &[]).map(drop)
}

/// The same for a folder that is made if it is not there.
///
/// # Errors
/// When something else has its place, or no file can be written in it or in the folder that it is to be
/// made in.
pub fn check_folder(path: &Path) -> Result<()> {
    // The nearest part of the path that is there; an empty path stands for the current folder.
    let there = path.ancestors().find(|p| p.exists()).unwrap_or(Path::new("."));
    if !there.is_dir() {
        return Err(Error::io("make folder", path)(io::ErrorKind::NotADirectory.into()));
    }
    write_beside(&there.join("qrad"), &[]).map(drop)
}

fn write_beside(path: &Path, bytes: &[u8]) -> Result<NamedTempFile> {
    let folder = match path.parent() {
        Some(p) if !p.as_os_str().is_empty() => p,
        _ => Path::new("."),
    };
    let mut builder = tempfile::Builder::new();
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        // Temporary files are private; a map is for everyone the umask allows.
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    let failed = || Error::io("write", path);
    if !folder.is_dir() {
        return Err(failed()(io::Error::new(io::ErrorKind::NotFound, "the folder does not exist")));
    }
    let mut file = builder.prefix(".qrad-").tempfile_in(folder).map_err(|e| {
        // Its own message would name a temporary file that nobody knows.
        failed()(e.kind().into())
    })?;
    file.write_all(bytes).map_err(failed())?;
    file.as_file().sync_all().map_err(failed())?;
    Ok(file)
}

/// Writes a picture as PNG.
///
/// # Errors
/// When the folder cannot be written to.
pub fn write_png(path: &Path, picture: &RgbImage) -> Result<()> {
    let mut bytes = Cursor::new(Vec::new());
    picture
        .write_to(&mut bytes, ImageFormat::Png)
        .map_err(|e| Error::format(path.display().to_string(), format!("cannot encode: {e}")))?;
    write(path, bytes.get_ref())
}

/// Removes a file if it is there; a device or a pipe stays.
///
/// # Errors
/// When it is there and cannot be removed.
pub fn remove(path: &Path) -> Result<()> {
    if is_special(path) {
        return Ok(());
    }
    match std::fs::remove_file(path) {
        Err(e) if e.kind() != std::io::ErrorKind::NotFound => Err(Error::io("remove", path)(e)),
        _ => Ok(()),
    }
}
