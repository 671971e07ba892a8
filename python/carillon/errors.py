"""What goes wrong, with the words of the command line; what is an option there is an argument here."""
import re

_OPTION = re.compile(r"(?<![\w-])--([a-z]+(?:-[a-z]+)*)")


def _arguments(text: str) -> str:
    return _OPTION.sub(lambda option: option[1].replace("-", "_"), text)


class Error(Exception):
    """A failure with a message and, where it helps, a hint how to mend it."""

    def __init__(self, message: str, hint: str = ""):
        super().__init__(message, hint)
        self.message, self.hint = _arguments(message), _arguments(hint)

    def __str__(self) -> str:
        return f"{self.message}\n  hint: {self.hint}" if self.hint else self.message


class InputError(Error, ValueError):
    """A mesh, a sound or a value cannot be used."""


class ConfigError(InputError):
    """A configuration, or what stands for one, is wrong; the message says where."""


class SolverError(Error, RuntimeError):
    """A numerical method did not reach its goal."""


class LimitError(SolverError):
    """More than a limit that was set would be needed; the message names it."""


class ResourceError(SolverError):
    """Time or memory ran out."""


class FileError(Error):
    """A file cannot be read or written, or is not what it should be; the message names it."""


class CarillonWarning(UserWarning):
    """Something that should be known before a result is used."""


#: By what the library calls an error.
_KINDS = {"ConfigError": ConfigError, "InputError": InputError, "SolverError": SolverError, "LimitError": LimitError,
          "TimeError": ResourceError, "MemoryError": ResourceError, "FileError": FileError, "StorageError": FileError}


def error_class(kind: str) -> type[Error]:
    """The class that stands for what the library, and `carillon --json`, call an error."""
    return _KINDS.get(kind, Error)
