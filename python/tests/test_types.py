"""The types: those of the stubs are those of the module, and code that uses them is checked."""

import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parent.parent


def run(*arguments: str, folder: Path) -> None:
    done = subprocess.run([sys.executable, "-m", *arguments], cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr


def test_the_package_and_its_tests_are_typed() -> None:
    run("mypy", folder=ROOT)


def test_the_stubs_are_those_of_the_module(tmp_path: Path) -> None:
    # Elsewhere than beside the sources, which hold no compiled module.
    run("mypy.stubtest", "precomp", "--ignore-disjoint-bases", "--mypy-config-file", str(ROOT / "pyproject.toml"), folder=tmp_path)
