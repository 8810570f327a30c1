//! `revolve mesh`: generates a quadrilateral mesh of a projectile or a body with a rectangular section as a file for
//! `*INCLUDE`, or refines the mesh of a deck.

use std::error::Error;
use std::fs;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

use clap::{Args, Subcommand};

use super::mesh_rectangle::{BlockArguments, DiscArguments, TubeArguments};
use super::mesh_refine::RefineArguments;
use super::options::QuietOption;
use super::words::print_out;
use super::{CommandStatus, PictureFormat};
use crate::deck::{Diagnostic, files};
use crate::generate::{
    CaseCavity, CavityFill, DeckLabels, MeridianPoint, MeshMeasure, MeshRequest, NoseShape, PartVolume,
    ProjectileMesh as Meshed, QuadQuality,
};
use crate::output::drawing::Drawing;
use crate::output::{self, csv};

/// Generate a CAX4R mesh of a projectile, block, plate, disc, ring or tube as a file for *INCLUDE, or refine the mesh of a
/// deck.
#[derive(Args)]
pub struct MeshCommand {
    #[command(subcommand)]
    shape: MeshShape,
}

#[derive(Subcommand)]
enum MeshShape {
    /// Ogive nose and cylindrical shank.
    Ogive {
        /// Caliber radius head (CRH): ogive radius divided by shank diameter.
        #[arg(long)]
        crh: f64,
        #[command(flatten)]
        shank: ShankArguments,
        #[command(flatten)]
        made: MeshArguments,
    },
    /// Hemispherical nose and cylindrical shank.
    Sphere {
        #[command(flatten)]
        shank: ShankArguments,
        #[command(flatten)]
        made: MeshArguments,
    },
    /// Conical nose and cylindrical shank.
    Cone {
        /// Half of the cone angle, in degrees.
        #[arg(long, value_name = "DEGREES")]
        half_angle: f64,
        #[command(flatten)]
        shank: ShankArguments,
        #[command(flatten)]
        made: MeshArguments,
    },
    /// Cylinder with a flat front.
    Blunt {
        #[command(flatten)]
        shank: ShankArguments,
        #[command(flatten)]
        made: MeshArguments,
    },
    /// Arbitrary profile from a file of points `r, z`.
    Polyline {
        /// Point file: one point `r, z` per line, from the tip to the base; lines that begin with # are comments.
        points: PathBuf,
        #[command(flatten)]
        made: MeshArguments,
    },
    /// Body between two radii and two heights.
    Block(BlockArguments),
    /// Circular plate, whose upper face is at the height --z: a target.
    Plate(DiscArguments),
    /// Solid disc, whose lower face is at the height --z.
    Disc(DiscArguments),
    /// Ring between two radii.
    Ring(BlockArguments),
    /// Tube with an inner radius and a wall.
    Tube(TubeArguments),
    /// Write a deck with its mesh refined or coarsened, and listed node by node.
    Refine(RefineArguments),
}

/// Dimensions of the shank.
#[derive(Args)]
struct ShankArguments {
    /// Shank radius, in the length unit of the deck.
    #[arg(long)]
    radius: f64,
    /// Total length of the projectile, including the nose.
    #[arg(long)]
    length: f64,
}

/// Options of the mesh and of the output files.
#[derive(Args)]
struct MeshArguments {
    /// Element size at the nose.
    #[arg(long)]
    size: f64,
    /// Grading along the axis: element length at the base divided by element length at the shoulder.
    #[arg(long, default_value = "1", value_name = "FACTOR")]
    along: f64,
    /// Grading in the radial direction: element width at the axis divided by element width at the surface.
    #[arg(long, default_value = "1", value_name = "FACTOR")]
    across: f64,
    /// Wall thickness of a hollow case.
    #[arg(long, requires = "cavity_front")]
    wall: Option<f64>,
    /// Number of elements through the wall (default: from --size, at least two).
    #[arg(long, requires = "wall", value_name = "N")]
    through: Option<NonZeroUsize>,
    /// Distance from the tip to the front of the cavity.
    #[arg(long, requires = "wall", value_name = "LENGTH")]
    cavity_front: Option<f64>,
    /// Thickness of the base plate; 0 leaves the cavity open at the base.
    #[arg(long, requires = "wall", default_value = "0", value_name = "LENGTH")]
    cavity_base: f64,
    /// Contents of the cavity: empty, a fill that shares nodes with the case, or a separate fill for contact.
    #[arg(long, requires = "wall", default_value = "none")]
    fill: CavityFill,
    /// Mesh file to write.
    #[arg(short, long, default_value = "projectile.inp")]
    out: PathBuf,
    /// Write a picture of the mesh, .png or .svg.
    #[arg(long, value_name = "FILE")]
    picture: Option<PathBuf>,
    #[command(flatten)]
    masses: MassArguments,
    /// Density of the fill; its mass is printed.
    #[arg(long, requires = "wall")]
    fill_density: Option<f64>,
    /// Material name of the projectile or its case; the deck must define it.
    #[arg(long, default_value = "STEEL", value_name = "NAME")]
    material: String,
    /// Material name of the fill; the deck must define it.
    #[arg(long, default_value = "FILL", value_name = "NAME")]
    fill_material: String,
    /// First node and element number.
    #[arg(long, default_value = "1", value_name = "N")]
    first: NonZeroUsize,
    /// Prefix of set and surface names.
    #[arg(long, default_value = "", value_name = "TEXT")]
    prefix: String,
    #[command(flatten)]
    quiet: QuietOption,
}

