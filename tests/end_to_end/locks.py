"""A build on a file system without locks (a library that is loaded first lets flock fail)."""
import errno
import os
import unittest

import h5py
import program

CONFIG = """
name: tiny
materials: [steel]
objects: [{shape: bar}]
audio: {sample_rate: 8 kHz, seconds: 0.1 s}
modes: {max_frequency: 4 kHz}
strikes: {per_object: 2}
"""


class Locks(program.FolderTest):
    def build(self, output, error=None):
        environment = {"LD_PRELOAD": os.environ["NO_LOCKS"], "NO_LOCKS_ERROR": str(error)}
        before = dict(os.environ)
        try:
            if error:
                os.environ.update(environment)
            return program.run("build", self.write("tiny.yaml", CONFIG), "--output",
                               self.folder / output, ranks=2)
        finally:
            os.environ.clear()
            os.environ.update(before)

    def test_builds_with_a_warning_where_there_are_no_locks(self):
        plain = self.build("plain")
        self.assertEqual(plain.returncode, 0, plain.stderr)
        self.assertNotIn("has no locks", plain.stderr)
        for error in (errno.ENOSYS, errno.ENOLCK, errno.EOPNOTSUPP):
            output = self.folder / errno.errorcode[error]
            result = self.build(output, error)
            self.assertEqual(result.returncode, 0, result.stderr)
            self.assertEqual(result.stderr.count(f"{output}: this file system has no locks"), 1)
            with h5py.File(self.folder / "plain/index.h5") as a, h5py.File(output / "index.h5") as b:
                self.assertEqual(a["audio"][:].tobytes(), b["audio"][:].tobytes())

    def test_other_errors_of_locking_still_end_the_build(self):
        result = self.build("broken", errno.EIO)
        self.assertEqual(result.returncode, 2)
        self.assertIn("cannot be locked: Input/output error", result.stderr)


if __name__ == "__main__":
    unittest.main()
