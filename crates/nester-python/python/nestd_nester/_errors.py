"""The exceptions of the package, and its warning."""


class NestingError(Exception):
    """The base class of the exceptions of this package."""


class InputError(NestingError, ValueError):
    """The input makes no sense or cannot be read. The message says what to do."""


class ProofError(NestingError):
    """A layout or a written file is not valid. The message names the faults."""


class PartWarning(UserWarning):
    """Something that a person should know about a part, for example that its surface is not closed."""


for _class in (NestingError, InputError, ProofError, PartWarning):
    _class.__module__ = "nestd_nester"
del _class
