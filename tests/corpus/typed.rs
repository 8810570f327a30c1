//! Decks typed by hand: mixed case, blanks, tabs, continuation lines, missing last commas, CRLF, numbers such as
//! `1.d0`, parameters, included files, generated meshes, and user subroutines in Fortran.

use std::f64::consts::PI;
use std::fmt::Write;

use crate::common::fortran;
use crate::grid::{Grid, Side};
use crate::run::{Deck, assert_near};

/// Returns nodes and CAX4R elements in an uneven style: tabs, blanks and no third coordinate.
fn mesh(grid: &Grid) -> String {
    let mut text = "*node, nset=nall\n".to_owned();
    for (i, [r, z]) in grid.points().into_iter().enumerate() {
        let _ = writeln!(text, "{},\t{r} ,{z}", i + 1);
    }
    text += "*ELEMENT , type = cax4r , ELSET=eall\n";
    for (i, [a, b, c, d]) in grid.quads().into_iter().enumerate() {
        let _ = writeln!(text, "{} ,{a},{b},{c},{d}", i + 1);
    }
    for (name, side) in [("base", Side::Bottom), ("top", Side::Top), ("axis", Side::Inner)] {
        let nodes = grid.side_nodes(side);
        let step = nodes[1] - nodes[0];
        let _ = writeln!(text, "*nset,nset={name},generate\n{},{},{step}", nodes[0], nodes[nodes.len() - 1]);
    }
    for (name, side) in [("ebase", Side::Bottom), ("etop", Side::Top)] {
        let elements = grid.side_elements(side);
        let _ = writeln!(text, "*elset,elset={name},generate\n{},{}", elements[0], elements[elements.len() - 1]);
    }
    text
}

/// A block hangs on a spring and a dashpot by `*MPC`; the deck has `*PARAMETER`, an included mesh and CRLF.
///
/// Estimate: the first largest displacement of a damped oscillator is `v/ω exp(-ζ/s atan(s/ζ))` with `s = sqrt(1 - ζ²)`
/// (Thomson, Theory of Vibration with Applications, chapter 2). Tolerance 1 %.
#[test]
fn block_on_spring_and_dashpot_swings_as_a_damped_oscillator() {
    let grid = Grid::uniform([0.0, 0.0], [10.0, 10.0], 2, 2);
    let text = "*HEADING\nblock on a spring, units mm t s\n** typed from the old deck\n*PARAMETER\nk = 100.\nmass = 7.85e-9*3.14159265*1000.\n\
                c = 2.*0.05*(k*mass)**0.5   # five percent\nperiod = 2.*3.14159265*(mass/k)**0.5\ntend = 0.6*period\n\
                *INCLUDE,\n INPUT=block.msh\n*NSET,NSET=REF\n1\n*NSET,NSET=OTHERS\n2,3\n\
                *SOLID SECTION,ELSET=EALL,MATERIAL=STEEL\n*MATERIAL,NAME=STEEL\n*DENSITY\n7.85d-9\n*ELASTIC\n2.1D5,.3d0\n\
                *MPC\nBEAM, OTHERS, REF\n\
                *ELEMENT,TYPE=SPRING1,ELSET=SPR\n2001,1\n*SPRING,ELSET=SPR\n2\n<k>\n\
                *ELEMENT,TYPE=DASHPOT1,ELSET=DSH\n2002,1\n*DASHPOT,ELSET=DSH\n2\n<c>\n\
                *INITIAL CONDITIONS,TYPE=VELOCITY\nNALL,2,1.d3\n*STEP\n*DYNAMIC,EXPLICIT\n,<tend>\n*BOUNDARY\nAXIS,1\n\
                *OUTPUT,HISTORY,TIME INTERVAL=1.E-5\n*NODE OUTPUT,NSET=REF\nU2,V2\n*ENERGY OUTPUT\nALLKE,ALLIE,ALLWK,ETOTAL\n*END STEP\n";
    let run = Deck::new(&text.replace('\n', "\r\n")).with_file("block.msh", &mesh(&grid)).completes(&[]);
    let (ratio, mass) = (0.05_f64, 7.85e-9 * PI * 1000.0);
    let root = (1.0 - ratio * ratio).sqrt();
    let largest = 1000.0 / (100.0 / mass).sqrt() * (-ratio / root * (root / ratio).atan()).exp();
    assert_near("largest displacement", run.largest(run.columns_with("U2@")[0]), largest, 0.01);
}