impl MeshCommand {
    pub fn execute(self) -> Result<CommandStatus, Box<dyn Error>> {
        let (nose, shank, made) = match self.shape {
            MeshShape::Refine(refine) => return refine.execute(),
            MeshShape::Block(block) => return block.execute("block"),
            MeshShape::Plate(plate) => return plate.execute("plate"),
            MeshShape::Disc(disc) => return disc.execute("disc"),
            MeshShape::Ring(ring) => return ring.execute("ring"),
            MeshShape::Tube(tube) => return tube.execute(),
            MeshShape::Ogive { crh, shank, made } => (NoseShape::Ogive { crh }, Some(shank), made),
            MeshShape::Sphere { shank, made } => (NoseShape::Sphere, Some(shank), made),
            MeshShape::Cone { half_angle, shank, made } => (NoseShape::Cone { half_angle }, Some(shank), made),
            MeshShape::Blunt { shank, made } => (NoseShape::Blunt, Some(shank), made),
            MeshShape::Polyline { points, made } => (NoseShape::Polyline(read_points(&points)?), None, made),
        };
        made.write(&made.mesh_request(nose, shank))?;
        Ok(super::output_status())
    }
}

impl MeshArguments {
    fn mesh_request(&self, nose: NoseShape, shank: Option<ShankArguments>) -> MeshRequest {
        let (radius, length) = shank.map_or((0.0, 0.0), |s| (s.radius, s.length));
        let cavity = self.wall.zip(self.cavity_front).map(|(wall, front)| CaseCavity {
            wall,
            through: self.through.map(NonZeroUsize::get),
            front,
            base: self.cavity_base,
            fill: self.fill,
        });
        MeshRequest { nose, radius, length, size: self.size, along: self.along, across: self.across, cavity }
    }

    /// Writes the mesh file and the picture, and prints quality measures, volume and mass.
    fn write(&self, wanted: &MeshRequest) -> Result<(), Box<dyn Error>> {
        let mesh = Meshed::new(wanted)?;
        let lines = self.lines(&mesh.measure(), mesh.order())?;
        let labels = DeckLabels {
            first: self.first.get(),
            prefix: self.prefix.clone(),
            material: self.material.clone(),
            fill: self.fill_material.clone(),
        };
        let mut comments = vec![request_title(wanted)];
        comments.extend(lines.iter().cloned());
        let files = MeshFiles { deck: &self.out, picture: self.picture.as_deref() };
        files.write(&mesh.deck(&labels, &comments), || mesh.drawing(&comments[0]))?;
        if !self.quiet.quiet {
            files.print(&lines);
        }
        Ok(())
    }

    /// Returns the lines that are printed and written as comments at the top of the mesh file.
    fn lines(&self, measure: &MeshMeasure, order: Option<f64>) -> Result<Vec<String>, Diagnostic> {
        let mut lines = quality_lines(&measure.quality);
        lines.push(volume_line("volume", &measure.case, order));
        if measure.fill.exact > 0.0 {
            lines.push(volume_line("volume of the fill", &measure.fill, None));
        }
        let fill = self.fill_density.unwrap_or(0.0) * measure.fill.meshed;
        lines.extend(self.masses.lines(measure.case.meshed, fill)?);
        Ok(lines)
    }
}

/// Density or mass of a body.
#[derive(Args)]
pub struct MassArguments {
    /// Density of the body, of a hollow projectile that of its case; the mass is printed.
    #[arg(long, conflicts_with = "target_mass")]
    density: Option<f64>,
    /// Required total mass; the density that gives this mass on the mesh is printed.
    #[arg(long, value_name = "MASS")]
    target_mass: Option<f64>,
}

impl MassArguments {
    /// Returns the lines on the mass of a body with a volume, and with a fill of a mass.
    pub fn lines(&self, volume: f64, fill: f64) -> Result<Vec<String>, Diagnostic> {
        let mut lines = Vec::new();
        if let Some(density) = self.density {
            let mass = density * volume;
            let with = if fill > 0.0 { format!(", {:.6e} with the fill", mass + fill) } else { String::new() };
            lines.push(format!("mass {mass:.6e} at a density of {density}{with}"));
        }
        if let Some(mass) = self.target_mass {
            if mass <= fill {
                let message =
                    format!("the mass of the fill is {fill:.4e}, not below the required total mass {mass:.4e}");
                return Err(
                    Diagnostic::error("G007", message).help("decrease --fill-density or increase --target-mass")
                );
            }
            lines.push(format!("density {:.8e} gives a mass of {mass}", (mass - fill) / volume));
        }
        Ok(lines)
    }
}

