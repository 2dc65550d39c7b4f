//! Frames as they come, into one animation or a sequence of pictures.

use std::{
    io::Write,
    path::{Path, PathBuf},
};

use image::{
    Delay, Frame, RgbaImage,
    codecs::gif::{GifEncoder, Repeat},
};
use prism_engine::error::{Error, Result};

use super::{console, files, picture::Picture, png};

/// What the output is, in messages.
const OBJECT: &str = "animation";

/// Frames a second, as both formats can say it: a GIF counts hundredths of a second.
const FRAMES_PER_SECOND: u16 = 25;
/// From one frame to the next, seconds.
pub const STEP: f64 = 1.0 / FRAMES_PER_SECOND as f64;

/// Of what kind the output is, by its name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// `NAME-000.png` and so on for `NAME.png`.
    Sequence,
    /// One file of at most 256 colours a frame.
    Gif,
    /// One file of all colours.
    Apng,
}

impl Kind {
    /// The kind of the file that `flag` names.
    ///
    /// # Errors
    /// `Usage` where the name says none.
    pub fn of(flag: &str, path: &Path) -> Result<Kind> {
        match path.extension().map(|extension| extension.to_string_lossy().to_lowercase()).as_deref() {
            Some("png") => Ok(Kind::Sequence),
            Some("gif") => Ok(Kind::Gif),
            Some("apng") => Ok(Kind::Apng),
            _ => Err(Error::Usage(format!(
                "{flag} {}: frames are written as .gif, .apng or, a picture each, .png; name it so",
                path.display()
            ))),
        }
    }
}

/// Collects frames of one size.
pub struct Animation {
    path: PathBuf,
    kind: Kind,
    frames: Vec<Picture>,
    written: usize,
}

impl Animation {
    /// Into `path`.
    pub fn new(path: &Path, kind: Kind) -> Animation {
        Animation { path: path.to_owned(), kind, frames: Vec::new(), written: 0 }
    }

    /// The next frame.
    pub fn add(&mut self, picture: Picture) -> Result<()> {
        if self.kind == Kind::Sequence {
            png::write(&numbered(&self.path, self.written), &picture)?;
            self.written += 1;
        } else {
            self.frames.push(picture);
        }
        Ok(())
    }

    /// Writes what is left to write, and tells what there is.
    pub fn finish(self) -> Result<()> {
        let Animation { path, kind, frames, written } = self;
        match kind {
            Kind::Sequence => {
                if let Some(last) = written.checked_sub(1) {
                    let [first, last] = [0, last].map(|n| numbered(&path, n));
                    console::notice(format_args!("wrote {} to {}", first.display(), last.display()));
                }
                return Ok(());
            }
            Kind::Gif => files::replace(&path, OBJECT, |file| gif(file, frames))?,
            Kind::Apng => files::replace(&path, OBJECT, |file| apng(file, &frames))?,
        }
        console::notice(format_args!("wrote {}", path.display()));
        Ok(())
    }
}

/// `NAME-007.png` for `NAME.png`.
pub fn numbered(path: &Path, number: usize) -> PathBuf {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    path.with_file_name(format!("{stem}-{number:03}.png"))
}

fn gif(file: &mut impl Write, frames: Vec<Picture>) -> files::WriteResult {
    // Of ten speeds: the best colours take several times as long for a difference that no eye finds in motion.
    let mut encoder = GifEncoder::new_with_speed(file, 10);
    encoder.set_repeat(Repeat::Infinite)?;
    for Picture { size, pixels } in frames {
        let image = RgbaImage::from_raw(size[0], size[1], pixels.into_iter().flat_map(opaque).collect());
        let delay = Delay::from_numer_denom_ms(1000, FRAMES_PER_SECOND.into());
        encoder.encode_frame(Frame::from_parts(image.ok_or("fewer pixels than its size")?, 0, 0, delay))?;
    }
    Ok(())
}

/// A frame's alpha means nothing to a viewer.
fn opaque([r, g, b, _]: [u8; 4]) -> [u8; 4] {
    [r, g, b, 255]
}

fn apng(file: &mut impl Write, frames: &[Picture]) -> files::WriteResult {
    let [width, height] = frames.first().ok_or("no frame")?.size;
    let mut encoder = ::png::Encoder::new(file, width, height);
    encoder.set_color(::png::ColorType::Rgb);
    encoder.set_animated(u32::try_from(frames.len())?, 0)?;
    encoder.set_frame_delay(1, FRAMES_PER_SECOND)?;
    let mut writer = encoder.write_header()?;
    for frame in frames {
        let rgb: Vec<u8> = frame.pixels.iter().flat_map(|p| [p[0], p[1], p[2]]).collect();
        writer.write_image_data(&rgb)?;
    }
    writer.finish()?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::{AnimationDecoder, codecs::gif::GifDecoder, codecs::png::PngDecoder};
    use std::{fs::File, io::BufReader};

    fn write(name: &str) -> (tempfile::TempDir, PathBuf) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(name);
        let mut animation = Animation::new(&path, Kind::of("--out", &path).unwrap());
        for level in [0, 120, 240] {
            animation.add(Picture::filled([4, 3], [level, 0, 255 - level])).unwrap();
        }
        animation.finish().unwrap();
        (folder, path)
    }

    #[test]
    fn each_kind_reads_back() {
        let (_folder, path) = write("turn.gif");
        let frames = GifDecoder::new(BufReader::new(File::open(&path).unwrap())).unwrap().into_frames();
        let frames = frames.collect_frames().unwrap();
        assert_eq!(frames.len(), 3);
        assert_eq!(frames[1].buffer().get_pixel(2, 1).0, [120, 0, 135, 255]);
        assert_eq!(frames[0].delay().numer_denom_ms(), (40, 1));

        let (_folder, path) = write("turn.apng");
        let decoder = PngDecoder::new(BufReader::new(File::open(&path).unwrap())).unwrap();
        let frames = decoder.apng().unwrap().into_frames().collect_frames().unwrap();
        assert_eq!(frames.len(), 3);
        assert_eq!(frames[2].buffer().get_pixel(3, 2).0, [240, 0, 15, 255]);

        let (folder, path) = write("turn.png");
        assert!(!path.exists());
        let names: Vec<bool> = (0..4).map(|n| folder.path().join(format!("turn-00{n}.png")).exists()).collect();
        assert_eq!(names, [true, true, true, false]);
    }

    #[test]
    fn another_name_says_what_there_is() {
        let told = Kind::of("--out", Path::new("turn.mp4")).unwrap_err().to_string();
        assert!(told.contains("turn.mp4") && told.contains(".gif"), "{told}");
    }
}
