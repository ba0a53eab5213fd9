//! Files that scenes name, which the caller reads: links of a robot, and arrays.

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

/// The parts of a robot read from a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Imported {
    /// Links, parents before their children.
    pub links: Vec<Link>,
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
    /// The bytes of a file, whose name is relative to the folder of the scene.
    ///
    /// # Errors
    /// Why it cannot be read.
    fn read(&mut self, file: &str) -> Result<Vec<u8>, Refusal>;

    /// The links in a file that has been read.
    ///
    /// # Errors
    /// The problems of the file.
    fn links(&mut self, request: &Request, content: &[u8]) -> Result<Imported, Refusal>;
}

/// An implementation that rejects all files.
#[derive(Clone, Copy, Debug)]
pub struct NoImports;

impl Imports for NoImports {
    fn read(&mut self, _: &str) -> Result<Vec<u8>, Refusal> {
        Err(Refusal::Unreadable("nobody here reads other files".to_owned()))
    }

    fn links(&mut self, _: &Request, _: &[u8]) -> Result<Imported, Refusal> {
        Err(Refusal::Unreadable("nobody here reads links".to_owned()))
    }
}
