"""Compiles the kernels (`native/`) if there is a C compiler; without one the package is complete and slower."""

import subprocess
import sys
import sysconfig
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

ROOT = Path(__file__).parent
MODULE = ROOT / "src" / "timonel" / "_native.abi3.so"
# A product is rounded before it is added to, as in Python, on processors too that would do both at once.
FLAGS = ("-O3", "-std=gnu11", "-ffp-contract=off", "-fPIC", "-shared", "-fvisibility=hidden")
STABLE_ABI = "-DPy_LIMITED_API=0x030b0000"  # CPython 3.11 and all that follow


class Kernels(BuildHookInterface):  # type: ignore[type-arg]
    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        MODULE.unlink(missing_ok=True)
        trouble = compiled(MODULE)
        if trouble is None:
            platform = sysconfig.get_platform().replace("-", "_").replace(".", "_")
            build_data |= {"pure_python": False, "tag": f"cp311-abi3-{platform}"}
            build_data["artifacts"].append(str(MODULE.relative_to(ROOT)))
        else:
            self.app.display_warning(f"without compiled kernels, and slower: {trouble}")


def compiled(module: Path, *options: str) -> str | None:
    """Compile the kernels; why that was not possible."""
    compiler = (sysconfig.get_config_var("CC") or "cc").split()[0]
    sources = sorted(map(str, (ROOT / "native").glob("*.c")))
    include = f"-I{sysconfig.get_path('include')}"
    try:
        subprocess.run(
            [compiler, *FLAGS, STABLE_ABI, include, *options, *sources, "-o", module],
            check=True, capture_output=True, text=True,
        )  # fmt: skip
    except OSError as error:
        return f"no C compiler ({error})"
    except subprocess.CalledProcessError as error:
        return str(error.stderr)
    return None


if __name__ == "__main__":
    sys.exit(compiled(MODULE, *sys.argv[1:]))