/// A rigid mass of the older form `*RIGID SURFACE` strikes an elastic rod; the deck is in capitals with continuation
/// lines.
///
/// Estimate: until `2L/c` the force is `ρ c A v exp(-ρ c A t / M)` (Saint-Venant; Goldsmith, Impact, chapter 3).
/// Compared by the velocity of the mass, `v exp(-ρ c A t / M)`, at `1.8 L/c`. Tolerance 2 %.
#[test]
fn rigid_mass_on_a_rod_slows_down_exponentially() {
    let grid = Grid::uniform([0.0, 0.0], [5.0, 100.0], 1, 80);
    let wave = (200_000.0_f64 / 7.85e-9).sqrt();
    let time = 1.8 * 100.0 / wave;
    let (mass, speed) = (5e-5, 5000.0);
    let text = format!(
        "*HEADING\nRAM ON A ROD\n{}*NODE, NSET=RAM\n900, 0., 100.\n*ELEMENT, TYPE=MASS, ELSET=M\n900, 900\n*MASS, ELSET=M\n{mass}\n\
         *RIGID SURFACE, TYPE=SEGMENTS, NAME=HAMMER,\nREF NODE=900\nSTART, 12., 100.\nLINE, 0., 100.\n\
         *SOLID SECTION, ELSET=EALL,\n  MATERIAL=BAR\n*MATERIAL, NAME=BAR\n*ELASTIC\n200.E3\n*DENSITY\n7850.E-12\n\
         *SURFACE, NAME=HEAD\nETOP, S3\n*SURFACE INTERACTION, NAME=I1\n\
         *INITIAL CONDITIONS, TYPE=VELOCITY\nRAM, 2, -{speed}\n*BOUNDARY\nBASE, YSYMM\nAXIS, XSYMM\nRAM, 1\nRAM, 6\n\
         *STEP\n*DYNAMIC, EXPLICIT\n,{time}\n*CONTACT PAIR, INTERACTION=I1\nHAMMER, HEAD\n\
         *OUTPUT, HISTORY, TIME INTERVAL={}\n*NODE OUTPUT, NSET=RAM\nU2,\nV2\n*ENERGY OUTPUT\nALLKE,ALLIE,ALLWK,ETOTAL\n*END STEP\n",
        mesh(&grid),
        time / 200.0
    );
    let run = Deck::new(&text).completes(&[]);
    let decay = 7.85e-9 * wave * PI * 25.0 / mass;
    assert_near("velocity of the mass", -run.last(run.columns_with("V2@")[0]), speed * (-decay * time).exp(), 0.02);
}

