//! `revolve mesh`: a quadrilateral mesh of a projectile as a file for `*INCLUDE`.

use std::error::Error;
use std::fs;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

use clap::{Args, Subcommand};

use super::words::say;
use super::{PictureFormat, Status};
use crate::deck::{Diagnostic, files};
use crate::generate::{Cavity, DeckLabels, Fill, Mesh as Meshed, MeshMeasure, MeshRequest, Nose, PartVolume, Point};
use crate::output::{self, csv};

/// Mesh a projectile with quadrilaterals (CAX4R) and write it as a file to include.
#[derive(Args)]
pub struct Mesh {
    #[command(subcommand)]
    shape: Shape,
}

#[derive(Subcommand)]
enum Shape {
    /// An ogive nose on a shank.
    Ogive {
        /// Calibre-radius-head: radius of the ogive over the diameter of the shank.
        #[arg(long)]
        crh: f64,
        #[command(flatten)]
        shank: ShankArguments,
        #[command(flatten)]
        made: MeshArguments,
    },
    /// A hemisphere on a shank.
    Sphere {
        #[command(flatten)]
        shank: ShankArguments,
        #[command(flatten)]
        made: MeshArguments,
    },
    /// A cone on a shank.
    Cone {
        /// Angle between axis and flank in degrees.
        #[arg(long, value_name = "DEGREES")]
        half_angle: f64,
        #[command(flatten)]
        shank: ShankArguments,
        #[command(flatten)]
        made: MeshArguments,
    },
    /// A cylinder with a level front.
    Blunt {
        #[command(flatten)]
        shank: ShankArguments,
        #[command(flatten)]
        made: MeshArguments,
    },
    /// Any profile: points `r, z` from the tip to the base, one a line.
    Polyline {
        /// The file of points; lines that begin with # are left out.
        points: PathBuf,
        #[command(flatten)]
        made: MeshArguments,
    },
}

/// Measures of a shank.
#[derive(Args)]
struct ShankArguments {
    /// Radius of the shank, in the deck's unit of length.
    #[arg(long)]
    radius: f64,
    /// Length of the whole projectile, nose included.
    #[arg(long)]
    length: f64,
}

/// What is made of a profile.
#[derive(Args)]
struct MeshArguments {
    /// Length of the sides of elements at the nose.
    #[arg(long)]
    size: f64,
    /// How many times longer elements are at the base than at the shoulder.
    #[arg(long, default_value = "1", value_name = "FACTOR")]
    along: f64,
    /// How many times wider elements are at the axis than at the surface.
    #[arg(long, default_value = "1", value_name = "FACTOR")]
    across: f64,
    /// Thickness of the wall of a hollow case.
    #[arg(long, requires = "cavity_front")]
    wall: Option<f64>,
    /// Elements through the wall (default: by their size, two at least).
    #[arg(long, requires = "wall", value_name = "N")]
    through: Option<NonZeroUsize>,
    /// Where the cavity begins, from the tip.
    #[arg(long, requires = "wall", value_name = "LENGTH")]
    cavity_front: Option<f64>,
    /// Thickness of the base behind the cavity; 0 leaves it open.
    #[arg(long, requires = "wall", default_value = "0", value_name = "LENGTH")]
    cavity_base: f64,
    /// What the cavity holds.
    #[arg(long, requires = "wall", default_value = "none")]
    fill: Fill,
    /// The file to write.
    #[arg(short, long, default_value = "projectile.inp")]
    out: PathBuf,
    /// A picture of the mesh, .png or .svg.
    #[arg(long, value_name = "FILE")]
    picture: Option<PathBuf>,
    /// Density of the projectile or its case: the mass is printed.
    #[arg(long, conflicts_with = "target_mass")]
    density: Option<f64>,
    /// The mass that the projectile shall have: the density of the mesh that gives it is printed.
    #[arg(long, value_name = "MASS")]
    target_mass: Option<f64>,
    /// Density of the fill.
    #[arg(long, requires = "wall")]
    fill_density: Option<f64>,
    /// Name of the material of the projectile or its case, which the deck defines.
    #[arg(long, default_value = "STEEL", value_name = "NAME")]
    material: String,
    /// Name of the material of the fill.
    #[arg(long, default_value = "FILL", value_name = "NAME")]
    fill_material: String,
    /// The first number of nodes and of elements.
    #[arg(long, default_value = "1", value_name = "N")]
    first: NonZeroUsize,
    /// What the names of sets and surfaces begin with.
    #[arg(long, default_value = "", value_name = "TEXT")]
    prefix: String,
}

impl Mesh {
    pub fn execute(self) -> Result<Status, Box<dyn Error>> {
        let (nose, shank, made) = match self.shape {
            Shape::Ogive { crh, shank, made } => (Nose::Ogive { crh }, Some(shank), made),
            Shape::Sphere { shank, made } => (Nose::Sphere, Some(shank), made),
            Shape::Cone { half_angle, shank, made } => (Nose::Cone { half_angle }, Some(shank), made),
            Shape::Blunt { shank, made } => (Nose::Blunt, Some(shank), made),
            Shape::Polyline { points, made } => (Nose::Polyline(read_points(&points)?), None, made),
        };
        made.write(&made.wanted(nose, shank))?;
        Ok(super::shown())
    }
}

impl MeshArguments {
    fn wanted(&self, nose: Nose, shank: Option<ShankArguments>) -> MeshRequest {
        let (radius, length) = shank.map_or((0.0, 0.0), |s| (s.radius, s.length));
        let cavity = self.wall.zip(self.cavity_front).map(|(wall, front)| Cavity {
            wall,
            through: self.through.map(NonZeroUsize::get),
            front,
            base: self.cavity_base,
            fill: self.fill,
        });
        MeshRequest { nose, radius, length, size: self.size, along: self.along, across: self.across, cavity }
    }

