//! Errors that name the file, the object and the mend. Imports nothing of the engine.

use std::path::PathBuf;

/// What a caller can meet. Each kind has its exit code on the command line ([`Error::exit_code`]).
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A scene, image or other input file that cannot be used.
    #[error("{}: {object}: {problem}; {mend}", file.display())]
    Input {
        /// The file at fault.
        file: PathBuf,
        /// The object in it: "material 2 'wall'", "accessor 7", "image 'bricks.png'".
        object: String,
        /// What is wrong with it.
        problem: String,
        /// What the user can do.
        mend: String,
    },
    /// This machine lacks what was asked for.
    #[error("{what}; {mend}")]
    Unsupported {
        /// What is missing, by name, and on which device.
        what: String,
        /// What the user can do.
        mend: String,
    },
    /// A combination of settings that cannot be honoured.
    #[error("{0}")]
    Usage(String),
    /// A Vulkan call failed, with the object or pass it was for.
    #[error("{doing}: {cause}")]
    Gpu {
        /// What was being done, with the resource's or pass's name.
        doing: String,
        /// The driver's answer.
        cause: String,
    },
    /// A shader that does not compile: the compiler's own text, with file and line.
    #[error("{shader}: {log}")]
    Shader {
        /// Path below `shaders/`, with the defines it was compiled with.
        shader: String,
        /// The compiler's messages.
        log: String,
    },
    /// The validation layer spoke.
    #[error("validation: {count} message(s), the first: {first}")]
    Validation {
        /// How many.
        count: usize,
        /// The first one.
        first: String,
    },
}

/// The engine's result.
pub type Result<T> = std::result::Result<T, Error>;

impl Error {
    /// An [`Error::Input`]; see there for the parts.
    pub fn input(
        file: impl Into<PathBuf>,
        object: impl Into<String>,
        problem: impl Into<String>,
        mend: impl Into<String>,
    ) -> Self {
        Error::Input { file: file.into(), object: object.into(), problem: problem.into(), mend: mend.into() }
    }

    /// An [`Error::Unsupported`]; see there for the parts.
    pub fn unsupported(what: impl Into<String>, mend: impl Into<String>) -> Self {
        Error::Unsupported { what: what.into(), mend: mend.into() }
    }

    /// An [`Error::Gpu`] from a driver's answer.
    pub fn gpu(doing: impl Into<String>, cause: impl std::fmt::Display) -> Self {
        Error::Gpu { doing: doing.into(), cause: cause.to_string() }
    }

    /// The command line's exit code: 1 failed, 2 wrong usage, 77 this machine lacks what was asked.
    pub fn exit_code(&self) -> u8 {
        match self {
            Error::Usage(_) => 2,
            Error::Unsupported { .. } => 77,
            _ => 1,
        }
    }
}