/// A thin ring of `*NGEN`, `*NFILL` and `*ELGEN` expands freely; adiabatic heating.
///
/// Estimate: the kinetic energy is dissipated by the hoop strain, `ε = ρ v² / 2Y`. The radius grows to `R exp(ε)`, the
/// temperature by `0.9 v² / 2c` (Walling and Forrestal, AIAA J. 11 (1973) 1196). Tolerance 2 %; elastic vibration is
/// small.
#[test]
fn expanding_ring_stops_when_its_kinetic_energy_is_dissipated() {
    let (speed, time) = (1.2e5_f64, 3e-4);
    let text = format!(
        "*Heading\n ring\n*Node\n1, 50., 0.\n5, 52., 0.\n101, 50., 2.\n105, 52., 2.\n*Ngen, nset=lower\n1, 5\n*Ngen, nset=upper\n101, 105, 1\n\
         *Nfill, nset=ring\nlower, upper, 4, 25\n*Element, type=CAX4R\n1, 1, 2, 27, 26\n*Elgen, elset=RING\n1, 4, 1, 1, 4, 25, 10\n\
         *Solid Section, elset=ring, material=copper, controls=c\n*Section Controls, name=c, hourglass=stiffness\n*Material, name=COPPER\n*Density\n8.9e-9\n*Elastic\n\
         120e3, 0.34\n*Plastic\n 250.\n*Inelastic Heat Fraction\n .9\n*Specific Heat\n 3.85e8\n*Initial Conditions, type=Temperature\nring, 300\n\
         *Initial Conditions, type=velocity\nring, 1, {speed}\n*Step, inc=100000\n*Dynamic, explicit, adiabatic\n, {time}\n*Output, history, time interval=2e-7\n\
         *Node output, nset=lower, statistics=mean\nU1, V1\n*Element output, elset=ring, statistics=mean\nTEMP, PEEQ\n\
         *Energy output\nALLKE, ALLIE, ALLWK, ETOTAL\n*End step\n"
    );
    let run = Deck::new(&text).completes(&[]);
    let work = 8.9e-9 * speed * speed / 2.0;
    assert_near("mean radius", 51.0 + run.largest("U1_MEAN@LOWER"), 51.0 * (work / 250.0).exp(), 0.02);
    assert_near("temperature rise", run.last("TEMP_MEAN@RING") - 300.0, 0.9 * work / (8.9e-9 * 3.85e8), 0.02);
}

/// A rod whose end is moved at constant velocity, with an elastic VUMAT in fixed form.
///
/// Estimate: the stress after the wave front is `ρ c v` (Graff, Wave Motion in Elastic Solids, chapter 2). Tolerance 1
/// %.
#[test]
fn elastic_vumat_gives_the_stress_of_the_wave() {
    if !fortran("an elastic VUMAT") {
        return;
    }
    let subroutine = "      subroutine vumat(
     1 nblock, ndir, nshr, nstatev, nfieldv, nprops, lanneal,
     2 stepTime, totalTime, dt, cmname, coordMp, charLength,
     3 props, density, strainInc, relSpinInc,
     4 tempOld, stretchOld, defgradOld, fieldOld,
     5 stressOld, stateOld, enerInternOld, enerInelasOld,
     6 tempNew, stretchNew, defgradNew, fieldNew,
     7 stressNew, stateNew, enerInternNew, enerInelasNew )
      include 'vaba_param.inc'
      dimension props(nprops), strainInc(nblock,ndir+nshr),
     1 stressOld(nblock,ndir+nshr), stressNew(nblock,ndir+nshr),
     2 density(nblock), enerInternOld(nblock), enerInternNew(nblock)
      character*80 cmname
C     Lame constants from E and nu
      twomu = props(1)/(1.d0+props(2))
      alame = twomu*props(2)/(1.d0-2.d0*props(2))
      do 100 k = 1, nblock
        tr = strainInc(k,1) + strainInc(k,2) + strainInc(k,3)
        w = 0.d0
        do 50 i = 1, ndir+nshr
          stressNew(k,i) = stressOld(k,i) + twomu*strainInc(k,i)
          if (i.le.ndir) stressNew(k,i) = stressNew(k,i) + alame*tr
          f = 1.d0
          if (i.gt.ndir) f = 2.d0
          w = w + f*0.5d0*(stressOld(k,i)+stressNew(k,i))*strainInc(k,i)
   50   continue
        enerInternNew(k) = enerInternOld(k) + w/density(k)
  100 continue
      return
      end
";
    let grid = Grid::uniform([0.0, 0.0], [5.0, 100.0], 1, 100);
    let time = 1.6e-5;
    let text = format!(
        "*heading\nrod\n{}*elset, elset=gauge\n30\n*solid section, elset=eall, material=mine\n*material, name=mine\n*user material, constants=2\n\
         200000., 0.\n*density\n7.85e-9,\n*step\n*dynamic, explicit\n, {time}\n*boundary, type=velocity\nbase, 2, 2, 1.e4\n*boundary\naxis, 1\n\
         *output, history, time interval=1e-7\n*element output, elset=gauge\ns22\n*energy output\nallke, allie, allwk, etotal\n*end step\n",
        mesh(&grid)
    );
    let run = Deck::new(&text).with_subroutine("elastic.for", subroutine).completes(&[]);
    let stress = (200_000.0_f64 * 7.85e-9).sqrt() * 1e4;
    assert_near("stress", -run.mean(run.columns_with("S22@")[0], 1e-5, time), stress, 0.01);
}

