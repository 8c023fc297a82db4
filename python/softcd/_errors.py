"""The exceptions of softcd. The module's C++ finds the classes here."""


class Error(RuntimeError):
    """The text names the problem, its cause and the remedy. A call that raises leaves everything as it was."""


class InvalidInput(Error, ValueError):
    """An argument cannot be used: an index out of range, a wrong shape, an option out of its range."""


class BackendError(Error):
    """Backend.cuda was requested but cannot be used: it was not built, no device exists, or the device failed."""


class OutOfMemory(Error, MemoryError):
    """A mesh, its positions or a detection needs more memory than there is."""


class MeshError(Error, ValueError):
    """A file cannot be read as a mesh."""


for _class in (Error, InvalidInput, BackendError, OutOfMemory, MeshError):
    _class.__module__ = "softcd"
