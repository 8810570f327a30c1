//! `revolve mesh block`, `plate`, `disc`, `ring` and `tube`: bodies with a rectangular meridian section.

use std::error::Error;
use std::num::NonZeroUsize;
use std::path::PathBuf;

use clap::Args;

use super::CommandStatus;
use super::mesh::{MassArguments, MeshFiles, quality_lines, volume_line};
use super::options::QuietOption;
use crate::deck::Diagnostic;
use crate::generate::{BodyLabels, RectangleMesh, RectangleRequest};

/// Inner and outer radius, and height.
#[derive(Args)]
pub struct BlockArguments {
    /// Inner radius; 0 is a solid body.
    #[arg(long, default_value = "0")]
    inner: f64,
    /// Outer radius.
    #[arg(long)]
    outer: f64,
    /// Height along z.
    #[arg(long)]
    height: f64,
    #[command(flatten)]
    made: RectangleArguments,
}

/// Radius and thickness.
#[derive(Args)]
pub struct DiscArguments {
    /// Radius.
    #[arg(long)]
    radius: f64,
    /// Thickness along z.
    #[arg(long)]
    thickness: f64,
    #[command(flatten)]
    made: RectangleArguments,
}

/// Inner radius, wall and length.
#[derive(Args)]
pub struct TubeArguments {
    /// Inner radius.
    #[arg(long)]
    inner: f64,
    /// Thickness of the wall.
    #[arg(long)]
    wall: f64,
    /// Length along z.
    #[arg(long)]
    length: f64,
    #[command(flatten)]
    made: RectangleArguments,
}

/// Options of the mesh and of the output files.
#[derive(Args)]
struct RectangleArguments {
    /// Size of the smallest elements.
    #[arg(long)]
    size: f64,
    /// Grading in the radial direction: element width at the outer radius divided by element width at the inner radius.
    #[arg(long, default_value = "1", value_name = "FACTOR")]
    across: f64,
    /// Grading along the axis: element height at the upper face divided by element height at the lower face.
    #[arg(long, default_value = "1", value_name = "FACTOR")]
    along: f64,
    /// Height z of the lower face; of a plate, of the upper face.
    #[arg(long, default_value = "0", value_name = "Z", allow_negative_numbers = true)]
    z: f64,
    /// Name of the sets of all nodes and elements, and prefix of the names of faces (default: the shape in upper case).
    #[arg(long)]
    name: Option<String>,
    #[command(flatten)]
    masses: MassArguments,
    /// Material name; the deck must define it.
    #[arg(long, default_value = "STEEL", value_name = "NAME")]
    material: String,
    /// First node and element number.
    #[arg(long, default_value = "1", value_name = "N")]
    first: NonZeroUsize,
    /// Mesh file to write (default: the shape with the suffix .inp).
    #[arg(short, long)]
    out: Option<PathBuf>,
    /// Write a picture of the mesh, .png or .svg.
    #[arg(long, value_name = "FILE")]
    picture: Option<PathBuf>,
    #[command(flatten)]
    quiet: QuietOption,
}

impl BlockArguments {
    /// Writes a block or a ring.
    pub fn execute(self, shape: &str) -> Result<CommandStatus, Box<dyn Error>> {
        if shape == "ring" && self.inner == 0.0 {
            let message = "a ring has an inner radius above 0";
            return Err(Box::new(Diagnostic::error("G001", message).help("add --inner, or use `block` or `disc`")));
        }
        self.made.write(shape, [self.inner, self.outer], [self.made.z, self.height])
    }
}

impl DiscArguments {
    /// Writes a disc, whose lower face is at the given height, or a plate, whose upper face is there.
    pub fn execute(self, shape: &str) -> Result<CommandStatus, Box<dyn Error>> {
        let bottom = if shape == "plate" { self.made.z - self.thickness } else { self.made.z };
        self.made.write(shape, [0.0, self.radius], [bottom, self.thickness])
    }
}

impl TubeArguments {
    /// Writes a tube.
    pub fn execute(self) -> Result<CommandStatus, Box<dyn Error>> {
        self.made.write("tube", [self.inner, self.inner + self.wall], [self.made.z, self.length])
    }
}

impl RectangleArguments {
    /// Writes the mesh file and the picture, and prints quality measures, volume and mass.
    fn write(&self, shape: &str, radii: [f64; 2], [bottom, height]: [f64; 2]) -> Result<CommandStatus, Box<dyn Error>> {
        let RectangleArguments { size, across, along, .. } = *self;
        let mesh = RectangleMesh::new(&RectangleRequest { radii, bottom, height, size, across, along })?;
        let volume = mesh.volume();
        let mut lines = quality_lines(&mesh.quality());
        lines.push(volume_line("volume", &volume, None));
        lines.extend(self.masses.lines(volume.meshed, 0.0)?);
        let graded = if (across, along) == (1.0, 1.0) {
            String::new()
        } else {
            format!(", grading {across} across and {along} along")
        };
        let [inner, outer] = radii;
        let title =
            format!("{shape}, radii {inner} to {outer}, z from {bottom} to {}, size {size}{graded}", bottom + height);
        let name = self.name.clone().unwrap_or_else(|| shape.to_uppercase());
        let labels = BodyLabels { first: self.first.get(), name, material: self.material.clone() };
        let mut comments = vec![title];
        comments.extend(lines.iter().cloned());
        let out = self.out.clone().unwrap_or_else(|| format!("{shape}.inp").into());
        let files = MeshFiles { deck: &out, picture: self.picture.as_deref() };
        files.write(&mesh.deck(&labels, &comments), || mesh.drawing(&comments[0]))?;
        if !self.quiet.quiet {
            files.print(&lines);
        }
        Ok(super::output_status())
    }
}
