//! The program as a whole: commands and their files, external faults, restart, reports, studies, reproducibility.

#[path = "../common/mod.rs"]
mod common;

mod browser;
mod command_line;
mod composed;
mod diagram;
mod evaluate;
mod extending;
mod faults;
mod fragments;
mod fuzz;
mod growth;
mod hostile;
mod identify;
mod instruction_counts;
mod language;
mod list_cost;
mod manual;
mod material;
mod matrix;
mod memory;
mod mesh;
mod new_meshes;
mod packaging;
mod parts;
mod provenance;
mod python;
mod report;
mod reproducibility;
mod restart;
mod same_bits;
mod searches;
mod sensitivity;
mod slurm;
mod soak;
mod staged_shots;
mod study;
mod study_cases;
mod study_effects;
mod supply;
mod tidy;
mod tutorial;
mod view;
mod vtk;
mod watching;