/// Returns the lines on the quality of the elements.
pub fn quality_lines(quality: &QuadQuality) -> Vec<String> {
    let location = |[r, z]: MeridianPoint| format!("at r = {r:.4e}, z = {z:.4e}");
    let [nodes, elements] = quality.counts;
    vec![
        format!("{elements} elements, {nodes} nodes"),
        format!("smallest scaled Jacobian {:.3} {}", quality.jacobian.0, location(quality.jacobian.1)),
        format!("largest aspect ratio {:.2} {}", quality.aspect.0, location(quality.aspect.1)),
        format!("smallest element height {:.4e} {}", quality.height.0, location(quality.height.1)),
    ]
}

pub fn volume_line(what: &str, part: &PartVolume, order: Option<f64>) -> String {
    let error = match part.error() {
        0.0 => "exact".to_owned(),
        error => format!("{:+.3} % relative to the exact profile", 100.0 * error),
    };
    let order = order.map_or(String::new(), |order| format!(", convergence order {order:.2}"));
    format!("{what} {:.8e}, {error}{order}", part.meshed)
}

/// Returns a title for the picture: nose shape, dimensions and element size.
fn request_title(wanted: &MeshRequest) -> String {
    let MeshRequest { radius, length, size, along, across, .. } = wanted;
    let shape = match &wanted.nose {
        NoseShape::Ogive { crh } => format!("ogive, CRH {crh}, radius {radius}, length {length}"),
        NoseShape::Sphere => format!("spherical nose, radius {radius}, length {length}"),
        NoseShape::Cone { half_angle } => format!("cone of {half_angle} degrees, radius {radius}, length {length}"),
        NoseShape::Blunt => format!("cylinder, radius {radius}, length {length}"),
        NoseShape::Polyline(points) => format!("profile of {} points", points.len()),
    };
    let hollow = wanted.cavity.map_or(String::new(), |c| {
        let fill = match c.fill {
            CavityFill::None => "",
            CavityFill::Bonded => ", bonded fill",
            CavityFill::Apart => ", fill apart",
        };
        format!(", wall {}, cavity from {}, base {}{fill}", c.wall, c.front, c.base)
    });
    let graded = match (*along, *across) {
        (1.0, 1.0) => String::new(),
        _ => format!(", grading {along} along and {across} across"),
    };
    format!("{shape}, size {size}{hollow}{graded}")
}

/// Files of a generated mesh.
pub struct MeshFiles<'a> {
    /// File for `*INCLUDE`.
    pub deck: &'a Path,
    /// Picture of the mesh.
    pub picture: Option<&'a Path>,
}

impl MeshFiles<'_> {
    /// Writes the text of the deck, and the drawing if a picture is wanted.
    ///
    /// # Errors
    /// If the format of the picture is unknown, or a file cannot be written.
    pub fn write(&self, deck: &str, drawing: impl FnOnce() -> Drawing) -> Result<(), Box<dyn Error>> {
        let format = self.picture.map(PictureFormat::of).transpose()?;
        let picture = format.map(|format| format.bytes(&drawing())).transpose()?;
        write(self.deck, deck.as_bytes())?;
        if let (Some(path), Some(bytes)) = (self.picture, picture) {
            write(path, &bytes)?;
        }
        Ok(())
    }

    /// Prints lines on the mesh and the names of the files.
    pub fn print(&self, lines: &[String]) {
        lines.iter().for_each(|line| print_out!("{line}"));
        let picture = self.picture.map_or(String::new(), |path| format!(" and {}", path.display()));
        print_out!("wrote {}{picture}", self.deck.display());
    }
}

pub fn write(path: &Path, bytes: &[u8]) -> Result<(), String> {
    if let Some(folder) = path.parent() {
        fs::create_dir_all(folder).map_err(|e| format!("cannot create {}: {e}", folder.display()))?;
    }
    output::write_whole(path, bytes).map_err(|e| e.to_string())
}

fn read_points(path: &Path) -> Result<Vec<MeridianPoint>, Box<Diagnostic>> {
    let refuse = |message: String| {
        let help = "one point per line, `r, z`, from the tip to the base";
        Box::new(Diagnostic::error("G004", format!("{}: {message}", path.display())).help(help))
    };
    let text = files::read_text(path).map_err(|e| refuse(e.to_string()))?;
    let point = |(n, line): (usize, &str)| {
        let numbers = line.split([',', ' ', '\t', ';']).filter(|word| !word.is_empty()).map(str::parse::<f64>);
        match numbers.collect::<Result<Vec<_>, _>>() {
            Ok(numbers) if numbers.len() == 2 => Ok([numbers[0], numbers[1]]),
            _ => Err(refuse(format!("line {n}: `{}` is not a point", line.trim()))),
        }
    };
    csv::lines(&text).map(point).collect()
}
