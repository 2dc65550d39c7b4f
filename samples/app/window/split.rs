//! Two settings side by side: the second one's frame lies over the first one's, right of a line.

use prism_engine::{
    error::Result,
    gpu::{Access, CommandEncoder, Context, Image, vk},
    settings::{Settings, View},
};

use crate::app::{drawing::Drawing, load::Loaded, offscreen::Offscreen, sample::Moment, surface::SurfaceArgs};

/// The second settings, drawn.
pub struct Split<'a> {
    drawing: Drawing<'a>,
    surface: SurfaceArgs,
    /// Where the line is, as a share of the width.
    at: f64,
    picture: Option<Offscreen>,
}

impl<'a> Split<'a> {
    /// Beside `first`, with its settings and materials, and the line in the middle.
    pub fn new(first: &Drawing<'a>, surface: SurfaceArgs) -> Result<Split<'a>> {
        Ok(Split { drawing: first.beside()?, surface, at: 0.5, picture: None })
    }

    /// What draws it.
    pub fn drawing(&mut self) -> &mut Drawing<'a> {
        &mut self.drawing
    }

    /// Its settings.
    pub fn settings(&self) -> &Settings {
        self.drawing.renderer().settings()
    }

    /// What its displaced materials and lights have in place of their own values.
    pub fn surface(&self) -> &SurfaceArgs {
        &self.surface
    }

    /// Draws scenes in which they have these. All frames so far have run.
    pub fn replace(&mut self, scenes: Vec<Loaded>, surface: SurfaceArgs) -> Result<()> {
        self.drawing.replace(scenes)?;
        self.surface = surface;
        Ok(())
    }

    /// Draws it otherwise; the error has one place only, the first picture's.
    pub fn set_settings(&mut self, settings: &Settings) -> Result<()> {
        let view = if settings.view == View::Error { View::Shaded } else { settings.view };
        self.drawing.set_settings(&Settings { view, ..settings.clone() })
    }

    /// The line's column in a picture of `width`.
    pub fn column(&self, width: u32) -> u32 {
        (self.at * f64::from(width)).round() as u32
    }

    /// Moves the line to a column.
    pub fn move_to(&mut self, column: f64, width: u32) {
        self.at = (column / f64::from(width.max(1))).clamp(0.0, 1.0);
    }

    /// GPU time of its last measured frame, milliseconds.
    pub fn gpu_ms(&self) -> Option<f64> {
        self.drawing.latest().and_then(|frame| frame.gpu_ms())
    }

    /// Draws the whole frame, so that both have the same to do, and lays its right part over `target` (at
    /// [`Access::COLOR_WRITE`] before and after).
    pub fn record(
        &mut self,
        ctx: &Context,
        cmd: &mut CommandEncoder,
        slot: usize,
        measured: (u64, f64),
        moment: &Moment,
        target: &Image,
    ) -> Result<()> {
        let extent = target.extent();
        if self.picture.as_ref().is_none_or(|picture| picture.image().extent() != extent) {
            self.picture = Some(Offscreen::new(ctx, extent, target.format())?);
        }
        let column = self.column(extent[0]);
        let Some(picture) = &self.picture else { return Ok(()) };
        picture.prepare(cmd);
        self.drawing.record(cmd, slot, Some(measured), moment, picture.image())?;
        if !target.usage().contains(vk::ImageUsageFlags::TRANSFER_DST) {
            return Ok(());
        }
        cmd.image_barrier(picture.image(), Access::COLOR_WRITE, Access::TRANSFER_SRC);
        cmd.image_barrier(target, Access::COLOR_WRITE, Access::TRANSFER_DST);
        cmd.copy_right(picture.image(), target, column);
        cmd.image_barrier(target, Access::TRANSFER_DST, Access::COLOR_WRITE);
        Ok(())
    }
}
