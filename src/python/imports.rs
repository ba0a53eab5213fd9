//! Files that scenes name: read beside them, or given. Links are read by `lissom.urdf`.

use std::collections::BTreeMap;
use std::path::PathBuf;

use pyo3::exceptions::{PyOSError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};

use super::part::parts_of;
use super::signal::Functions;
use crate::scene::{FileProblem, Imported, Imports, Refusal, Request};

/// Reads files relative to a folder, or returns contents read earlier.
pub(super) struct Files {
    folder: PathBuf,
    /// Whether files outside the folder are read.
    anywhere: bool,
    /// Contents by name in place of files, if they are given.
    given: Option<BTreeMap<String, Vec<u8>>>,
    /// An unexpected exception, to be raised when the scene has been read.
    raised: Option<PyErr>,
}

impl Files {
    /// Files in the folder of a file.
    pub(super) fn beside(file: &str, anywhere: bool) -> Self {
        let folder = PathBuf::from(file).parent().map(PathBuf::from).unwrap_or_default();
        Self { folder, anywhere, given: None, raised: None }
    }

    /// Contents in place of files.
    pub(super) fn given(contents: BTreeMap<String, Vec<u8>>) -> Self {
        Self { folder: PathBuf::new(), anywhere: false, given: Some(contents), raised: None }
    }

    /// Raises the unexpected exception, if any.
    pub(super) fn or_raised<T>(self, read: T) -> PyResult<T> {
        self.raised.map_or(Ok(read), Err)
    }

    fn content(&self, py: Python<'_>, file: &str) -> PyResult<Vec<u8>> {
        if let Some(given) = &self.given {
            return given.get(file).cloned().ok_or_else(|| {
                PyValueError::new_err(format!(
                    "{file:?} is none of the files in `imports`: {:?}",
                    given.keys()
                ))
            });
        }
        let options = PyDict::new(py);
        options.set_item("anywhere", self.anywhere)?;
        let read = py.import("lissom.common.disk")?.getattr("read_beside")?;
        read.call((&self.folder, file), Some(&options))?.extract()
    }

    fn robot(&self, py: Python<'_>, request: &Request, content: &[u8]) -> PyResult<Imported> {
        let Request { file, floating, limit_stiffness, mend_inertia } = request;
        let name = self.folder.join(file).display().to_string();
        let options = PyDict::new(py);
        options.set_item("floating", floating)?;
        options.set_item("limit_stiffness", limit_stiffness)?;
        options.set_item("mend_inertia", mend_inertia)?;
        let read = py.import("lissom.urdf")?.getattr("imported_from")?;
        let imported = read.call((name, PyBytes::new(py, content)), Some(&options))?;
        // Files have no functions.
        let links = parts_of(&imported.getattr("links")?, "links", &mut Functions::default())?;
        let is_complete = imported.getattr("not_taken")?.is_empty()?;
        let not_taken = if is_complete { None } else { Some(imported.str()?.to_string()) };
        Ok(Imported { links, not_taken })
    }

    /// Reason why a file was rejected; exceptions that do not concern the file are stored.
    fn refusal(&mut self, py: Python<'_>, error: PyErr) -> Refusal {
        if error.is_instance_of::<PyOSError>(py) {
            return Refusal::Unreadable(format!("cannot be read: {}", error.value(py)));
        }
        match problems_of(py, &error) {
            Ok(problems) if !problems.is_empty() => Refusal::Wrong(problems),
            _ if error.is_instance_of::<PyValueError>(py) => Refusal::Unreadable(error.value(py).to_string()),
            _ => {
                self.raised = Some(error);
                Refusal::Unreadable("it could not be read".to_owned())
            }
        }
    }
}

impl Imports for Files {
    fn read(&mut self, file: &str) -> Result<Vec<u8>, Refusal> {
        Python::attach(|py| self.content(py, file).map_err(|error| self.refusal(py, error)))
    }

    fn links(&mut self, request: &Request, content: &[u8]) -> Result<Imported, Refusal> {
        Python::attach(|py| self.robot(py, request, content).map_err(|error| self.refusal(py, error)))
    }
}

/// Problems listed by a `lissom.urdf.UrdfError`.
fn problems_of(py: Python<'_>, error: &PyErr) -> PyResult<Vec<FileProblem>> {
    let mut problems = Vec::new();
    for problem in error.value(py).getattr("problems")?.try_iter()? {
        let problem = problem?;
        let text = |name: &str| problem.getattr(name)?.extract::<String>();
        problems.push(FileProblem {
            file: text("file")?,
            line: problem.getattr("line")?.extract()?,
            column: problem.getattr("column")?.extract()?,
            key: text("key")?,
            wrong: text("wrong")?,
            right: text("right")?,
            snippet: text("snippet")?,
        });
    }
    Ok(problems)
}
