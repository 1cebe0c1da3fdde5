"""Cells that begin with `%%sh`, in the build: run as by IPython, but a command that fails ends the build, and what they
print is kept in one piece.
"""

import os
import subprocess
from typing import Any


def sh(line: str, cell: str) -> None:
    """Run a cell by the shell; raises CalledProcessError where a command fails."""
    plain = {name: value for name, value in os.environ.items() if name != "FORCE_COLOR"}  # no terminal: no bars
    done = subprocess.run(
        ["sh", "-e"], input=cell, text=True, env=plain, stdout=subprocess.PIPE, stderr=subprocess.STDOUT
    )
    print(done.stdout, end="")
    done.check_returncode()


def load_ipython_extension(shell: Any) -> None:
    """Take the place of IPython's own."""
    shell.register_magic_function(sh, "cell", "sh")