/// A bar with linear hardening by VUHARD is pulled by one node that the others follow through `*EQUATION`.
///
/// Estimate: `F = A0 (Y + H ε_p) exp(-ε)` with `ε = ln(l/l0)` and `ε_p = ε - σ/E`, as volume is nearly conserved.
/// Tolerance 1 %.
#[test]
fn linear_hardening_by_vuhard_gives_the_force_of_the_tension_test() {
    if !fortran("a VUHARD with linear hardening") {
        return;
    }
    let subroutine = "      SUBROUTINE VUHARD(NBLOCK,JELEM,KINTPT,KLAYER,KSECPT,LANNEAL,
     + STEPTIME,TOTALTIME,DT,CMNAME,NSTATEV,NFIELDV,NPROPS,PROPS,
     + TEMPOLD,TEMPNEW,FIELDOLD,FIELDNEW,STATEOLD,EQPS,EQPSRATE,
     + YIELD,DYIELDDTEMP,DYIELDDEQPS,STATENEW)
      INCLUDE 'VABA_PARAM.INC'
      DIMENSION PROPS(NPROPS),EQPS(NBLOCK),EQPSRATE(NBLOCK),
     + YIELD(NBLOCK),DYIELDDTEMP(NBLOCK),DYIELDDEQPS(NBLOCK,2)
      CHARACTER*80 CMNAME
      DO KM=1,NBLOCK
        YIELD(KM)=PROPS(1)+PROPS(2)*EQPS(KM)
        DYIELDDEQPS(KM,1)=PROPS(2)
        DYIELDDEQPS(KM,2)=0.D0
        DYIELDDTEMP(KM)=0.D0
      END DO
      RETURN
      END
";
    let grid = Grid::uniform([0.0, 0.0], [5.0, 20.0], 2, 8);
    let time = 4e-4;
    let text = format!(
        "*HEADING\nTENSION\n{}*NSET, NSET=PULL\n{}\n*NSET, NSET=OTHERS, GENERATE\n{}, {}, 1\n*EQUATION\n2\nOTHERS, 2, 1., PULL, 2, -1.\n\
         *SOLID SECTION, ELSET=EALL, MATERIAL=M\n*MATERIAL, NAME=M\n*DENSITY\n7.85E-9\n*ELASTIC\n2.E5, .3\n\
         *PLASTIC, HARDENING=USER, PROPERTIES=2\n300., 1500.\n*AMPLITUDE, NAME=A, DEFINITION=SMOOTH STEP\n0., 0., {time}, 1.\n\
         *STEP\n*DYNAMIC, EXPLICIT\n, {time}\n*BOUNDARY\nBASE, 2\nAXIS, 1\n*BOUNDARY, AMPLITUDE=A\nPULL, 2, 2, 2.\n\
         *OUTPUT, HISTORY, NUMBER INTERVAL=200\n*NODE OUTPUT, NSET=PULL\nRF2, U2\n*ENERGY OUTPUT\nALLKE, ALLIE, ALLWK, ETOTAL\n*END STEP\n",
        mesh(&grid),
        grid.node(0, 8),
        grid.node(1, 8),
        grid.node(2, 8)
    );
    let run = Deck::new(&text).with_subroutine("vuhard.f", subroutine).completes(&[]);
    let (pull, force) = (run.columns_with("U2@")[0], run.columns_with("RF2@")[0]);
    let strain = (1.0 + run.at(pull, 0.6 * time) / 20.0).ln();
    let stress = (300.0 + 1500.0 * strain) / (1.0 + 1500.0 / 200_000.0);
    let result = run.mean(force, 0.58 * time, 0.62 * time);
    assert_near("force", result, PI * 25.0 * stress * (-strain).exp(), 0.01);
}

