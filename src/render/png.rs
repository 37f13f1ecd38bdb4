//! Pictures as PNG files.

use crate::{Error, Result};
use image::{ImageFormat, RgbImage};
use std::io::{self, BufWriter};
use std::path::Path;

/// Writes `image` as PNG to `path`: to a temporary file beside it, which is renamed when complete,
/// so that a failure leaves an older picture as it was.
///
/// # Errors
/// [`Error::Io`] if the file cannot be written.
pub fn save_png(image: &RgbImage, path: &Path) -> Result<()> {
    let folder = match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    let mut file = tempfile::NamedTempFile::new_in(folder).map_err(Error::io("write", path))?;
    let mut buffered = BufWriter::new(file.as_file_mut());
    let encoded = image.write_to(&mut buffered, ImageFormat::Png).map_err(io::Error::other);
    encoded.map_err(Error::io("write", path))?;
    buffered.into_inner().map_err(|e| Error::io("write", path)(e.into_error()))?;
    open_to_readers(file.as_file()).map_err(Error::io("write", path))?;
    file.persist(path).map_err(|e| Error::io("write", path)(e.error))?;
    Ok(())
}

/// Temporary files are private; a picture is not.
#[cfg(unix)]
fn open_to_readers(file: &std::fs::File) -> io::Result<()> {
    use std::os::unix::fs::PermissionsExt as _;
    file.set_permissions(std::fs::Permissions::from_mode(0o644))
}

#[cfg(not(unix))]
fn open_to_readers(_: &std::fs::File) -> io::Result<()> {
    Ok(())
}
