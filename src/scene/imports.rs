//! Imports of scenes: links of a robot from another file, which the caller reads.

use crate::robot::described::Link;

/// An import requested by a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Request {
    /// Path of the URDF file as written in the scene, relative to the scene's folder.
    pub file: String,
    /// Whether its root link has a free joint.
    pub floating: bool,
    /// Stiffness of stops at the joint limits; `None` ignores limits.
    pub limit_stiffness: Option<f64>,
    /// Whether impossible moments of inertia are replaced by the nearest possible ones.
    pub mend_inertia: bool,
}

/// Content of a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Imported {
    /// Links, parents before their children.
    pub links: Vec<Link>,
    /// Bytes of the file, to read the scene again.
    pub content: Vec<u8>,
    /// Description of unsupported content, if any.
    pub not_taken: Option<String>,
}

/// A problem of a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FileProblem {
    /// Its name in messages.
    pub file: String,
    /// Line in the file, from 1.
    pub line: usize,
    /// Column in characters, from 1.
    pub column: usize,
    /// Subject of the problem, such as an element; may be empty.
    pub key: String,
    /// What was found.
    pub wrong: String,
    /// What was expected; may be empty.
    pub right: String,
    /// The source line, with a mark at the position.
    pub snippet: String,
}

/// Reason why nothing was imported.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Refusal {
    /// The file cannot be read, with the reason.
    Unreadable(String),
    /// All problems of the file.
    Wrong(Vec<FileProblem>),
}

/// Reads files for scenes.
pub trait Imports {
    /// Reads the links of a file.
    ///
    /// # Errors
    /// The problems of the file.
    fn read(&mut self, request: &Request) -> Result<Imported, Refusal>;
}

/// An implementation that rejects all imports.
#[derive(Clone, Copy, Debug)]
pub struct NoImports;

impl Imports for NoImports {
    fn read(&mut self, _: &Request) -> Result<Imported, Refusal> {
        Err(Refusal::Unreadable("nobody here reads other files".to_owned()))
    }
}
