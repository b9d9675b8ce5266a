"""The files of an FMU in memory, and changes to them."""

import struct
import zipfile

DESCRIPTION = "modelDescription.xml"


class Files:
    """The entries of an archive by name, in their order."""

    def __init__(self, entries):
        self.entries = dict(entries)

    @classmethod
    def read(cls, path):
        with zipfile.ZipFile(path) as file:
            return cls({name: file.read(name) for name in file.namelist() if not name.endswith("/")})

    def copy(self):
        return Files(self.entries)

    def replace(self, old, new, name=DESCRIPTION):
        """Replaces one existing text."""
        old, new = (text.encode() if isinstance(text, str) else text for text in (old, new))
        content = self.entries[name]
        assert old in content, f"{name} has no {old!r}"
        self.entries[name] = content.replace(old, new, 1)
        return self

    def write(self, path, extra=()):
        """Writes the archive; `extra` are further entries, which may repeat a name."""
        # One archive for each fault: its size does not matter.
        with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as file:
            for name, content in [*self.entries.items(), *extra]:
                file.writestr(name, content)
        return path


def library(files):
    """The name of the first shared library."""
    return next(name for name in files.entries if name.startswith("binaries/") and name.endswith((".so", ".dll", ".dylib")))


def lie_about_size(path):
    """Declares one byte more than the first entry has, in both of its headers."""
    content = bytearray(path.read_bytes())
    for mark, offset in ((b"PK\x03\x04", 22), (b"PK\x01\x02", 24)):
        at = content.index(mark) + offset
        (size,) = struct.unpack_from("<I", content, at)
        struct.pack_into("<I", content, at, size + 1)
    path.write_bytes(content)
    return path