    /// Writes deck and picture and prints what the mesh amounts to.
    fn write(&self, wanted: &MeshRequest) -> Result<(), Box<dyn Error>> {
        let mesh = Meshed::new(wanted)?;
        let lines = self.lines(&mesh.measure(), mesh.order())?;
        let labels = DeckLabels {
            first: self.first.get(),
            prefix: self.prefix.clone(),
            material: self.material.clone(),
            fill: self.fill_material.clone(),
        };
        let mut comments = vec![asked(wanted)];
        comments.extend(lines.iter().cloned());
        let format = self.picture.as_deref().map(PictureFormat::of).transpose()?;
        let picture = format.map(|format| format.bytes(&mesh.drawing(&comments[0]))).transpose()?;
        write(&self.out, mesh.deck(&labels, &comments).as_bytes())?;
        lines.iter().for_each(|line| say!("{line}"));
        if let (Some(path), Some(bytes)) = (&self.picture, picture) {
            write(path, &bytes)?;
            say!("wrote {} and {}", self.out.display(), path.display());
        } else {
            say!("wrote {}", self.out.display());
        }
        Ok(())
    }

    /// What is printed, and stands at the head of the deck.
    fn lines(&self, measure: &MeshMeasure, order: Option<f64>) -> Result<Vec<String>, Diagnostic> {
        let place = |[r, z]: Point| format!("at r = {r:.4e}, z = {z:.4e}");
        let [nodes, elements] = measure.counts;
        let mut lines = vec![
            format!("{elements} elements, {nodes} nodes"),
            format!("least scaled Jacobian {:.3} {}", measure.jacobian.0, place(measure.jacobian.1)),
            format!("largest aspect ratio {:.2} {}", measure.aspect.0, place(measure.aspect.1)),
            format!("least height of an element {:.4e} {}", measure.height.0, place(measure.height.1)),
            volume_line("volume", &measure.case, order),
        ];
        if measure.fill.exact > 0.0 {
            lines.push(volume_line("volume of the fill", &measure.fill, None));
        }
        let fill = self.fill_density.unwrap_or(0.0) * measure.fill.meshed;
        if let Some(density) = self.density {
            let mass = density * measure.case.meshed;
            let with = if fill > 0.0 { format!(", {:.6e} with the fill", mass + fill) } else { String::new() };
            lines.push(format!("mass {mass:.6e} at a density of {density}{with}"));
        }
        if let Some(mass) = self.target_mass {
            if mass <= fill {
                let message = format!("the fill alone weighs {fill:.4e}, all shall weigh {mass:.4e}");
                return Err(Diagnostic::error("G007", message).help("a lighter fill or a larger mass"));
            }
            lines.push(format!("density {:.8e} gives a mass of {mass}", (mass - fill) / measure.case.meshed));
        }
        Ok(lines)
    }
}

fn volume_line(what: &str, part: &PartVolume, order: Option<f64>) -> String {
    let error = match part.error() {
        0.0 => "exact".to_owned(),
        error => format!("{:+.3} % from that of the profile", 100.0 * error),
    };
    let order = order.map_or(String::new(), |order| format!(", order {order:.2} as sides are halved"));
    format!("{what} {:.8e}, {error}{order}", part.meshed)
}

/// What was asked for, as a title.
fn asked(wanted: &MeshRequest) -> String {
    let MeshRequest { radius, length, size, along, across, .. } = wanted;
    let shape = match &wanted.nose {
        Nose::Ogive { crh } => format!("ogive, CRH {crh}, radius {radius}, length {length}"),
        Nose::Sphere => format!("spherical nose, radius {radius}, length {length}"),
        Nose::Cone { half_angle } => format!("cone of {half_angle} degrees, radius {radius}, length {length}"),
        Nose::Blunt => format!("cylinder, radius {radius}, length {length}"),
        Nose::Polyline(points) => format!("profile of {} points", points.len()),
    };
    let hollow = wanted.cavity.map_or(String::new(), |c| {
        let fill = match c.fill {
            Fill::None => "",
            Fill::Bonded => ", bonded fill",
            Fill::Apart => ", fill apart",
        };
        format!(", wall {}, cavity from {}, base {}{fill}", c.wall, c.front, c.base)
    });
    let graded = match (*along, *across) {
        (1.0, 1.0) => String::new(),
        _ => format!(", growing by {along} along and {across} across"),
    };
    format!("{shape}, size {size}{hollow}{graded}")
}

fn write(path: &Path, bytes: &[u8]) -> Result<(), String> {
    if let Some(folder) = path.parent() {
        fs::create_dir_all(folder).map_err(|e| format!("cannot create {}: {e}", folder.display()))?;
    }
    output::write_whole(path, bytes).map_err(|e| e.to_string())
}

fn read_points(path: &Path) -> Result<Vec<Point>, Box<Diagnostic>> {
    let refuse = |message: String| {
        let help = "one point a line, `r, z`, from the tip to the base";
        Box::new(Diagnostic::error("G004", format!("{}: {message}", path.display())).help(help))
    };
    let text = files::read_text(path).map_err(|e| refuse(e.to_string()))?;
    let point = |(n, line): (usize, &str)| {
        let numbers = line.split([',', ' ', '\t', ';']).filter(|word| !word.is_empty()).map(str::parse::<f64>);
        match numbers.collect::<Result<Vec<_>, _>>() {
            Ok(numbers) if numbers.len() == 2 => Ok([numbers[0], numbers[1]]),
            _ => Err(refuse(format!("line {n}, `{}`, is no point", line.trim()))),
        }
    };
    csv::lines(&text).map(point).collect()
}
