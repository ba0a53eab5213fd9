//! Imports of scenes: links of a robot from another file, which the caller reads.

use crate::robot::Link;

/// The request of a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Request {
    /// The URDF file, as the scene writes it: seen from the scene's folder.
    pub file: String,
    /// Whether its root link moves freely.
    pub floating: bool,
    /// Stiffness of stops at the limits of its joints; without it limits are not taken over.
    pub limit_stiffness: Option<f64>,
    /// Whether moments of inertia that no body can have are replaced by the nearest ones.
    pub mend_inertia: bool,
}

/// The content of a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Imported {
    /// Its links, parents before their children.
    pub links: Vec<Link>,
    /// The file itself, to read the scene again.
    pub content: Vec<u8>,
    /// Unsupported content of the file, in words, if there is any.
    pub not_taken: Option<String>,
}

/// One thing that is wrong with a file.
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
    /// The line it is about, with the place marked.
    pub snippet: String,
}

/// Why nothing is imported.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Refusal {
    /// The file cannot be read: why.
    Unreadable(String),
    /// Everything that is wrong with it.
    Wrong(Vec<FileProblem>),
}

/// Reads files for scenes.
pub trait Imports {
    /// The links of a file.
    ///
    /// # Errors
    /// The problems of the file.
    fn read(&mut self, request: &Request) -> Result<Imported, Refusal>;
}

/// Reads nothing.
#[derive(Clone, Copy, Debug)]
pub struct NoImports;

impl Imports for NoImports {
    fn read(&mut self, _: &Request) -> Result<Imported, Refusal> {
        Err(Refusal::Unreadable("nobody here reads other files".to_owned()))
    }
}
