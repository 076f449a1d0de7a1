//! All tests of the whole compiler, in one program: the compiler is linked
//! once. `cargo test --workspace --test all MODULE::` runs those of a module.
//!
//! Tests run side by side in threads of one process: none changes the
//! environment or the working directory, and files come from folders of their
//! own or from the tree, which is only read.

// What tests share.
mod compiled;
mod mutation;
mod reference;
mod rtl_support;
mod support;

mod accuracy;
mod against_gcc;
mod agreement;
mod book;
mod bounds;
mod budget;
mod check;
mod cli;
mod clock;
mod codegen_c;
mod codegen_layouts;
mod commands;
mod composite;
mod determinism;
mod docs;
mod drop_in;
mod exact_outputs;
mod faults;
mod fit;
mod fpcore;
mod front;
mod generate_cli;
mod labels;
mod library;
mod limits;
mod mistaken;
mod models;
mod neglect;
mod operations;
mod optimise;
mod packages;
mod pages;
mod passes;
mod project;
mod provenance;
mod published;
mod quartus;
mod reader;
mod reduce;
mod robots;
mod rooms;
mod rtl;
mod rtl_fits;
mod rtl_host;
mod rules;
mod scenes;
mod shares;
mod sim;
mod simulate;
mod stress;
mod study;
mod superwords;
mod suspension;
mod targets;
mod text;
mod told;
mod trigonometry;
mod vendors;
mod view;
mod whole_step;
mod words;
mod write;