/// A free disc under a pressure `p (1 - r²/R²)` of VDLOAD.
///
/// Estimate: the total force is `p π R² / 2`, so that the momentum after `t` is `p π R² t / 2`. Tolerance 0.5 %.
#[test]
fn parabolic_pressure_by_vdload_gives_its_momentum() {
    if !fortran("a VDLOAD with a parabolic pressure") {
        return;
    }
    let subroutine = "! pressure that falls to zero at the rim
subroutine vdload(nblock, ndim, stepTime, totalTime, amplitude, curCoords, velocity, dirCos, jltyp, sname, value)
  include 'vaba_param.inc'
  dimension curCoords(nblock,ndim), velocity(nblock,ndim), dirCos(nblock,ndim,ndim), value(nblock)
  character*80 sname
  do k = 1, nblock
    value(k) = 20.d0*amplitude*(1.d0 - (curCoords(k,1)/40.d0)**2)
  end do
end subroutine vdload
";
    let grid = Grid::uniform([0.0, 0.0], [40.0, 20.0], 16, 6);
    let time = 1e-4;
    let text = format!(
        "*Heading\nfree disc\n{}*surface, name=loaded\nebase, s1\n*solid section, elset=eall, material=al\n1.\n*material, name=al\n*density\n2.7e-9\n\
         *elastic\n70e3, 0.33\n*step, name=push\n*dynamic, explicit\n, {time}\n*boundary\naxis, 1\n*dsload\nloaded, PNU\n\
         *output, field, number interval=2\n*node output\nu, v\n*output, history, time interval={}\n*node output, nset=nall, statistics=mean\nv2\n\
         *energy output\nallke, allie, allwk, etotal\n*end step\n",
        mesh(&grid),
        time / 100.0
    );
    let run = Deck::new(&text).with_subroutine("vdload.f90", subroutine).completes(&[]);
    // The work of the load is nearly that of a rigid disc: m v² / 2.
    let (mass, momentum) = (2.7e-9 * PI * 1600.0 * 20.0, 20.0 * PI * 1600.0 / 2.0 * time);
    assert_near("kinetic energy", run.last("ALLKE"), momentum * momentum / (2.0 * mass), 0.02);
}

/// Slips of a typist: each has one located message with the correction, and no other follows.
#[test]
fn slips_of_a_typist_have_located_corrections() {
    let grid = Grid::uniform([0.0, 0.0], [5.0, 10.0], 1, 2);
    let head = mesh(&grid);
    let tail = "*step\n*dynamic, explicit\n, 1e-6\n*boundary\nbase, 2\n*end step\n";
    let good = "*solid section, elset=eall, material=s\n*material, name=s\n*density\n7.8e-9\n*elastic\n2.1e5, .3\n";
    for (wrong, right, code, advice) in [
        ("2.1e5 .3", "2.1e5, .3", "D301", "did you mean 2.1e5, .3?"),
        ("*elastc", "*elastic", "D101", "did you mean *ELASTIC?"),
        ("elset=eal,", "elset=eall,", "M110", "EALL"),
        ("7.8e-O9", "7.8e-9", "D302", "letter O"),
        ("*dynamic, xplicit", "*dynamic, explicit", "D103", "did you mean EXPLICIT?"),
        ("*material, nme=s", "*material, name=s", "D103", "did you mean NAME?"),
        ("material=st", "material=s", "M111", "did you mean S?"),
    ] {
        let text = format!("*heading\n{head}{good}{tail}").replacen(right, wrong, 1);
        let finished = Deck::new(&text).run();
        println!("slip {wrong}: {:?}", finished.codes("error"));
        assert_eq!((finished.status, finished.codes("error")), (2, vec![code]), "{wrong}");
        assert!(finished.printed.contains(advice) && finished.printed.contains("deck.inp:"), "{wrong}");
    }
}
